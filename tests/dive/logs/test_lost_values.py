# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Values that are written as numbers but stand for lost ones, in whatever way drivers mark them."""

from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon.dive.logs.lost_values import (
    drop_false_beams,
    drop_lost_velocities,
    drop_ranges_at_limit,
    is_false_attitude,
)
from hullrecon.dive.logs.messages.covariance import sigma_of
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.dive.logs.samples import PressureSample
from hullrecon.dive.logs.streams.pressure import PressureModel, pressure_samples
from hullrecon.findings.finding import sentences
from hullrecon.records.clock import NS

COUNT, LOCKLESS = 150, slice(60, 80)
T_NS = (np.arange(COUNT) * 0.2 * NS).astype(np.int64)
LOST_ROWS = np.isin(np.arange(COUNT), np.arange(COUNT)[LOCKLESS])


def survey(speed=0.25, noise=0.003, seed=1):
    """Velocities of a vehicle that goes along, turns about and comes back."""
    along = speed * np.sign(0.501 - np.arange(COUNT) / COUNT)[:, None] * [1.0, 0.0, 0.0]
    return along + noise * np.random.default_rng(seed).standard_normal((COUNT, 3))


def _or_none(ranges, velocity):
    return np.zeros((len(velocity), 0)) if ranges is None else ranges


def lost(velocity, sigma=np.nan, t_ns=T_NS, ranges=None):
    notes = []
    sigmas = np.broadcast_to(np.asarray(sigma, float), len(velocity)).copy()
    found, _ = drop_lost_velocities(
        t_ns, velocity.copy(), sigmas, _or_none(ranges, velocity), notes
    )
    return np.isnan(found).all(axis=1), sentences(notes)


def velocities_without_lock(**how):
    velocity = survey(**how)
    velocity[LOCKLESS] = 0.0
    return velocity


def test_zeros_of_a_moving_vehicle_are_an_outage_that_is_named():
    rows, (line,) = lost(velocities_without_lock())
    assert (rows == LOST_ROWS).all()
    assert "the last 3.8 s later: 20 are exactly zero, unlike those around them" in line


def test_zeros_of_a_slow_vehicle_are_told_by_the_sensors_noise():
    velocity = velocities_without_lock(speed=0.03)
    assert (lost(velocity)[0] == LOST_ROWS).all()
    slow_pings = (np.arange(COUNT) * NS).astype(np.int64)
    assert (lost(velocity, t_ns=slow_pings)[0] == LOST_ROWS).all()


def test_a_velocity_that_a_filter_makes_up_while_no_beam_has_a_range_is_lost():
    velocity, ranges = survey(), np.full((COUNT, 4), 1.5)
    velocity[LOCKLESS] *= np.exp(-np.arange(20) / 4)[:, None]
    ranges[LOCKLESS] = np.nan
    rows, (line,) = lost(velocity, ranges=ranges)
    assert (rows == LOST_ROWS).all()
    assert "20 come while no beam has a range" in line
    ranges[::3] = np.nan  # of an instrument that gives few ranges
    ranges[1::3] = np.nan
    assert not lost(velocity, ranges=ranges)[0].any()


@pytest.mark.parametrize("times", [1, 4])
def test_a_velocity_that_is_held_for_seconds_is_lost_after_the_first(times):
    """Also by a driver that writes each ping several times."""
    velocity = survey()
    velocity[LOCKLESS] = velocity[60]
    t_ns = np.linspace(0, T_NS[-1], COUNT * times).astype(np.int64)
    rows, (line,) = lost(np.repeat(velocity, times, axis=0), t_ns=t_ns)
    expected = np.repeat(LOST_ROWS, times)
    expected[60 * times] = False
    assert (rows == expected).all()
    assert f"{expected.sum()} repeat the last one exactly" in line
    assert not lost(np.repeat(survey(), times, axis=0), t_ns=t_ns)[0].any()


def test_a_simulator_without_noise_may_hold_its_speed():
    assert not lost(survey(noise=0.0))[0].any()


def test_an_attitude_that_is_the_messages_default_amid_others_is_lost():
    heading = np.linspace(1.0, 1.5, 40)
    quaternion = np.stack([0 * heading, 0 * heading, np.sin(heading / 2), np.cos(heading / 2)], 1)
    quaternion[10:15] = 0, 0, 0, 1
    assert np.flatnonzero(is_false_attitude(quaternion)).tolist() == [10, 11, 12, 13, 14]
    through_zero = np.linspace(-0.2, 0.2, 41)
    quaternion = np.stack([0 * through_zero] * 2 + [np.sin(through_zero), np.cos(through_zero)], 1)
    quaternion[20] = 0, 0, 0, 1
    assert not is_false_attitude(quaternion).any()
    assert not is_false_attitude(np.tile([0.0, 0, 0, 1], (9, 1))).any()


def test_a_pressure_of_zero_amid_others_is_lost():
    model, notes = PressureModel(1025.0, 9.81, 101325.0), []
    samples = [PressureSample(k, 0.0 if k in (3, 4) else 121_325.0) for k in range(20)]
    found = pressure_samples(samples, model, notes)
    assert len(found.t_ns) == 18
    assert found.depth.min() > 1.9
    assert "2 of 20 readings lie 6 m or more above the water" in notes[0].sentence


def test_a_vehicle_that_comes_to_rest_is_believed():
    """Of a simulator without noise, and of an instrument that writes whole centimetres a second."""
    fade = np.clip(np.abs(np.arange(COUNT) - 75) / 60 - 0.25, 0, 1)
    at_rest = 0.3 * fade[:, None] * [1.0, 0.2, 0.1]
    assert (at_rest[70:80] == 0).all()
    assert lost(at_rest) == (pytest.approx(np.zeros(COUNT, bool)), [])
    coarse = np.round(at_rest + survey(0.0, 0.002), 2)
    assert not lost(coarse)[0].any()


