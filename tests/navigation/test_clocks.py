# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Clocks that part, of a vehicle that swims along a wall and looks at it."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from functools import cache, partial

import numpy as np
import pytest
from navigation.conftest import START_NS
from navigation.instruments import RIG, SIGMAS
from navigation.wall_dive import STREAMS, AlongWall, late, logs_along_wall, unsteady

from hullrecon.geometry import poses
from hullrecon.navigation.clocks.comparisons.comparison import ClockComparison, ClockedSensor
from hullrecon.navigation.clocks.evidence import weigh_comparisons
from hullrecon.navigation.clocks.remaining_offsets import UNCHECKED_S
from hullrecon.navigation.clocks.synchronise import (
    Synchronised,
    _longest_pauses,
    choose_runs,
    corrected_stamps,
    describe_offsets,
    synchronise,
)
from hullrecon.navigation.clocks.time_offsets import TimeOffset, segments
from hullrecon.navigation.clocks.wrong_clocks import find_wrong_clocks
from hullrecon.navigation.dead_reckoning.dead_reckon import NavigationLogs
from hullrecon.navigation.navigate import reckon_dive


@pytest.fixture(scope="module")
def swum() -> AlongWall:
    return AlongWall(RIG)


@pytest.fixture(scope="module")
def logged(swum) -> NavigationLogs:
    return logs_along_wall(swum)


@pytest.fixture(scope="module")
def measure(swum, logged):
    """Motions between images by the truth, with the noise of good pairs, at the times at which they
    were truly taken. The noise is the pair's own, whatever was asked before.
    """
    true_s = (logged.top.t_ns - START_NS) * 1e-9
    camera = swum.cameras(true_s)

    @cache
    def between(first: int, second: int):
        rng = np.random.default_rng([5, first, second])
        found = (camera[second].inverse() @ camera[first]).matrix()[0]
        found[:3, 3] /= np.linalg.norm(found[:3, 3])
        found[:3, 3] += 0.01 * rng.standard_normal(3)
        turn = poses.from_rpy(np.zeros(3), 0.001 * rng.standard_normal(3)).rotation.as_matrix()[0]
        found[:3, :3] = found[:3, :3] @ turn
        return found, np.array([0.001, 0.01])

    return between


def put_right(logs: NavigationLogs, measure=None) -> Synchronised:
    return synchronise(logs, RIG, 0.002, measure)


def off_s(found: Synchronised, true: NavigationLogs, sensor: ClockedSensor) -> float:
    """By how much the stamps are off in the median."""
    ours, stamps = (getattr(logs, STREAMS[sensor]).t_ns for logs in (found.logs, true))
    return float(np.median(np.abs(ours - stamps))) * 1e-9


def test_clocks_that_agree_are_left_alone(logged, measure):
    for found in (put_right(logged), put_right(logged, measure)):
        assert (found.offsets, found.remarks) == ([], [])
        for name in STREAMS.values():
            np.testing.assert_array_equal(
                getattr(found.logs, name).t_ns, getattr(logged, name).t_ns
            )


@pytest.mark.parametrize(
    ("sensor", "seconds"),
    [(ClockedSensor.DVL, 0.6), (ClockedSensor.IMU, -1.5), (ClockedSensor.PRESSURE, 0.6)],
)
def test_wrong_clock_is_found_by_hull_and_depth(logged, sensor, seconds):
    found = put_right(late(logged, sensor, seconds))
    assert [offset.sensor for offset in found.offsets] == [sensor]
    assert found.offsets[0].seconds == pytest.approx(seconds, abs=4 * found.offsets[0].sigma_s)
    assert off_s(found, logged, sensor) < 0.15


@pytest.mark.parametrize(
    ("sensor", "seconds"),
    [
        (ClockedSensor.DVL, -1.5),
        (ClockedSensor.IMU, 0.6),
        (ClockedSensor.PRESSURE, -1.5),
        (ClockedSensor.IMAGES, 0.6),
        (ClockedSensor.IMAGES, 37.0),
    ],
)
def test_wrong_clock_is_found_by_images(logged, measure, sensor, seconds):
    found = put_right(late(logged, sensor, seconds), measure)
    assert [offset.sensor for offset in found.offsets] == [sensor]
    assert off_s(found, logged, sensor) < 0.2
    others = [other for other in STREAMS.values() if other != STREAMS[sensor]]
    for name in others:
        np.testing.assert_array_equal(getattr(found.logs, name).t_ns, getattr(logged, name).t_ns)


