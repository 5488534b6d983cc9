# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What single sensors say of each other's clocks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from navigation.conftest import JANUS, START_NS
from navigation.instruments import RIG
from navigation.wall_dive import AlongWall, late, logs_along_wall

from hullrecon.geometry.poses import Poses
from hullrecon.navigation.clocks.clock_errors import ClockError, Sensor, on_time
from hullrecon.navigation.clocks.images import ImageMotions, dvl_beside_images, imu_beside_images
from hullrecon.navigation.clocks.instruments import (
    hull_normals,
    imu_beside_dvl,
    pressure_beside_dvl,
)
from hullrecon.navigation.clocks.time_shift import find_far_shift, find_time_shift
from hullrecon.navigation.sensors.attitude import attitude_history
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.sensors.velocity import usable_velocities
from hullrecon.records.sensors import DvlPings


@pytest.fixture(scope="module")
def logged():
    return logs_along_wall(AlongWall(RIG))


@pytest.fixture(scope="module")
def attitude(logged):
    return attitude_history(logged.imu, 0.002, 0.6)


@pytest.fixture(scope="module")
def motions(logged):
    """Without noise, between each frame and the next but one."""
    true_s = (logged.top.t_ns - START_NS)[::4] * 1e-9
    camera = AlongWall(RIG).cameras(true_s)
    moved = camera[slice(1, None)].inverse() @ camera[slice(None, -1)]
    t_ns = logged.top.t_ns[::4]
    return ImageMotions(
        first_ns=t_ns[:-1],
        second_ns=t_ns[1:],
        second_from_first=moved,
        sigma_rad=np.full((len(moved), 2), 0.001),
    )


def facing(normal: list[float], distance_m: float, pings: int = 20) -> DvlPings:
    """Pings at a plane with that normal, in `dvl`."""
    direction = np.array(normal) / np.linalg.norm(normal)
    ranges = np.tile(distance_m / (JANUS @ direction), (pings, 1))
    return DvlPings(
        t_ns=np.arange(pings) * 200_000_000,
        velocity=np.zeros((pings, 3)),
        velocity_sigma=np.full(pings, 0.003),
        ranges=ranges,
        beams=JANUS,
    )


def test_the_normal_of_a_plane_points_away_from_the_instrument():
    t_ns, normal = hull_normals(facing([0.1, -0.2, 1.0], 1.5))
    assert len(t_ns) == 20
    np.testing.assert_allclose(
        normal, np.tile(np.array([0.1, -0.2, 1.0]) / np.sqrt(1.05), (20, 1)), atol=1e-9
    )


def test_three_beams_tell_a_plane_and_two_do_not():
    pings = facing([0.1, -0.2, 1.0], 1.5)
    pings.ranges[4:8, 0] = np.nan
    pings.ranges[12:14, :2] = np.nan
    t_ns, normal = hull_normals(pings)
    assert len(t_ns) == 18
    np.testing.assert_allclose(normal, np.tile(normal[:1], (18, 1)), atol=1e-9)


def test_a_wild_return_is_left_out():
    pings = facing([0.0, 0.0, 1.0], 1.5)
    pings.ranges[10, 1] = 3.0
    t_ns, normal = hull_normals(pings)
    assert len(t_ns) == 20
    np.testing.assert_allclose(normal[:, 2], 1.0, atol=1e-9)


def test_a_dvl_of_no_or_two_beams_has_no_normals():
    pings = facing([0.0, 0.0, 1.0], 1.5)
    assert hull_normals(replace(pings, ranges=pings.ranges[:, :2], beams=JANUS[:2]))[0].shape == (
        0,
    )
    assert hull_normals(replace(pings, ranges=np.zeros((20, 0)), beams=np.zeros((0, 3))))[
        1
    ].shape == (0, 3)


@pytest.mark.parametrize("seconds", [0.0, 1.0, -0.7])
def test_the_hull_stands_still_at_the_imus_time(logged, attitude, seconds):
    moved = late(logged, Sensor.DVL, -seconds)
    found = imu_beside_dvl(moved.dvl, attitude, servo(logged.tray, START_NS), RIG)
    shift = find_time_shift(found.residuals, found.block)
    assert shift.seconds == pytest.approx(seconds, abs=4 * shift.sigma_s)
    assert shift.sigma_s < 0.1


