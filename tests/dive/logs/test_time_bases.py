# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.dive.logs.time_bases import BagStamps, join_time_bases
from hullrecon.findings.finding import sentences

NS = 10**9
WALL_S = 1_777_887_000


def logged(
    ahead_s: float = 0.0, delay_s: float = 0.004, rate: float = 1.0, stamped: bool = True
) -> BagStamps:
    """Readings over 100 s of wall time, logged some time after their stamps.

    ahead_s: of their clock, that runs at a rate. A reading that is not stamped has the logger's.
    """
    true_s = np.arange(0.0, 100.0, 0.2)
    at = np.round((WALL_S + true_s + delay_s) * NS).astype(np.int64)
    stamp = np.round((WALL_S + ahead_s + rate * true_s) * NS).astype(np.int64)
    return BagStamps(stamp if stamped else at, at)


def moved_s(sensors: dict[str, BagStamps]) -> tuple[dict[str, float], list[str]]:
    shifts, notes = join_time_bases(sensors)
    return {name: float(np.median(shift)) / NS for name, shift in shifts.items()}, sentences(notes)


def test_readings_without_stamp_join_the_time_of_a_simulator():
    simulated = {name: logged(12.3 - WALL_S) for name in ("dvl", "imu")}
    moved, notes = moved_s({**simulated, "pressure": logged(stamped=False)})
    assert moved == pytest.approx({"pressure": 12.3 - WALL_S - 0.004}, abs=1e-6)
    assert notes == [
        "pressure: by when they were logged, 500 stamps are 56.3 years ahead of those of dvl and "
        "imu (spread 0.000 s); they were put onto that time base"
    ]


def test_a_simulator_that_runs_slowly_is_followed():
    simulated = {name: logged(12.3 - WALL_S, rate=0.9) for name in ("dvl", "imu")}
    shifts, notes = join_time_bases({**simulated, "pressure": logged(stamped=False)})
    joined = logged(stamped=False).stamp_ns + shifts["pressure"]
    np.testing.assert_allclose(joined, simulated["dvl"].stamp_ns, atol=0.15 * NS)
    assert "by the offset of that moment" in notes[0].sentence


@pytest.mark.parametrize("ahead_s", [-WALL_S + 203.0, 7200.0, 18.0, -3600.0])
def test_a_clock_of_its_own_joins_that_of_the_others(ahead_s):
    others = {name: logged(delay_s=delay) for name, delay in (("imu", 0.002), ("pressure", 0.03))}
    moved, notes = moved_s({**others, "dvl": logged(ahead_s)})
    assert moved == pytest.approx({"dvl": -ahead_s}, abs=0.03)
    assert len(notes) == 1


@pytest.mark.parametrize("delay_s", [0.9, 3.0, 20.0])
def test_late_logging_is_no_other_clock(delay_s):
    sensors = {"dvl": logged(), "imu": logged(), "position": logged(delay_s=delay_s)}
    assert join_time_bases(sensors) == ({}, [])


def test_logs_of_a_replay_keep_their_stamps():
    year_s = 365 * 86400.0
    sensors = {name: logged(-year_s, rate=2.0) for name in ("dvl", "imu", "pressure")}
    assert join_time_bases(sensors) == ({}, [])


def test_a_clock_that_jumps_is_left_to_its_stream():
    half = logged(7200.0)
    late = np.where(np.arange(len(half.stamp_ns)) < 250, logged().stamp_ns, half.stamp_ns)
    sensors = {"imu": logged(), "pressure": logged(), "dvl": BagStamps(late, half.logged_ns)}
    assert join_time_bases(sensors) == ({}, [])


@pytest.mark.parametrize("rate", [0.5, 2.0])
def test_a_wall_clock_beside_a_simulator_of_another_rate_follows_it(rate):
    simulated = {name: logged(12.3 - WALL_S, rate=rate) for name in ("dvl", "imu", "joints")}
    shifts, _ = join_time_bases({**simulated, "pressure": logged(delay_s=0.03)})
    joined = logged().stamp_ns + shifts["pressure"]
    np.testing.assert_allclose(joined, simulated["dvl"].stamp_ns, atol=0.2 * NS)


def test_a_simulated_clock_of_another_rate_beside_wall_clocks_joins_them():
    others = {name: logged() for name in ("imu", "pressure")}
    shifts, _ = join_time_bases({**others, "dvl": logged(12.3 - WALL_S, rate=0.5)})
    joined = logged(12.3 - WALL_S, rate=0.5).stamp_ns + shifts["dvl"]
    np.testing.assert_allclose(joined, others["imu"].stamp_ns, atol=0.01 * NS)


@pytest.mark.parametrize("rate", [1 + 8e-4, 1 - 8e-4])
def test_a_clock_that_runs_fast_or_slow_is_put_right(rate):
    sensors = {"imu": logged(), "pressure": logged(), "dvl": logged(rate=rate)}
    shifts, notes = join_time_bases(sensors)
    joined = sensors["dvl"].stamp_ns + shifts["dvl"]
    np.testing.assert_allclose(joined, sensors["imu"].stamp_ns, atol=0.001 * NS)
    (said,) = sentences(notes)
    assert f"runs 800 millionths {'fast' if rate > 1 else 'slow'}" in said


@pytest.mark.parametrize("ahead_s", [0.0, -1.0])
def test_a_clock_that_gains_seconds_is_put_right(ahead_s):
    sensors = {"imu": logged(), "pressure": logged(), "dvl": logged(ahead_s, rate=1.02)}
    shifts, notes = join_time_bases(sensors)
    joined = sensors["dvl"].stamp_ns + shifts["dvl"]
    np.testing.assert_allclose(joined, sensors["imu"].stamp_ns, atol=0.001 * NS)
    assert "runs 20000 millionths fast" in sentences(notes)[0]


def test_a_queue_that_empties_is_no_drift_of_a_clock():
    sensors = {"imu": logged(), "pressure": logged(), "dvl": logged(-2.0, rate=1.02)}
    assert join_time_bases(sensors) == ({}, [])


def test_a_queue_that_grows_keeps_its_stamps_and_is_told():
    sensors = {"imu": logged(), "pressure": logged(), "dvl": logged(rate=0.98)}
    shifts, notes = join_time_bases(sensors)
    assert shifts == {}
    (said,) = sentences(notes)
    assert said.startswith("dvl: its stamps fall evenly behind")
    assert join_time_bases({name: logged(rate=0.98) for name in sensors}) == ({}, [])
