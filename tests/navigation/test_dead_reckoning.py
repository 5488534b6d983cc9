# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from navigation.instruments import SIGMAS
from scipy.spatial.transform import Rotation

from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.dead_reckoning.dead_reckon import (
    Navigated,
    NavigationLogs,
    dead_reckon,
    usable_logs,
)
from hullrecon.navigation.sigmas import NavigationSigmas
from hullrecon.rig import Rig


def reckoned(logs: NavigationLogs, rig: Rig, sigmas: NavigationSigmas = SIGMAS) -> Navigated:
    return dead_reckon(usable_logs(logs), rig, sigmas)


def truth_at(simulated, found: Navigated) -> Poses:
    t = (found.trajectory.t_ns - 1_777_887_000_000_000_000) * 1e-9
    place = simulated.place(t) - simulated.place(np.zeros(1)) * [1, 1, 0]
    return Poses(simulated.attitude(t).as_quat(), place)


def edges_error(simulated, found: Navigated) -> np.ndarray:
    """(m, 6) true minus measured motion, translation in i and rotation in the measured j."""
    true, o = truth_at(simulated, found), found.odometry
    step = true[o.first].inverse() @ true[o.second]
    turn = Rotation.from_quat(o.quaternion).inv() * step.rotation
    return np.hstack([step.translation - o.translation, turn.as_rotvec()])


def test_perfect_instruments_reproduce_path_with_lever_and_tray(simulated, perfect, rig):
    found = reckoned(perfect, rig)
    error = found.trajectory.translation - truth_at(simulated, found).translation
    assert np.abs(error).max() < 2e-3  # 20 Hz, trapezoid
    assert np.abs(edges_error(simulated, found)).max() < 1e-4


def test_path_starts_at_origin_and_depth_is_below_surface(simulated, perfect, rig):
    found = reckoned(perfect, rig)
    first = truth_at(simulated, found).translation[0]
    assert np.allclose(found.trajectory.translation[0], first, atol=2e-3)
    assert found.trajectory.translation[0, 2] == pytest.approx(2.0, abs=0.05)


def test_a_lever_that_is_forgotten_shows(simulated, perfect, rig):
    shifted = replace(rig, tray_origin=rig.tray_origin + np.array([0.2, 0, 0]))
    error = edges_error(simulated, reckoned(perfect, shifted))
    assert np.abs(error[:, :3]).max() > 2e-3


def test_odometry_does_not_know_the_pressure(perfect, rig):
    depth = perfect.pressure.depth + 3.0 + np.linspace(0, 1, len(perfect.pressure.depth))
    lifted = replace(perfect, pressure=replace(perfect.pressure, depth=depth))
    plain, other = reckoned(perfect, rig), reckoned(lifted, rig)
    assert np.array_equal(plain.odometry.translation, other.odometry.translation)
    assert other.trajectory.translation[0, 2] - plain.trajectory.translation[0, 2] == pytest.approx(
        3.0, abs=0.05
    )


def test_odometry_errors_are_as_large_as_their_covariance_says(simulated, noisy, rig):
    found = reckoned(noisy, rig)
    white = np.linalg.inv(np.linalg.cholesky(found.odometry.covariance))
    error = np.einsum("nij,nj->ni", white, edges_error(simulated, found))
    assert 0.7 < np.sqrt(np.mean(error[:, :3] ** 2)) < 1.3
    assert 0.4 < np.sqrt(np.mean(error[:, 3:] ** 2)) < 1.3


def test_rates_make_the_attitude_far_better_than_one_reading(simulated, noisy, rig):
    with_rates = edges_error(simulated, reckoned(noisy, rig))[:, 3:]
    silent = replace(
        noisy,
        imu=replace(noisy.imu, angular_velocity=np.full_like(noisy.imu.angular_velocity, np.nan)),
    )
    without = reckoned(silent, rig)
    assert np.std(with_rates) < 0.3 * np.std(edges_error(simulated, without)[:, 3:])
    assert any("no rates" in words for words in without.remarks)


def test_depth_neither_drifts_with_dvl_nor_scatters(simulated, noisy, rig):
    fast = replace(
        noisy, dvl=replace(noisy.dvl, velocity=noisy.dvl.velocity + np.array([0.01, 0, 0]))
    )
    found = reckoned(fast, rig)
    error = found.trajectory.translation[:, 2] - truth_at(simulated, found).translation[:, 2]
    assert np.abs(error).max() < 0.012  # 0.40 m by the DVL alone, 0.02 m a reading