@pytest.mark.parametrize("seconds", [0.0, 1.0, -0.7])
def test_the_depth_follows_the_dvl_at_the_pressures_time(logged, attitude, seconds):
    moved = late(logged, Sensor.PRESSURE, seconds)
    found = pressure_beside_dvl(
        logged.dvl, attitude, moved.pressure, servo(logged.tray, START_NS), RIG
    )
    shift = find_time_shift(found.residuals, found.block)
    assert shift.seconds == pytest.approx(seconds, abs=4 * shift.sigma_s)
    assert shift.sigma_s < 0.1


def test_the_attitude_that_levels_the_dvl_is_that_of_the_clock_that_the_imu_shares(
    logged, attitude
):
    """A DVL that is late beside IMU and pressure is levelled by the attitude of their time, or its
    shift comes out wrong.
    """
    moved, joint = late(logged, Sensor.DVL, 1.5), servo(logged.tray, START_NS)
    by_theirs, by_its_own = (
        pressure_beside_dvl(moved.dvl, attitude, logged.pressure, joint, RIG, late_s)
        for late_s in (None, 0.0)
    )
    right, wrong = (
        find_time_shift(found.residuals, found.block) for found in (by_theirs, by_its_own)
    )
    assert right.seconds == pytest.approx(-1.5, abs=4 * right.sigma_s)
    assert abs(wrong.seconds + 1.5) > abs(right.seconds + 1.5)


def test_less_than_a_minute_is_too_short_to_say_how_sure_a_shift_is(logged, attitude):
    few = logged.dvl.t_ns < START_NS + 50 * 10**9
    rows = {
        name: getattr(logged.dvl, name)[few]
        for name in ("t_ns", "velocity", "velocity_sigma", "ranges")
    }
    pings, joint = replace(logged.dvl, **rows), servo(logged.tray, START_NS)
    assert not imu_beside_dvl(pings, attitude, joint, RIG).is_enough
    assert not pressure_beside_dvl(pings, attitude, logged.pressure, joint, RIG).is_enough


@pytest.mark.parametrize("seconds", [0.0, 0.4, -2.0])
def test_images_tell_the_times_of_attitude_and_velocity(logged, attitude, motions, seconds):
    early = replace(
        motions,
        first_ns=motions.first_ns - round(seconds * 1e9),
        second_ns=motions.second_ns - round(seconds * 1e9),
    )
    turns = imu_beside_images(early, attitude, servo(logged.tray, START_NS), RIG)
    imu = find_far_shift(turns.residuals, turns.block)
    assert imu.seconds == pytest.approx(seconds, abs=0.02)
    velocities = usable_velocities(logged.dvl, (START_NS, START_NS + 240 * 10**9), 0.6)
    steps = dvl_beside_images(early, velocities, RIG)
    dvl = find_far_shift(steps.residuals, steps.block)
    assert dvl.seconds == pytest.approx(seconds, abs=0.1)


def test_few_motions_tell_nothing(logged, attitude, motions):
    few = ImageMotions(
        first_ns=motions.first_ns[:5],
        second_ns=motions.second_ns[:5],
        second_from_first=Poses(
            motions.second_from_first.quaternion[:5], motions.second_from_first.translation[:5]
        ),
        sigma_rad=motions.sigma_rad[:5],
    )
    velocities = usable_velocities(logged.dvl, (START_NS, START_NS + 240 * 10**9), 0.6)
    assert not imu_beside_images(few, attitude, servo(logged.tray, START_NS), RIG).is_enough
    assert not dvl_beside_images(few, velocities, RIG).is_enough


def test_stamps_are_moved_within_the_error_and_of_its_sensor_alone():
    wrong = ClockError(
        sensor=Sensor.IMU, from_ns=10, to_ns=20, late_s=-1e-9, sigma_s=1e-9, beside=(Sensor.DVL,)
    )
    t_ns = np.array([5, 10, 15, 20, 25])
    assert on_time(t_ns, [wrong], Sensor.IMU).tolist() == [5, 11, 16, 21, 25]
    assert on_time(t_ns, [wrong], Sensor.DVL).tolist() == t_ns.tolist()
