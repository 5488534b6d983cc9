# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.samples import (
    DepthSample,
    DvlSample,
    ImuSample,
    JointSample,
    PressureSample,
    SonarSample,
)
from hullrecon.dive.logs.streams.dvl import dvl_pings
from hullrecon.dive.logs.streams.imu import NED_FROM_ENU, imu_samples
from hullrecon.dive.logs.streams.joints import joint_samples
from hullrecon.dive.logs.streams.pressure import PressureModel, pressure_samples
from hullrecon.dive.logs.streams.sonar import sonar_pings
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding, sentences

S, C = 0.5, np.sqrt(0.75)
BEAMS = np.array([[-S, 0, C], [S, 0, C], [0, S, C], [0, -S, C]])


def ping(t=0, velocity=(0.1, 0.2, 0.3), sigma=np.nan, ranges=(1, 2, 3, 4), beams=BEAMS):
    return DvlSample(t, np.array(velocity, float), sigma, np.array(ranges, float), beams)


def test_beams_that_change_are_averaged_and_remarked():
    notes = []
    tilted = BEAMS @ Rotation.from_euler("z", 0.02).as_matrix()
    found = dvl_pings([ping(0), ping(1, beams=tilted)], None, 0.003, notes).beams
    assert np.linalg.norm(found, axis=1) == pytest.approx(np.ones(4))
    assert "change during the dive" in notes[0].sentence


def test_the_sigma_of_the_file_stands_where_the_message_has_none():
    pings = dvl_pings([ping(0), ping(1, sigma=0.02), ping(2, sigma=0.0)], None, 0.003, [])
    assert pings.velocity_sigma.tolist() == [0.003, 0.02, 0.003]


def test_a_half_lost_velocity_and_a_senseless_one_are_lost_whole():
    notes = []
    pings = dvl_pings(
        [ping(0, (0.1, np.nan, 0)), ping(1, (300, 0, 0)), ping(2)], None, 0.003, notes
    )
    assert np.isnan(pings.velocity).all(axis=1).tolist() == [True, True, False]
    assert "1 velocities above 15 m/s" in notes[0].sentence


def test_velocities_relative_to_the_water_are_counted():
    notes, water = [], replace(ping(1, [np.nan] * 3), not_over_ground="relative to the water")
    dvl_pings([ping(0), water, ping(2)], None, 0.003, notes)
    assert "1 of 3 velocities are relative to the water" in notes[0].sentence


def test_velocities_rounded_to_tenths_are_refused_until_they_have_more_digits():
    velocities = 0.2 * np.random.default_rng(1).standard_normal((40, 3))
    pings = [ping(t, velocity) for t, velocity in enumerate(np.round(velocities, 1))]
    with pytest.raises(InputError, match=r"rounded to 0\.1 m/s"):
        dvl_pings(pings, None, 0.003, [])
    pings = [ping(t, velocity) for t, velocity in enumerate(np.round(velocities, 2))]
    assert np.isfinite(dvl_pings(pings, None, 0.003, []).velocity).all()


def test_velocities_without_one_axis_are_refused_until_it_is_there():
    velocities = 0.2 * np.random.default_rng(1).standard_normal((40, 3))
    pings = [ping(t, velocity * [1, 1, 0]) for t, velocity in enumerate(velocities)]
    with pytest.raises(InputError, match="along z is exactly 0 in all 40 pings"):
        dvl_pings(pings, None, 0.003, [])
    pings = [ping(t, velocity) for t, velocity in enumerate(velocities)]
    assert np.isfinite(dvl_pings(pings, None, 0.003, []).velocity).all()


def test_ranges_not_positive_or_infinite_are_lost():
    pings = dvl_pings([ping(ranges=(0, -1, np.inf, 2))], None, 0.003, [])
    assert np.isnan(pings.ranges[0]).tolist() == [True, True, True, False]


