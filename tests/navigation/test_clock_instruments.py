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
from hullrecon.navigation.clocks.comparisons.comparison import ClockComparison, ClockedSensor
from hullrecon.navigation.clocks.comparisons.dvl import compare_depth, compare_hull_turns
from hullrecon.navigation.clocks.comparisons.images import (
    ImageMotions,
    compare_directions,
    compare_turns,
)
from hullrecon.navigation.clocks.evidence import Refined, refine, weigh_comparisons
from hullrecon.navigation.sensors.attitude import attitude_history
from hullrecon.navigation.sensors.motion_signals import hull_normals
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.sensors.velocity import usable_velocities
from hullrecon.records.sensors import DvlPings


@pytest.fixture(scope="module")
def logged():
    return logs_along_wall(AlongWall(RIG))


@pytest.fixture(scope="module")
def attitude(logged):
    return attitude_history(logged.imu, 0.002)


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


def refined(
    comparison: ClockComparison, offsets: dict[ClockedSensor, float] | None = None
) -> Refined:
    (evidence,) = weigh_comparisons([comparison])
    return refine(evidence, offsets or {comparison.first: evidence.minima_s[0]})


@pytest.mark.parametrize("seconds", [0.0, 1.0, -0.7])
def test_hull_stands_still_at_the_offset_of_the_imu(logged, attitude, seconds):
    moved = late(logged, ClockedSensor.DVL, -seconds)
    found = refined(compare_hull_turns(moved.dvl, attitude, servo(logged.tray, START_NS), RIG))
    sigma_s = np.sqrt(found.variance)
    assert found.relative_s == pytest.approx(seconds, abs=4 * sigma_s)
    assert sigma_s < 0.1


@pytest.mark.parametrize("seconds", [0.0, 1.0, -0.7])
def test_depth_follows_the_dvl_at_the_offset_of_the_pressure(logged, attitude, seconds):
    moved, joint = late(logged, ClockedSensor.PRESSURE, seconds), servo(logged.tray, START_NS)
    found = refined(compare_depth(logged.dvl, attitude, moved.pressure, joint, RIG))
    sigma_s = np.sqrt(found.variance)
    assert found.relative_s == pytest.approx(seconds, abs=4 * sigma_s)
    assert sigma_s < 0.1


def test_depth_of_late_dvl_is_levelled_by_attitude_of_its_time(logged, attitude):
    """With the attitude of its stamps, the DVL's offset comes out wrong."""
    moved, joint = late(logged, ClockedSensor.DVL, 1.5), servo(logged.tray, START_NS)
    depth = compare_depth(moved.dvl, attitude, logged.pressure, joint, RIG)
    right = refined(depth, {ClockedSensor.DVL: 1.5})
    wrong = refined(depth, {ClockedSensor.PRESSURE: -1.5})
    assert right.relative_s == pytest.approx(-1.5, abs=4 * np.sqrt(right.variance))
    assert abs(wrong.relative_s + 1.5) > abs(right.relative_s + 1.5)


def test_half_a_minute_is_too_short_for_an_offset(logged, attitude):
    few = logged.dvl.t_ns < START_NS + 30 * 10**9
    rows = {
        name: getattr(logged.dvl, name)[few]
        for name in ("t_ns", "velocity", "velocity_sigma", "ranges")
    }
    pings, joint = replace(logged.dvl, **rows), servo(logged.tray, START_NS)
    assert not compare_hull_turns(pings, attitude, joint, RIG).is_enough
    assert not compare_depth(pings, attitude, logged.pressure, joint, RIG).is_enough


@pytest.mark.parametrize("seconds", [0.0, 0.4, -2.0])
def test_images_show_offsets_of_attitude_and_velocity(logged, attitude, motions, seconds):
    early = replace(
        motions,
        first_ns=motions.first_ns - round(seconds * 1e9),
        second_ns=motions.second_ns - round(seconds * 1e9),
    )
    found = refined(compare_turns(early, attitude, servo(logged.tray, START_NS), RIG))
    assert found.relative_s == pytest.approx(seconds, abs=0.02)
    velocities = usable_velocities(logged.dvl, (START_NS, START_NS + 240 * 10**9))
    found = refined(compare_directions(early, velocities, RIG))
    assert found.relative_s == pytest.approx(seconds, abs=0.1)


def test_few_motions_tell_nothing(logged, attitude, motions):
    few = ImageMotions(
        first_ns=motions.first_ns[:5],
        second_ns=motions.second_ns[:5],
        second_from_first=Poses(
            motions.second_from_first.quaternion[:5], motions.second_from_first.translation[:5]
        ),
        sigma_rad=motions.sigma_rad[:5],
    )
    velocities = usable_velocities(logged.dvl, (START_NS, START_NS + 240 * 10**9))
    assert not compare_turns(few, attitude, servo(logged.tray, START_NS), RIG).is_enough
    assert not compare_directions(few, velocities, RIG).is_enough