def test_error_is_within_sigma_with_wrong_scale_and_mount(simulated, noisy, rig):
    mount = rig.tray_from_dvl.rotation * Rotation.from_rotvec([0.004, -0.003, 0.005])
    off = replace(rig, tray_from_dvl=Poses(mount.as_quat(), rig.tray_from_dvl.translation))
    found = reckoned(
        replace(noisy, dvl=replace(noisy.dvl, velocity=1.004 * noisy.dvl.velocity)), off
    )
    error = found.trajectory.translation - truth_at(simulated, found).translation
    sigma = np.sqrt(np.diagonal(found.trajectory.covariance, axis1=1, axis2=2))[:, :3]
    assert np.abs(error[-1, :2]).max() > 0.01
    assert (np.abs(error) < 3 * sigma).all()
    assert np.sqrt(np.mean((error[-20:, :2] / sigma[-20:, :2]) ** 2)) > 0.2
    assert (np.linalg.eigvalsh(found.trajectory.covariance) > 0).all()


def central(changed, step: float) -> np.ndarray:
    """Numeric derivative (m, 6) of the odometry by a cause: `changed(c)` gives logs and rig with it
    accounted for.
    """
    plus, minus = (dead_reckon(*changed(c), SIGMAS).odometry for c in (step, -step))
    turn = (
        Rotation.from_quat(minus.quaternion).inv() * Rotation.from_quat(plus.quaternion)
    ).as_rotvec()
    return np.hstack([plus.translation - minus.translation, turn]) / (2 * step)


def test_the_derivative_by_scale_is_that_of_reckoning_anew(perfect, rig):
    def changed(e: float):
        return replace(
            perfect, dvl=replace(perfect.dvl, velocity=(1 + e) * perfect.dvl.velocity)
        ), rig

    assert np.allclose(
        reckoned(perfect, rig).odometry.by_navigation[:, :, 0], central(changed, 1e-3), atol=1e-8
    )


def test_heading_drift_derivative_equals_numeric(perfect, rig):
    silent = replace(
        perfect,
        imu=replace(
            perfect.imu, angular_velocity=np.full_like(perfect.imu.angular_velocity, np.nan)
        ),
    )
    t = (silent.imu.t_ns - silent.dvl.t_ns[0]) * 1e-9

    def changed(c: float):
        turned = Rotation.from_rotvec(np.outer(c * t, [0, 0, 1])) * Rotation.from_quat(
            silent.imu.quaternion
        )
        return replace(silent, imu=replace(silent.imu, quaternion=turned.as_quat())), rig

    numeric = central(changed, 1e-4)
    assert np.allclose(reckoned(silent, rig).odometry.by_navigation[:, :, 1], numeric, atol=2e-4)
    assert np.allclose(
        reckoned(silent, rig).odometry.by_navigation[:, 3:, 1], numeric[:, 3:], atol=1e-6
    )


def test_the_derivative_by_mount_is_that_of_reckoning_anew(perfect, rig):
    analytic = reckoned(perfect, rig).odometry.by_mount
    for k in range(3):

        def changed(c: float, k: int = k):
            turn = rig.tray_from_dvl.rotation * Rotation.from_rotvec(c * np.eye(3)[k])
            return perfect, replace(
                rig, tray_from_dvl=Poses(turn.as_quat(), rig.tray_from_dvl.translation)
            )

        assert np.allclose(analytic[:, :, k], central(changed, 1e-4), atol=1e-7)


def test_the_derivative_by_tray_is_that_of_reckoning_anew(perfect, rig):
    def changed(d: float):
        return replace(perfect, tray=replace(perfect.tray, angle=perfect.tray.angle + d)), rig

    assert np.allclose(reckoned(perfect, rig).odometry.by_tray, central(changed, 1e-4), atol=1e-7)