def test_pings_without_any_range_have_no_beams():
    pings = dvl_pings([ping(ranges=(), beams=None)], None, 0.003, [])
    assert pings.ranges.shape == (1, 0)
    assert pings.beams.shape == (0, 3)


def imu(t, quaternion, rates=(1, 2, 3), acceleration=(4, 5, 6)):
    return ImuSample(
        t, np.array(quaternion, float), np.array(rates, float), np.array(acceleration, float)
    )


def test_ned_attitudes_are_taken_as_they_are():
    found = imu_samples([imu(0, [0, 0, 0, 1])], "ned", [])
    assert found.quaternion[0] == pytest.approx([0, 0, 0, 1])
    assert found.angular_velocity[0].tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("enu_yaw_deg", "ned_yaw_deg"), [(90.0, 0.0), (0.0, 90.0), (-90.0, 180.0), (180.0, -90.0)]
)  # east is 0 in ENU and 90 in NED
def test_enu_headings_become_ned_headings(enu_yaw_deg, ned_yaw_deg):
    quaternion = Rotation.from_euler("z", enu_yaw_deg, degrees=True).as_quat()
    found = imu_samples([imu(0, quaternion)], "enu", [])
    want = Rotation.from_euler("z", ned_yaw_deg, degrees=True)
    assert (Rotation.from_quat(found.quaternion[0]).inv() * want).magnitude() == pytest.approx(
        0, abs=1e-9
    )


def test_negative_pitch_in_enu_becomes_nose_up_in_ned():
    quaternion = Rotation.from_euler("ZYX", [90, -10, 5], degrees=True).as_quat()
    found = imu_samples([imu(0, quaternion)], "enu", [])
    yaw, pitch, roll = Rotation.from_quat(found.quaternion[0]).as_euler("ZYX", degrees=True)
    assert (roll, pitch, yaw) == pytest.approx((5, 10, 0), abs=1e-9)
    assert found.angular_velocity[0].tolist() == [1, -2, -3]
    assert found.acceleration[0].tolist() == [4, -5, -6]


def test_readings_without_attitude_are_left_out_and_counted():
    notes = []
    found = imu_samples(
        [imu(0, [0, 0, 0, 0]), imu(1, [0, 0, 0, 1.001]), imu(2, [np.nan] * 4)], "ned", notes
    )
    assert found.t_ns.tolist() == [1]
    assert np.linalg.norm(found.quaternion[0]) == pytest.approx(1)
    assert "2 of 3 readings" in notes[0].sentence


def test_gravity_that_a_filter_took_off_is_added_by_the_orientation():
    notes = []
    tilted = Rotation.from_euler("x", 30, degrees=True).as_quat()
    found = imu_samples([imu(0, tilted, acceleration=(0.1, 0, 0))], "ned", notes)
    want = [0.1, -9.80665 * 0.5, -9.80665 * np.sqrt(0.75)]
    assert found.acceleration[0] == pytest.approx(want)
    assert "gravity taken off (their median is 0.1 m/s2)" in notes[0].sentence


def test_gravity_is_not_added_where_the_orientation_turns_over_amid_the_dive():
    upright, on_its_back = [0, 0, 0, 1], [1, 0, 0, 0]
    samples = [
        imu(t, upright if t < 10 else on_its_back, acceleration=(0, 0, -9.81)) for t in range(20)
    ]
    notes = []
    found = imu_samples(samples, "ned", notes)
    np.testing.assert_allclose(found.acceleration, np.tile([0, 0, -9.81], (20, 1)))
    assert notes == []


def test_accelerations_that_nobody_filled_in_are_left_out():
    still = [imu(t, [0, 0, 1e-4 * t, 1], acceleration=(0, 0, 0)) for t in range(50)]
    assert np.isnan(imu_samples(still, "ned", []).acceleration).all()


def test_an_imu_without_any_attitude_is_refused():
    with pytest.raises(InputError, match="no attitude"):
        imu_samples([imu(0, [0, 0, 0, 0])], "ned", [])
    assert len(imu_samples([imu(0, [0, 0, 0, 1])], "ned", []).t_ns) == 1


