# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Clocks that are far apart, found by the vertical motion that DVL and pressure sensor measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from navigation.instruments import RIG
from navigation.wall_dive import AlongWall, logs_along_wall

from hullrecon.dive.check.motion_offset import (
    level_of,
    mend_shifted,
    motions_apart,
    offset_by_motion,
)
from hullrecon.records.sensors import SensorRecords

NS = 10**9


@pytest.fixture(scope="module")
def right() -> SensorRecords:
    logs = logs_along_wall(AlongWall(RIG))
    return SensorRecords(dvl=logs.dvl, imu=logs.imu, pressure=logs.pressure, tray=logs.tray)


def moved(records: SensorRecords, sensor: str, seconds: float) -> SensorRecords:
    stream = getattr(records, sensor)
    return replace(records, **{sensor: replace(stream, t_ns=stream.t_ns + round(seconds * NS))})


def level(records: SensorRecords):
    return level_of(records, RIG.tray_origin, RIG.pressure_origin, RIG.tray_from_dvl)


@pytest.mark.parametrize("late_s", [0.0, 75.0, 7203.7, -1.777e9])
@pytest.mark.parametrize("sensor", ["dvl", "pressure"])
def test_the_offset_of_a_clock_is_found_however_far_it_is(right, sensor, late_s):
    off = moved(right, sensor, late_s)
    assert offset_by_motion(sensor, off, level(off)) == pytest.approx(-late_s, abs=0.15)


@pytest.mark.parametrize("late_s", [75.0, -110.0])
def test_motions_over_a_minute_apart_are_told_and_the_remedy_heals(right, late_s):
    off = moved(right, "dvl", late_s)
    (found,) = motions_apart(off, level(off))
    assert found.severity == "error"
    assert f"dvl.time_offset = {found.values['seconds']:.2f}" in found.sentence
    healed = moved(off, "dvl", found.values["seconds"])
    assert motions_apart(healed, level(healed)) == []
    assert np.abs(healed.dvl.t_ns - right.dvl.t_ns).max() < 0.15 * NS


def test_right_clocks_and_small_offsets_are_not_told(right):
    for late_s in (0.0, 0.5, 20.0):
        off = moved(right, "dvl", late_s)
        assert motions_apart(off, level(off)) == []


@pytest.mark.parametrize("period_s", [9.0, 20.0])
def test_of_a_swell_that_repeats_itself_no_offset_is_told(right, period_s):
    """Velocity and depth of a steady swell agree at every multiple of its period."""
    rate, dvl, pressure = 2 * np.pi / period_s, right.dvl, right.pressure
    start = int(dvl.t_ns[0])
    at, read = (1e-9 * (t_ns - start) for t_ns in (dvl.t_ns, pressure.t_ns))
    still = replace(right.imu, quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (len(right.imu.t_ns), 1)))
    down = np.stack([0 * at, 0 * at, 0.3 * rate * np.cos(rate * at)], axis=1)
    steady = replace(
        right,
        imu=still,
        tray=None,
        dvl=replace(dvl, velocity=RIG.tray_from_dvl.rotation.inv().apply(down)),
        pressure=replace(pressure, depth=2 + 0.3 * np.sin(rate * read)),
    )
    off = moved(steady, "dvl", 3600.0)
    assert offset_by_motion("dvl", off, level(off)) is None


@pytest.mark.parametrize(("sensor", "late_s"), [("dvl", 18.0), ("pressure", -18.0)])
def test_a_log_that_is_late_at_both_ends_is_moved_where_motion_agrees(right, sensor, late_s):
    off = moved(right, sensor, late_s)
    mended, (said,) = mend_shifted(off, level(off))
    by = getattr(mended, sensor).t_ns - getattr(right, sensor).t_ns
    assert np.abs(by).max() < 0.15 * NS
    assert "GPS time is 18 s ahead" in said.sentence
    assert mend_shifted(mended, level(mended))[1] == []


def test_a_log_that_was_started_and_stopped_late_is_not_moved(right):
    dvl = right.dvl
    kept = (dvl.t_ns > dvl.t_ns[0] + 18 * NS) & (dvl.t_ns <= dvl.t_ns[-1])
    later = replace(
        dvl,
        t_ns=dvl.t_ns[kept],
        velocity=dvl.velocity[kept],
        velocity_sigma=dvl.velocity_sigma[kept],
        ranges=dvl.ranges[kept],
    )
    assert mend_shifted(replace(right, dvl=later), level(right))[1] == []
