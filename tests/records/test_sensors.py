# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest

from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PressureSamples,
    SensorRecords,
    SonarPings,
)
from hullrecon.records.serialisation import from_arrays, to_arrays

T = np.array([10, 20, 30], np.int64)
DVL = DvlPings(
    t_ns=T,
    velocity=np.array([[0.1, 0.0, 0.0], [np.nan] * 3, [0.2, 0.0, 0.1]]),
    velocity_sigma=np.full(3, 0.003),
    ranges=np.array([[1.0, np.nan], [2.0, 2.1], [np.nan, np.nan]]),
    beams=np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]]),
)
IMU = ImuSamples(
    t_ns=T,
    quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (3, 1)),
    angular_velocity=np.full((3, 3), np.nan),
    acceleration=np.tile([0.0, 0.0, -9.81], (3, 1)),
)
PRESSURE = PressureSamples(t_ns=T, depth=np.array([1.0, 1.5, 2.0]))
TRAY = JointSamples(t_ns=T, angle=np.array([0.0, 0.1, 0.2]))
SONAR = SonarPings(
    t_ns=T[:1],
    image=np.arange(6, dtype=np.uint8).reshape(1, 2, 3),
    directions=np.array([[0.0, 0.1, 1.0], [0.0, -0.1, 1.0]]),
    range_m=np.array([0.5, 1.0, 1.5]),
)
IMAGES = ImageIndex(
    t_ns=T,
    file=np.array(["a.jpg", "", ""], np.str_),
    offset=np.array([0, 0, 120]),
    size=np.array([0, 120, 80]),
    usable=np.array([True, True, False]),
    bits=np.array(12),
)
ALL = SensorRecords(dvl=DVL, imu=IMU, pressure=PRESSURE, tray=TRAY, sonar_tray=TRAY, sonar=SONAR)


@pytest.mark.parametrize(
    "record", [DVL, IMU, PRESSURE, TRAY, SONAR, IMAGES], ids=lambda record: type(record).__name__
)
def test_a_record_reads_back_as_it_was_written(record: object) -> None:
    again = from_arrays(type(record), to_arrays(record))
    for field in fields(record):  # type: ignore[arg-type]
        before, after = getattr(record, field.name), getattr(again, field.name)
        np.testing.assert_array_equal(after, before)
        assert after.dtype == before.dtype, field.name


@pytest.mark.parametrize("record", [DVL, PRESSURE, ALL], ids=lambda record: type(record).__name__)
def test_records_can_not_be_changed(record: object) -> None:
    name = fields(record)[0].name  # type: ignore[arg-type]
    with pytest.raises(FrozenInstanceError):
        setattr(record, name, None)


def test_records_are_made_by_keyword_only() -> None:
    with pytest.raises(TypeError):
        PressureSamples(T, np.zeros(3))  # type: ignore[misc]
    with pytest.raises(TypeError):
        SensorRecords(DVL)  # type: ignore[misc]


def test_sensors_are_listed_by_name_in_the_order_of_the_fields() -> None:
    assert list(ALL.by_name()) == ["dvl", "imu", "pressure", "tray", "sonar_tray", "sonar"]
    assert ALL.by_name()["sonar"] is SONAR


def test_a_sensor_that_was_not_read_is_not_listed() -> None:
    assert SensorRecords().by_name() == {}
    assert list(replace(ALL, imu=None, sonar_tray=None).by_name()) == [
        "dvl",
        "pressure",
        "tray",
        "sonar",
    ]


def test_a_sensor_without_readings_is_listed_all_the_same() -> None:
    none = JointSamples(t_ns=T[:0], angle=np.zeros(0))
    assert SensorRecords(tray=none).by_name() == {"tray": none}