def test_quaternions_of_whole_numbers_are_scaled_to_unit_length():
    angles = np.linspace(0.2, 0.4, 60)
    turned = np.column_stack([0 * angles, 0 * angles, np.sin(angles), np.cos(angles)])
    notes = []
    logged = [imu(t, np.round(16384 * q)) for t, q in enumerate(turned)]
    np.testing.assert_allclose(imu_samples(logged, "ned", notes).quaternion, turned, atol=1e-4)
    assert "16384 long" in notes[0].sentence
    euler = [imu(t, [0.0, 0.01 * t, 0.0, 1.0 + 0.01 * t]) for t in range(60)]
    with pytest.raises(InputError, match="are they angles"):
        imu_samples(euler, "ned", [])


MODEL = PressureModel(1025.0, 9.81, 101325.0)
DEPTHS = {"kind": "depth", "first": 0.1, "second": 0.1, "misfit": 0.0}  # compared with a way


TURNED = np.array([0.0, 0.0, 0.6, 0.8])


@pytest.mark.parametrize(
    ("quaternion", "rates", "why"),
    [
        ([0, 0, 0, 1], (0, 0, 0), "the default of a message"),
        ([0, 0, 0, -1], (np.nan,) * 3, "the default of a message"),
        (TURNED, (0, 0, 0.01), "while its rates are not zero"),
    ],
)
def test_an_orientation_that_is_never_filled_in_is_refused(quaternion, rates, why):
    with pytest.raises(InputError, match=f"the same, .* in all 50 readings, .*{why}"):
        imu_samples([imu(t, quaternion, rates) for t in range(50)], "ned", [])
    turning = [imu(t, [0, 0, 1e-4 * t, 1], rates) for t in range(50)]
    assert len(imu_samples(turning, "ned", []).t_ns) == 50


def test_few_equal_attitudes_or_a_vehicle_at_rest_are_accepted():
    assert len(imu_samples([imu(t, [0, 0, 0, 1]) for t in range(49)], "ned", []).t_ns) == 49
    assert len(imu_samples([imu(t, TURNED, (0, 0, 0)) for t in range(60)], "ned", []).t_ns) == 60
    moved = [imu(t, [0, 0, 0, 1]) for t in range(59)] + [imu(59, TURNED)]
    assert len(imu_samples(moved, "ned", []).t_ns) == 60


def test_a_hundredth_of_a_megapascal_is_a_metre_of_sea_water():
    notes = []
    found = pressure_samples(
        [PressureSample(0, 101325 + 1025 * 9.81 * 2), PressureSample(1, np.nan)], MODEL, notes
    )
    assert found.depth == pytest.approx([2.0])
    assert found.t_ns.tolist() == [0]
    assert sentences(notes) == [
        "pressure: 1 of 2 readings are no finite numbers, or marked as lost, and were left out"
    ]


def test_a_sensor_of_which_no_reading_is_a_number_has_no_record():
    notes = []
    assert (
        pressure_samples([PressureSample(0, np.nan), PressureSample(1, np.inf)], MODEL, notes)
        is None
    )
    assert joint_samples([JointSample(0, "tray", np.nan)], "sonar_tray", "tray", notes) is None
    assert sentences(notes) == [
        "pressure: 2 of 2 readings are no finite numbers, or marked as lost, and were left out",
        "joint tray: 1 of 1 readings are no finite numbers, or marked as lost, and were left out",
    ]


@pytest.mark.parametrize(
    ("unit", "readings"),
    [
        ("hPa", [1013.25, 1213.25]),
        ("kPa", [101.325, 121.325]),
        ("dbar", [10.1325, 12.1325]),
        ("bar", [1.01325, 1.21325]),
    ],
)
def test_a_pressure_of_another_unit_is_refused_with_one_that_heals(unit, readings):
    samples = [PressureSample(k, value) for k, value in enumerate(readings)]
    with pytest.raises(InputError, match=rf'pressure\.unit = "{unit}" \(0\.'):
        pressure_samples(samples, MODEL, [])
    healed = pressure_samples(samples, replace(MODEL, unit=unit), [])
    assert healed.depth == pytest.approx([0.0, 20_000 / (1025 * 9.81)], abs=1e-9)


