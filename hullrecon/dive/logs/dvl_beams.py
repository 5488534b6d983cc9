# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Directions of a DVL's beams: by the messages, else dive.toml, else the instrument's type."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.dive.logs.samples import DvlSample
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.typing import Array

A50 = "Water Linked A50"
A50_ANGLE_DEG = 22.5
A50_AZIMUTH_DEG = (135.0, -135.0, -45.0, 45.0)  # of beams 1 to 4 about z of `dvl`, from x towards y
SAME_DEG = 0.5  # directions that differ by less are the same
ADVICE = (
    "give [dvl] beams as unit vectors, or beam_angle_deg with beam_azimuth_deg, from the "
    "instrument's manual; "
    f"a guess would cost several per cent of every distance (a {A50} has beam_angle_deg = "
    f"{A50_ANGLE_DEG:g}, "
    f"beam_azimuth_deg = [{', '.join(f'{a:g}' for a in A50_AZIMUTH_DEG)}])"
)
# no DVL's beams stand farther off its axis: they are built with 15 to 30 degrees
FAR_OFF_DEG = 45.0
LEANING_DEG = 10.0  # of the beams' mean direction from the z axis
# share; 30 degrees in place of 22.5 make 0.063, and the ranges' own errors up to 0.03
SAME_ALTITUDE = 0.045
# share; the cosines of 15 and 30 degrees differ by 0.115, and a hull that slopes adds 0.012
FAR_ALTITUDE = 0.13
SAME_COSINE = 0.015  # share; on the slope of a hull an altitude is no mean of the beams
# of ranges beside an altitude in m, and how far (log) their ratio may be off
SMALL_UNITS, SAME_UNIT = {"mm": 1e-3, "cm": 1e-2, "ft": 0.3048}, 0.15
# Sigmas within which the scale of ranges lies that are in truth distances along the axis. Nothing
# excludes that, and more than one table in twenty holds them, as instruments write them: they
# belong in an interval of 95 %.
ALONG_AXIS_SIGMAS = 1.96
FEW = 10  # pings whose ranges and altitude are compared


def tilted_beams(angle_deg: float, azimuth_deg: Sequence[float]) -> Array:
    """Compute beams (b, 3) in `dvl`, tilted off its z axis by one angle at azimuths from x to y."""
    tilt, azimuth = np.radians(angle_deg), np.radians(np.asarray(azimuth_deg, float))
    across = np.sin(tilt)
    return np.stack(
        [across * np.cos(azimuth), across * np.sin(azimuth), np.full(len(azimuth), np.cos(tilt))],
        axis=1,
    )


def a50_beams() -> Array:
    """Compute the beams (4, 3) of a Water Linked A50 in the frame `dvl`."""
    return tilted_beams(A50_ANGLE_DEG, A50_AZIMUTH_DEG)


def choose_beams(
    samples: Sequence[DvlSample], configured: Array | None, width: int, notes: list[Finding]
) -> Array:
    """Choose the beams (width, 3) in `dvl`: of the messages, else of dive.toml, else of the type.

    Beams of the messages that point into the instrument are wrong: those of dive.toml are then
    taken. Empty where the log has no ranges.

    Parameters
    ----------
    samples : pings of the DVL, which may carry its beams' directions: logged, or (`instrument` is
        set) by the data sheet of the type that the message names
    configured : (b, 3) directions of dive.toml, None where it gives none
    width : number of beams with ranges in the log
    notes : findings are added where the directions contradict each other, or come from the type

    Raises
    ------
    InputError
        No source gives the directions, dive.toml describes another number of beams, or those of the
        messages point into the instrument and dive.toml gives none.
    """
    if not width:
        return np.zeros((0, 3))
    if configured is not None and len(configured) != width:
        raise InputError(
            f"[dvl] of dive.toml describes {len(configured)} beams, the log has {width}",
            where="dvl.beams",
        )
    described = [s for s in samples if s.beams is not None and len(s.beams) == width]
    logged = [s.beams for s in described if not s.instrument and s.beams is not None]
    if logged and float(np.mean(logged, axis=0)[:, 2].mean()) < 0:
        if configured is None:
            raise ask_for_beams(
                width,
                "the DVL's beams in the messages point into the instrument: z of dvl is out of the "
                "transducers, and their z is negative",
            )
        notes.append(Finding("beams-inward", where="dvl"))
        return unit(configured)
    if logged:
        return _logged_beams(logged, configured, notes)
    if configured is not None:
        return unit(configured)
    if described and described[0].beams is not None:
        values = {"instrument": described[0].instrument}
        notes.append(Finding("beams-of-type", values, "dvl"))
        return unit(described[0].beams)
    raise ask_for_beams(width)


def ask_for_beams(count: int, why: str = "") -> InputError:
    """Make the error that asks for the directions of the DVL's beams."""
    why = why or f"nothing says where the DVL's {count} beams point"
    return InputError(why, where="dvl.beams", remedy=ADVICE)


