# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, identity
from hullrecon.geometry.rotations import roll_pitch_yaw
from hullrecon.synthetic import instruments
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.options import DiveSpec, spec_from, with_options
from hullrecon.synthetic.vehicle import BEAMS, TRANSPONDER, TRAY_ORIGIN, Motion


@pytest.fixture
def hovering() -> Motion:
    """At rest, level, 3 m deep, for a minute."""
    t = np.arange(0, 60, 0.02)
    zero = np.zeros_like(t)
    position = np.stack([zero, zero, zero + 3], 1)
    return Motion(
        t_s=t,
        position=position,
        roll_pitch_yaw=np.zeros((len(t), 3)),
        encoder=zero,
        tray=zero,
        sonar_tray=zero,
        global_from_hull=identity(),
    )


def test_beams_are_unit_vectors_thirty_degrees_off_axis() -> None:
    np.testing.assert_allclose(np.linalg.norm(BEAMS, axis=1), 1)
    np.testing.assert_allclose(np.degrees(np.arccos(BEAMS[:, 2])), 30)


def test_velocity_is_that_of_instrument_in_its_own_frame(dive: Dive) -> None:
    dvl = instruments.dvl(dive.spec, dive.motion, dive.rig, dive.hull)
    step = 0.02
    place = lambda t: dive.motion.on_tray(t, dive.rig.tray_from_dvl, TRAY_ORIGIN)  # noqa: E731
    moved = (place(dvl.t_s + step).translation - place(dvl.t_s - step).translation) / (2 * step)
    true = place(dvl.t_s).rotation.inv().apply(moved)
    error = dvl.velocity - (1 + dive.spec.errors.dvl_scale_error) * true
    assert np.abs(error).max() < 6 * instruments.VELOCITY_SIGMA
    assert error.std() == pytest.approx(instruments.VELOCITY_SIGMA, rel=0.3)


def test_ranges_end_on_hull_as_built(dive: Dive) -> None:
    dvl = instruments.dvl(dive.spec, dive.motion, dive.rig, dive.hull)
    at = dive.motion.in_hull(dive.motion.on_tray(dvl.t_s, dive.rig.tray_from_dvl, TRAY_ORIGIN))
    hits = dive.hull.near(0.0).rays.cast(at.translation, at.rotation.apply(BEAMS[2]))
    error = dvl.ranges[:, 2] - hits.range_m
    assert np.nanmedian(np.abs(error)) < 1.5 * instruments.RANGE_SIGMA


def test_some_beams_are_lost_and_some_are_wild(dive: Dive) -> None:
    at = dive.motion.in_hull(
        dive.motion.on_tray(np.full(4000, 5.0), dive.rig.tray_from_dvl, TRAY_ORIGIN)
    )
    ranges = instruments._ranges(np.random.default_rng(1), at, dive.hull)
    assert np.isnan(ranges).mean() == pytest.approx(instruments.LOST_SHARE, rel=0.2)
    wild = np.abs(ranges - np.nanmedian(ranges, axis=0)) > 0.1
    assert wild.mean() == pytest.approx(instruments.WILD_SHARE, rel=0.4)


def test_beam_beside_hull_comes_back_empty(dive: Dive) -> None:
    away = Poses(np.array([[0.0, 0, 0, 1]]), np.array([[0.0, 100.0, 0.0]]))
    assert np.isnan(instruments._ranges(np.random.default_rng(1), away, dive.hull)).all()


def test_pressure_is_that_of_depth_with_bias_of_centimetres(hovering: Motion) -> None:
    series = instruments.pressure(DiveSpec(), hovering)
    depth = (series.value - 101325.0) / (1025.0 * 9.81)
    assert abs(abs(depth.mean() - 3.0) - 0.03) < 0.005
    assert depth.std() == pytest.approx(instruments.DEPTH_SIGMA, rel=0.2)


def test_without_time_between_them_no_positions_are_measured(dive: Dive) -> None:
    assert len(instruments.positions(dive.spec, dive.motion).t_s) == 0


def test_positions_are_transponder_in_frame_of_any_direction(dive: Dive) -> None:
    """Distances between them are those of the true path; z is up, and a mirrored path would not
    fit.
    """
    spec = with_options(dive.spec, position_every_s=0.5, position_sigma_m=0.0)
    found = instruments.positions(spec, dive.motion)
    true = dive.motion.vehicle(found.t_s).apply(np.array(TRANSPONDER))
    east, north, up = found.value.T
    np.testing.assert_allclose(up, -true[:, 2])
    there, here = np.column_stack([north, east]), true[:, :2]
    turn, _ = Rotation.align_vectors(
        # level, so the turn is a heading
        *(np.pad(xy - xy.mean(axis=0), ((0, 0), (0, 1))) for xy in (there, here))
    )
    np.testing.assert_allclose(
        turn.apply(np.pad(here - here.mean(0), ((0, 0), (0, 1))))[:, :2],
        there - there.mean(0),
        atol=1e-9,
    )
    assert np.abs(turn.as_rotvec()[:2]).max() < 1e-6
    assert np.diff(found.t_s) == pytest.approx(0.5, abs=0.05)