def test_the_covariance_of_the_path_is_that_of_its_causes(perfect, rig):
    """All sigmas but the scale's are nothing: what is left is the outer product of the path's
    change by scale.
    """
    alone = replace(
        SIGMAS,
        mount=np.zeros(6),
        heading_drift_rad_s=0.0,
        tilt_bias_rad=0.0,
        tray_rad=0.0,
        tilt_rad=0.0,
        scale=0.1,
    )
    still = replace(
        perfect, dvl=replace(perfect.dvl, velocity_sigma=np.full(len(perfect.dvl.t_ns), 1e-6))
    )
    base = reckoned(still, rig, alone).trajectory
    faster = reckoned(
        replace(still, dvl=replace(still.dvl, velocity=1.1 * still.dvl.velocity)), rig, alone
    ).trajectory
    moved = (faster.translation - base.translation)[:, :2]
    assert np.allclose(base.covariance[-1, :2, :2], np.outer(moved[-1], moved[-1]), atol=1e-5)


def test_velocities_beyond_an_imu_that_stopped_are_counted(perfect, rig):
    imu_s = (perfect.imu.t_ns - perfect.dvl.t_ns[0]) * 1e-9
    found = reckoned(replace(perfect, imu=perfect.imu.take(imu_s < 10), top=None, bottom=None), rig)
    (velocities,) = [words for words in found.remarks if "of its velocities" in words]
    assert velocities.startswith(
        "DVL: 74 % of its velocities (588 of 800) lie where no attitude was read and are not used"
    )
    (ranges,) = [words for words in found.remarks if "of its ranges" in words]
    assert ranges.endswith("of 3200) lie before or after the path and are not used")


def test_imu_without_velocity_is_noted_under_water_not_on_deck(perfect, rig):
    dvl_s = (perfect.dvl.t_ns - perfect.dvl.t_ns[0]) * 1e-9
    stopped = replace(perfect, dvl=perfect.dvl.take(dvl_s < 15), top=None, bottom=None)
    (words,) = [
        words for words in reckoned(stopped, rig).remarks if "of its readings under water" in words
    ]
    assert float(words.split()[1]) == pytest.approx(25.5, abs=1.0)
    depth = np.where(
        (perfect.pressure.t_ns - perfect.dvl.t_ns[0]) * 1e-9 > 16, 0.0, perfect.pressure.depth
    )
    on_deck = replace(stopped, pressure=replace(perfect.pressure, depth=depth))
    assert not [words for words in reckoned(on_deck, rig).remarks if "under water" in words]


def test_a_dive_that_dvl_and_imu_cover_leaves_nothing_out(noisy, rig):
    assert not [
        words
        for words in reckoned(noisy, rig).remarks
        if "not used" in words or "under water" in words
    ]


def test_a_slow_dvl_has_no_outage_between_two_pings(perfect, rig):
    slow = perfect.dvl.take(np.arange(len(perfect.dvl.t_ns)) % 20 == 0)
    assert not [
        words for words in reckoned(replace(perfect, dvl=slow), rig).remarks if "outage" in words
    ]
    holed = slow.take(np.abs(np.arange(len(slow.t_ns)) - 20) > 2)
    (words,) = [
        words for words in reckoned(replace(perfect, dvl=holed), rig).remarks if "outage" in words
    ]
    assert words.startswith("DVL: 1 outage bridged at constant velocity, the longest 6.0 s")


def test_an_outage_is_bridged_reported_and_widens_the_covariance(simulated, perfect, rig, silenced):
    whole, holed = reckoned(perfect, rig), reckoned(silenced(perfect, 10.0, 14.0), rig)
    error = holed.trajectory.translation - truth_at(simulated, holed).translation
    assert np.abs(error[:, :2]).max() < 0.25
    wide, usual = holed.odometry.covariance[:, 0, 0], whole.odometry.covariance[:, 0, 0]
    inside = slice(21, 26)
    assert (wide[inside] > 20 * usual[inside]).all()
    assert np.allclose(wide[:15], usual[:15])
    assert any("1 outage bridged" in words and "4.1 s" in words for words in holed.remarks)
    assert holed.facts["outages_s"] == [[9.95, 14.05]]


def test_a_wild_velocity_is_rejected_and_reported(simulated, perfect, rig):
    velocity = perfect.dvl.velocity.copy()
    velocity[200] += [3.0, 0, 0]
    found = reckoned(replace(perfect, dvl=replace(perfect.dvl, velocity=velocity)), rig)
    assert (
        np.abs(found.trajectory.translation - truth_at(simulated, found).translation).max() < 3e-3
    )
    assert any("1 velocity rejected" in sentence for sentence in found.remarks)


