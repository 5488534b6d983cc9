# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sensors held against each other, for `check` and the step navigate."""

from __future__ import annotations

from collections.abc import Mapping

from hullrecon.dive.check.motion_offset import level_of, motions_apart
from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.schema import Topics
from hullrecon.findings.finding import Finding
from hullrecon.navigation.suspects.comparisons import Sensor
from hullrecon.navigation.suspects.suspects import Judged, judge
from hullrecon.records.sensors import SensorRecords
from hullrecon.rig import RIG_KEYS, rig_from_settings

WATER_KEYS = ("pressure.density", "pressure.gravity", "pressure.atmosphere")
SENSOR_KEYS = (*RIG_KEYS, *WATER_KEYS, "topics")


def judge_sensors(settings: Mapping[str, object], records: SensorRecords) -> Judged:
    """Hold the sensors of a dive against each other, by SENSOR_KEYS of dive.toml."""
    density, gravity, atmosphere = (_number(settings[key]) for key in WATER_KEYS)
    topics = settings["topics"]
    named = {
        sensor: topic
        for sensor, topic in {
            Sensor.PRESSURE: getattr(topics, "pressure", None),
            Sensor.DVL: getattr(topics, "dvl", None),
            Sensor.RATES: getattr(topics, "imu", None),
            Sensor.ATTITUDE: getattr(topics, "imu", None),
            Sensor.ACCELERATION: getattr(topics, "imu", None),
            Sensor.TRAY: getattr(topics, "joints", None),
        }.items()
        if isinstance(topics, Topics) and topic
    }
    rig = rig_from_settings(settings)
    level = level_of(records, rig.tray_origin, rig.pressure_origin, rig.tray_from_dvl)
    apart = motions_apart(records, level)
    if apart:  # nothing else compares sensors whose clocks are apart
        return Judged(records=records, findings=apart, tried=[])
    return judge(records, rig, atmosphere / (density * gravity), named)


def describe_sensors(
    loaded: LoadedConfig, records: SensorRecords
) -> tuple[SensorRecords, list[Finding], list[dict[str, object]]]:
    """Judge the sensors for `check`: records put right, what was found, and what was tried."""
    judged = judge_sensors({key: loaded.value(key) for key in SENSOR_KEYS}, records)
    return judged.records, judged.findings, [one.document() for one in judged.tried]


def _number(value: object) -> float:
    return float(str(value))
