# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where a sensor was silent."""

import numpy as np
import pytest

from hullrecon.navigation.sensors.silence import describe_silence, silent_spans, unread_s

SECOND = 10**9


def stamps(t_s) -> np.ndarray:
    return (np.asarray(t_s, float) * SECOND).astype(np.int64)


TWICE = stamps(np.r_[5:10:0.5, 20:30:0.5])  # twice a second, from 5 to 9.5 s and from 20 to 29.5 s


def test_the_time_before_the_first_and_after_the_last_reading_is_silent_too() -> None:
    assert (silent_spans(TWICE, 0, 40 * SECOND) / SECOND).tolist() == [
        [0, 5],
        [9.5, 20],
        [29.5, 40],
    ]


def test_spans_end_where_the_path_does() -> None:
    assert (silent_spans(TWICE, 6 * SECOND, 15 * SECOND) / SECOND).tolist() == [[9.5, 15]]


def test_a_slow_sensor_is_not_silent_between_two_readings() -> None:
    assert not len(silent_spans(stamps([0, 3, 6, 9, 20]), 0, 20 * SECOND))


def test_an_instant_is_as_far_from_what_was_read_as_the_nearer_reading() -> None:
    assert unread_s(TWICE, stamps([0, 7.1, 12, 19, 24, 34.5])) == pytest.approx(
        [5, 0, 2.5, 1, 0, 5]
    )


def test_a_single_reading_is_a_sensor_that_fell_silent() -> None:
    assert unread_s(stamps([3]), stamps([0, 3, 10])) == pytest.approx([3, 0, 7])


def test_silence_is_told_with_its_share_of_the_path() -> None:
    told = describe_silence(TWICE, stamps([0, 20, 40]))
    assert told == "no reading for 26.0 s of the path's 40.0 (the longest silence 10.5 s)"
    assert describe_silence(TWICE, stamps([21, 29])) == ""
