# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Attitude, velocities and depth, each by itself: what is kept, what is bridged and how sure each
is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.rotations import cross_matrix
from hullrecon.navigation.dead_reckoning.odometry import velocity_variance
from hullrecon.navigation.dead_reckoning.reckoning import reckon
from hullrecon.navigation.sensors.attitude import (
    BRIDGED_RATE_RAD_S,
    LEAST_SIGMA_RAD,
    AttitudeHistory,
    attitude_history,
)
from hullrecon.navigation.sensors.depth import hold_to_pressure
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.sensors.velocity import Agitation, Velocities, usable_velocities
from hullrecon.records.sensors import DvlPings, ImuSamples, PressureSamples

SECOND = 1_000_000_000
NO_HOLES = np.zeros((0, 2), np.int64)


def stamps(t_s: np.ndarray) -> np.ndarray:
    return np.round(np.asarray(t_s) * SECOND).astype(np.int64)


# attitude


def imu(
    seed: int = 0, white_rad: float = 0.002, bias: float = 0.0, n: int = 2000
) -> tuple[ImuSamples, Rotation]:
    """A heading that swings at 50 Hz: noisy orientations, rates with a bias; and the truth."""
    t = np.arange(n) / 50
    truth = Rotation.from_euler(
        "xyz", np.stack([0.05 * np.sin(t), 0 * t, 0.4 * np.sin(0.3 * t)], axis=1)
    )
    h = 1e-4
    later = Rotation.from_euler(
        "xyz", np.stack([0.05 * np.sin(t + h), 0 * t, 0.4 * np.sin(0.3 * (t + h))], axis=1)
    )
    rates = (truth.inv() * later).as_rotvec() / h + bias
    noise = Rotation.from_rotvec(white_rad * np.random.default_rng(seed).standard_normal((n, 3)))
    return ImuSamples(
        t_ns=stamps(t),
        quaternion=(truth * noise).as_quat(),
        angular_velocity=rates,
        acceleration=np.zeros((n, 3)),
    ), truth


def departure(history: AttitudeHistory, record: ImuSamples, truth: Rotation) -> np.ndarray:
    return (truth.inv() * history.rotation(record.t_ns)).as_rotvec()


def test_fused_attitude_error_matches_sigma_and_beats_readings() -> None:
    record, truth = imu()
    history = attitude_history(record, 0.01, 0.5)
    error = departure(history, record, truth)[200:-200]
    assert history.fused
    assert np.std(error) < 0.3 * 0.002
    assert 0.3 < np.std(error) / history.sigma_rad < 3


def test_a_bias_of_the_rates_does_not_turn_the_attitude() -> None:
    error = [
        departure(attitude_history(r, 0.01, 0.5), r, t)[200:-200]
        for r, t in (imu(), imu(bias=0.01))
    ]
    assert np.abs(error[1] - error[0]).max() < 3e-4


def test_without_rates_the_readings_stand_as_they_are() -> None:
    record, _ = imu()
    silent = replace(record, angular_velocity=np.full_like(record.angular_velocity, np.nan))
    history = attitude_history(silent, 0.01, 0.5)
    assert not history.fused
    assert history.sigma_rad == 0.01
    assert np.array_equal(history.quaternion, record.quaternion)


def history(
    fused: bool, walk: float = 1e-8, holes: np.ndarray = NO_HOLES, sigma: float = 0.001
) -> AttitudeHistory:
    return AttitudeHistory(
        stamps([0, 100]), np.tile([0, 0, 0, 1.0], (2, 1)), sigma, walk, holes, fused
    )


def test_turn_variance_is_rate_walk_up_to_two_attitudes() -> None:
    (short,) = history(True).turn_variance(stamps([0]), stamps([0.1]))
    (long,) = history(True, walk=1e-5).turn_variance(stamps([0]), stamps([100]))
    assert short == pytest.approx(1e-9 + LEAST_SIGMA_RAD**2, rel=1e-3)
    assert long == pytest.approx(2e-6 + LEAST_SIGMA_RAD**2)
    assert history(False).turn_variance(stamps([0]), stamps([0.1]))[0] == pytest.approx(
        2e-6 + LEAST_SIGMA_RAD**2
    )


def test_attitude_variance_grows_beyond_the_readings() -> None:
    """At 0.05 rad/s for seconds, then as a walk: to the square root of the time."""
    ends = history(True)
    sigma = ends.unread_sigma(stamps([-64, -2, 50, 102, 164]))
    assert sigma == pytest.approx([0.8, 0.1, 0, 0.1, 0.8])
    variance = ends.turn_variance(
        stamps([100, 110, -20, 40, -64]), stamps([102, 120, -10, 60, 164])
    )
    assert variance == pytest.approx([0.01, 0.1, 0.1, 0, 1.28], abs=3e-6)


