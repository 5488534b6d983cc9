# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stack the angles of a servo into a record: radians that run on beyond a turn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.dive.logs.lost_values import describe_lost
from hullrecon.dive.logs.samples import JointSample, stamps
from hullrecon.dive.logs.two_sensors import refuse_two_sensors, windows
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.records.sensors import JointSamples
from hullrecon.typing import Array

NEARLY_A_TURN = 1.5 * np.pi  # rad, farther than a servo turns from one reading to the next
WHOLE_TURN_DEG = 360.0


@np.errstate(all="ignore")
def joint_samples(
    samples: Sequence[JointSample], record: str, name: str, notes: list[Finding], unit: str = "rad"
) -> JointSamples | None:
    """Stack the angles of one servo. None where no reading of the sonar's is finite.

    Readings that are not finite are dropped. Angles that begin anew after each turn are made to run
    on.

    Parameters
    ----------
    samples : readings of the servo in order of time
    record : "tray" or "sonar_tray", whose angles may go beyond a turn
    name : of the joint in the log
    notes : findings of what was changed or dropped are added
    unit : "rad" or "deg"

    Raises
    ------
    InputError
        A tray without any finite reading or that would turn by more than a whole turn, or angles of
        two servos.
    """
    angle = np.array([s.angle for s in samples])
    angle = np.radians(angle) if unit == "deg" else angle
    good = np.isfinite(angle)
    notes += describe_lost(f"joint {name}", good)
    if not good.any():
        if record != "tray":
            return None
        raise InputError(
            f"none of the {len(good)} messages of joint {name} holds its angle",
            where="tray.joint",
            remedy='log its position, or set tray.joint = "" if nothing turns there',
        )
    largest_rad = float(np.abs(angle[good]).max())
    joined = _join_turns(angle[good], f"joint {name}", notes)
    cut = np.degrees(windows(joined))
    refuse_two_sensors(f"joint {name}", np.abs(cut - cut[:, :1]), "degrees")
    if largest_rad > 2 * np.pi and record == "tray":
        is_degrees = unit == "rad" and largest_rad <= WHOLE_TURN_DEG
        raise InputError(
            f"the angles of {name} reach {largest_rad:.1f} rad, more than a whole turn",
            where="tray.joint_unit",
            remedy='give tray.joint_unit = "deg" where they are degrees'
            if is_degrees
            else "log them in radians or degrees: they are neither (a servo's pulse or counts?)",
        )
    if largest_rad > 2 * np.pi:
        notes.append(Finding("angles-in-degrees", {"largest_rad": largest_rad}, f"joint {name}"))
    return JointSamples(t_ns=stamps(samples)[good], angle=joined)


def _join_turns(angle: Array, name: str, notes: list[Finding]) -> Array:
    """Let an angle's readings (n,) rad run on where they count anew from 0 after each whole turn.

    Whole turns are then taken off all, so that their median lies within half a turn of 0. Angles
    without such jumps are returned unchanged. name: of the stream, for `notes`.
    """
    jumps = int(np.count_nonzero(np.abs(np.diff(angle)) > NEARLY_A_TURN))
    if not jumps:
        return angle
    notes.append(Finding("angles-wrap", {"jumps": jumps}, name))
    joined = np.unwrap(angle, discont=NEARLY_A_TURN)
    return np.asarray(joined - 2 * np.pi * np.round(np.median(joined) / (2 * np.pi)))