@pytest.fixture(scope="module")
def felt() -> NavigationLogs:
    """A dive of 45 s, too short for the hull's turns, whose IMU measures accelerations."""
    swum = AlongWall(RIG, duration_s=45.0)
    logs = logs_along_wall(swum)
    t_s, step_s = (logs.imu.t_ns - START_NS) * 1e-9, 0.05
    before, at, after = (swum.place(t_s + of) for of in (-step_s, 0.0, step_s))
    force = (before - 2 * at + after) / step_s**2 - [0.0, 0.0, 9.81]
    noise = 0.03 * np.random.default_rng(6).standard_normal(force.shape)
    felt = swum.attitude(t_s).inv().apply(force) + noise
    return replace(logs, imu=replace(logs.imu, acceleration=felt))


@pytest.mark.parametrize(
    ("sensor", "seconds"), [(ClockedSensor.DVL, 0.4), (ClockedSensor.IMU, -3.0)]
)
def test_wrong_clock_of_a_short_dive_is_found_by_accelerations(felt, sensor, seconds):
    found = put_right(late(felt, sensor, seconds))
    assert [offset.sensor for offset in found.offsets] == [sensor]
    assert off_s(found, felt, sensor) < 0.1


def blind(logs: NavigationLogs) -> NavigationLogs:
    """Nothing compares the clocks: a filtered attitude, no returns, no depth."""
    silent = np.full_like(logs.imu.acceleration, np.nan)
    return replace(without_ranges(logs), imu=replace(logs.imu, acceleration=silent), pressure=None)


def test_what_is_left_of_a_delay_is_as_large_as_the_evidence_leaves_it(felt):
    assert put_right(felt).late_sigma_s[ClockedSensor.DVL] < 0.07
    assert put_right(blind(felt)).late_sigma_s[ClockedSensor.DVL] == pytest.approx(UNCHECKED_S)


def test_delays_of_images_that_show_no_motion_are_as_without_a_camera(felt):
    shown = put_right(felt, lambda first, second: None)
    assert shown.late_sigma_s == put_right(felt).late_sigma_s


@pytest.mark.parametrize("seconds", [0.08, -0.08])
def test_delay_too_small_to_put_right_is_held_by_what_is_left(felt, seconds):
    found = put_right(late(felt, ClockedSensor.DVL, seconds))
    assert found.offsets or abs(seconds) < 3 * found.late_sigma_s[ClockedSensor.DVL]


def test_clock_that_runs_fast_is_held_by_what_is_left(felt):
    since_s = (felt.dvl.t_ns - felt.dvl.t_ns[0]) * 1e-9
    t_ns = felt.dvl.t_ns + np.round(0.01e9 * (since_s - since_s.mean())).astype(np.int64)
    found = put_right(replace(felt, dvl=replace(felt.dvl, t_ns=t_ns)))
    assert found.late_sigma_s[ClockedSensor.DVL] > 0.5 * 0.01 * since_s[-1] / np.sqrt(12)


def test_sigma_of_a_path_without_evidence_holds_a_late_dvl(felt):
    """0.1 s late: nothing tells, and the path is as far off as its sigma says."""
    right, off = (
        reckon_dive(blind(of), RIG, SIGMAS) for of in (felt, late(felt, ClockedSensor.DVL, 0.1))
    )
    at = right.trajectory.t_ns
    moved = [np.interp(at, off.trajectory.t_ns, axis) for axis in off.trajectory.translation.T]
    error = np.stack(moved, axis=1) - right.trajectory.translation
    sigma = np.sqrt(right.trajectory.covariance[:, [0, 1, 2], [0, 1, 2]])
    assert np.abs(error).max() > 0.02
    assert np.abs(error - error[0])[:, :2].max() < 3 * sigma[:, :2].max()
    assert any("known to 0.10 s" in remark for remark in right.remarks)