def put_ranges_right(beams: Array, ranges: Array, altitude: Array) -> tuple[Array, list[Finding]]:
    """Correct ranges that the altitude shows to be in another unit than m, or along the axis.

    Arguments as of `check_beams`. A distance along the axis is shorter than the range along its
    beam by the cosine of the beam's angle. Beams with a wrong angle, such as 30 degrees in place of
    22.5, are not taken for that: they change the ratio by less than the cosine. Ranges that no
    altitude can be compared with are returned unchanged.

    Returns
    -------
    ranges (n, b) along the beams, m, and what was corrected

    Raises
    ------
    InputError
        Ranges and altitude differ by more than any DVL's beams explain, and no unit explains it.
    """
    ratio = _reach_over_altitude(beams, ranges, altitude)
    for unit, metres in SMALL_UNITS.items():
        if abs(np.log(ratio * metres)) < SAME_UNIT:
            return metres * ranges, [Finding("ranges-in-unit", {"unit": unit}, "dvl")]
    if abs(ratio - 1) > SAME_ALTITUDE and abs(ratio / beams[:, 2].mean() - 1) < SAME_COSINE:
        return ranges / beams[:, 2], [Finding("ranges-along-axis", where="dvl")]
    if abs(np.log(ratio)) > np.log1p(FAR_ALTITUDE):
        raise InputError(
            f"along its beams the DVL's ranges reach {ratio:.2f} times the altitude that it "
            "computed: the ranges or the altitude are scaled, or the beams are another DVL's",
            where="dvl",
        )
    return ranges, []


def check_beams(beams: Array, ranges: Array, altitude: Array) -> list[Finding]:
    """Report beams that point far off the axis or contradict the altitude. Empty for good ones.

    Parameters
    ----------
    beams : (b, 3) unit vectors in `dvl`
    ranges : (n, b) along the beams, m, NaN where lost
    altitude : (n,) along z of `dvl`, m, as the DVL computed it, NaN where lost
    """
    if not len(beams):
        return []
    out = []
    off_axis_deg = np.degrees(np.arccos(np.clip(beams[:, 2], -1, 1)))
    middle = beams.mean(axis=0)
    leaning = float(np.degrees(np.arctan2(np.linalg.norm(middle[:2]), middle[2])))
    if off_axis_deg.max() > FAR_OFF_DEG:
        out.append(Finding("beams-off-axis", {"degrees": float(off_axis_deg.max())}, "dvl"))
    elif leaning > LEANING_DEG:
        out.append(Finding("beams-leaning", {"degrees": leaning}, "dvl"))
    ratio = _reach_over_altitude(beams, ranges, altitude)
    if abs(ratio - 1) > SAME_ALTITUDE:
        side = "longer" if ratio > 1 else "shorter"
        values = {"percent": 100 * abs(ratio - 1), "side": side}
        out.append(Finding("beams-against-altitude", values, "dvl"))
    return out


def range_scale_sigma(
    beams: Array, ranges: Array, altitude: Array, by_hand: bool
) -> tuple[float, list[Finding]]:
    """Compute the sigma of a scale error that all ranges share, as a share of the range.

    Where the altitude contradicts the ranges, one of the two is wrong by that much. Where there is
    no altitude, the ranges of a table may in truth be distances along the axis, as PD0 and others
    give them. In a dive without cameras nothing else shows which of the two was logged. The change
    of the ranges with the velocities does not, as a vehicle keeps its distance and a hull is
    curved. The sigma is then so large that the error of such distances is ALONG_AXIS_SIGMAS of it.

    Parameters
    ----------
    beams, ranges, altitude : as of `check_beams`
    by_hand : the ranges are of a table, whose writer may have taken either distance

    Returns
    -------
    sigma, 0 where nothing speaks against the ranges, and findings, empty but for a table's ranges
    that no altitude confirms
    """
    if not len(beams):
        return 0.0, []
    ratio = _reach_over_altitude(beams, ranges, altitude)
    if np.isfinite(ratio):
        contradiction = abs(ratio - 1)
        return contradiction if contradiction > SAME_ALTITUDE else 0.0, []
    if not by_hand:
        return 0.0, []
    sigma = float(1 / beams[:, 2].mean() - 1) / ALONG_AXIS_SIGMAS
    return sigma, [Finding("ranges-unconfirmed", {"percent": 100 * sigma}, "dvl")]


def _reach_over_altitude(beams: Array, ranges: Array, altitude: Array) -> float:
    """Compute the median over all pings of the beams' mean reach along z divided by the altitude.

    It is 1 where ranges, beams and altitude agree. NaN where too few are known, or where the
    altitude is constant while the ranges change: a driver that computes none may fill in any.
    Arguments as of `check_beams`.
    """
    whole = np.isfinite(ranges).all(axis=1) & np.isfinite(altitude)
    if not len(beams) or np.count_nonzero(whole) < FEW:
        return float("nan")
    reach, logged = (ranges[whole] * beams[:, 2]).mean(axis=1), altitude[whole]
    if np.ptp(logged) == 0 and np.ptp(reach) > SAME_ALTITUDE * np.median(reach):
        return float("nan")
    return float(np.median(reach / logged))


def _logged_beams(logged: Sequence[Array], configured: Array | None, notes: list[Finding]) -> Array:
    """Average the beam directions of the messages, and compare them with dive.toml's.

    Those of the messages are returned in any case, (b, 3) in `dvl`. A finding is noted where they
    change in the log or differ from dive.toml's.

    logged: (b, 3) of each message. configured: (b, 3) of dive.toml, None where it gives none.
    """
    if max(float(np.abs(b - logged[0]).max()) for b in logged) > 1e-6:
        notes.append(Finding("beams-change", where="dvl"))
    beams = unit(np.mean(logged, axis=0))
    if configured is not None:
        apart = float(
            np.degrees(np.arccos(np.clip(np.sum(beams * unit(configured), axis=1), -1, 1))).max()
        )
        if apart > SAME_DEG:
            notes.append(Finding("beams-unlike-toml", {"degrees": apart}, "dvl"))
    return beams


def unit(vectors: Array) -> Array:
    """Scale vectors (n, 3) to length 1."""
    v = np.asarray(vectors, float)
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))
