# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Faults of the pressure sensor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hullrecon.dive.logs.streams.pressure import DEEPEST_HULL_M, METRES, PASCALS
from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.faults.clock import clock_faults
from hullrecon.navigation.suspects.faults.hypothesis import FACTORS, Hypothesis
from hullrecon.records.sensors import PressureSamples, SensorRecords

# Pa of each unit in which a pressure may have been logged instead
PASCAL = {u: pa for u, pa in PASCALS.items() if u not in ("Pa", "mbar")}
PASCAL |= {"0.1 mbar": 10.0}  # whole numbers of an MS5837, which its drivers pass on


def pressure_faults(
    records: SensorRecords, pressure: PressureSamples, air_m: float
) -> Iterator[Hypothesis]:
    """Yield faults of the pressure: units, scales, gauge pressure, sign, constant readings, clock.

    Each holds the records with the depth, m, as it would be without the fault. The fault of
    constant readings leaves the sensor out, which would explain anything: `suspects.py` tries it
    only where the readings stand still.

    air_m: the air's pressure in metres of water, which was taken off the absolute pressure.
    """
    depth = pressure.depth
    # the usual interpretations first: of those that explain as much, the first counts
    interpretations = {
        **{("unit", unit): pa * (depth + air_m) - air_m for unit, pa in PASCAL.items()},
        **{("unit", unit): metre * depth for unit, metre in METRES.items() if metre != 1},
        **{("scale", f"{factor:.2f}"): factor * depth for factor in FACTORS},
        **{("gauge", unit): pa * (depth + air_m) for unit, pa in {"Pa": 1.0, **PASCAL}.items()},
        ("sign", ""): -depth,
    }
    for (fault, value), corrected in interpretations.items():
        # a unit by which the vehicle was deeper than any hull is not the right one
        if fault in ("unit", "gauge") and np.median(corrected) > DEEPEST_HULL_M:
            continue
        mended = replace(records, pressure=replace(pressure, depth=corrected))
        yield Hypothesis(
            sensor=Sensor.PRESSURE, fault=fault, value=value, mended=mended, exact=True
        )
    # exact: nothing is lost with readings without information
    without = replace(records, pressure=None)
    yield Hypothesis(sensor=Sensor.PRESSURE, fault="constant", value="", mended=without, exact=True)
    for clock in clock_faults(pressure.t_ns):
        yield clock.hypothesis(Sensor.PRESSURE, replace(records, pressure=clock.correct(pressure)))