def test_a_turn_across_a_hole_is_as_unsure_as_the_hole_is_long() -> None:
    holed = history(True, holes=np.array([stamps([10, 12])]))
    out, part, whole = holed.turn_variance(stamps([5, 11, 9]), stamps([6, 15, 15]))
    assert out < 1e-6
    assert part == pytest.approx((BRIDGED_RATE_RAD_S * 1.0) ** 2, rel=0.01)
    assert whole == pytest.approx((BRIDGED_RATE_RAD_S * 2.0) ** 2, rel=0.01)


def test_attitude_between_two_readings_is_on_the_shortest_turn() -> None:
    ends = Rotation.from_euler("z", [[0.0], [0.2]])
    between = replace(history(False), quaternion=ends.as_quat()).rotation(stamps([25.0]))
    assert between.as_rotvec()[0] == pytest.approx([0, 0, 0.05])


# velocity


def pings(velocity: np.ndarray, hz: float = 5.0) -> DvlPings:
    n = len(velocity)
    return DvlPings(
        t_ns=stamps(np.arange(n) / hz),
        velocity=velocity,
        velocity_sigma=np.full(n, 0.003),
        ranges=np.ones((n, 4)),
        beams=np.eye(4)[:, :3],
    )


ALWAYS = (-(10**18), 10**18)


def test_lost_velocities_and_those_without_attitude_are_dropped() -> None:
    velocity = np.tile([0.2, 0, 0], (50, 1))
    velocity[20] = np.nan
    record = pings(velocity)
    record.velocity_sigma[30] = 0.0
    found = usable_velocities(record, (int(record.t_ns[5]), int(record.t_ns[44])))
    assert (
        found.t_ns.tolist() == record.t_ns[[k for k in range(5, 45) if k not in (20, 30)]].tolist()
    )


def test_a_jump_is_a_stray_and_a_steady_acceleration_is_none() -> None:
    velocity = np.column_stack([0.02 * np.arange(60), np.zeros((60, 2))])
    assert len(usable_velocities(pings(velocity), ALWAYS).outliers) == 0
    velocity[25, 1] += 0.4
    found = usable_velocities(pings(velocity), ALWAYS)
    assert found.outliers.tolist() == [5 * SECOND]
    assert len(found.t_ns) == 59


def pausing(hz: float, pause_s: float) -> np.ndarray:
    """Velocities of a vehicle that goes at 0.35 m/s and pauses every 20 s; it stops, and goes on,
    within half a second.
    """
    since = np.mod(np.arange(round(60 * hz)) / hz - 10.0, 20.0)
    along = 0.35 * np.clip(np.maximum(1 - since / 0.5, (since - pause_s) / 0.5), 0, 1)
    return np.column_stack([along, np.zeros((len(along), 2))])


@pytest.mark.parametrize(
    ("hz", "pause_s"), [(1.0, 1.0), (1.0, 4.0), (2.0, 1.0), (2.0, 2.0), (3.0, 1.5), (5.0, 1.5)]
)
def test_a_stop_is_no_stray_however_slow_the_dvl(hz: float, pause_s: float) -> None:
    assert len(usable_velocities(pings(pausing(hz, pause_s), hz), ALWAYS, 1.5).outliers) == 0


@pytest.mark.parametrize(("hz", "jump_m_s"), [(0.5, 1.3), (1.0, 0.8), (2.0, 0.4), (8.0, 0.4)])
def test_a_single_jump_is_a_stray_however_slow_the_dvl(hz: float, jump_m_s: float) -> None:
    velocity = np.tile([0.3, 0.0, 0.0], (40, 1))
    velocity[20, 1] += jump_m_s
    found = usable_velocities(pings(velocity, hz), ALWAYS, 3.0)
    assert found.outliers.tolist() == stamps([20 / hz]).tolist()


@pytest.mark.parametrize("hz", [5.0, 8.0, 20.0])
def test_a_usual_dvl_is_compared_with_the_median_of_nine_pings(hz: float) -> None:
    velocity = np.tile([0.3, 0.0, 0.0], (40, 1))
    velocity[20:24, 1] += 0.4
    assert len(usable_velocities(pings(velocity, hz), ALWAYS, 1.5).outliers) == 4
    velocity[24, 1] += 0.4
    assert len(usable_velocities(pings(velocity, hz), ALWAYS, 1.5).outliers) == 0


WALK = Agitation(lag_s=np.array([1.0]), rate=np.array([0.01]))