def test_nothing_is_said_of_the_clock_of_a_sensor_that_was_not_logged(felt, monkeypatch):
    monkeypatch.setattr("hullrecon.navigation.navigate.UNSURE_M", 0.0)
    remarks = reckon_dive(blind(felt), RIG, SIGMAS).remarks
    assert [remark[:4] for remark in remarks if "its clock agrees" in remark] == ["DVL:"]


def test_accelerations_do_not_accuse_clocks_that_agree(felt):
    gravity = poses.from_rpy(np.zeros((len(felt.imu.t_ns), 3)), 0 * felt.imu.acceleration)
    still = replace(felt.imu, acceleration=gravity.rotation.apply([0.0, 0.0, -9.81]))
    for logs in (felt, replace(felt, imu=still)):
        assert put_right(logs).offsets == []


@pytest.mark.parametrize("seconds", [-6.0, 37.0])
def test_imu_off_by_many_seconds_is_found_without_images(logged, seconds):
    found = put_right(late(logged, ClockedSensor.IMU, seconds))
    assert [offset.sensor for offset in found.offsets] == [ClockedSensor.IMU]
    assert off_s(found, logged, ClockedSensor.IMU) < 0.15


@pytest.mark.parametrize("seconds", [70.0, -90.0])
def test_imu_off_by_over_a_minute_is_left_alone(logged, seconds):
    assert put_right(late(logged, ClockedSensor.IMU, seconds)).offsets == []


def test_offset_that_fits_by_chance_is_not_taken(monkeypatch):
    """In this swell one of 57 s explains the turns better than all others up to two minutes."""
    monkeypatch.setattr("navigation.wall_dive.unsteady", partial(unsteady, seed=1))
    assert put_right(late(logs_along_wall(AlongWall(RIG)), ClockedSensor.IMU, 140.0)).offsets == []


def test_dvl_late_by_a_fifth_of_a_second_is_found(logged, measure):
    found = put_right(late(logged, ClockedSensor.DVL, 0.2), measure)
    assert [(one.sensor, one.relative_to) for one in found.offsets] == [
        (ClockedSensor.DVL, (ClockedSensor.IMU, ClockedSensor.PRESSURE, ClockedSensor.IMAGES))
    ]
    assert off_s(found, logged, ClockedSensor.DVL) < 0.06


@pytest.mark.parametrize("seen", [False, True], ids=["no images", "images"])
@pytest.mark.parametrize("sensor", [ClockedSensor.DVL, ClockedSensor.IMU])
def test_clock_that_jumps_is_wrong_from_there_on(logged, measure, sensor, seen):
    found = put_right(late(logged, sensor, 2.0, from_s=120.0), measure if seen else None)
    (one,) = found.offsets
    assert one.sensor is sensor
    assert one.seconds == pytest.approx(2.0, abs=0.2)
    assert (one.from_ns - START_NS) * 1e-9 == pytest.approx(121.0, abs=1.5)
    assert off_s(found, logged, sensor) < 0.1


def test_images_late_by_a_fifth_are_moved_within_their_sigma(logged, measure):
    """Over eight draws of the noise they came out 175 to 216 ms late, with sigmas of 13 to 17."""
    (found,) = put_right(late(logged, ClockedSensor.IMAGES, 0.2), measure).offsets
    assert found.sensor is ClockedSensor.IMAGES
    assert abs(found.seconds - 0.2) < 3 * found.sigma_s
    assert found.sigma_s < 0.02


def test_dvl_is_compared_with_imu_alone(logged):
    found = put_right(replace(late(logged, ClockedSensor.DVL, 0.8), pressure=None))
    assert [(offset.sensor, offset.relative_to) for offset in found.offsets] == [
        (ClockedSensor.DVL, (ClockedSensor.IMU,))
    ]


class LevelAlongWall(AlongWall):
    """A vehicle that does not turn, so that levelling the DVL's velocity shows no time."""

    def attitude(self, t):
        return poses.from_rpy(np.zeros((len(t), 3)), np.zeros((len(t), 3))).rotation


