# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import json
import re
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.dive.check.time_overlap import shifted_streams
from hullrecon.dive.logs.dvl_beams import tilted_beams
from hullrecon.dive.logs.heading import heading_by_rates
from hullrecon.dive.logs.samples import ImuSample
from hullrecon.dive.logs.streams.imu import FRD_FROM_FLU, NED_FROM_ENU, imu_samples
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_mount
from hullrecon.geometry.robust import GAIN
from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.comparisons.motions import Motions, compare
from hullrecon.navigation.suspects.faults.axes import Conventions
from hullrecon.navigation.suspects.faults.hypothesis import Hypothesis
from hullrecon.navigation.suspects.pairs import judge_pairs
from hullrecon.navigation.suspects.parts import judge_parts
from hullrecon.navigation.suspects.shifted_imu import mend_shifted_imu
from hullrecon.navigation.suspects.suspects import Tried, explain_best, judge, possible_orders
from hullrecon.records.sensors import (
    DvlPings,
    ImuSamples,
    JointSamples,
    PressureSamples,
    SensorRecords,
)
from hullrecon.rig import Rig, RigPriors

NS = 1_000_000_000
BOTH = ("first", "second")  # images of a flow
SECONDS = 40
AIR_M = 10.0
CAMERA = CameraModel(1000, 800, 1000.0, 1000.0, 499.5, 399.5, k1=-0.05)
RIG = Rig(
    tray_origin=np.zeros(3),
    pressure_origin=np.zeros(3),
    tray_from_dvl=from_mount([0, 0, 0, 0, 90, 0]),
    tray_from_top=from_mount([0, 0, -0.05, 90, 0, 90]),
    camera_models={Camera.TOP: CAMERA},
)
WALL_M = 1.5  # ahead of where the dive begins
JANUS = tilted_beams(30.0, (180.0, 0.0, 90.0, -90.0))


def stamps(hz: float) -> np.ndarray:
    return np.arange(0, SECONDS * NS, round(NS / hz), dtype=np.int64)


def attitude(t_s: np.ndarray) -> Rotation:
    phase = np.outer(t_s, [0.9, 0.7, 0.4]) + np.array([0.0, 1.0, 2.0])
    angles = np.radians([2.0, 3.0, 5.0]) * np.sin(phase)
    return Rotation.from_euler("xyz", angles)


def position(t_s: np.ndarray) -> np.ndarray:
    """The integral of the velocity that `dive` has."""
    return np.column_stack([0.02 * np.sin(t_s), 3.0 * np.sin(0.1 * t_s), 0.8 * np.sin(0.3 * t_s)])


def acceleration(t_s: np.ndarray) -> np.ndarray:
    """The second derivative of the position."""
    return np.column_stack(
        [-0.02 * np.sin(t_s), -0.03 * np.sin(0.1 * t_s), -0.072 * np.sin(0.3 * t_s)]
    )


def ranges(t_s: np.ndarray) -> np.ndarray:
    """Distances to the wall along the beams."""
    ahead = [(attitude(t_s) * RIG.tray_from_dvl.rotation).apply(beam)[:, 0] for beam in JANUS]
    return (WALL_M - position(t_s)[:, :1]) / np.stack(ahead, axis=1)


def flows(turn: np.ndarray | None = None, k1: float = 0.0) -> list[Flow]:
    """Places of points of the wall in neighbouring images, by a calibration that turns them.

    k1: by which that calibration's is too small.
    """
    rng = np.random.default_rng(3)
    out = []
    for start_s in np.arange(2.0, SECONDS - 3, 3.0):
        times = start_s + np.array([0.0, 0.6])
        places = position(times)
        points = places[0] + rng.uniform(-0.5, 0.5, (50, 3))
        points[:, 0] = WALL_M
        seen = []
        for place, level in zip(places, attitude(times), strict=True):
            in_vehicle = level.inv().apply(points - place)
            in_top = RIG.tray_from_top.inverse().apply(in_vehicle)
            ideal = in_top[:, :2] / in_top[:, 2:]
            ideal *= 1 + k1 * (ideal**2).sum(axis=1, keepdims=True)
            seen.append(ideal @ (np.eye(2) if turn is None else turn).T)
        t_ns = (int(times[0] * NS), int(times[1] * NS))
        out.append(Flow(t_ns=t_ns, first=seen[0], second=seen[1]))
    return out


def dive(seed: int = 1) -> SensorRecords:
    """A vehicle that goes along a hull, down and up by 0.8 m, and turns by some degrees."""
    rng = np.random.default_rng(seed)
    imu_ns, ping_ns, read_ns = stamps(50), stamps(5), stamps(10)
    imu_s, ping_s, read_s = (t / NS for t in (imu_ns, ping_ns, read_ns))
    turned = attitude(imu_s)
    noise = Rotation.from_rotvec(np.radians(0.1) * rng.standard_normal((len(imu_s), 3)))
    rates = (turned.inv() * attitude(imu_s + 0.01)).as_rotvec() / 0.01
    ashore = np.column_stack(
        [0.02 * np.cos(ping_s), 0.3 * np.cos(0.1 * ping_s), 0.24 * np.cos(0.3 * ping_s)]
    )
    vehicle = attitude(ping_s).inv().apply(ashore)
    velocity = RIG.tray_from_dvl.rotation.inv().apply(vehicle)
    return SensorRecords(
        imu=ImuSamples(
            t_ns=imu_ns,
            quaternion=(turned * noise).as_quat(),
            angular_velocity=rates + 0.002 * rng.standard_normal(rates.shape),
            acceleration=turned.inv().apply(acceleration(imu_s) - [0.0, 0.0, 9.81]),
        ),
        dvl=DvlPings(
            t_ns=ping_ns,
            velocity=velocity + 0.003 * rng.standard_normal(velocity.shape),
            velocity_sigma=np.full(len(ping_ns), 0.003),
            ranges=ranges(ping_s) + 0.01 * rng.standard_normal((len(ping_s), 4)),
            beams=JANUS,
        ),
        pressure=PressureSamples(
            t_ns=read_ns,
            depth=2.0 + 0.8 * np.sin(0.3 * read_s) + 0.02 * rng.standard_normal(len(read_s)),
        ),
    )