def test_outage_variance_is_shared_by_overlap_with_interval() -> None:
    v = Velocities(
        t_ns=stamps([0, 10]),
        velocity=np.zeros((2, 3)),
        sigma=np.ones(2),
        outages=np.array([stamps([2, 6])]),
        agitation=WALK,
        outliers=np.zeros(0, np.int64),
    )
    whole, half, none = v.bridged_variance(stamps([0, 4, 7]), stamps([9, 9, 9]))
    assert whole == pytest.approx(0.01 * 4**3 / 12)
    assert half == pytest.approx(whole / 2)
    assert none == 0


def test_variance_beyond_velocities_matches_a_free_random_walk() -> None:
    """A velocity that walks from zero, at 0.01 m2/s3: against 4,000 such walks."""
    v = Velocities(
        t_ns=stamps([0, 10]),
        velocity=np.zeros((2, 3)),
        sigma=np.ones(2),
        outages=np.zeros((0, 2), np.int64),
        agitation=WALK,
        outliers=np.zeros(0, np.int64),
    )
    walked = (
        0.1
        * np.random.default_rng(1).normal(0, 0.1, (4000, 600)).cumsum(axis=1).cumsum(axis=1)
        * np.sqrt(0.01 / 0.1)
    )
    after, later, before, across, inside = v.bridged_variance(
        stamps([10, 13, -6, -6, 2]), stamps([16, 16, 0, 16, 8])
    )
    assert after == pytest.approx(float(walked[:, 59].var()), rel=0.1)
    assert later == pytest.approx(after - 0.01 * 3**3 / 3)
    assert before == pytest.approx(after)
    assert across == pytest.approx(2 * after)
    assert inside == 0


def test_a_vehicle_that_darts_about_has_a_wider_bridge() -> None:
    t = np.arange(200) / 5
    calm, wild = (np.column_stack([a * np.sin(2 * t), 0 * t, 0 * t]) for a in (0.01, 0.3))
    rate = [float(usable_velocities(pings(v), ALWAYS).agitation.over(1.0)) for v in (calm, wild)]
    assert rate[0] < 3e-4
    assert rate[1] > 100 * rate[0]


def test_agitation_grows_with_lag_for_a_swing_not_a_walk() -> None:
    """A walk of 0.002 m2/s3 on one axis; a swing of 0.3 m/s in a minute hardly changes in a second,
    wholly in half a minute.
    """
    rng, t = np.random.default_rng(2), np.arange(20_000) / 5
    nothing = np.zeros((len(t), 2))
    walk = np.column_stack([np.cumsum(rng.normal(0, np.sqrt(0.002 / 5), len(t))), nothing])
    swing = np.column_stack([0.3 * np.sin(2 * np.pi * t / 60), nothing]) + rng.normal(
        0, 0.003, (len(t), 3)
    )
    of_walk, of_swing = (
        usable_velocities(pings(v), ALWAYS).agitation.over(np.array([1, 8, 30]))
        for v in (walk, swing)
    )
    assert of_walk == pytest.approx([0.002] * 3, rel=0.25)
    assert of_swing == pytest.approx(
        [0.3**2 * (1 - np.cos(2 * np.pi * s / 60)) / s for s in (1, 8, 30)], rel=0.25
    )


# a path of one's own making: straight ahead and level


def straight(rig, speed: float = 0.2, down: float = 0.0, duration_s: float = 60.0):
    """The vehicle swims along x of g; the DVL looks forward, so its z is the vehicle's x and its x
    is up.
    """
    n = int(duration_s * 5)
    mount = rig.tray_from_dvl.rotation.as_matrix()[0]
    velocity = np.tile(mount.T @ [speed, 0.0, down], (n, 1))
    level = AttitudeHistory(
        stamps([-1, duration_s + 1]), np.tile([0, 0, 0, 1.0], (2, 1)), 1e-3, 0.0, NO_HOLES, False
    )
    return reckon(usable_velocities(pings(velocity), ALWAYS), level, servo(None, 0), rig)


def test_a_straight_run_is_as_long_as_its_speed_and_time_say(rig) -> None:
    at = straight(rig, 0.25).at(stamps([0, 10, 30]))
    assert np.allclose(
        np.diff(at.poses().translation, axis=0), [[2.5, 0, 0], [5.0, 0, 0]], atol=1e-12
    )


def test_velocity_noise_grows_with_time_and_ping_period(rig) -> None:
    path = straight(rig)
    short, long = velocity_variance(path, stamps([10, 10]), stamps([11, 20]))
    assert short == pytest.approx(0.003**2 * 0.2 * 1.0)
    assert long == pytest.approx(10 * short)


def test_a_cross_matrix_gives_the_cross_product() -> None:
    v, w = np.random.default_rng(0).standard_normal((2, 7, 3))
    assert np.allclose(np.einsum("nij,nj->ni", cross_matrix(v), w), np.cross(v, w))


# depth


def readings(depth: np.ndarray, hz: float = 10.0) -> PressureSamples:
    return PressureSamples(t_ns=stamps(np.arange(len(depth)) / hz), depth=depth)