def without_ranges(logs: NavigationLogs) -> NavigationLogs:
    return replace(logs, dvl=replace(logs.dvl, ranges=np.full_like(logs.dvl.ranges, np.nan)))


def test_which_of_two_clocks_is_wrong_is_not_guessed():
    level = without_ranges(logs_along_wall(LevelAlongWall(RIG)))
    found = put_right(late(level, ClockedSensor.DVL, 0.8))
    assert found.offsets == []
    assert len(found.remarks) == 1
    assert re.search(r"DVL and pressure: their clocks differ by 0\.[6-9]\d s", found.remarks[0])
    assert "not known" in found.remarks[0]


def test_levelled_velocity_shows_dvl_offset_without_ranges(logged):
    found = put_right(late(without_ranges(logged), ClockedSensor.DVL, 0.8))
    assert [one.sensor for one in found.offsets] == [ClockedSensor.DVL]
    assert off_s(found, logged, ClockedSensor.DVL) < 0.15


def test_vehicle_at_rest_shows_no_offset(logged, measure):
    still = replace(
        logged,
        dvl=replace(
            logged.dvl,
            velocity=np.zeros_like(logged.dvl.velocity),
            ranges=np.full_like(logged.dvl.ranges, 1.5),
        ),
        imu=replace(
            logged.imu, quaternion=np.tile(logged.imu.quaternion[:1], (len(logged.imu.t_ns), 1))
        ),
    )
    assert put_right(late(still, ClockedSensor.DVL, 0.8)).offsets == []
    assert put_right(late(still, ClockedSensor.DVL, 0.8), lambda first, second: None).offsets == []


def test_images_without_motion_leave_hull_and_depth(logged):
    late_dvl = late(logged, ClockedSensor.DVL, 0.8)
    found = put_right(late_dvl)
    assert put_right(late_dvl, lambda first, second: None).offsets == found.offsets
    assert [one.sensor for one in found.offsets] == [ClockedSensor.DVL]


def test_two_clocks_late_by_the_same_are_found(logged, measure):
    """Two and two: those with the IMU are taken to be right."""
    both = late(late(logged, ClockedSensor.IMAGES, 0.9), ClockedSensor.PRESSURE, 0.9)
    found = put_right(both, measure)
    assert {one.sensor for one in found.offsets} == {ClockedSensor.PRESSURE, ClockedSensor.IMAGES}
    assert off_s(found, logged, ClockedSensor.IMAGES) < 0.05
    assert off_s(found, logged, ClockedSensor.PRESSURE) < 0.2


def test_pauses_without_a_jump_change_nothing(logged, measure):
    """The DVL loses the bottom for 15 s, the cameras pause."""
    t_s = (logged.dvl.t_ns - START_NS) * 1e-9
    kept = (t_s < 90) | (t_s > 105)
    rows = {
        name: getattr(logged.dvl, name)[kept]
        for name in ("t_ns", "velocity", "velocity_sigma", "ranges")
    }
    paused = replace(logged, dvl=replace(logged.dvl, **rows))
    for found in (put_right(paused), put_right(paused, measure)):
        assert found.offsets == []


def without_pings(logs: NavigationLogs, *spans: tuple[float, float]) -> NavigationLogs:
    """Return the logs without the DVL's pings from so many seconds to so many."""
    t_s = (logs.dvl.t_ns - START_NS) * 1e-9
    kept = ~np.any([(t_s > begin) & (t_s < end) for begin, end in spans], axis=0)
    rows = {
        name: getattr(logs.dvl, name)[kept]
        for name in ("t_ns", "velocity", "velocity_sigma", "ranges")
    }
    return replace(logs, dvl=replace(logs.dvl, **rows))


@pytest.mark.parametrize("sensor", [ClockedSensor.DVL, ClockedSensor.IMU, ClockedSensor.PRESSURE])
def test_late_clock_is_corrected_across_pauses(logged, sensor):
    """Stretches of less than a minute tell nothing by themselves."""
    true = without_pings(logged, (60, 62), (120, 122), (190, 192))
    found = put_right(late(true, sensor, 1.5))
    assert [one.sensor for one in found.offsets] == [sensor]
    ours, stamps = (getattr(logs, STREAMS[sensor]).t_ns for logs in (found.logs, true))
    assert np.abs(ours - stamps).max() < 0.15e9


