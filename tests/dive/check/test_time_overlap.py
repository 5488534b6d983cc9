# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.dive.check.time_overlap import clock_gaps, shifted_streams
from hullrecon.records.sensors import PressureSamples

NS = 10**9
START_S = 1_777_887_000


def stream(start_s: float, length_s: float = 100.0) -> PressureSamples:
    t_ns = np.round((start_s + np.arange(0.0, length_s)) * NS).astype(np.int64)
    return PressureSamples(t_ns=t_ns, depth=np.zeros(len(t_ns)))


def sensors(**late_s: float) -> dict[str, PressureSamples]:
    late = {"dvl": 0.0, "imu": 0.0, "pressure": 0.0, **late_s}
    return {name: stream(START_S + start) for name, start in late.items()}


def test_streams_that_overlap_have_no_gap():
    assert clock_gaps(sensors(camera_top=99.0, tray=-98.0)) == []


@pytest.mark.parametrize("hours", [-5, 2, 5.5])
def test_a_clock_of_another_time_zone_is_told_with_its_key(hours):
    (found,) = clock_gaps(sensors(dvl=3600.0 * hours + 20))
    assert (found.code, found.severity, found.where) == ("clocks-apart", "error", "dvl")
    assert f"try dvl.time_offset = {-3600.0 * hours:.2f}" in found.sentence
    assert f"({-hours:+g} h, as of a time zone)" in found.sentence


def test_hours_are_not_guessed_where_logs_begin_and_end_elsewhere():
    off = {name: stream(START_S, 3000.0) for name in ("imu", "pressure")}
    (found,) = clock_gaps({**off, "dvl": stream(START_S + 7200 + 1000, 1000.0)})
    assert found.values["offset_s"] is None
    assert "give dvl.time_offset, the seconds to add" in found.sentence


@pytest.mark.parametrize("factor", [1000, 1_000_000])
def test_stamps_of_another_unit_are_no_offset(factor):
    others = sensors()
    small = PressureSamples(t_ns=others["dvl"].t_ns // factor, depth=others["dvl"].depth)
    (found,) = clock_gaps({**others, "dvl": small})
    assert (found.code, found.severity) == ("stamps-in-other-unit", "error")
    assert f"{factor} times smaller than those of imu and pressure" in found.sentence
    written = PressureSamples(t_ns=small.t_ns * factor, depth=small.depth)
    assert clock_gaps({**others, "dvl": written}) == []


@pytest.mark.parametrize("factor", [1000, 1e-3])
def test_a_stream_of_another_length_than_all_others_is_of_another_unit(factor):
    right = {name: stream(0.0) for name in ("dvl", "imu", "pressure")}
    moved = PressureSamples(
        t_ns=(right["pressure"].t_ns * factor).astype(np.int64), depth=right["pressure"].depth
    )
    (found,) = clock_gaps({**right, "pressure": moved})
    size = "larger" if factor > 1 else "smaller"
    assert f"1000 times {size} than those of dvl and imu" in found.sentence
    assert clock_gaps(right) == []


def test_an_offset_that_is_given_counts():
    off = sensors(camera_top=7200.0 + 30.0)
    (found,) = clock_gaps(off, {"camera_top": 30 * NS})
    assert found.values["offset_s"] == 30.0 - 7200.0
    assert found.values["key"] == "camera.top.time_offset"


def test_a_clock_that_was_never_set_is_the_one_that_is_named():
    off = {**sensors(), "dvl": stream(203.4), "tray": stream(-200.0)}
    found = clock_gaps(off)
    assert {f.where: f.values["key"] for f in found} == {
        "dvl": "dvl.time_offset",
        "tray": "tray.time_offset",
    }
    assert "it counts from 1970" in found[0].sentence
    assert "try dvl.time_offset = 1777886796.60 (it then begins and ends" in found[0].sentence
    assert found[0].sentence.startswith("dvl: it ends 56.3 years before imu and pressure begin")


def test_the_lone_clock_of_three_is_the_one_that_is_named():
    assert [f.where for f in clock_gaps(sensors(imu=5000.0))] == ["imu"]


@pytest.mark.parametrize(("late_s", "severity"), [(-500.0, "warning"), (-9000.0, "error")])
def test_fixes_at_the_surface_before_the_dive_are_no_gap(late_s, severity):
    assert [f.severity for f in clock_gaps(sensors(position=late_s))] == [severity]


def test_a_servo_an_hour_before_the_dive_that_lasts_as_long_is_of_another_clock():
    (found,) = clock_gaps(sensors(tray=-3600.0))
    assert (found.code, found.values["offset_s"]) == ("clocks-apart", 3600.0)


def test_a_single_reading_says_nothing_about_a_clock():
    once = PressureSamples(t_ns=np.array([5], np.int64), depth=np.zeros(1))
    assert clock_gaps({**sensors(), "tray": once}) == []


@pytest.mark.parametrize("late_s", [30.0, -12.0])
def test_a_stream_that_is_shifted_is_told_with_its_seconds(late_s):
    (found,) = shifted_streams(sensors(camera_top=late_s))
    side = "after" if late_s > 0 else "before"
    assert (found.where, found.severity) == ("camera_top", "warning")
    assert found.sentence.startswith(f"camera_top: it begins and ends {abs(late_s):.1f} s {side}")
    assert f"shares {99 - abs(late_s):.1f} s of its 99.0 s" in found.sentence
    assert "camera.top.time_offset" in found.sentence
    assert shifted_streams(sensors(camera_top=late_s - found.values["seconds"])) == []


def test_logs_that_begin_and_end_as_they_like_are_not_told():
    assert shifted_streams(sensors(camera_top=2.0)) == []
    assert shifted_streams(sensors(imu=-40.0, camera_top=30.0)) == []
    longer = {**sensors(), "camera_top": stream(START_S + 30, 60.0)}
    assert shifted_streams(longer) == []