def held(rig, depth: np.ndarray, at_s, **path):
    reckoned = straight(rig, **path)
    nodes = stamps(at_s)
    found = hold_to_pressure(readings(depth), reckoned, nodes, 0.2)
    z = reckoned.at(nodes).poses().translation[:, 2] + found.shift
    return found, z + rig.pressure_origin[2]


def test_the_sensor_stands_where_the_pressure_says(rig) -> None:
    found, depth = held(rig, np.full(600, 3.0), [10, 30, 50])
    assert np.allclose(depth, 3.0, atol=1e-9)
    assert np.allclose(found.measured, 3.0, atol=1e-9)
    assert (found.sigma == 1e-3).all()
    assert len(found.steps) == 0


def test_pressure_scatter_is_smoothed_and_its_sigma_reported(rig) -> None:
    noise = 0.02 * np.random.default_rng(1).standard_normal(600)
    found, depth = held(rig, 3.0 + noise, np.arange(10, 50, 0.5))
    assert np.abs(depth - 3.0).max() < 0.012
    assert found.white == pytest.approx(0.02, rel=0.15)
    assert found.sigma == pytest.approx(0.02 * np.sqrt(0.1 / (2 * np.sqrt(np.pi) * 5)), rel=0.15)


def test_depth_in_dvl_outage_follows_pressure_with_its_sigma(
    rig,
) -> None:
    def true(at_s):  # down by a metre and up again, unheard
        return 3.0 + 0.5 * (1 - np.cos(2 * np.pi * np.clip(at_s - 20, 0, 20) / 20))

    t_s, heard_s = np.arange(600) / 10, np.arange(0, 60, 0.2)
    heard = (heard_s < 20) | (heard_s > 40)
    mount = rig.tray_from_dvl.rotation.as_matrix()[0]
    every = pings(np.tile(mount.T @ [0.2, 0.0, 0.0], (300, 1)))
    parts = {
        name: getattr(every, name)[heard]
        for name in ("t_ns", "velocity", "velocity_sigma", "ranges")
    }
    some = DvlPings(**parts, beams=every.beams)
    level = AttitudeHistory(
        stamps([-1, 61]), np.tile([0, 0, 0, 1.0], (2, 1)), 1e-3, 0.0, NO_HOLES, False
    )
    path = reckon(usable_velocities(some, ALWAYS), level, servo(None, 0), rig)
    nodes_s = np.arange(2, 58, 0.5)
    noise = 0.02 * np.random.default_rng(3).standard_normal(600)
    found = hold_to_pressure(readings(true(t_s) + noise), path, stamps(nodes_s), 0.2)
    z = path.at(stamps(nodes_s)).poses().translation[:, 2] + found.shift + rig.pressure_origin[2]
    error, silent = z - true(nodes_s), (nodes_s > 20) & (nodes_s < 40)
    assert (np.abs(error) < 4 * found.sigma).all()
    assert np.abs(error[~silent]).max() < 0.01
    assert (
        np.median(found.sigma[~silent])
        < 0.003
        < 0.005
        < found.sigma[silent].min()
        < found.sigma.max()
        < 0.03
    )


def test_a_dvl_of_a_ping_a_second_is_not_silent_between_two(rig) -> None:
    mount = rig.tray_from_dvl.rotation.as_matrix()[0]
    slow = usable_velocities(
        pings(np.tile(mount.T @ [0.2, 0.0, 0.0], (60, 1)), hz=1.0), ALWAYS, 0.6
    )
    level = AttitudeHistory(
        stamps([-1, 61]), np.tile([0, 0, 0, 1.0], (2, 1)), 1e-3, 0.0, NO_HOLES, False
    )
    noise = 0.02 * np.random.default_rng(4).standard_normal(590)
    nodes = stamps(np.arange(10, 50, 0.5))
    found = hold_to_pressure(
        readings(3.0 + noise), reckon(slow, level, servo(None, 0), rig), nodes, 0.2
    )
    assert len(slow.outages) == 59
    assert found.sigma.max() < 0.002


def test_a_dvl_that_sinks_is_held_to_the_pressure_without_lag(rig) -> None:
    _, depth = held(rig, np.full(600, 3.0), [20, 40], down=0.02)
    assert np.allclose(depth, 3.0, atol=1e-6)


def test_a_step_that_the_dvl_did_not_see_is_named(rig) -> None:
    depth = np.full(600, 3.0)
    depth[300:] += 0.8
    assert held(rig, depth, [10])[0].steps.tolist() == [30 * SECOND]


def test_lost_readings_are_left_out(rig) -> None:
    depth = np.full(600, 3.0)
    depth[100:150] = np.nan
    assert np.allclose(held(rig, depth, [12.0])[1], 3.0)