def test_a_technical_atmosphere_is_read_where_it_is_given_and_named_beside_the_bar():
    """Motion does not tell the two apart: one is 2 % more than the other."""
    bar = Finding(
        "sensor-mended", {"sensor": "pressure", "fault": "unit", "value": "bar", **DEPTHS}
    )
    (unit,) = re.findall(r'then give pressure\.unit = "(.*?)"', bar.sentence)
    samples = [PressureSample(0, 121325 / 98066.5)]
    read = pressure_samples(samples, replace(MODEL, unit=unit), [])
    assert read.depth == pytest.approx([20_000 / (1025 * 9.81)])


def test_hectopascals_logged_as_depths_are_asked_for():
    samples = [DepthSample(t, 1013.25 + 100 + t, is_up=False) for t in range(30)]
    with pytest.raises(InputError, match="a pressure, or in centimetres, which") as caught:
        pressure_samples(samples, MODEL, [])
    assert 'pressure.unit = "hPa" (1.0 to 1.3 m deep then) or "cm" (11.1 to' in caught.value.remedy
    told = pressure_samples(samples, replace(MODEL, unit="hPa"), [])
    assert told.depth[0] == pytest.approx(1.0, abs=0.01)
    pascals = [DepthSample(t, 101325.0 + 10055 * t, is_up=False) for t in range(30)]
    with pytest.raises(InputError, match=r'a pressure .*give pressure\.unit = "Pa" \(1\.'):
        pressure_samples(pascals, MODEL, [])
    shallow = [DepthSample(t, 150.0 + t, is_up=False) for t in range(30)]  # centimetres
    assert pressure_samples(shallow, MODEL, []) is not None


def test_a_gauge_pressure_is_refused_with_the_atmosphere_that_heals():
    samples = [PressureSample(0, 20_000.0)]
    with pytest.raises(InputError, match=r"pressure\.atmosphere = 0"):
        pressure_samples(samples, MODEL, [])
    healed = pressure_samples(samples, replace(MODEL, atmosphere=0.0), [])
    assert healed.depth == pytest.approx([20_000 / (1025 * 9.81)])


def test_a_number_is_a_pressure_or_a_depth_by_its_unit():
    for unit, value in (("mbar", 1213.25), ("cm", 198.9), ("ft", 6.526)):
        samples = [DepthSample(0, value, is_up=False)]
        found = pressure_samples(samples, replace(MODEL, unit=unit), [])
        assert found.depth == pytest.approx([1.989], abs=2e-3)


def test_a_tray_whose_messages_hold_no_angle_is_refused():
    with pytest.raises(InputError, match=r'or set tray\.joint = ""') as refused:
        joint_samples([JointSample(0, "servo", np.nan)] * 3, "tray", "servo", [])
    assert refused.value.what == "none of the 3 messages of joint servo holds its angle"


def test_joint_angles_in_degrees_are_refused_until_their_unit_is_given():
    samples = [JointSample(0, "tray", 45.0), JointSample(1, "tray", np.nan)]
    with pytest.raises(InputError, match=r'tray\.joint_unit = "deg"'):
        joint_samples(samples, "tray", "tray", [])
    notes = []
    found = joint_samples(samples, "tray", "tray", notes, "deg")
    assert found.angle == pytest.approx([np.pi / 4])
    assert sentences(notes) == [
        "joint tray: 1 of 2 readings are no finite numbers, or marked as lost, and were left out"
    ]


