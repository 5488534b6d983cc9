# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.navigation.dead_reckoning.integral import integral
from hullrecon.navigation.dead_reckoning.nodes import choose_nodes, pair_frames
from hullrecon.navigation.dead_reckoning.returns import flag_ranges
from hullrecon.navigation.sensors.servo import doubtful_angles, frozen_readings, servo
from hullrecon.navigation.sensors.smoothing import local_line, running_median
from hullrecon.records.sensors import DvlPings, JointSamples

QUICK = settings(max_examples=30, deadline=None, derandomize=True)

SECOND = 1_000_000_000
NONE = (np.zeros(0, np.int64), np.zeros(0, np.int64))


def stamps(*seconds: float) -> np.ndarray:
    return np.round(np.array(seconds) * SECOND).astype(np.int64)


def rows(t_ns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return t_ns, np.arange(len(t_ns))


def pings(ranges: np.ndarray, hz: float = 5.0) -> DvlPings:
    n = len(ranges)
    return DvlPings(
        t_ns=stamps(*(np.arange(n) / hz)),
        velocity=np.zeros((n, 3)),
        velocity_sigma=np.ones(n),
        ranges=ranges,
        beams=np.tile([0.0, 0, 1], (ranges.shape[1], 1)),
    )


# smoothing


@QUICK
@given(slope=st.floats(-5, 5), level=st.floats(-5, 5), seed=st.integers(0, 99))
def test_a_straight_trend_passes_unchanged_to_the_ends(
    slope: float, level: float, seed: int
) -> None:
    t = np.sort(np.random.default_rng(seed).uniform(0, 30, 200))
    value, rate = local_line(t, level + slope * t, np.array([t[0], 12.0, t[-1]]), 2.0)
    assert np.allclose(
        value[:, 0], level + slope * np.array([t[0], 12.0, t[-1]]), atol=0.02 * abs(slope) + 1e-9
    )
    assert np.allclose(rate, slope, atol=1e-6)


def test_white_noise_shrinks_as_the_window_holds_samples() -> None:
    t = np.arange(0, 200, 0.1)
    value, _ = local_line(t, np.random.default_rng(1).standard_normal(len(t)), t[200:-200], 3.0)
    assert np.std(value) == pytest.approx(np.sqrt(0.1 / (2 * np.sqrt(np.pi) * 3.0)), rel=0.2)


def test_a_long_gap_is_joined_by_a_line() -> None:
    t = np.concatenate([np.arange(0, 10, 0.1), np.arange(100, 110, 0.1)])
    value, _ = local_line(t, np.where(t < 50, 1.0, 3.0), np.array([55.0]), 1.0)
    assert value[0, 0] == pytest.approx(2.0, abs=0.05)


def test_smoothing_across_a_gap_of_months_needs_little_memory() -> None:
    t = np.arange(0, 20, 0.02)
    both = np.concatenate([t - 200 * 86400.0, t])
    tracemalloc.start()
    value, rate = local_line(both, np.sin(both), t, 0.5)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    alone = local_line(t, np.sin(t), t, 0.5)
    np.testing.assert_allclose(value, alone[0], atol=1e-3)  # bins are counted from another start
    np.testing.assert_allclose(rate, alone[1], atol=1e-2)
    assert peak < 2e6


def test_the_running_median_forgives_a_spike_and_a_missing_value() -> None:
    values = np.array([1.0, 1.1, 9.0, np.nan, 1.2, 1.3, 1.4])[:, None]
    assert np.allclose(running_median(values, 5)[2:5, 0], [1.15, 1.25, 1.35])


# integral


def test_integral_of_linear_signal_is_exact_between_samples() -> None:
    t = np.array([0.0, 0.5, 2.0, 3.0])
    total = integral(t, 2 * t)
    assert np.allclose(total.at(np.array([0.0, 0.25, 1.0, 3.0])), [0, 0.0625, 1.0, 9.0])


def test_beyond_its_ends_a_signal_holds_its_last_value() -> None:
    total = integral(np.array([0.0, 1.0]), np.array([[1.0], [3.0]]))
    assert np.allclose(total.at(np.array([-1.0, 2.0]))[:, 0], [-1.0, 2.0 + 3.0])


# servo


def test_servo_direction_flips_at_turning_point_not_on_flicker() -> None:
    travel = np.radians(np.concatenate([np.arange(0, 5, 0.2), np.arange(5, 2, -0.2)]))
    angle = travel + np.radians(0.02) * np.sin(40 * np.arange(len(travel)))
    found = servo(JointSamples(t_ns=stamps(*np.arange(len(angle))), angle=angle), 0)
    assert found.direction[:25].tolist() == [1.0] * 25
    assert found.direction[27:].tolist() == [-1.0] * (len(angle) - 27)


def test_a_tray_that_stands_still_keeps_its_direction() -> None:
    angle = np.radians(np.concatenate([np.arange(5, 2, -0.5), np.full(20, 2.0)]))
    found = servo(JointSamples(t_ns=stamps(*np.arange(len(angle))), angle=angle), 0)
    assert (found.direction == -1).all()
    assert found.angle_at(stamps(0.5))[0] == pytest.approx(np.radians(4.75))


@pytest.mark.parametrize(
    ("angle_deg", "unit", "said"),
    [
        (np.zeros(100), "rad", ["tray-still"]),
        (np.radians(20 * np.sin(0.1 * np.arange(100))), "deg", ["tray-little"]),
        (20 * np.sin(0.1 * np.arange(100)), "deg", []),
        (0.05 * np.random.default_rng(1).standard_normal(100), "deg", []),  # held in place
        (np.where(np.arange(100) < 50, 0.1, 0.2), "deg", []),  # and by a coarse encoder
    ],
)
def test_zeros_and_radians_as_degrees_are_doubted(angle_deg, unit, said) -> None:
    tray = JointSamples(t_ns=stamps(*np.arange(100)), angle=np.radians(angle_deg))
    assert [one.code for one in doubtful_angles(tray, unit, np.radians(0.8))] == said


def test_angles_that_a_driver_repeats_are_told_from_a_servo_at_rest() -> None:
    rest = np.repeat([0.1, 0.3, 0.2], [40, 1, 60])
    rest[38:43] = np.linspace(0.1, 0.2, 5)
    noise = 0.002 * np.random.default_rng(1).standard_normal(len(rest))
    stuck = np.where(np.arange(len(rest)) < 50, rest + noise, 0.15)
    assert not frozen_readings(rest).any()
    assert not frozen_readings(rest + noise).any()
    assert np.flatnonzero(frozen_readings(stuck)).tolist() == list(range(51, len(rest)))


def test_a_tray_that_was_not_logged_stands_at_zero() -> None:
    assert servo(None, 5).angle_at(stamps(1, 2)).tolist() == [0, 0]


# nodes


def test_frames_pair_by_nearest_stamp_within_half_a_period() -> None:
    top, bottom = stamps(0, 1, 2, 3), stamps(0.1, 1.6, 2.9)
    assert pair_frames(top, bottom).tolist() == [[0, 0], [2, 1], [3, 2]]
    assert pair_frames(top, stamps(10, 11)).tolist() == []


def test_nodes_stand_at_frames_and_at_pings_far_from_any() -> None:
    frames, dvl = stamps(10, 11), stamps(*np.arange(7, 14, 0.2))
    nodes = choose_nodes(rows(frames), NONE, dvl, (0, 100 * SECOND))
    t = nodes.t_ns / SECOND
    assert {10.0, 11.0} <= set(t.tolist())
    extra = t[(nodes.image < 0).all(axis=1)]
    assert (np.abs(extra[:, None] - [10, 11]).min(axis=1) > 1.0).all()
    assert np.diff(extra[extra < 8.7]).min() > 0.3
    assert (np.diff(t) > 0).all()


def test_a_lower_frame_without_partner_has_its_own_node() -> None:
    nodes = choose_nodes(
        rows(stamps(1, 2)), rows(stamps(1.01, 2.01, 2.5)), stamps(), (0, 9 * SECOND)
    )
    assert nodes.image.tolist() == [[0, 0], [1, 1], [-1, 2]]
    assert nodes.unpaired == 1


def test_frames_outside_the_log_of_navigation_get_no_node() -> None:
    nodes = choose_nodes(rows(stamps(1, 4, 30)), NONE, stamps(1, 2.5, 4), (0, 5 * SECOND))
    assert nodes.t_ns.tolist() == stamps(1, 2.5, 4).tolist()
    assert nodes.outside == 1


def test_without_cameras_nodes_are_thinned_pings() -> None:
    nodes = choose_nodes(NONE, NONE, stamps(*np.arange(0, 10, 0.2)), (0, 99 * SECOND))
    assert 24 <= len(nodes.t_ns) <= 29
    assert (nodes.image == -1).all()


# returns


def test_return_half_a_metre_off_is_flagged_alone() -> None:
    ranges = 1.5 + 0.01 * np.random.default_rng(3).standard_normal((100, 4))
    ranges[40, 2] += 0.6
    flagged = flag_ranges(pings(ranges), 0.01, sigmas=50.0)
    assert np.argwhere(flagged).tolist() == [[40, 2]]


def test_a_return_five_sigma_off_is_flagged() -> None:
    ranges = np.full((60, 1), 1.5)
    ranges[30] += 0.06
    assert np.argwhere(flag_ranges(pings(ranges), 0.01)).tolist() == [[30, 0]]
    ranges[30] = 1.54
    assert not flag_ranges(pings(ranges), 0.01).any()


def test_lost_beams_are_never_flagged() -> None:
    ranges = np.full((60, 2), 1.5)
    ranges[10:20, 0], ranges[25:27, 1] = np.nan, np.nan
    assert not flag_ranges(pings(ranges), 0.01).any()


def test_a_slope_is_not_an_outlier() -> None:
    ranges = (1.5 + 0.3 * np.arange(60) / 5)[:, None]
    assert not flag_ranges(pings(ranges), 0.01)[8:-8].any()