def on_tray(records: SensorRecords, factor: float = 1.0) -> SensorRecords:
    """The same dive by a vehicle that pitches by as much more as its tray turns back.

    factor: of the angles that are logged.
    """
    imu = records.imu
    angle = 0.5 * np.sin(0.2 * imu.t_ns / NS)
    back = Rotation.from_euler("y", -angle[:, None])
    turned = Rotation.from_quat(imu.quaternion) * back
    rates = (turned[:-1].inv() * turned[1:]).as_rotvec() * NS / np.diff(imu.t_ns)[:, None]
    return replace(
        records,
        imu=replace(
            imu,
            quaternion=turned.as_quat(),
            angular_velocity=np.vstack([rates, rates[-1:]]),
            acceleration=back.inv().apply(imu.acceleration),
        ),
        tray=JointSamples(t_ns=imu.t_ns, angle=factor * angle),
    )


def judged(records: SensorRecords, seen=()):
    return judge(records, RIG, AIR_M, flows=seen)


def with_depth(records: SensorRecords, depth: np.ndarray) -> SensorRecords:
    return replace(records, pressure=replace(records.pressure, depth=depth))


def with_rates(records: SensorRecords, rates: np.ndarray) -> SensorRecords:
    return replace(records, imu=replace(records.imu, angular_velocity=rates))


@pytest.mark.parametrize("seed", range(5))
def test_sensors_that_agree_are_not_accused(seed):
    assert judged(dive(seed), flows()).findings == []


@pytest.mark.parametrize(
    ("unit", "factor"), [("rad", np.pi / 180), ("deg", 180 / np.pi), ("turns", 0.5 / np.pi)]
)
def test_tray_angle_in_the_other_unit_is_converted(unit, factor):
    found = judged(on_tray(dive(), factor), flows())
    (finding,) = found.findings
    assert (finding.code, finding.values["sensor"], finding.values["value"]) == (
        "sensor-mended",
        "tray's angle",
        unit,
    )
    assert np.allclose(found.records.tray.angle, on_tray(dive()).tray.angle)


def test_tray_angle_in_its_own_unit_is_not_accused():
    assert judged(on_tray(dive()), flows()).findings == []


@pytest.mark.parametrize("off_deg", [45, 180])
def test_tray_whose_zero_is_eighths_of_a_turn_off_is_put_right(off_deg):
    right = on_tray(dive())
    off = replace(right.tray, angle=right.tray.angle + np.radians(off_deg))
    found = judged(replace(right, tray=off), flows())
    (finding,) = found.findings
    assert (finding.code, finding.values["value"]) == ("sensor-mended", f"+{off_deg}")
    np.testing.assert_allclose(found.records.tray.angle, right.tray.angle)


def test_tray_that_grows_down_from_another_zero_is_named_with_the_keys_that_heal():
    right = on_tray(dive())
    off = replace(right.tray, angle=np.pi / 2 - right.tray.angle)
    (finding,) = judged(replace(right, tray=off), flows()).findings
    assert finding.severity == "error"
    ((positive, offset_deg),) = re.findall(
        r'give tray\.positive = "(\w+)" and tray\.offset_deg = ([-\d]+)', finding.sentence
    )
    sense = {"up": 1.0, "down": -1.0}[positive]
    np.testing.assert_allclose(
        sense * off.angle + np.radians(float(offset_deg)), right.tray.angle, atol=1e-12
    )


def test_a_tray_that_hardly_moves_about_a_quarter_of_a_turn_is_in_no_degrees():
    """They would be the thirtieth part of a degree, by which no servo moves."""
    imu_ns = dive().imu.t_ns
    angle = np.pi / 2 + 0.02 * np.sin(0.2 * imu_ns / NS)
    found = judge(
        replace(dive(), tray=JointSamples(t_ns=imu_ns, angle=angle)), RIG, AIR_M, flows=flows()
    )
    (finding,) = found.findings
    assert (finding.values["fault"], finding.values["value"]) == ("zero", "+90")


def test_orientation_of_half_the_angle_is_put_right_and_of_twice_is_named():
    true = dive()
    turns = Rotation.from_quat(true.imu.quaternion).as_rotvec()
    half = judged(with_imu(true, quaternion=Rotation.from_rotvec(turns / 2).as_quat()))
    assert [finding.code for finding in half.findings] == ["sensor-mended"]
    mended = Rotation.from_quat(half.records.imu.quaternion).as_rotvec()
    np.testing.assert_allclose(mended, turns, atol=1e-12)
    twice = judged(with_imu(true, quaternion=Rotation.from_rotvec(turns * 2).as_quat()))
    (finding,) = twice.findings
    assert (finding.code, finding.values["value"]) == ("sensor-wrong", "twice")
    assert judged(true).findings == []  # the quaternion of the angle itself


@pytest.mark.parametrize(("unit", "pascal"), [("0.1 mbar", 10.0), ("kPa", 1000.0)])
def test_pressure_in_another_unit_is_converted(unit, pascal):
    true = dive()
    logged = (true.pressure.depth + AIR_M) / pascal - AIR_M
    found = judged(with_depth(true, logged))
    (finding,) = found.findings
    assert (finding.code, finding.values["value"]) == ("sensor-mended", unit)
    assert found.records.pressure.depth == pytest.approx(true.pressure.depth)


@pytest.mark.parametrize(
    ("unit", "pascal"), [("Pa", 1.0), ("hPa", 100.0), ("kPa", 1000.0), ("bar", 1e5), ("psi", 6895)]
)
def test_pressure_above_the_air_is_converted_in_its_unit(unit, pascal):
    true = dive()
    found = judged(with_depth(true, true.pressure.depth / pascal - AIR_M))
    (finding,) = found.findings
    assert [finding.values[key] for key in ("fault", "value")] == ["gauge", unit]
    assert found.records.pressure.depth == pytest.approx(true.pressure.depth, rel=1e-3)