def test_angles_that_are_counted_from_0_to_360_degrees_are_joined():
    true = np.radians([3.0, 0.5, -0.5, -2.0, 1.0])
    notes = []
    logged = [JointSample(t, "tray", a) for t, a in enumerate(true % (2 * np.pi))]
    found = joint_samples(logged, "tray", "tray", notes)
    assert found.angle == pytest.approx(true)
    assert "jump by a whole turn 2 times" in notes[0].sentence


def test_a_sonars_rotator_may_turn_more_than_once():
    notes = []
    found = joint_samples([JointSample(0, "pan", 9.0)], "sonar_tray", "pan", notes)
    assert found.angle.tolist() == [9.0]
    assert 'are they in degrees (give sonar.joint_unit = "deg" then)?' in notes[0].sentence
    found = joint_samples([JointSample(0, "pan", 9.0)], "sonar_tray", "pan", notes, "deg")
    assert np.degrees(found.angle) == pytest.approx([9.0])
    assert len(notes) == 1


@pytest.mark.parametrize("unit", ["cm/s", "mm/s"])
def test_velocities_of_another_unit_are_refused_until_it_is_given(unit):
    scale = {"cm/s": 100.0, "mm/s": 1000.0}[unit]
    samples = [
        DvlSample(k, scale * np.array([0.3, 0.01, 0.0]), 0.003 * scale, np.zeros(0), None)
        for k in range(3)
    ]
    with pytest.raises(InputError, match=rf'"{unit}" \(0\.3 m/s\)'):
        dvl_pings(samples, None, 0.01, [])
    found = dvl_pings(samples, None, 0.01, [], unit)
    assert found.velocity == pytest.approx(np.tile([0.3, 0.01, 0.0], (3, 1)))
    assert found.velocity_sigma == pytest.approx(0.003)


def test_rates_in_degrees_and_axes_of_another_convention_are_put_right():
    """East-north-up orientation of a body forward, starboard, down: the vehicle's own axes."""
    ned_from_body = Rotation.from_euler("ZYX", [0.7, 0.2, -0.1])
    enu_from_body = NED_FROM_ENU.inv() * ned_from_body
    rates = np.array([0.01, 0.02, -0.03])
    samples = [ImuSample(0, enu_from_body.as_quat(), np.degrees(rates), np.full(3, np.nan))]
    found = imu_samples(samples, "enu", [], (180.0, 0.0, 0.0), "deg/s")
    assert found.angular_velocity[0] == pytest.approx(rates)
    turn = Rotation.from_quat(found.quaternion[0]) * ned_from_body.inv()
    assert turn.magnitude() < 1e-9


def sonar(t, image, reach=1.5):
    image = np.asarray(image)
    directions = np.stack(
        [np.zeros(len(image)), np.zeros(len(image)), np.full(len(image), 2.0)], axis=1
    )
    return SonarSample(t, image, directions, np.linspace(1, reach, image.shape[1]))


def test_sonar_pings_of_another_range_are_left_out_and_counted():
    notes = []
    pixels = np.zeros((2, 3), np.uint8)
    found = sonar_pings([sonar(0, pixels), sonar(1, pixels, 1.8), sonar(2, pixels)], notes)
    assert found.t_ns.tolist() == [0, 2]
    assert found.directions[0] == pytest.approx([0, 0, 1])
    assert "1 of 3 pings" in notes[0].sentence


def test_deep_sonar_pixels_are_scaled_to_8_bits_by_brightest():
    notes = []
    found = sonar_pings([sonar(0, np.array([[0, 500], [1000, 250]], np.uint16))], notes)
    assert found.image.tolist() == [[[0, 128], [255, 64]]]
    assert "scaled to 8 bits" in notes[0].sentence


@pytest.mark.parametrize("dtype", [np.uint16, np.uint32, np.float32])
def test_few_saturated_pixels_do_not_darken_a_sonar_image(dtype):
    pixels = np.tile(np.linspace(0, 2000, 400).astype(dtype), (10, 1))
    saturated = pixels.copy()
    saturated[3:5, 7] = 65535
    found = sonar_pings([sonar(0, pixels), sonar(1, saturated)], [])
    assert found.image[0, 0, -1] == 255
    assert found.image[0, 0, 200] == pytest.approx(128, abs=1)
    np.testing.assert_array_equal(
        found.image[1][saturated < 3000], found.image[0][saturated < 3000]
    )
    assert (found.image[1][saturated > 3000] == 255).all()