def test_a_hole_in_the_attitude_is_reported_and_widens_the_turn(perfect, rig):
    t = (perfect.imu.t_ns - perfect.dvl.t_ns[0]) * 1e-9
    kept = (t < 20) | (t > 22)
    fields = ("t_ns", "quaternion", "angular_velocity", "acceleration")
    imu = replace(perfect.imu, **{f: getattr(perfect.imu, f)[kept] for f in fields})
    found = reckoned(replace(perfect, imu=imu), rig)
    assert any("1 gap in the attitude" in words for words in found.remarks)
    assert found.odometry.covariance[40, 5, 5] > 100 * found.odometry.covariance[10, 5, 5]


def until(record, stop_s: float, *fields: str):
    """A record whose sensor stopped."""
    kept = (record.t_ns - 1_777_887_000_000_000_000) * 1e-9 < stop_s
    return replace(record, **{name: getattr(record, name)[kept] for name in ("t_ns", *fields)})


def test_stopped_pressure_sensor_gives_no_depth_afterwards(simulated, noisy, rig):
    whole = reckoned(noisy, rig)
    found = reckoned(replace(noisy, pressure=until(noisy.pressure, 15.0, "depth")), rig)
    t = (found.trajectory.t_ns - 1_777_887_000_000_000_000) * 1e-9
    read, unread = t < 15.0, t > 15.5
    np.testing.assert_array_equal(found.attitude.sigma[read], whole.attitude.sigma[read])
    assert (found.attitude.sigma[unread, 0] >= 100.0).all()
    error = np.abs(found.trajectory.translation - truth_at(simulated, found).translation)[:, 2]
    sigma = np.sqrt(found.trajectory.covariance[:, 2, 2])
    assert (error < 3 * sigma).all()
    assert sigma[-1] > 1.05 * sigma[read][-1]  # DVL, mount and tray drift from there
    assert (
        "pressure: no reading for 24.4 s of the path's 39.0; there the depth "
        "is counted on by the DVL"
    ) in found.remarks


def test_depths_at_nodes_carry_slow_pressure_readings_once(simulated, noisy, rig, frames):
    many = replace(noisy, top=frames(np.arange(0.25, 39.5, 0.1)))
    usual = dead_reckon(many, rig, SIGMAS).attitude.sigma[:, 0]
    assert usual[50:-50] == pytest.approx(SIGMAS.depth_m, rel=0.01)
    pressure = replace(
        noisy.pressure, t_ns=noisy.pressure.t_ns[::10], depth=noisy.pressure.depth[::10]
    )
    slow = replace(many, pressure=pressure)
    sigma = dead_reckon(slow, rig, SIGMAS).attitude.sigma[:, 0]
    assert (1 / sigma**2).sum() == pytest.approx(40 / SIGMAS.depth_m**2, rel=0.1)
    rare = dead_reckon(noisy, rig, SIGMAS).attitude.sigma[:, 0]
    assert (rare == SIGMAS.depth_m).all()


def test_a_pressure_sensor_that_never_ran_beside_the_dvl_is_none(perfect, rig):
    late = replace(perfect.pressure, t_ns=perfect.pressure.t_ns + 10**12)
    found = reckoned(replace(perfect, pressure=late), rig)
    assert (found.attitude.sigma[:, 0] >= 100.0).all()
    assert any("no pressure" in words for words in found.remarks)


def test_a_tray_that_is_no_longer_read_may_have_turned_on(simulated, perfect, rig):
    found = reckoned(replace(perfect, tray=until(perfect.tray, 20.0, "angle")), rig)
    whole = reckoned(perfect, rig)
    t = (found.trajectory.t_ns - 1_777_887_000_000_000_000) * 1e-9
    sigma, wrong = found.attitude.tray_sigma, np.abs(simulated.tray(t) - found.trajectory.tray)
    assert (sigma[t < 20] == 0).all()
    assert (wrong < 1e-3 + 3 * sigma).all()
    assert wrong.max() > 0.3
    assert (found.odometry.covariance[-5:, 0, 0] > 2 * whole.odometry.covariance[-5:, 0, 0]).all()
    error = np.abs(found.trajectory.translation - truth_at(simulated, found).translation)[:, :2]
    assert (
        error < 3 * np.sqrt(np.diagonal(found.trajectory.covariance, axis1=1, axis2=2))[:, :2]
    ).all()
    assert any(words.startswith("tray: no reading for 19.") for words in found.remarks)


