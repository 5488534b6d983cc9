# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Hypotheses of what is wrong with the sensors of a dive.

Each holds the records as they would be without its fault (`faults/`). Comparisons are repeated with
these records in suspects.py, which judges the hypotheses.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set

from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.faults.axes import BY_DEFAULT, Conventions
from hullrecon.navigation.suspects.faults.camera import camera_faults
from hullrecon.navigation.suspects.faults.dvl import dvl_faults
from hullrecon.navigation.suspects.faults.hypothesis import Hypothesis
from hullrecon.navigation.suspects.faults.imu import imu_faults, rate_faults
from hullrecon.navigation.suspects.faults.pressure import pressure_faults
from hullrecon.navigation.suspects.faults.tray import tray_faults
from hullrecon.records.sensors import SensorRecords
from hullrecon.rig import Rig


def hypotheses(
    records: SensorRecords,
    sensors: Set[Sensor],
    atmosphere_m: float,
    rig: Rig,
    flows: Sequence[Flow] = (),
    given: Conventions = BY_DEFAULT,
) -> Iterator[Hypothesis]:
    """Yield what may be wrong with some sensors of a dive, one fault at a time.

    Parameters
    ----------
    records
        The dive.
    sensors
        Those that are suspected.
    atmosphere_m
        The air's pressure in metres of water, which was subtracted from the pressure.
    rig
        Mount of the DVL, and calibration of the upper camera.
    flows
        Features of neighbouring images.
    given
        What dive.toml says of the sensors.
    """
    dvl, imu, pressure, tray = records.dvl, records.imu, records.pressure, records.tray
    if Sensor.PRESSURE in sensors and pressure is not None:
        yield from pressure_faults(records, pressure, atmosphere_m)
    if Sensor.DVL in sensors and dvl is not None:
        yield from dvl_faults(records, dvl, rig, flows)
    if Sensor.RATES in sensors and imu is not None:
        yield from rate_faults(records, imu)
    if imu is not None and sensors & {Sensor.ATTITUDE, Sensor.ACCELERATION}:
        yield from imu_faults(records, imu, given)
    if Sensor.TRAY in sensors and tray is not None:
        yield from tray_faults(records, tray)
    if Sensor.CAMERA in sensors and rig.top is not None:
        yield from camera_faults(records, flows, rig.top)
