# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import re

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hullrecon.dive.logs.timeline import describe_ends, describe_gaps, put_in_order
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences
from hullrecon.records.clock import NS


def ns(*seconds):
    return np.round(np.array(seconds) * NS).astype(np.int64)


def test_rows_in_order_stay_and_nothing_is_said():
    line = put_in_order("imu", ns(0, 1, 2), ns(0, 1, 2))
    assert line.keep.tolist() == [0, 1, 2]
    assert sentences(line.notes) == []


def test_rows_out_of_order_are_sorted_and_counted():
    line = put_in_order("imu", ns(0, 0.2, 0.1, 0.3), ns(0, 0.1, 0.2, 0.3))
    assert line.keep.tolist() == [0, 2, 1, 3]
    assert sentences(line.notes) == ["imu: 1 readings stood out of order and were sorted"]


@pytest.mark.parametrize("step_s", [10, 0.01, 0.25])
def test_stamps_in_steps_of_seconds_are_refused_until_finer(step_s):
    read_s = 1_777_887_000 + 0.1 * np.arange(400)
    stamp = ns(*(np.floor(read_s / step_s) * step_s))
    if step_s < 1:
        assert len(put_in_order("imu", stamp, stamp, spread=True).keep) >= 160
        return
    with pytest.raises(InputError, match=r"400 readings have only 4 stamps, 10 s apart") as refused:
        put_in_order("imu", stamp, stamp, spread=True)
    assert "all their digits" in refused.value.remedy