def test_pressure_of_a_dive_at_one_depth_asks_for_its_unit():
    """Nothing tells hPa above the air (as deep as it is) from kPa (deeper)."""
    true = dive()
    level = replace(true.dvl, velocity=0.0 * true.dvl.velocity + [0.0, 1e-3, 0.0])
    # accelerations would tell of the way that is taken off
    imu = replace(true.imu, acceleration=np.full_like(true.imu.acceleration, np.nan))
    still = replace(true, dvl=level, imu=imu)
    hectopascal = (1.5 + 0.0 * true.pressure.depth) / 100.0
    (finding,) = judged(with_depth(still, hectopascal - AIR_M)).findings
    assert finding.severity == "error"
    assert "hPa above the air (1.5 to 1.5 m deep)" in finding.sentence
    assert "give pressure.unit, and pressure.atmosphere = 0" in finding.sentence
    assert judged(with_depth(still, 100.0 * hectopascal)).findings == []


def test_pressure_that_nothing_explains_is_refused_until_it_is_left_away():
    true = dive()
    counts = 0.05 * true.pressure.depth + 0.3
    (finding,) = judged(with_depth(true, counts)).findings
    assert finding.values["sensors"] == ["pressure"]
    assert finding.sentence.endswith(
        "leave topics.pressure away, or name the topic of the water's pressure"
    )
    assert judged(replace(true, pressure=None)).findings == []


def test_pressure_of_an_enclosure_is_left_out():
    true = dive()
    still = 0.2 + 0.0002 * np.random.default_rng(2).standard_normal(len(true.pressure.depth))
    found = judged(with_depth(true, still))
    (finding,) = found.findings
    assert (finding.values["sensor"], finding.values["fault"]) == ("pressure", "constant")
    assert found.records.pressure is None
    assert found.tried[0].explains


def test_rates_in_degrees_are_converted():
    true = dive()
    found = judged(with_rates(true, np.degrees(true.imu.angular_velocity)))
    (finding,) = found.findings
    assert finding.values["value"] == "deg/s"
    assert found.records.imu.angular_velocity == pytest.approx(true.imu.angular_velocity)


@pytest.mark.parametrize(
    ("fault", "wrong"),
    [
        ("scale", lambda rates: 7.0 * rates),
        ("bias", lambda rates: rates + np.array([0.05, -0.04, 0.06])),
    ],
)
def test_rates_of_any_factor_or_bias_are_put_right(fault, wrong):
    true = dive()
    found = judged(with_rates(true, wrong(true.imu.angular_velocity)))
    assert [finding.values["fault"] for finding in found.findings] == [fault]
    np.testing.assert_allclose(
        found.records.imu.angular_velocity, true.imu.angular_velocity, atol=0.005
    )


def test_accelerations_along_the_global_axes_are_turned():
    true = dive()
    along = Rotation.from_quat(true.imu.quaternion).apply(true.imu.acceleration)
    found = judged(with_imu(true, acceleration=along))
    assert [finding.values["fault"] for finding in found.findings] == ["global"]
    np.testing.assert_allclose(found.records.imu.acceleration, true.imu.acceleration, atol=1e-9)


def test_rates_about_exchanged_axes_are_turned():
    true = dive()
    found = judged(with_rates(true, true.imu.angular_velocity[:, [1, 0, 2]] * [1, 1, -1]))
    assert found.records.imu.angular_velocity == pytest.approx(true.imu.angular_velocity)


def test_velocities_without_lock_are_left_out():
    true = dive()
    velocity = true.dvl.velocity.copy()
    velocity[60:95] = 0.0
    found = judged(replace(true, dvl=replace(true.dvl, velocity=velocity)))
    assert np.isnan(found.records.dvl.velocity[60:95]).all()
    assert np.isfinite(found.records.dvl.velocity[:60]).all()


def test_dvl_that_looks_the_other_way_is_refused():
    true = dive()
    velocity = true.dvl.velocity * [-1, 1, -1]
    (finding,) = judged(replace(true, dvl=replace(true.dvl, velocity=velocity))).findings
    assert finding.severity == "error"
    assert "DVL" in finding.sentence


@pytest.mark.parametrize("late_s", [0.8, -7.0])
def test_stamps_that_are_late_are_left_to_the_clocks(late_s):
    true = dive()
    moved = replace(true.pressure, t_ns=true.pressure.t_ns + round(late_s * NS))
    found = judged(replace(true, pressure=moved))
    (finding,) = found.findings
    assert finding.code == "sensors-late"
    assert finding.values["seconds"] == pytest.approx(late_s, abs=0.25)


def test_pictures_that_are_mirrored_are_named():
    (finding,) = judged(dive(), flows(np.diag([-1.0, 1.0]))).findings
    assert (finding.severity, finding.values["sensor"]) == ("error", "camera")
    assert finding.values["fault"] == "picture"


@pytest.mark.parametrize(("cause", "named"), [("medium", ["medium"]), ("focal", None)])
def test_known_factor_is_preferred_to_any_that_fits_as_well(cause, named):
    """The chi-squares are those of a small dive with a calibration made in air."""
    faults = [("DVL", "ranges", 41.1), ("camera", "focal", 43.0), ("camera", cause, 43.2)]
    found = [
        (
            Hypothesis(sensor=Sensor(sensor), fault=fault, value="1", mended=dive()),
            Tried(
                sensor=Sensor(sensor),
                fault=fault,
                value="1",
                chi2=chi2,
                chi2_before=128.9,
                explains=True,
            ),
        )
        for sensor, fault, chi2 in faults
    ]
    best = [one.fault for one, _ in explain_best(found)]
    assert best == (named or [fault for _, fault, _ in faults])


def seen_by(lens: Callable[[np.ndarray], np.ndarray]) -> list[Flow]:
    """Flows whose ideal coordinates another calibration changes."""
    return [replace(one, first=lens(one.first), second=lens(one.second)) for one in flows()]