def test_late_pressure_is_corrected_in_a_short_segment(logged, measure):
    true = without_pings(logged, (200, 202))
    found = put_right(late(true, ClockedSensor.PRESSURE, 1.5), measure)
    assert np.abs(found.logs.pressure.t_ns - true.pressure.t_ns).max() < 0.2e9


def test_short_segment_before_a_jump_is_left_alone(logged):
    """It is too short to tell a shift, and yet says that the one behind the jump is not its own."""
    found = put_right(late(logged, ClockedSensor.IMU, 2.0, from_s=40.0))
    assert [offset.sensor for offset in found.offsets] == [ClockedSensor.IMU]
    before = logged.imu.t_ns < START_NS + 40 * 10**9
    np.testing.assert_array_equal(found.logs.imu.t_ns[before], logged.imu.t_ns[before])
    assert np.abs(found.logs.imu.t_ns - logged.imu.t_ns).max() < 0.15e9


def offset(sensor: ClockedSensor, begin_s: float, end_s: float, seconds: float) -> TimeOffset:
    return TimeOffset(
        sensor=sensor,
        from_ns=round(begin_s * 1e9),
        to_ns=round(end_s * 1e9),
        seconds=seconds,
        sigma_s=0.01,
        relative_to=(ClockedSensor.IMU,),
    )


def test_offsets_of_one_sensor_are_one_sentence():
    words = describe_offsets(
        [
            offset(ClockedSensor.DVL, 0, 5, 0.5),
            offset(ClockedSensor.DVL, 5, 9, 2.5),
            offset(ClockedSensor.IMU, 0, 9, -0.4),
        ]
    )
    assert words[0].startswith("DVL: the clock is 0.50 s late (sigma 0.010 s) from 1970-01-01T00:")
    assert "Z to 1970-01-01T00:00:05.000Z, 2.50 s late" in words[0]
    assert words[1].startswith("IMU: the clock is 0.40 s early")
    assert words[0].endswith("relative to that of IMU; the stamps were put right")
    assert words[1].endswith("put right, as imu.time_offset higher by 0.40 does for a whole log")
    three = replace(
        offset(ClockedSensor.DVL, 0, 5, 0.5),
        relative_to=(ClockedSensor.IMU, ClockedSensor.PRESSURE, ClockedSensor.IMAGES),
    )
    assert "relative to those of IMU, pressure and images;" in describe_offsets([three])[0]


@pytest.mark.parametrize("lower", ["shares the clock", "has its own"])
def test_lower_camera_moves_where_it_shares_the_clock(logged, measure, lower):
    moved = late(logged, ClockedSensor.IMAGES, 1.5)
    bottom = moved.top if lower == "shares the clock" else logged.top
    found = put_right(replace(moved, bottom=bottom), measure).logs
    assert np.abs(found.bottom.t_ns - logged.top.t_ns).max() < 0.06e9


def test_segments_lie_between_the_longest_pauses():
    even = np.arange(0, 100, 1) * 10**9
    paused = even[(even < 20 * 10**9) | (even > 30 * 10**9)]
    assert segments(_longest_pauses(even), (0, 99 * 10**9)) == [(0, 99 * 10**9)]
    assert segments(_longest_pauses(paused), (0, 99 * 10**9)) == [
        (0, 25 * 10**9),
        (25 * 10**9, 99 * 10**9),
    ]
    often = np.cumsum(np.where(np.arange(60) % 6, 0.1, 3.0))
    assert len(_longest_pauses(np.round(often * 1e9).astype(np.int64))) == 4


def test_runs_of_images_are_spread():
    t_ns = np.arange(0, 100, 0.1) * 1e9
    runs = choose_runs(t_ns.astype(np.int64), np.arange(1000), 4)
    assert [len(run) for run in runs] == [6, 6, 6, 6]
    assert np.diff([run[0] for run in runs]).min() > 150
    assert min(np.diff(run).min() for run in runs) >= 5
    assert choose_runs(t_ns.astype(np.int64), np.arange(1), 4) == []