def test_few_overbright_pings_do_not_darken_the_others():
    pixels = np.tile(np.linspace(0, 2000, 20).astype(np.uint16), (10, 1))
    found = sonar_pings([sonar(t, pixels + (60000 if t == 50 else 0)) for t in range(200)], [])
    assert found.image[0].max() == 255
    assert found.image[50].min() == 255


def test_pixels_that_are_no_finite_numbers_set_no_scale():
    pixels = np.array([[np.nan, 500, np.inf], [1000, 250, 0]], np.float32)
    assert sonar_pings([sonar(0, pixels)], []).image.tolist() == [[[0, 128, 255], [255, 64, 0]]]


def test_a_few_echoes_in_black_are_not_black():
    pixels = np.zeros((100, 100), np.uint16)
    pixels[50, 50:53] = [300, 150, 600]
    found = sonar_pings([sonar(0, pixels)], [])
    assert found.image[0, 50, 50:53].tolist() == [128, 64, 255]


def test_black_pings_stay_black():
    assert not sonar_pings([sonar(0, np.zeros((2, 2), np.float32))], []).image.any()


def test_no_pings_are_no_record():
    assert sonar_pings([], []) is None


def test_ranges_in_millimetres_are_refused():
    with pytest.raises(InputError, match=r"half of the DVL's ranges are 2500 m or more"):
        dvl_pings([ping(ranges=(1000, 2000, 3000, 4000))], None, 0.003, [])
    for ranges in ((1, 2, 3, 4), ()):  # in metres, or left away
        assert len(dvl_pings([ping(ranges=ranges)], None, 0.003, []).t_ns) == 1


def test_angles_of_a_servo_that_are_neither_radians_nor_degrees_are_refused():
    samples = [JointSample(t, "tray", angle) for t, angle in enumerate((1500.0, 1580.0))]
    with pytest.raises(InputError, match="more than a whole turn") as caught:
        joint_samples(samples, "tray", "tray", [])
    assert "they are neither" in caught.value.remedy
    for unit, angle in (("rad", 0.1), ("deg", 5.7)):
        logged = [JointSample(t, "tray", angle) for t in range(2)]
        assert joint_samples(logged, "tray", "tray", [], unit).angle[0] < 0.11


def test_angles_written_as_a_quaternion_are_refused_by_their_length():
    samples = [imu(t, [1.0, -2.0, 3.0 * (t > 0), 0.0]) for t in range(20)]
    with pytest.raises(InputError, match=r"none of 20 .* half of them are 3.74 long or more"):
        imu_samples(samples, "ned", [])


def test_depths_that_no_vehicle_reaches_are_left_out_and_counted():
    depth = np.linspace(2, 3, 40)
    depth[[7, 20, 21, 39]] = [650, -4, -3, 99]
    samples = [DepthSample(k * 10**8, value, is_up=False) for k, value in enumerate(depth)]
    notes = []
    model = PressureModel(1025, 9.81, 101325)
    found = pressure_samples(samples, model, notes)
    assert sorted({*depth} - {*found.depth}) == [-4, -3, 99, 650]
    assert "4 of 40 readings lie farther" in notes[0].sentence


def test_readings_of_an_imu_that_stood_still_are_left_out():
    turns = [Rotation.from_euler("z", min(k, 30) / 100).as_quat() for k in range(60)]
    stood = [imu(k * 10**8, q, rates=(0, 0, min(k, 30))) for k, q in enumerate(turns)]
    notes = []
    found = imu_samples(stood, "ned", notes)
    assert len(found.t_ns) == 31
    assert "29 readings repeat" in notes[0].sentence