@pytest.mark.parametrize("factor", [0.75, 0.85])
def test_focal_lengths_are_corrected_with_the_distortion_as_it_is(factor):
    """Scaled alone, features far from the middle would seem to turn."""
    right = replace(CAMERA, k1=-0.3, k2=0.08)
    wrong = replace(right, fx=factor * right.fx, fy=factor * right.fy)
    rig = replace(RIG, camera_models={Camera.TOP: wrong})
    seen = seen_by(lambda ideal: wrong.undistort(right.distort(ideal)))
    found = judge(dive(), rig, AIR_M, flows=seen)
    (finding,) = found.findings
    assert (finding.severity, finding.values["sensor"]) == ("error", "camera")
    assert finding.values["fault"] == ("medium" if factor == 0.75 else "focal")
    assert float(finding.values["value"]) == pytest.approx(1 / factor, rel=0.05)


def test_calibration_in_air_behind_a_flat_port_is_named():
    def in_air(ideal: np.ndarray) -> np.ndarray:
        """Refract rays in the water into the port: the sine grows by the refractive index."""
        sine = 1.333 * np.linalg.norm(ideal, axis=1) / np.hypot(1, np.linalg.norm(ideal, axis=1))
        return ideal * (np.tan(np.arcsin(sine)) / np.linalg.norm(ideal, axis=1))[:, None]

    (finding,) = judged(dive(), seen_by(in_air)).findings
    assert (finding.severity, finding.values["sensor"]) == ("error", "camera")
    assert finding.values["fault"] == "port"
    assert "made in air" in finding.sentence


@pytest.mark.parametrize(
    ("orders", "said"),
    [
        (["1, 2, 4, 3"], "1, 2, 4, 3"),
        (["1, 2, 4, 3", "2, 1, 4, 3"], "1, 2, 4, 3 (or 2, 1, 4, 3)"),
        (
            ["1, 2, 4, 3", "2, 1, 4, 3", "2, 4, 1, 3"],
            "1, 2, 4, 3 (or in one of 2 other orders that fit as well)",
        ),
    ],
)
def test_orders_of_beams_that_fit_as_well_are_told(orders, said):
    best = [Hypothesis(sensor=Sensor.DVL, fault="beams", value=o, mended=dive()) for o in orders]
    assert possible_orders(best) == said


@pytest.mark.parametrize("size", [0.5, 2.0])
def test_calibration_of_pictures_of_another_size_is_named(size):
    centre = (CAMERA.cx + 0.5) * size - 0.5, (CAMERA.cy + 0.5) * size - 0.5
    wrong = replace(CAMERA, fx=1000.0 * size, fy=1000.0 * size, cx=centre[0], cy=centre[1])
    seen = seen_by(lambda ideal: wrong.undistort(CAMERA.distort(ideal)))
    rig = replace(RIG, camera_models={Camera.TOP: wrong})
    (finding,) = judge(dive(), rig, AIR_M, flows=seen).findings
    assert (finding.severity, finding.values["sensor"]) == ("error", "camera")
    assert (finding.values["fault"], finding.values["value"]) == ("size", f"{size:g}")


def test_camera_of_another_distortion_is_named_with_its_k1():
    k1 = 0.1
    (finding,) = judged(dive(), flows(k1=k1)).findings
    assert (finding.severity, finding.values["sensor"]) == ("error", "camera")
    assert finding.values["fault"] == "distortion"
    assert float(finding.values["value"]) == pytest.approx(k1, abs=0.051)


def test_distortion_as_good_as_calibrations_are_is_no_contradiction():
    assert judged(dive(), flows(k1=0.01)).findings == []


def test_images_that_are_stamped_early_are_a_clock_and_no_wrong_camera():
    late_s = -0.5
    ns = round(late_s * NS)
    seen = [replace(flow, t_ns=(flow.t_ns[0] + ns, flow.t_ns[1] + ns)) for flow in flows()]
    (finding,) = judged(dive(), seen).findings
    assert (finding.code, finding.values["sensor"]) == ("sensors-late", "camera")
    assert finding.values["seconds"] == pytest.approx(late_s, abs=0.26)


def with_ranges(records: SensorRecords, ranges: np.ndarray) -> SensorRecords:
    return replace(records, dvl=replace(records.dvl, ranges=ranges))


def test_ranges_that_are_too_long_are_named_before_the_camera():
    true = dive()
    (finding,) = judged(with_ranges(true, 1.3 * true.dvl.ranges), flows()).findings
    assert (finding.values["sensor"], finding.values["fault"]) == ("DVL", "ranges")
    assert float(finding.values["value"]) == pytest.approx(1 / 1.3, rel=0.05)


def test_ranges_of_exchanged_beams_are_named_with_the_beams_that_they_are_of():
    true = dive()
    logged = true.dvl.ranges[:, [1, 3, 0, 2]]
    (finding,) = judged(with_ranges(true, logged), flows()).findings
    assert (finding.severity, finding.values["sensor"]) == ("error", "DVL")
    assert "2, 4, 1, 3" in finding.values["value"]


def test_clock_that_runs_slow_is_named_with_its_rate():
    true, rate = dive(), -0.02
    since_ns = true.dvl.t_ns - true.dvl.t_ns[0]
    moved = true.dvl.t_ns + np.round(rate * since_ns).astype(np.int64)
    (finding,) = judged(replace(true, dvl=replace(true.dvl, t_ns=moved)), flows()).findings
    assert (finding.code, finding.values["sensors"]) == ("sensors-drift", ["DVL"])
    assert finding.values["per_cent"] == pytest.approx(100 * rate, abs=0.6)


def test_accelerations_along_exchanged_axes_are_turned():
    true = dive()
    found = judged(with_imu(true, acceleration=true.imu.acceleration[:, [1, 0, 2]]), flows())
    assert [finding.code for finding in found.findings] == ["sensor-mended"]
    np.testing.assert_array_equal(found.records.imu.acceleration, true.imu.acceleration)