def test_tray_logged_only_when_turning_is_known_at_rest(perfect, rig):
    t = perfect.dvl.t_ns[0] + 10**9 * np.array([-1, 0, 1, 30, 31, 41])
    tray = replace(perfect.tray, t_ns=t, angle=np.array([0.0, 0.1, 0.2, 0.2, 0.3, 0.3]))
    assert (reckoned(replace(perfect, tray=tray), rig).attitude.tray_sigma == 0).all()


def test_roll_and_pitch_in_attitude_gap_have_wide_sigma(perfect, rig):
    t = (perfect.imu.t_ns - perfect.dvl.t_ns[0]) * 1e-9
    kept = (t < 20) | (t > 30)
    fields = ("t_ns", "quaternion", "angular_velocity", "acceleration")
    imu = replace(perfect.imu, **{f: getattr(perfect.imu, f)[kept] for f in fields})
    sigma = reckoned(replace(perfect, imu=imu), rig).attitude.sigma[:, 1]
    assert sigma.max() == pytest.approx(0.25, rel=0.1)
    assert sigma[:38] == pytest.approx(SIGMAS.tilt_rad)


def test_images_of_the_upper_camera_alone_are_counted(perfect, rig):
    bottom = replace(perfect.top, usable=np.arange(len(perfect.top.t_ns)) < 60)
    found = reckoned(replace(perfect, bottom=bottom), rig)
    assert "19 images of the upper camera without a partner in the lower one" in found.remarks


def test_a_step_in_depth_is_reported(perfect, rig):
    depth = perfect.pressure.depth.copy()
    depth[200:] += 1.0
    found = reckoned(replace(perfect, pressure=replace(perfect.pressure, depth=depth)), rig)
    assert any("pressure: 1 step" in words for words in found.remarks)


def test_without_pressure_the_depth_is_unknown_and_said(perfect, rig):
    found = reckoned(replace(perfect, pressure=None), rig)
    assert found.trajectory.covariance[0, 2, 2] >= 100.0
    assert (found.attitude.sigma[:, 0] >= 100.0).all()
    assert any("no pressure" in words for words in found.remarks)


def test_without_tray_angles_it_stands_at_zero_and_says_so(perfect, rig):
    found = reckoned(replace(perfect, tray=None), rig)
    assert (found.trajectory.tray == 0).all()
    assert any("tray" in words for words in found.remarks)


def test_a_dvl_that_never_saw_the_bottom_is_an_error_in_words(perfect, rig, silenced):
    with pytest.raises(StageError, match="no velocity to reckon with"):
        reckoned(silenced(perfect, -1, 100), rig)


def test_an_imu_without_orientation_is_an_error_in_words(perfect, rig):
    blind = replace(
        perfect, imu=replace(perfect.imu, quaternion=np.full_like(perfect.imu.quaternion, np.nan))
    )
    with pytest.raises(StageError, match="no orientation"):
        reckoned(blind, rig)
    assert len(reckoned(perfect, rig).trajectory.t_ns)  # the same, filled in


def test_imu_with_single_orientation_is_refused_as_such(perfect, rig):
    quaternion = np.full_like(perfect.imu.quaternion, np.nan)
    quaternion[0] = perfect.imu.quaternion[0]
    with pytest.raises(StageError, match="a single orientation"):
        reckoned(replace(perfect, imu=replace(perfect.imu, quaternion=quaternion)), rig)
    quaternion[-1] = perfect.imu.quaternion[-1]  # of a window that left one reading of two
    wider = replace(perfect, imu=replace(perfect.imu, quaternion=quaternion))
    assert len(reckoned(wider, rig).trajectory.t_ns)


def test_the_same_logs_give_the_same_numbers(noisy, rig):
    a, b = reckoned(noisy, rig), reckoned(noisy, rig)
    assert np.array_equal(a.trajectory.covariance, b.trajectory.covariance)
    assert np.array_equal(a.odometry.quaternion, b.odometry.quaternion)