def test_positions_have_noise_and_outliers_that_are_asked_for(hovering: Motion) -> None:
    spec = spec_from(position_every_s=0.1, position_sigma_m=0.3, position_outlier_share=0.2)
    at = instruments.positions(spec, hovering).value[:, :2]
    off = np.abs(at - np.median(at, axis=0))
    assert np.median(off) == pytest.approx(0.6745 * 0.3, rel=0.5)
    assert (off.max(axis=1) > 1.5).mean() == pytest.approx(0.2, abs=0.06)


def test_level_imu_at_rest_feels_gravity_upwards(hovering: Motion) -> None:
    imu = instruments.imu(DiveSpec(), hovering)
    np.testing.assert_allclose(imu.force.mean(0), [0, 0, -9.81], atol=0.01)
    np.testing.assert_allclose(imu.rates.mean(0), 0, atol=0.002)


def test_attitude_has_bias_in_roll_and_pitch_of_tenths_of_degree(hovering: Motion) -> None:
    imu = instruments.imu(DiveSpec(), hovering)
    rpy = np.degrees(roll_pitch_yaw(Rotation.from_quat(imu.quaternion)))
    assert 0.005 < np.abs(rpy[:, :2].mean(0)).max() < 0.5
    assert np.abs(rpy[:, 2]).max() < 0.5


def test_rates_of_sensors_are_as_promised(hovering: Motion) -> None:
    for series, rate in (
        (instruments.pressure(DiveSpec(), hovering), 10),
        (instruments.joints(DiveSpec(), hovering), 10),
        (instruments.imu(DiveSpec(), hovering), 25),
    ):
        assert 1 / np.diff(series.t_s).mean() == pytest.approx(rate, rel=0.01)
        assert (np.diff(series.t_s) > 0).all()


def test_joints_report_encoder_not_tray(dive: Dive) -> None:
    reported = instruments.joints(with_options(dive.spec, servo_sigma_deg=0.0), dive.motion)
    np.testing.assert_allclose(
        reported.value[:, 0], dive.motion.angle(dive.motion.encoder, reported.t_s)
    )
    np.testing.assert_allclose(
        reported.value[:, 1], dive.motion.angle(dive.motion.sonar_tray, reported.t_s)
    )


@pytest.mark.parametrize("drift", [0.0, 90.0, -360.0])
def test_heading_drifts_by_what_was_asked_for(hovering: Motion, drift: float) -> None:
    imu = instruments.imu(spec_from(heading_drift_deg_per_hour=drift), hovering)
    heading = np.degrees(roll_pitch_yaw(Rotation.from_quat(imu.quaternion))[:, 2])
    # the walk is not noiseless
    assert 3600 * np.polyfit(imu.t_s, heading, 1)[0] == pytest.approx(drift, abs=6.0)


def test_drift_alone_changes_nothing_but_heading(hovering: Motion) -> None:
    calm, drifting = (
        instruments.imu(spec_from(heading_drift_deg_per_hour=d), hovering) for d in (0.0, 90.0)
    )
    np.testing.assert_array_equal(calm.rates, drifting.rates)
    np.testing.assert_array_equal(calm.force, drifting.force)
    turned = roll_pitch_yaw(Rotation.from_quat(drifting.quaternion)) - roll_pitch_yaw(
        Rotation.from_quat(calm.quaternion)
    )
    np.testing.assert_allclose(
        turned, np.radians(90.0) / 3600 * calm.t_s[:, None] * [0, 0, 1], atol=1e-9
    )


@pytest.mark.parametrize("error", [0.0, 0.05, -0.02])
def test_velocities_are_too_long_by_scale_error(dive: Dive, error: float) -> None:
    plain = instruments.dvl(
        with_options(dive.spec, dvl_scale_error=0.0), dive.motion, dive.rig, dive.hull
    )
    scaled = instruments.dvl(
        with_options(dive.spec, dvl_scale_error=error), dive.motion, dive.rig, dive.hull
    )
    slope = ((scaled.velocity - plain.velocity) * plain.velocity).sum() / (plain.velocity**2).sum()
    assert slope == pytest.approx(error, rel=0.02, abs=1e-12)
    np.testing.assert_array_equal(plain.ranges, scaled.ranges)


def test_encoder_is_as_noisy_as_asked(dive: Dive) -> None:
    quiet, noisy = (
        instruments.joints(with_options(dive.spec, servo_sigma_deg=s), dive.motion).value
        for s in (0.0, 0.3)
    )
    assert np.degrees(noisy - quiet).std() == pytest.approx(0.3, rel=0.15)