def test_dvl_that_measures_too_long_is_named_by_depth_and_images():
    true = dive()
    long = replace(true, dvl=replace(true.dvl, velocity=1.4 * true.dvl.velocity))
    (finding,) = judged(long, flows()).findings
    assert (finding.values["sensor"], finding.values["fault"]) == ("DVL", "scale")


def without_accelerations(records: SensorRecords) -> SensorRecords:
    return with_imu(records, acceleration=np.full_like(records.imu.acceleration, np.nan))


def with_imu(records: SensorRecords, **fields) -> SensorRecords:
    return replace(records, imu=replace(records.imu, **fields))


def with_velocity(records: SensorRecords, factors) -> SensorRecords:
    return replace(records, dvl=replace(records.dvl, velocity=records.dvl.velocity * factors))


def test_scale_of_one_of_two_sensors_names_both():
    (finding,) = judged(with_velocity(without_accelerations(dive()), 1.4)).findings
    assert {"pressure", "DVL"} <= set(finding.values["sensors"])


@pytest.mark.parametrize(
    ("axis", "off", "seen"),
    [(0, -0.08, ()), (1, -0.08, flows()), (2, 0.14, flows())],
)
def test_velocities_off_by_a_constant_blame_the_dvl(axis, off, seen):
    at, wrong = dive(), off * np.eye(3)[axis]
    moved = replace(at, dvl=replace(at.dvl, velocity=at.dvl.velocity + wrong))
    (found,) = judged(moved, seen).findings
    assert found.values["sensor"] == "DVL"
    axes = [float(axis) for axis in found.values["value"].split(", ")]
    assert axes == pytest.approx(wrong, abs=0.05)


def test_velocities_ten_times_too_long_are_no_pressure_that_stands_still():
    (finding,) = judged(with_velocity(dive(), 10.0)).findings
    assert finding.severity == "error"
    assert "DVL" in finding.values["sensors"]


def test_accelerations_tell_whose_scale_is_wrong():
    true = dive()
    (finding,) = judged(with_velocity(true, 1.4)).findings
    assert (finding.values["sensor"], finding.values["value"]) == ("DVL", "0.71")
    (finding,) = judged(with_depth(true, 1.4 * true.pressure.depth)).findings
    assert finding.values["sensor"] == "pressure"


@pytest.mark.parametrize(("factors", "axes"), [([1, -1, 1], "+x -y +z"), ([1, 1, -1], "+x +y -z")])
def test_velocity_with_one_axis_negated_is_put_right(factors, axes):
    true = dive()
    found = judged(with_velocity(true, factors))
    (finding,) = found.findings
    assert [finding.values[key] for key in ("sensor", "value")] == ["DVL", axes]
    np.testing.assert_array_equal(found.records.dvl.velocity, true.dvl.velocity)


@pytest.mark.parametrize("sign", [1, -1])
def test_velocities_along_the_beams_are_converted(sign):
    true = dive()
    along = sign * true.dvl.velocity @ JANUS[:3].T
    found = judged(replace(true, dvl=replace(true.dvl, velocity=along)))
    assert [finding.values["fault"] for finding in found.findings] == ["along"]
    np.testing.assert_allclose(found.records.dvl.velocity, true.dvl.velocity, atol=1e-9)


@pytest.mark.parametrize(("unit", "metres_s"), [("kn", 0.514444), ("km/h", 1 / 3.6)])
def test_velocities_in_another_unit_are_converted_and_no_scale_is_taken(unit, metres_s):
    true = dive()
    found = judged(with_velocity(true, 1 / metres_s))
    assert [finding.values["value"] for finding in found.findings] == [unit]
    np.testing.assert_allclose(found.records.dvl.velocity, true.dvl.velocity)


def logged_otherwise(records: SensorRecords, turns, vectors) -> SensorRecords:
    """The IMU with factors on the vector of its quaternion and on its rates, and accelerations."""
    imu = records.imu
    return with_imu(
        records,
        quaternion=imu.quaternion * [*turns, 1.0],
        angular_velocity=imu.angular_velocity * turns,
        acceleration=imu.acceleration * vectors,
    )


def test_left_handed_imu_is_put_right_where_images_tell_it_from_the_dvl():
    true = dive()
    left = logged_otherwise(true, [-1, 1, -1], [1, -1, 1])
    found = judged(left, flows())
    assert [finding.values["fault"] for finding in found.findings] == ["mirrored"]
    np.testing.assert_allclose(found.records.imu.quaternion, true.imu.quaternion, atol=1e-12)
    np.testing.assert_allclose(found.records.imu.angular_velocity, true.imu.angular_velocity)
    (finding,) = judged(left).findings
    assert finding.values["sensors"] == ["DVL", "IMU's orientation"]


def test_imu_with_one_component_negated_in_all_is_put_right():
    true = dive()
    found = judged(logged_otherwise(true, [1, -1, 1], [1, -1, 1]))
    assert [finding.values["fault"] for finding in found.findings] == ["negated"]
    np.testing.assert_allclose(found.records.imu.acceleration, true.imu.acceleration)


@pytest.mark.parametrize(
    ("order", "given"), [("inverse", Conventions(imu_frame="enu")), ("w x y z", Conventions())]
)
def test_quaternion_of_another_order_is_put_right_in_either_frame(given, order):
    true = dive()
    logged = given.logged(Rotation.from_quat(true.imu.quaternion))
    wrong = logged.inv()
    if order == "w x y z":
        wrong = Rotation.from_quat(logged.as_quat()[:, [3, 0, 1, 2]])
    read = with_imu(true, quaternion=given.read(wrong).as_quat())
    found = judge(read, RIG, AIR_M, given=given)
    assert [finding.values["value"] for finding in found.findings] == [order]
    mended = Rotation.from_quat(found.records.imu.quaternion)
    assert (mended.inv() * Rotation.from_quat(true.imu.quaternion)).magnitude().max() < 1e-9