def apart(shift: float) -> np.ndarray:
    """Difference of a signal from a noisy copy of it that is 0.7 s late."""
    t = np.arange(0, 120, 0.5)
    noise = 0.1 * np.random.default_rng(1).standard_normal((len(t), 1))
    return unsteady(t)[:, :1] + noise - unsteady(t + shift - 0.7)[:, :1]


def comparison(residuals) -> ClockComparison:
    """Pressure relative to the DVL."""
    rows = np.arange(240)

    def evaluate(offsets, rows):
        shift = offsets.get(ClockedSensor.PRESSURE, 0.0) - offsets.get(ClockedSensor.DVL, 0.0)
        return residuals(shift)[rows]

    return ClockComparison(
        first=ClockedSensor.PRESSURE,
        second=ClockedSensor.DVL,
        systematic_s=0.001,
        begin_ns=rows,
        end_ns=rows,
        block=rows // 20,
        evaluate=evaluate,
        rows=rows,
        least_rows=60,
    )


def test_offset_of_a_signal_is_found_with_its_sigma():
    first, second = find_wrong_clocks(weigh_comparisons([comparison(apart)]))
    assert {first.wrong, second.wrong} == {(ClockedSensor.PRESSURE,), (ClockedSensor.DVL,)}
    pressure = first if first.wrong == (ClockedSensor.PRESSURE,) else second
    sigma_s = pressure.sigma_s[ClockedSensor.PRESSURE]
    assert pressure.offsets[ClockedSensor.PRESSURE] == pytest.approx(0.7, abs=4 * sigma_s)
    assert 0.002 < sigma_s < 0.03
    dvl = second if pressure is first else first
    assert dvl.offsets[ClockedSensor.DVL] == pytest.approx(-0.7, abs=4 * sigma_s)


def test_far_offset_is_found_and_one_beyond_reach_is_not():
    far = find_wrong_clocks(weigh_comparisons([comparison(lambda shift: apart(shift - 30))]))
    assert abs(far[0].offsets[far[0].wrong[0]]) == pytest.approx(30.7, abs=0.1)
    assert [
        one.wrong
        for one in find_wrong_clocks(weigh_comparisons([comparison(lambda s: apart(s - 300))]))
    ] == [()]


def test_rows_without_data_speak_for_no_offset():
    """Of a signal that ends, a far offset leaves few rows: they must not make it the better one."""
    t = np.arange(0, 120, 0.5)

    def ended(shift: float) -> np.ndarray:
        found = apart(shift)
        found[(t + shift < 0) | (t + shift > 120)] = np.nan
        return found

    found = find_wrong_clocks(weigh_comparisons([comparison(ended)]))[0]
    assert abs(found.offsets[found.wrong[0]]) == pytest.approx(
        0.7, abs=4 * found.sigma_s[found.wrong[0]]
    )


def test_noise_has_no_offset():
    noise = np.random.default_rng(2).standard_normal((240, 2))
    assert [
        one.wrong for one in find_wrong_clocks(weigh_comparisons([comparison(lambda shift: noise)]))
    ] == [()]
    assert weigh_comparisons([comparison(lambda shift: np.full((240, 2), np.nan))]) == []


def test_stamps_are_corrected_in_segment_and_sensor_only():
    wrong = replace(offset(ClockedSensor.IMU, 0, 0, -1e-9), from_ns=10, to_ns=20)
    t_ns = np.array([5, 10, 15, 20, 25])
    assert corrected_stamps(t_ns, [wrong], ClockedSensor.IMU).tolist() == [5, 11, 16, 21, 25]
    assert corrected_stamps(t_ns, [wrong], ClockedSensor.DVL).tolist() == t_ns.tolist()


def test_offsets_have_the_fields_of_navigation_json():
    assert [field.name for field in fields(TimeOffset)] == [
        "sensor",
        "from_ns",
        "to_ns",
        "seconds",
        "sigma_s",
        "relative_to",
    ]