def test_of_duplicate_stamps_the_first_stays():
    line = put_in_order("imu", ns(0, 1, 1, 1, 2), ns(0, 1, 2, 3, 4) // 10)
    assert line.keep.tolist() == [0, 1, 4]
    assert any("2 of 5 stamps are duplicates" in note for note in sentences(line.notes))


def test_clock_jump_is_noted_with_size_and_time():
    (words,) = sentences(put_in_order("dvl", ns(0, 1, 2, 12.5, 13.5), ns(0, 1, 2, 3, 4)).notes)
    assert "jumps by +9.500 s at 1970-01-01T00:00:02.000Z" in words


def test_a_clock_that_falls_back_is_named_without_a_logger_too():
    stamps = ns(10, 11, 12, 5, 6)
    (words,) = sentences(put_in_order("dvl", stamps, stamps).notes)
    assert "jumps by -7.000 s" in words


def test_clock_set_back_is_corrected_without_logger_clock():
    true = np.arange(0, 30, 0.1)
    stamps = ns(*np.where(true >= 15, true - 2.03, true))
    line = put_in_order("dvl", stamps, stamps)
    assert line.keep.tolist() == list(range(300))
    np.testing.assert_allclose(line.t_ns / NS, true, atol=1e-6)
    assert len(sentences(line.notes)) == 1
    assert "jumps by -1.930 s" in sentences(line.notes)[0]
    assert "150 stamps were put right as if it had been set back" in sentences(line.notes)[0]


def test_clock_of_local_time_falls_back_by_an_hour_amid_the_dive():
    true = np.arange(10_000, 10_030, 0.1)
    stamps = ns(*np.where(true >= 10_015, true - 3600, true))
    line = put_in_order("dvl", stamps, stamps)
    np.testing.assert_allclose(line.t_ns / NS, true, atol=1e-6)


def test_a_step_back_by_less_than_a_second_mixes_no_two_times():
    true = np.arange(0, 30, 0.1)
    stamps = ns(*np.where(true >= 15, true - 0.93, true))
    line = put_in_order("dvl", stamps, stamps)
    assert line.keep.tolist() == list(range(300))
    np.testing.assert_allclose(line.t_ns / NS, true, atol=1e-6)
    assert "jumps by -0.830 s" in sentences(line.notes)[0]
    late = np.arange(0, 30, 0.1)
    late[[150, 151]] = late[[151, 150]] - [0.2, 0.0]  # one reading alone was late
    line = put_in_order("dvl", ns(*late), ns(*late))
    assert sorted(line.t_ns.tolist()) == sorted(set(ns(*late).tolist()))


def test_stamps_that_fall_back_to_before_the_log_are_refused_until_one_part_is_given():
    parts = np.arange(100, 130, 0.1), np.arange(40, 70, 0.1)
    stamps = ns(*np.concatenate(parts))
    with pytest.raises(InputError, match=r"fall back by 89\.9 s at") as caught:
        put_in_order("dvl", stamps, stamps)
    assert "dive.from = 1970-01-01T00:01:40.000Z" in caught.value.remedy
    for part in parts:
        assert len(put_in_order("dvl", ns(*part), ns(*part)).t_ns) == 300


@pytest.mark.parametrize(
    "second", [np.arange(0, 15, 0.1), np.arange(5, 30, 0.1)], ids=["logged later", "logged twice"]
)
def test_reordered_or_repeated_parts_are_sorted_and_not_shifted(second):
    first = np.arange(15, 30, 0.1) if second[0] == 0 else np.arange(0, 20, 0.1)
    stamps = ns(*np.concatenate([first, second]))
    line = put_in_order("dvl", stamps, stamps)
    np.testing.assert_allclose(line.t_ns / NS, np.unique(np.round(stamps / NS, 6)), atol=1e-6)


def test_two_recordings_that_overlap_are_sorted_and_not_moved():
    first, second = np.arange(0, 330, 0.1), np.arange(300.02, 600, 0.1)
    stamps = ns(*first, *second)
    line = put_in_order("pressure", stamps, stamps, [0] * len(first) + [1] * len(second))
    np.testing.assert_array_equal(line.t_ns, np.sort(stamps))
    (words,) = sentences(line.notes)
    assert (
        "logs were read in another order than they were recorded, or overlap: 29.9 s back to "
        "1970-01-01T00:05:00.020Z" in words
    )


def test_a_recording_by_another_computer_of_the_same_is_no_jump():
    first, second = np.arange(0, 400) * 10**8, np.arange(200, 500) * 10**8
    stamp, log = np.r_[first, second], np.repeat([0, 1], [400, 300])
    line = put_in_order("imu", stamp, stamp + 10**7 + log * 7 * 10**9, log)
    assert line.t_ns.tolist() == (np.arange(500) * 10**8).tolist()
    assert not any("clock jumps" in said for said in sentences(line.notes))


def test_logs_listed_in_another_order_show_no_clock_jump():
    stamps = ns(*np.arange(300, 600, 0.1), *np.arange(0, 300, 0.1))
    line = put_in_order("dvl", stamps, stamps + 2_000_000, np.repeat([0, 1], 3000))
    assert (np.diff(line.t_ns) == NS // 10).all()
    assert [note for note in sentences(line.notes) if "jump" in note] == []
    assert "read in another order" in sentences(line.notes)[0]


@pytest.mark.parametrize("delay_ms", [0, 3], ids=["no logger's clock", "logged by that computer"])
def test_a_computer_s_clock_that_was_set_back_mixes_no_two_times(delay_ms):
    true = np.arange(0, 600, 0.1)
    jitter_s = np.random.default_rng(0).uniform(-0.003, 0.003, len(true))
    stamps = ns(*(np.where(true >= 300, true - 30, true) + jitter_s))
    delay_ns = np.random.default_rng(1).integers(0, delay_ms * 1_000_000 + 1, len(true))
    line = put_in_order("dvl", stamps, stamps + delay_ns)
    assert line.keep.tolist() == list(range(6000))
    np.testing.assert_allclose(line.t_ns / NS, true, atol=0.02)
    assert "3000 stamps were put right as if it had been set back" in sentences(line.notes)[0]


def test_clock_set_back_by_whole_periods_drops_no_reading():
    true = np.arange(0, 600, 0.1)
    stamps = ns(*np.where(true >= 300, true - 30, true))
    line = put_in_order(
        "dvl", stamps, stamps + np.random.default_rng(1).integers(1_000_000, 4_000_000, len(true))
    )
    np.testing.assert_allclose(line.t_ns / NS, true, atol=1e-6)


@pytest.mark.parametrize("count", [1, 19, 900])
def test_a_few_stamps_of_another_day_are_left_out_and_counted(count):
    stamps = ns(*(1_777_887_000 + np.arange(0, 400, 0.02)))
    stamps[:count] -= ns(200 * 86400)[0]
    line = put_in_order("imu", stamps, stamps + 2_000_000)
    assert line.keep.tolist() == list(range(count, 20_000))
    assert f"imu: {count} reading" in sentences(line.notes)[0]
    assert "stamped a day or more from all others" in sentences(line.notes)[0]
    assert "2025-10-16T09:30:00.000Z" in sentences(line.notes)[0]


def test_another_days_dive_and_few_joint_readings_are_kept():
    days = ns(*np.arange(0, 100, 0.1), *np.arange(100_000, 100_010, 0.1))
    assert len(put_in_order("camera_top", days, days).keep) == 1100
    twice = ns(5, 1_777_887_000)
    assert len(put_in_order("joint tray", twice, twice).keep) == 2


def test_what_a_logger_that_stalled_wrote_late_is_no_jump():
    stamps = ns(*np.arange(0, 600, 0.1))
    logged = stamps + 3_000_000
    logged[3000:3050] = stamps[3050] - 30_000_000 + 10_000 * np.arange(50)
    line = put_in_order("dvl", stamps, logged)
    np.testing.assert_array_equal(line.t_ns, stamps)
    assert sentences(line.notes) == [
        "dvl: 40 readings were logged late, by up to 5.0 s, the first at 1970-01-01T00:05:00.000Z; "
        "their stamps were kept"
    ]


def test_several_jumps_are_counted():
    words = sentences(put_in_order("dvl", ns(0, 5, 0, 5), ns(0, 0.1, 0.2, 0.3)).notes)[0]
    assert "and 2 more times" in words


def test_a_dropout_is_a_gap_not_a_jump():
    stamps = ns(0, 1, 2, 60, 61)
    assert sentences(put_in_order("dvl", stamps, stamps).notes) == []
    assert sentences(describe_gaps("dvl", stamps)) == [
        "dvl: nothing for 58.0 s from 1970-01-01T00:00:02.000Z to 1970-01-01T00:01:00.000Z"
    ]


def test_a_missing_message_or_two_is_no_gap():
    assert sentences(describe_gaps("imu", ns(0, 0.1, 0.2, 0.5, 0.6))) == []


def test_many_gaps_are_summed_up():
    stamps = ns(*[t + 20 * (t // 5) for t in range(50)])
    words = sentences(describe_gaps("imu", stamps))
    assert len(words) == 6
    assert words[-1] == "imu: 4 more gaps, shorter"


@given(st.lists(st.integers(0, 10**12), min_size=1, max_size=50))
def test_what_is_kept_is_strictly_increasing_and_complete(stamps):
    assume(len(stamps) <= 2 or len(set(stamps)) > 1)
    keep = put_in_order("x", stamps, stamps).keep  # the logger tells nothing more
    kept = np.array(stamps)[keep]
    assert (np.diff(kept) > 0).all()
    assert set(kept) == set(stamps)


def test_a_clock_that_stands_still_is_refused():
    with pytest.raises(InputError, match="imu: all 3 stamps are the same, 1970-01-01T00:00:05"):
        put_in_order("imu", [5_000_000_000] * 3, [1, 2, 3])


def test_two_readings_of_one_stamp_are_duplicates():
    line = put_in_order("imu", [5, 5], [1, 2])
    assert line.keep.tolist() == [0]
    assert sentences(line.notes) == [
        "imu: 1 of 2 stamps are duplicates; the first of each was kept"
    ]


def clock(count=200, jump_s=2.0, at=100, rate_s=0.04, delay_s=0.003):
    """Stamps of a clock that jumps, when they were logged, and when they were measured."""
    true = np.round(1e9 * (1000 + rate_s * np.arange(count))).astype(np.int64)
    late = np.round(1e9 * delay_s * np.random.default_rng(3).exponential(1.0, count)).astype(
        np.int64
    )
    return true + (np.arange(count) >= at) * round(jump_s * NS), true + late, true


@pytest.mark.parametrize("jump_s", [2.0, -2.0])
def test_stamps_after_a_jump_are_corrected_by_logger_clock(jump_s):
    stamps, logged, true = clock(jump_s=jump_s)
    line = put_in_order("imu", stamps, logged)
    assert np.abs(line.t_ns - true).max() < 0.003 * NS
    assert line.keep.tolist() == list(range(200))
    named = re.search(r"jumps by ([-+][.0-9]+) s", sentences(line.notes)[0])
    assert named is not None
    assert float(named[1]) == pytest.approx(jump_s, abs=0.02)
    assert "100 stamps were put right by the logger's clock" in sentences(line.notes)[0]


def test_stamps_wrong_before_a_jump_are_corrected():
    stamps, logged, true = clock()
    line = put_in_order("imu", stamps - 2 * NS, logged)
    assert np.abs(line.t_ns - true).max() < 0.003 * NS


def test_a_clock_that_jumps_and_comes_back_is_put_right_between():
    stamps, logged, true = clock()
    stamps[150:] -= 2 * NS
    assert np.abs(put_in_order("imu", stamps, logged).t_ns - true).max() < 0.003 * NS


def test_of_clocks_of_their_own_the_longest_stretch_is_right():
    stamps, logged, true = clock(at=60)
    line = put_in_order("imu", stamps - 500 * NS, logged)
    assert np.abs(line.t_ns - (true - 498 * NS)).max() < 0.003 * NS


def test_what_the_logger_wrote_late_keeps_its_stamps():
    true = clock(count=400, jump_s=0.0)[0]
    # a stall of 3 s, caught up
    logged = np.maximum(true, true[100] + 3 * NS) * (true >= true[100]) + true * (true < true[100])
    assert (put_in_order("imu", true, logged).t_ns == true).all()
    one = true.copy()
    one[50] += 5 * NS
    assert (put_in_order("imu", true, one).t_ns == true).all()


def test_without_a_loggers_clock_stamps_stay_as_they_are():
    stamps = clock()[0]
    assert (put_in_order("imu", stamps, stamps).t_ns == stamps).all()


@given(
    st.lists(st.integers(0, 10**12), min_size=1, max_size=80),
    st.integers(0, 10**12),
    st.integers(1, 79),
)
def test_kept_stamps_always_increase_and_belong_to_rows(stamps, jump, at):
    assume(len(stamps) <= 2 or len(set(stamps)) > 1)
    moved = [t + (jump if i >= at else 0) for i, t in enumerate(sorted(stamps))]
    assume(len(moved) <= 2 or len(set(moved)) > 1)
    line = put_in_order("x", moved, sorted(stamps))
    assert (np.diff(line.t_ns) > 0).all()
    assert len(set(line.keep.tolist())) == len(line.keep) == len(line.t_ns)


def test_a_sensor_that_began_late_or_ended_early_is_named() -> None:
    assert sentences(describe_ends("pressure", ns(6.5, 7, 8), 0, 10 * NS)) == [
        "pressure: begins 6.5 s after the log does", "pressure: ends 2.0 s before the log does",
    ]  # fmt: skip
    assert sentences(describe_ends("imu", ns(0.5, 7, 9), 0, 10 * NS)) == []


@pytest.mark.parametrize("parts_s", [(1.777e9, 3.0), (3.0, 1.777e9)])
def test_a_clock_that_is_set_amid_a_table_is_refused_with_the_way_to_use_the_rest(parts_s):
    stamp = np.concatenate([start_s + np.arange(50.0) for start_s in parts_s]) * NS
    with pytest.raises(InputError, match="50 of 100 stamps count from 1970") as raised:
        put_in_order("dvl", stamp.astype(np.int64), stamp.astype(np.int64))
    assert "dive.from = 2026-04-24T03:06:40.000Z" in raised.value.line()
    assert len(put_in_order("dvl", *2 * [stamp[stamp >= 1.777e9 * NS]]).t_ns) == 50