def test_dvl_that_is_turned_about_its_axis_is_named_before_pressure_and_camera():
    true = dive()
    turn = Rotation.from_euler("z", 45, degrees=True)
    turned = replace(true, dvl=replace(true.dvl, velocity=turn.apply(true.dvl.velocity)))
    (finding,) = judged(turned, flows()).findings
    assert (finding.severity, finding.values["sensor"]) == ("error", "DVL")
    assert finding.values["value"] == "-45"


def with_turned_imu(records: SensorRecords, angle_deg: float) -> SensorRecords:
    vehicle_from_imu = Rotation.from_euler("z", angle_deg, degrees=True)
    return with_imu(
        records,
        quaternion=(Rotation.from_quat(records.imu.quaternion) * vehicle_from_imu).as_quat(),
        angular_velocity=vehicle_from_imu.inv().apply(records.imu.angular_velocity),
        acceleration=vehicle_from_imu.inv().apply(records.imu.acceleration),
    )


def test_imu_that_sits_turned_is_named_before_pressure_dvl_and_camera():
    angle_deg = 180
    (finding,) = judged(with_turned_imu(dive(), angle_deg), flows()).findings
    assert (finding.severity, finding.values["sensor"]) == ("error", "IMU's orientation")
    assert finding.values["fault"] == "mount"
    assert float(finding.values["value"]) == pytest.approx(angle_deg, abs=15)


def test_without_images_an_imu_that_sits_turned_is_no_other_than_a_dvl_that_looks_aside():
    (finding,) = judged(with_turned_imu(dive(), 45)).findings
    assert finding.severity == "error"
    assert set(finding.values["sensors"]) == {"DVL", "IMU's orientation"}


def test_dvl_that_looks_aside_is_named_by_images_with_the_mount_that_heals():
    aside = replace(RIG, tray_from_dvl=from_mount([0, 0, 0.08, 0, 90, 45]))
    (finding,) = judge(dive(), aside, AIR_M, flows=flows()).findings
    assert (finding.values["sensor"], finding.values["fault"]) == ("DVL", "mount")
    (mount,) = re.findall(r"give dvl\.mount = (\[.*\])", finding.sentence)
    assert json.loads(mount) == [0, 0, 0.08, 0, 90, 0]  # that of the dive


@pytest.mark.parametrize(("turned_deg", "named"), [(0, False), (4, False), (20, True)])
def test_accelerations_tell_a_dvl_that_looks_a_little_aside(turned_deg, named):
    """All residuals are small for their sigmas, which allow for thrusters that shake."""
    true = dive()
    start_s = true.imu.t_ns / NS
    surge = np.array([[0.0, 0.15, 0.0]])  # m/s, of a velocity along the hull that comes and goes
    felt = (
        Rotation.from_quat(true.imu.quaternion)
        .inv()
        .apply(0.8 * np.cos(0.8 * start_s)[:, None] * surge)
    )
    heard = true.dvl.t_ns / NS
    faster = (
        (attitude(heard) * RIG.tray_from_dvl.rotation)
        .inv()
        .apply(np.sin(0.8 * heard)[:, None] * surge)
    )
    surging = replace(
        true,
        imu=replace(true.imu, acceleration=true.imu.acceleration + felt),
        dvl=replace(true.dvl, velocity=true.dvl.velocity + faster),
    )
    aside = replace(RIG, tray_from_dvl=from_mount([0, 0, 0, 0, 90, turned_deg]))
    (push,) = compare(Motions(surging, aside), {"push"})
    assert push.accuses == named


@pytest.mark.parametrize("late_s", [18.0, -12.0])
def test_imu_late_at_both_ends_is_moved_where_motion_agrees(late_s):
    true = dive()
    imu = true.imu
    off = replace(true, imu=replace(imu, t_ns=imu.t_ns + round(late_s * NS)))
    records, (said,) = mend_shifted_imu(off, RIG, flows())
    assert np.abs(records.imu.t_ns - imu.t_ns).max() < 0.15 * NS
    assert said.values["seconds"] == pytest.approx(late_s, abs=0.15)
    assert "its accelerations and the DVL show one motion" in said.sentence


def test_imu_that_was_switched_on_and_off_late_is_not_moved():
    true = dive()
    end_ns, since_ns = 22 * NS, 18 * NS
    records = SensorRecords(
        imu=true.imu.take(true.imu.t_ns >= since_ns),
        dvl=true.dvl.take(true.dvl.t_ns < end_ns),
        pressure=true.pressure.take(true.pressure.t_ns < end_ns),
    )
    assert shifted_streams(records.by_name())
    assert mend_shifted_imu(records, RIG, [])[1] == []


def test_two_faults_of_a_tray_explain_no_better_than_one():
    """Whether a small angle in degrees grows the other way hardly shows."""
    rig = replace(RIG, tray_from_dvl=from_mount([0, 0, 0, 0, 87, 0]))
    imu_ns = dive().imu.t_ns
    degrees = JointSamples(t_ns=imu_ns, angle=np.full(len(imu_ns), 3.0))
    found = judge(replace(dive(), tray=degrees), rig, AIR_M, flows=flows())
    (finding,) = found.findings
    assert (finding.values["fault"], finding.values["value"]) == ("unit", "deg")
    chi2 = {(one.fault, one.value): one.chi2 for one in found.tried}
    assert chi2["sign", "deg"] > chi2["unit", "deg"] + GAIN


def test_accelerations_of_gravity_alone_accuse_nobody():
    true = dive()
    gravity = Rotation.from_quat(true.imu.quaternion).inv().apply([0.0, 0.0, -9.81])
    assert judged(with_imu(true, acceleration=gravity)).findings == []


def test_orientation_of_a_vehicle_with_z_up_is_named_before_rates_and_dvl():
    true = dive()
    turned = Rotation.from_quat(true.imu.quaternion) * Rotation.from_euler("x", np.pi)
    (finding,) = judged(with_imu(true, quaternion=turned.as_quat())).findings
    assert (finding.values["sensor"], finding.values["fault"]) == ("IMU's orientation", "frame")
    assert finding.values["value"] == "the vehicle's axes of the orientation alone"


