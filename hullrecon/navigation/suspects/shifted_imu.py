# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Put right the stamps of an IMU that are seconds late, or early, throughout a dive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hullrecon.dive.check.motion_offset import GAIN_OF_FEW
from hullrecon.dive.check.time_overlap import shifted_streams
from hullrecon.findings.finding import Finding
from hullrecon.navigation.suspects.comparisons.comparison import Comparison
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.comparisons.motions import Motions, compare
from hullrecon.records.clock import NS
from hullrecon.records.sensors import SensorRecords
from hullrecon.rig import Rig

# Comparisons that show when the IMU moved, and whose motion each compares
TIMED = {"push": "its accelerations and the DVL", "view": "its turns and the images"}
# Residuals as a share of the motion, beyond which two sensors do not show one motion
ONE_MOTION = 0.4


def mend_shifted_imu(
    records: SensorRecords, rig: Rig, flows: Sequence[Flow]
) -> tuple[SensorRecords, list[Finding]]:
    """Correct the stamps of an IMU whose log begins and ends seconds late, or early.

    Both ends have to be late by the same time beside all others (`shifted_streams`), and the IMU
    has to show the motion of the DVL or of the images with stamps put right by that, and not as
    stamped. Otherwise the records are returned unchanged.

    flows: features of neighbouring images.

    Returns
    -------
    the records, and a finding of what was corrected
    """
    imu = records.imu
    for shifted in shifted_streams(records.by_name()):
        if shifted.where != "imu" or imu is None:
            continue
        late_s = shifted.values["seconds"]
        assert isinstance(late_s, float)
        moved = replace(records, imu=replace(imu, t_ns=imu.t_ns - round(late_s * NS)))
        as_stamped = {c.kind: c for c in compare(Motions(records, rig, flows), TIMED.keys())}
        for after in compare(Motions(moved, rig, flows), TIMED.keys()):
            if _shows_one_motion(after, as_stamped.get(after.kind)):
                values = {"seconds": late_s, "compared": TIMED[after.kind]}
                return moved, [Finding("stream-moved", values, "imu")]
    return records, []


def _shows_one_motion(moved: Comparison, as_stamped: Comparison | None) -> bool:
    """Tell whether two sensors show one motion with stamps moved, and a worse one as stamped.

    The size of the noise is taken as unknown: the ratio of the two misfits decides, as two offsets
    alone are possible. as_stamped: None where hardly anything was measured at the same time.
    """
    if moved.is_contradiction or moved.misfit > ONE_MOTION:
        return False
    if as_stamped is None:
        return True
    rows = min(len(moved.residual), len(as_stamped.residual))
    return bool(2 * rows * np.log(as_stamped.misfit / max(moved.misfit, 1e-9)) > GAIN_OF_FEW)
