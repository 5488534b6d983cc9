# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Times of readings: nearest stamps, periods, gaps and silences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hullrecon.records.clock import (
    NS,
    describe_silence,
    format_time,
    gaps,
    nearest,
    period,
    rate_hz,
    seconds_to_nearest,
    silent_spans,
    unread_s,
)


def stamps(t_s) -> np.ndarray:
    return np.round(np.asarray(t_s, float) * NS).astype(np.int64)


TWICE = stamps(np.r_[5:10:0.5, 20:30:0.5])  # twice a second, from 5 to 9.5 s and from 20 to 29.5 s


@given(st.lists(st.integers(0, 1000), min_size=1, max_size=20, unique=True), st.integers(-50, 1050))
def test_nearest_stamp_has_least_distance(values: list[int], wanted: int) -> None:
    table = np.sort(np.array(values, np.int64))
    found = nearest(table, np.array([wanted], np.int64))[0]
    assert abs(table[found] - wanted) == np.abs(table - wanted).min()


def test_without_stamps_the_nearest_is_infinitely_far() -> None:
    assert np.isinf(seconds_to_nearest(stamps([]), stamps([1]))).all()
    assert seconds_to_nearest(stamps([0, 4]), stamps([1, 3.5])).tolist() == [1.0, 0.5]


def test_gaps_are_steps_longer_than_allowed() -> None:
    assert gaps(stamps([0, 0.2, 1.5, 1.7]), 0.6).tolist() == [stamps([0.2, 1.5]).tolist()]
    assert gaps(stamps([0, 0.2]), 0.6).shape == (0, 2)


def bursts(t_s, latency_s=0.016):
    """Return the stamps of readings that an adapter hands on every 16 ms, 50 us apart."""
    handed_on = np.ceil(t_s / latency_s)
    first = np.searchsorted(handed_on, handed_on)
    return handed_on * latency_s + 50e-6 * (np.arange(len(t_s)) - first)


def test_rate_counts_readings_without_holes():
    assert rate_hz(stamps([0, 0.1, 0.2, 5])) == pytest.approx(10.0, rel=1e-9)
    assert rate_hz(stamps([0, 0.1, 0.3, 0.4])) == pytest.approx(7.5, rel=1e-9)
    assert rate_hz(stamps([1])) == 0.0
    even = np.arange(2000) / 200
    assert rate_hz(stamps(bursts(even))) == pytest.approx(200, rel=0.01)
    assert rate_hz(stamps(bursts(np.arange(300) / 30, latency_s=0.1))) == pytest.approx(
        30, rel=0.01
    )


def test_period_of_bursts_is_mean_step():
    even = np.arange(2000) / 200
    assert period(even) == pytest.approx(0.005)
    assert period(bursts(even)) == pytest.approx(0.005, rel=0.01)
    with_hole = np.where(even > 5, even + 100, even)
    assert period(with_hole) == pytest.approx(0.005)
    assert period(bursts(with_hole)) == pytest.approx(0.005, rel=0.02)
    assert period(np.array([0.0, 3.0])) == 3.0


def test_stamp_beyond_calendar_is_shown_in_seconds():
    assert format_time(2**62) == "4611686018.427 s" or format_time(2**62).startswith("2116-")
    assert format_time(-(2**62)).startswith(("-", "18"))


def test_time_before_first_and_after_last_reading_is_silent() -> None:
    assert (silent_spans(TWICE, 0, 40 * NS) / NS).tolist() == [[0, 5], [9.5, 20], [29.5, 40]]


def test_silent_spans_end_where_the_path_does() -> None:
    assert (silent_spans(TWICE, 6 * NS, 15 * NS) / NS).tolist() == [[9.5, 15]]


def test_slow_sensor_is_not_silent_between_readings() -> None:
    assert not len(silent_spans(stamps([0, 3, 6, 9, 20]), 0, 20 * NS))


def test_unread_time_counts_to_the_nearer_reading() -> None:
    assert unread_s(TWICE, stamps([0, 7.1, 12, 19, 24, 34.5])) == pytest.approx(
        [5, 0, 2.5, 1, 0, 5]
    )


def test_single_reading_is_a_sensor_that_fell_silent() -> None:
    assert unread_s(stamps([3]), stamps([0, 3, 10])) == pytest.approx([3, 0, 7])


def test_silence_is_described_with_its_share_of_the_path() -> None:
    described = describe_silence(TWICE, stamps([0, 20, 40]))
    assert described == "no reading for 26.0 s of the path's 40.0 (the longest silence 10.5 s)"
    assert describe_silence(TWICE, stamps([21, 29])) == ""