@pytest.mark.parametrize("angle", ["yaw", "pitch", "roll"])
def test_angle_that_grows_the_other_way_is_put_right_or_named(angle):
    true = dive()
    sign = np.where(np.array(["yaw", "pitch", "roll"]) == angle, -1, 1)
    angles = sign * Rotation.from_quat(true.imu.quaternion).as_euler("ZYX")
    found = judged(with_imu(true, quaternion=Rotation.from_euler("ZYX", angles).as_quat()))
    (finding,) = found.findings
    if finding.severity == "error":
        assert "IMU's orientation" in finding.values.get("sensors", [finding.values.get("sensor")])
    else:
        mended = Rotation.from_quat(found.records.imu.quaternion)
        assert (mended.inv() * Rotation.from_quat(true.imu.quaternion)).magnitude().max() < 1e-9


def test_dvl_that_sits_otherwise_is_named_with_the_mount_that_heals():
    upright = replace(RIG, tray_from_dvl=from_mount([0, 0, 0.08, 0, 0, 0]))
    (finding,) = judge(dive(), upright, AIR_M, flows=flows()).findings
    assert (finding.values["sensor"], finding.values["fault"]) == ("DVL", "axes")
    (mount,) = re.findall(r"give dvl\.mount = (\[.*\])", finding.sentence)
    assert json.loads(mount) == [0, 0, 0.08, 0, 90, 0]  # that of the dive


SIDEWAYS = Rotation.from_euler("ZYX", [0, 0, 90], degrees=True)


@pytest.mark.parametrize(
    ("down", "own", "fault"),
    [
        (NED_FROM_ENU, FRD_FROM_FLU, "frame"),
        (NED_FROM_ENU, Rotation.identity(), "frame"),
        (Rotation.identity(), SIDEWAYS, "body"),
        (Rotation.identity(), Rotation.from_euler("z", 90, degrees=True), "mount"),
    ],
    ids=[
        "forward, port, up",
        "east, north, up of forward, starboard, down",
        "on its side",
        "turned about the vertical",
    ],
)
def test_convention_of_an_imu_is_named_with_the_keys_that_heal(down, own, fault):
    true = dive()
    rates, acceleration = (
        own.inv().apply(axes) for axes in (true.imu.angular_velocity, true.imu.acceleration)
    )
    quaternion = (down * Rotation.from_quat(true.imu.quaternion) * own).as_quat()
    logged = [
        ImuSample(int(t_ns), *readings)
        for t_ns, *readings in zip(true.imu.t_ns, quaternion, rates, acceleration, strict=True)
    ]
    seen = flows() if fault == "mount" else []  # images tell it from a DVL that looks aside
    (finding,) = judged(replace(true, imu=imu_samples(logged, "ned", [])), seen).findings
    assert (finding.values["sensor"], finding.values["fault"]) == ("IMU's orientation", fault)
    frame = re.findall(r'imu\.frame = "(\w+)"', finding.sentence) or ["ned"]
    mount = re.findall(r"imu\.mount_deg = (\[.*?\])", finding.sentence) or ["[0, 0, 0]"]
    healed = imu_samples(logged, frame[0], [], tuple(json.loads(mount[0])))
    assert judged(replace(true, imu=healed), seen).findings == []


@pytest.mark.parametrize(
    ("down", "own", "axes"),
    [
        (NED_FROM_ENU, NED_FROM_ENU, "+y +x -z for those of the vehicle, -z downwards"),
        (FRD_FROM_FLU, NED_FROM_ENU, "+y +x -z for those of the vehicle, -z downwards"),
    ],
    ids=["components exchanged", "frames in the wrong order"],
)
def test_orientation_of_other_axes_is_named_before_rates_and_dvl(down, own, axes):
    given = dive()
    logged = (down * Rotation.from_quat(given.imu.quaternion) * own).as_quat()
    (found,) = judged(replace(given, imu=replace(given.imu, quaternion=logged)), flows()).findings
    assert (found.values["sensor"], found.values["fault"]) == ("IMU's orientation", "axes")
    assert found.values["value"] == axes


def swung(records: SensorRecords, swing_rad: np.ndarray) -> SensorRecords:
    """The dive with a heading that is off by `swing_rad`, one for each reading of the IMU."""
    turn = Rotation.from_euler("z", swing_rad[:, None])
    quaternion = (turn * Rotation.from_quat(records.imu.quaternion)).as_quat()
    return with_imu(records, quaternion=quaternion)


@pytest.mark.parametrize("seen", [[], flows()], ids=["no camera", "camera"])
@pytest.mark.parametrize("swing_deg", [4.0, 12.0])
def test_compass_that_swings_is_put_right_by_the_rates(swing_deg, seen):
    true = dive()
    swing = np.radians(swing_deg) * np.sin(0.25 * true.imu.t_ns / NS)
    found = judged(swung(true, swing), seen)
    (finding,) = found.findings
    assert (finding.code, finding.values["fault"]) == ("sensor-mended", "heading")
    off = Rotation.from_quat(found.records.imu.quaternion) * attitude(true.imu.t_ns / NS).inv()
    heading = np.degrees(off.as_rotvec()[:, 2])
    assert np.ptp(heading) < swing_deg / 2
    slope = np.polyfit(true.imu.t_ns / NS, heading, 1)[0]  # degrees a second
    assert abs(slope) < 3 * np.degrees(found.heading_drift_sigma_rad_s)


def test_compass_without_fault_adds_no_drift():
    assert judged(dive()).heading_drift_sigma_rad_s == 0.0


@pytest.mark.parametrize("factor", [0.0, 2.0], ids=["dead", "twice as fast"])
def test_rates_that_are_wrong_about_the_vertical_are_not_taken_for_a_compass(factor):
    records = dive()
    rates = records.imu.angular_velocity * [1.0, 1.0, factor]
    (finding,) = judged(with_imu(records, angular_velocity=rates)).findings
    assert finding.values["sensors"] == ["IMU's rates", "IMU's orientation"]


