# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A hypothesis of what is wrong with a sensor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.records.sensors import SensorRecords

# factors by which a length may be wrong, in steps so small that a comparison agrees at the nearest
FACTORS = [*np.geomspace(0.5, 0.93, 10), *np.geomspace(1.07, 2.0, 10)]
# Faults that a driver's settings make. Scales and offsets of any size, and clocks, explain more.
OF_DRIVERS = frozenset(
    {
        *("unit", "gauge", "sign", "axes", "mirrored", "along", "order", "frame", "global"),
        *("turn", "mount", "picture"),
    }
)


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """A fault of one sensor."""

    sensor: Sensor
    fault: str  # the second of a key of FAULTS of hullrecon/findings/sensors.py, "clock" or "rate"
    value: str  # which unit, which axes
    # with the fault corrected, or without the sensor where that is impossible
    mended: SensorRecords
    exact: bool = False  # the corrected readings can be used, as the correction is known exactly
    flows: Sequence[Flow] | None = None  # corrected features, where the camera is at fault
    # by which the stamps are late (the last one, where the clock runs fast); negative: early
    late_s: float = 0.0
    faults: int = 1  # that are corrected at once
    # share of a comparison's rows, by its kind, that the correction makes agree in any case
    untested: Mapping[str, float] = field(default_factory=dict)
    heading_drift_sigma_rad_s: float = 0.0  # of a heading that is the integral of rates