@pytest.mark.parametrize("mark", [0.5, 1.0, 31.6, 1e3])
def test_a_velocity_with_a_sigma_that_says_nothing_is_lost(mark):
    """Whatever stands in its place: drivers leave the last one."""
    velocity, sigma = survey(), np.full(COUNT, 0.003)
    velocity[LOCKLESS], sigma[LOCKLESS] = velocity[59], mark
    rows, (line,) = lost(velocity, sigma)
    assert (rows == LOST_ROWS).all()
    assert "20 have a sigma of 0.4 m/s or more" in line


def test_a_useless_sigma_of_every_velocity_marks_none_as_lost():
    """Such is a default of the driver; zeros among them are lost all the same."""
    notes = []
    found, sigma = drop_lost_velocities(
        T_NS, velocities_without_lock(), np.full(COUNT, 1.0), np.zeros((COUNT, 0)), notes
    )
    assert (np.isnan(found).all(axis=1) == LOST_ROWS).all()
    assert np.isnan(sigma).all()
    assert "dvl.sigma_velocity was used" in notes[0].sentence


def test_a_beam_that_hears_itself_and_an_altitude_for_all_beams_are_lost():
    comes_and_goes = 1.5 + 0.4 * np.sin(0.1 * np.arange(COUNT))[:, None]
    deaf = comes_and_goes + np.array([0, 0.1, 0.2, 0.3])
    notes = []
    assert np.isfinite(drop_false_beams(deaf, notes)).all()
    assert not notes
    deaf[:, 1] = 0.05 + 0.001 * np.arange(COUNT) / COUNT
    lost_beams = np.isnan(drop_false_beams(deaf, notes)).all(axis=0)
    assert lost_beams.tolist() == [False, True, False, False]
    assert "beam 2 reads 0.05 to 0.05 m" in sentences(notes)[0]
    assert np.isnan(drop_false_beams(comes_and_goes[:, [0] * 4], [])).all()


def test_ranges_at_the_instruments_limit_are_lost():
    ranges = np.random.default_rng(3).normal(2.0, 0.2, (COUNT, 4))
    ranges[LOCKLESS, 1] = 50.0
    notes = []
    found = drop_ranges_at_limit(ranges, notes)
    assert (np.isnan(found[:, 1]) == LOST_ROWS).all()
    assert np.isfinite(found[:, [0, 2, 3]]).all()
    assert "20 ranges are exactly 50 m" in notes[0].sentence
    measured = np.clip(ranges, 0, 2.3)  # a wall that many pings meet at the same distance
    assert np.isfinite(drop_ranges_at_limit(measured, [])).all()


@pytest.mark.parametrize(
    ("variances", "sigma"),
    [
        ((4.0, 4.0, 4.0), 2.0),
        ((0.0, 0.0, 0.0), np.nan),
        ((np.nan, np.nan, np.nan), np.nan),
        ((4.0, 0.0, 4.0), 2.0),
        ((-1.0, 0.0, 0.0), np.inf),
        ((4.0, 4.0, -1.0), np.inf),
        ((np.inf, 1.0, 1.0), np.inf),
    ],
)
def test_a_covariance_says_sigma_nothing_or_lost(variances, sigma):
    for size in (3, 6):
        covariance = np.zeros((size, size))
        covariance[[0, 1, 2], [0, 1, 2]] = variances
        assert sigma_of(covariance.ravel(), (0, 1, 2)) == pytest.approx(sigma, nan_ok=True)


def twist(variance):
    covariance = np.diag([1e-5, 1e-5, variance, 0, 0, 0]).ravel()
    linear = SimpleNamespace(x=0.1, y=0.2, z=0.3)
    return SimpleNamespace(
        twist=SimpleNamespace(covariance=covariance, twist=SimpleNamespace(linear=linear))
    )


def test_one_axis_that_was_not_measured_loses_the_velocity():
    kind = "geometry_msgs/msg/TwistWithCovarianceStamped"
    (good,), (bad,) = (TYPES["dvl"][kind](twist(v), 0, "dvl") for v in (1e-5, -1.0))
    assert good.velocity.tolist() == [0.1, 0.2, 0.3]
    assert np.isnan(bad.velocity).all()


def imu(kit, orientation=(0.0, 0.0, 0.0), rates=0.0):
    message = kit.imu(0)
    message.orientation_covariance = np.diag(orientation).ravel()
    message.angular_velocity_covariance = (np.eye(3) * rates).ravel()
    (sample,) = TYPES["imu"]["sensor_msgs/msg/Imu"](message, 0, "imu")
    return sample


def test_an_attitude_is_lost_where_roll_and_pitch_are_unknown(kit):
    for variances in ((-1.0, 0, 0), (1e6, 1e6, 1e6), (np.inf, 0, 0)):
        assert np.isnan(imu(kit, variances).quaternion).all()
    for variances in ((0, 0, 0), (1e-4, 1e-4, 1e6), (1.0, 1.0, 1.0)):
        assert np.isfinite(imu(kit, variances).quaternion).all()
    assert np.isnan(imu(kit, rates=1e4).rates).all()
    assert np.isfinite(imu(kit, rates=1.0).rates).all()


def test_a_pressure_is_lost_by_its_variance():
    translate = TYPES["pressure"]["sensor_msgs/msg/FluidPressure"]
    for variance, is_lost in (
        (0.0, False),
        (np.nan, False),
        (1e4, False),
        (-1.0, True),
        (1e13, True),
    ):
        message = SimpleNamespace(fluid_pressure=120_000.0, variance=variance)
        (sample,) = translate(message, 0, "pressure")
        assert np.isnan(sample.pascal) == is_lost