def test_compass_that_turns_twice_as_far_as_the_rates_is_told_with_the_key_that_heals():
    """Soft iron does that, and so do rates of a wrong scale: either may be wrong."""
    true = dive()
    given = swung(true, attitude(true.imu.t_ns / NS).as_euler("ZYX")[:, 0])
    (finding,) = judged(given).findings
    assert finding.values["sensors"] == ["IMU's rates", "IMU's orientation"]
    assert 'give imu.heading = "rates"' in finding.sentence
    logged = Rotation.from_quat(given.imu.quaternion)
    healed = heading_by_rates(given.imu.t_ns, logged, given.imu.angular_velocity)
    assert not judged(with_imu(given, quaternion=healed.rotation.as_quat())).findings


def test_orientation_that_stands_still_does_not_blame_the_rates_alone():
    true = dive()
    still = np.tile(true.imu.quaternion[:1], (len(true.imu.t_ns), 1))
    (finding,) = judged(replace(true, imu=replace(true.imu, quaternion=still))).findings
    assert finding.severity == "error"
    assert "IMU's orientation" in finding.values.get("sensors", [finding.values.get("sensor")])


@pytest.mark.parametrize(("stated_deg", "accused"), [(0.8, True), (1.5, False)])
def test_backlash_within_the_stated_sigma_of_the_tray_accuses_nobody(stated_deg, accused):
    seen = flows()
    for k in (1, 4, 7, 10):  # the tray's load turned by 1.3 degrees that the angle does not show
        across = RIG.tray_from_top.rotation.inv().apply([0.0, np.radians(1.3), 0.0])[0]
        moved = np.cross(across, [0.0, 0.0, 1.0])[:2]
        seen[k] = replace(seen[k], second=seen[k].second + moved)
    rig = replace(RIG, priors=RigPriors(tray_sigma_rad=np.radians(stated_deg)))
    assert bool(judge(dive(), rig, AIR_M, flows=seen).findings) == accused


CHANGE_S = 22.0  # when a driver starts anew


def from_change_on(logged: np.ndarray, otherwise: np.ndarray, t_ns: np.ndarray) -> np.ndarray:
    """What is logged by a driver that starts anew with other settings."""
    return np.where(t_ns[:, None] >= CHANGE_S * NS, otherwise, logged)


def part_of(records: SensorRecords, seen=()):
    return judge_parts(records, RIG, AIR_M, seen)


@pytest.mark.parametrize("seed", range(5))
def test_sensors_that_agree_in_all_parts_are_not_accused(seed):
    assert part_of(dive(seed), flows()) is None


def test_fault_of_a_whole_dive_is_no_fault_of_a_part():
    assert part_of(with_velocity(dive(), [1, -1, 1])) is None


@pytest.mark.parametrize("from_on", [True, False])
def test_velocity_of_other_axes_in_a_part_is_named_with_the_time(from_on):
    true = dive()
    dvl, other = true.dvl, true.dvl.velocity * [-1, 1, 1]
    velocities = (dvl.velocity, other) if from_on else (other, dvl.velocity)
    velocity = from_change_on(*velocities, dvl.t_ns)
    found = part_of(replace(true, dvl=replace(dvl, velocity=velocity)))
    assert [found.values[key] for key in ("sensor", "value")] == ["DVL", "-x +y +z"]
    assert found.severity == "error"
    assert found.values["from_on"] == from_on
    limit = datetime.fromisoformat(found.values["time"]).timestamp()
    before_s = CHANGE_S - limit if from_on else limit - CHANGE_S
    assert 0.0 <= before_s < 4.0  # what is left without the part has no fault in it
    assert f"dive.{'to' if from_on else 'from'} = {found.values['time']}" in found.sentence


def test_quaternion_of_another_order_in_a_part_is_named():
    true = dive()
    imu = true.imu
    turned = from_change_on(imu.quaternion, np.roll(imu.quaternion, 1, axis=1), imu.t_ns)
    found = part_of(replace(true, imu=replace(imu, quaternion=turned)))
    assert [found.values[key] for key in ("sensor", "fault")] == ["IMU's orientation", "order"]


def test_pictures_that_stand_on_their_head_in_a_part_blame_the_camera_alone():
    upright, turned = flows(), flows(-np.eye(2))
    seen = [
        after if before.t_ns[0] >= CHANGE_S * NS else before
        for before, after in zip(upright, turned, strict=True)
    ]
    found = part_of(dive(), seen)
    assert [found.values[key] for key in ("sensor", "fault")] == ["camera", "picture"]


def with_quaternion_from_w(records: SensorRecords) -> SensorRecords:
    turned = np.roll(records.imu.quaternion, 1, axis=1)
    return replace(records, imu=replace(records.imu, quaternion=turned))


def test_two_faults_that_meet_in_one_comparison_are_both_put_right():
    true = dive()
    both = with_quaternion_from_w(with_velocity(true, [1, -1, 1]))
    found = judge_pairs(both, RIG, AIR_M)
    named = {(one.values["sensor"], one.values["value"]) for one in found.findings}
    assert named == {("IMU's orientation", "w x y z"), ("DVL", "+x -y +z")}
    assert {one.severity for one in found.findings} == {"warning"}
    np.testing.assert_array_equal(found.records.dvl.velocity, true.dvl.velocity)
    np.testing.assert_allclose(found.records.imu.quaternion, true.imu.quaternion)
    assert found.cost < judged(both).cost  # of a pressure whose clock is 10 s off


def test_pressure_in_another_unit_beside_other_axes_is_absolute():
    true = dive()
    logged = with_depth(true, (true.pressure.depth + AIR_M) / 1e4 - AIR_M)
    found = judge_pairs(with_velocity(logged, [-1, 1, 1]), RIG, AIR_M)
    assert {one.values["fault"] for one in found.findings} == {"unit", "axes"}
    assert np.abs(found.records.pressure.depth - true.pressure.depth).max() < 0.3
