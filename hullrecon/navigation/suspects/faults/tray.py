# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Faults of the tray's angles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hullrecon.navigation.sensors.servo import FEW_READINGS, LEAST_TRAVEL_RAD, has_moved
from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.faults.hypothesis import Hypothesis
from hullrecon.records.sensors import JointSamples, SensorRecords


def tray_faults(records: SensorRecords, tray: JointSamples) -> Iterator[Hypothesis]:
    """Yield faults of the tray's angles: zeros off by eighths of a turn, units, signs, and both."""
    degree = np.pi / 180
    for off_deg in (90, -90, 180, 45, -45, 135, -135):
        angle = tray.angle - degree * off_deg
        for fault, sense in (("zero", 1), ("reversed", -1)):
            yield Hypothesis(
                sensor=Sensor.TRAY,
                fault=fault,
                value=f"{off_deg:+d}",
                mended=replace(records, tray=replace(tray, angle=sense * angle)),
                exact=fault == "zero",
                faults=1 if fault == "zero" else 2,
            )
    # In the right unit a servo that was moved turned by LEAST_TRAVEL_RAD or more, and by less than
    # a whole turn
    known = tray.angle[np.isfinite(tray.angle)]
    farthest_rad = float(np.abs(known).max(initial=0.0))
    span_rad = float(np.ptp(known)) if len(known) >= FEW_READINGS and has_moved(known) else np.inf
    for fault, value, factor, exact in (
        ("unit", "deg", degree, True),
        ("unit", "rad", 1 / degree, True),
        ("unit", "turns", 2 * np.pi, True),
        ("sign", "", -1.0, False),
        ("sign", "deg", -degree, False),
    ):
        if abs(factor) * span_rad < LEAST_TRAVEL_RAD or abs(factor) * farthest_rad > 2 * np.pi:
            continue
        mended = replace(records, tray=replace(tray, angle=factor * tray.angle))
        yield Hypothesis(
            sensor=Sensor.TRAY,
            fault=fault,
            value=value,
            mended=mended,
            exact=exact,
            faults=2 if (fault, value) == ("sign", "deg") else 1,
        )
