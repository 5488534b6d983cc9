# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The errors of dead reckoning, against paths that were reckoned anew with the error in the
instruments.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from navigation.instruments import SIGMAS
from scipy.spatial.transform import Rotation

from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.dead_reckoning import error_propagation
from hullrecon.navigation.dead_reckoning.dead_reckon import NavigationLogs, dead_reckon
from hullrecon.navigation.dead_reckoning.error_propagation import (
    pose_by_error,
    trajectory_covariance,
    twist_by_pose_error,
)
from hullrecon.navigation.dead_reckoning.reckoning import Reckoning, reckon
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.sensors.velocity import usable_velocities
from hullrecon.navigation.sigmas import NavigationSigmas
from hullrecon.records.sensors import ImuSamples
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.trajectory import TrajectoryErrorModel
from hullrecon.rig import Rig
from hullrecon.vision.pairs.camera_track import CameraTrack, NavigationErrors

NO_HOLES = np.zeros((0, 2), np.int64)


def imu_rows(imu: ImuSamples, rows: np.ndarray) -> ImuSamples:
    return ImuSamples(**{name: values[rows] for name, values in to_arrays(imu).items()})


def path_of(logs: NavigationLogs, rig: Rig, error: np.ndarray) -> Reckoning:
    """Dead reckoning of instruments that err by `error` (ERRORS,), the depth's bias aside."""
    span = int(logs.imu.t_ns[0]), int(logs.imu.t_ns[-1])
    velocities = usable_velocities(logs.dvl, span)
    velocities = replace(
        velocities, velocity=(1 + error[error_propagation.SCALE]) * velocities.velocity
    )
    t = (logs.imu.t_ns - logs.dvl.t_ns[0]) * 1e-9
    heading = error[error_propagation.HEADING] + error[error_propagation.DRIFT] * t
    turned = Rotation.from_euler("z", heading[:, None]) * Rotation.from_quat(logs.imu.quaternion)
    turned = turned * Rotation.from_rotvec([*error[error_propagation.ROLL_PITCH], 0.0])
    history = AttitudeHistory(logs.imu.t_ns, turned.as_quat(), 1e-4, 0.0, NO_HOLES, False)
    mount = rig.tray_from_dvl.rotation * Rotation.from_rotvec(error[error_propagation.MOUNT_TURN])
    off = replace(rig, tray_from_dvl=Poses(mount.as_quat(), rig.tray_from_dvl.translation))
    hung = servo(logs.tray, 0)
    hung = replace(hung, angle=hung.angle + error[error_propagation.TRAY_BACKLASH] * hung.direction)
    return reckon(velocities, history, hung, off)


def nodes_of(logs: NavigationLogs) -> np.ndarray:
    return logs.dvl.t_ns[40::60]


def numeric(logs: NavigationLogs, rig: Rig, column: int, step: float = 1e-4) -> np.ndarray:
    """(n, 6): central difference of the poses by one error."""
    error = np.zeros(error_propagation.ERRORS)
    error[column] = step
    plus, minus = (path_of(logs, rig, sign * error).at(nodes_of(logs)).poses() for sign in (1, -1))
    turn = (minus.rotation.inv() * plus.rotation).as_rotvec()
    return np.hstack([plus.translation - minus.translation, turn]) / (2 * step)


@pytest.mark.parametrize(
    ("column", "tolerance"),
    # The drift's turn of a velocity grows between two pings, the play flips between two readings.
    [
        (0, 1e-6),
        (1, 5e-3),
        (2, 1e-5),
        (3, 1e-5),
        (4, 1e-5),
        (5, 2e-2),
        (6, 1e-5),
        (7, 1e-5),
        (8, 1e-5),
    ],
)
def test_the_path_changes_with_each_error_as_reckoning_anew_says(
    perfect, rig, column: int, tolerance: float
) -> None:
    analytic = pose_by_error(
        path_of(perfect, rig, np.zeros(error_propagation.ERRORS)).at(nodes_of(perfect))
    )[:, :, column]
    assert np.abs(analytic).max() > 0.5
    assert np.abs(analytic - numeric(perfect, rig, column)).max() < tolerance


def certain(**sigma: float) -> NavigationSigmas:
    """Every error that persists is nothing, but for those named."""
    none = {
        "scale": 0.0,
        "heading_drift_rad_s": 0.0,
        "tilt_bias_rad": 0.0,
        "tray_rad": 0.0,
        "tilt_rad": 0.0,
    }
    return replace(SIGMAS, mount=np.zeros(6), **(none | sigma))


def test_heading_drift_covariance_equals_that_of_a_drifted_path(perfect, rig) -> None:
    drift = 1e-3
    silent = replace(
        perfect,
        imu=replace(
            perfect.imu, angular_velocity=np.full_like(perfect.imu.angular_velocity, np.nan)
        ),
        dvl=replace(perfect.dvl, velocity_sigma=np.full(len(perfect.dvl.t_ns), 1e-6)),
    )
    t = (silent.imu.t_ns - silent.dvl.t_ns[0]) * 1e-9
    turned = Rotation.from_euler("z", (drift * t)[:, None]) * Rotation.from_quat(
        silent.imu.quaternion
    )
    drifted = replace(silent, imu=replace(silent.imu, quaternion=turned.as_quat()))
    off = certain(heading_drift_rad_s=drift)
    base, other = (dead_reckon(logs, rig, off).trajectory for logs in (silent, drifted))
    moved = (other.translation - base.translation)[:, :2]
    assert np.linalg.norm(moved[-1]) > 0.1
    for k in (20, 40, 60, -1):
        assert np.allclose(
            base.covariance[k, :2, :2],
            np.outer(moved[k], moved[k]),
            atol=0.02 * moved[k] @ moved[k],
        )


def delayed(logs: NavigationLogs, stream: str, late_s: float) -> NavigationLogs:
    of = getattr(logs, stream)
    return replace(logs, **{stream: replace(of, t_ns=of.t_ns + round(late_s * 1e9))})


@pytest.mark.parametrize(
    ("stream", "sigma"), [("dvl", "dvl_late_s"), ("pressure", "pressure_late_s")]
)
def test_delay_moves_the_path_by_what_its_sigma_says(noisy, rig, stream, sigma) -> None:
    late_s = 0.05
    off = certain(**{sigma: late_s, "depth_bias_m": 0.0})
    base, other = (dead_reckon(logs, rig, off) for logs in (noisy, delayed(noisy, stream, late_s)))
    t_ns, place = other.trajectory.t_ns, other.trajectory.translation
    at = base.trajectory.t_ns
    moved = np.stack([np.interp(at, t_ns, axis) for axis in place.T], axis=1)
    moved -= base.trajectory.translation
    model = base.error_model
    column = error_propagation.DVL_LATE if stream == "dvl" else error_propagation.PRESSURE_LATE
    said = np.linalg.inv(twist_by_pose_error(base.trajectory.poses())) @ model.by_error
    said = late_s * said[:, :3, column]
    # to the first ping, at which the path is zero, the others are relative
    moved, said = ((of - of[5])[5:-5] for of in (moved, said))
    assert np.abs(moved).max() > 0.004
    assert np.abs(moved - said).max() < 0.3 * np.abs(moved).max()


def test_delay_of_the_dvl_widens_the_edges_by_its_largest_shift(noisy, rig) -> None:
    late_s = 0.05
    sure, unsure = (dead_reckon(noisy, rig, certain(dvl_late_s=s)) for s in (0.0, late_s))
    more = unsure.odometry.covariance - sure.odometry.covariance
    speed = np.linalg.norm(unsure.error_model.by_error[:, :3, error_propagation.DVL_LATE], axis=1)
    assert np.sqrt(more[:, 0, 0].sum()) == pytest.approx(late_s * speed.max(), rel=0.1)


def relative_by_error(
    logs: NavigationLogs, rig: Rig, first: np.ndarray, second: np.ndarray, step: float = 1e-4
) -> np.ndarray:
    """Central differences (m, 6, ERRORS) of relative poses of paths reckoned anew."""
    out = np.zeros((len(first), 6, error_propagation.ERRORS))
    for k in range(error_propagation.DEPTH_BIAS):
        error = step * np.eye(error_propagation.ERRORS)[k]
        plus, minus = (
            path_of(logs, rig, sign * error).at(nodes_of(logs)).poses() for sign in (1, -1)
        )
        after, before = plus[second].inverse() @ plus[first], minus[second].inverse() @ minus[first]
        turn = (before.rotation.inv() * after.rotation).as_rotvec()
        out[:, :, k] = np.hstack([after.translation - before.translation, turn]) / (2 * step)
    return out


def test_relative_covariance_equals_reckoned_disturbances(perfect, rig) -> None:
    """Scale, drift, mount, play, attitude bias and heading at once; of nodes far apart, near, and
    in the other order.
    """
    sigma = np.array([0.005, 2e-4, 0.005, 0.005, 0.005, 0.01, 0.003, 0.003, 0.01, 0, 0, 0])
    truth = path_of(perfect, rig, np.zeros(error_propagation.ERRORS)).at(nodes_of(perfect))
    by_error = twist_by_pose_error(truth.poses()) @ pose_by_error(truth)
    none = np.zeros((len(truth.t_ns), 6, 6))
    model = TrajectoryErrorModel(
        by_error=by_error, error_covariance=np.diag(sigma**2), walk=none, white=none
    )
    first, second = np.array([0, 3, 9]), np.array([12, 5, 1])
    predicted = NavigationErrors(global_from_camera=truth.poses(), model=model).relative_covariance(
        first, second
    )
    J = relative_by_error(perfect, rig, first, second)
    wanted = (J * sigma**2) @ J.swapaxes(1, 2)
    for p in range(len(first)):
        scale = np.repeat(
            [np.sqrt(np.trace(wanted[p][k, k])) for k in (slice(0, 3), slice(3, 6))], 3
        )
        assert np.abs((predicted[p] - wanted[p]) / np.outer(scale, scale)).max() < 0.02


def test_covariance_grows_with_dvl_sigma_of_each_ping(perfect, rig) -> None:
    """What two nodes gained between them is what its parts gained, of each axis, whatever the
    pings' sigmas.
    """
    sigma = 0.004 * np.exp(0.5 * np.random.default_rng(1).standard_normal(len(perfect.dvl.t_ns)))
    logs = replace(perfect, dvl=replace(perfect.dvl, velocity_sigma=sigma))
    at = path_of(logs, rig, np.zeros(error_propagation.ERRORS)).at(logs.dvl.t_ns[3:-3:7])
    path = path_of(logs, rig, np.zeros(error_propagation.ERRORS))
    model = error_propagation.dead_reckoning_errors(path, at, at.poses(), None, certain())
    gained = np.diff(model.walk[:, 0, 0])
    period_s = float(np.median(np.diff(logs.dvl.t_ns))) * 1e-9
    assert (gained > 0).all()
    # A ping's noise holds until the next one: seven pings to a step.
    steps = np.array([(sigma[k : k + 7] ** 2).mean() for k in range(3, len(sigma) - 10, 7)])[
        : len(gained)
    ]
    assert np.median(np.abs(gained / (steps * 7 * period_s**2) - 1)) < 0.3
    assert gained.sum() == pytest.approx(steps.sum() * 7 * period_s**2, rel=0.05)
    errors = NavigationErrors(global_from_camera=at.poses(), model=model)
    apart = errors.relative_covariance(np.arange(len(gained)), np.arange(len(gained)) + 1)
    assert np.linalg.eigvalsh(apart).min() > -1e-12


def test_an_error_of_a_pose_and_its_twist_are_one_motion() -> None:
    rng = np.random.default_rng(1)
    true = poses.exp(rng.normal(0, 1, (4, 6)) + np.array([5, 9, 2, 0, 0, 0]))
    error = 1e-6 * rng.standard_normal((4, 6))
    off = Poses(
        (true.rotation * Rotation.from_rotvec(error[:, 3:])).as_quat(),
        true.translation + error[:, :3],
    )
    carried = off @ true.inverse()  # what moves the true frame onto the wrong one
    assert np.allclose(
        np.einsum("nij,nj->ni", twist_by_pose_error(true), error), carried.log(), atol=1e-11
    )


def test_a_model_gives_each_nodes_own_covariance_back() -> None:
    """One error that shifts x by 3 m a unit, a walk of 4 mm2 and white noise of 2 mrad, at a node
    away from the origin.
    """
    at = poses.exp([[10.0, 5.0, 2.0, 0.1, 0.2, 0.3]])
    by_error, walk, white = np.zeros((1, 6, 1)), np.zeros((1, 6, 6)), np.zeros((1, 6, 6))
    by_error[0, 0, 0], walk[0, 1, 1] = 3.0, 4e-6
    white[0, [3, 4, 5], [3, 4, 5]] = 0.002**2
    to_twist = twist_by_pose_error(at)
    model = TrajectoryErrorModel(
        by_error=by_error,
        error_covariance=np.array([[0.01]]),
        walk=walk,
        white=to_twist @ white @ to_twist.swapaxes(1, 2),
    )
    assert np.allclose(
        trajectory_covariance(model, at)[0], np.diag([0.09, 4e-6, 0, 4e-6, 4e-6, 4e-6]), atol=1e-12
    )


def test_with_pressure_no_error_of_the_dvl_moves_the_depth(perfect, rig) -> None:
    found = dead_reckon(perfect, rig, SIGMAS)
    z = found.trajectory.covariance[:, 2, 2]
    assert np.allclose(z, z[0])
    assert z[0] == pytest.approx(SIGMAS.depth_bias_m**2, rel=0.01)


def test_start_depth_is_one_shared_unknown_without_pressure(perfect, rig) -> None:
    found = dead_reckon(replace(perfect, pressure=None), rig, SIGMAS)
    assert found.trajectory.covariance[30, 2, 2] > 100.0
    poses_found = found.trajectory.poses()
    errors = NavigationErrors(global_from_camera=poses_found, model=found.error_model)
    track = CameraTrack(global_from_camera=poses_found, errors=errors)
    assert track.relative_sigma(np.array([30]), np.array([32]))[0] < 0.05


def test_velocity_noise_accumulates_and_is_no_smaller_later(noisy, rig) -> None:
    walk = dead_reckon(noisy, rig, SIGMAS).error_model.walk
    assert (np.diff(walk[:, 0, 0]) > 0).all()
    # sigma^2 period duration
    assert walk[-1, 0, 0] == pytest.approx(0.003**2 * 0.05 * 39.5, rel=0.05)


def test_path_through_imu_gap_is_within_its_sigma(perfect, rig) -> None:
    """Twelve seconds around a turn without a reading: the attitude there is a guess, and the way is
    off with it.
    """
    t = (perfect.imu.t_ns - perfect.imu.t_ns[0]) * 1e-9
    there = (t < 20.0) | (t > 32.0)
    silent = replace(perfect, imu=imu_rows(perfect.imu, there))
    whole, found = (dead_reckon(logs, rig, SIGMAS) for logs in (perfect, silent))
    assert len(whole.trajectory.t_ns) == len(found.trajectory.t_ns)
    turn = (whole.trajectory.poses().rotation.inv() * found.trajectory.poses().rotation).magnitude()
    shift = np.linalg.norm(found.trajectory.translation - whole.trajectory.translation, axis=1)
    sigma = np.sqrt(np.einsum("nii->ni", found.trajectory.covariance))
    assert turn.max() > np.radians(2.0)
    assert (turn < 3 * np.linalg.norm(sigma[:, 3:], axis=1) + 1e-3).all()
    assert (shift < 3 * np.linalg.norm(sigma[:, :3], axis=1) + 1e-3).all()
    outside = np.linalg.norm(sigma[:, 3:], axis=1)[(turn < 1e-4)]
    assert np.median(outside) < np.radians(0.5)


def test_two_holes_are_two_errors(perfect, rig) -> None:
    t = (perfect.imu.t_ns - perfect.imu.t_ns[0]) * 1e-9

    def end_variance(*spans: tuple[float, float]) -> float:
        there = np.all([(t < begin) | (t > end) for begin, end in spans], axis=0)
        logs = replace(perfect, imu=imu_rows(perfect.imu, there))
        return float(dead_reckon(logs, rig, SIGMAS).error_model.walk[-1, 0, 0])

    first, second, none = (
        end_variance((20.0, 26.0)),
        end_variance((40.0, 46.0)),
        end_variance((-2.0, -1.0)),
    )
    assert first > 2 * none
    np.testing.assert_allclose(
        end_variance((20.0, 26.0), (40.0, 46.0)) - none, first + second - 2 * none, rtol=0.02
    )


def test_heading_disagreement_widens_the_rest_of_the_path(perfect, rig) -> None:
    """Five degrees within a second, which no rate tells: either may be wrong, so heading and place
    after it may be too.
    """
    t = (perfect.imu.t_ns - perfect.imu.t_ns[0]) * 1e-9
    off = np.radians(5.0) * np.clip(t - 30.0, 0.0, 1.0)
    turned = (
        Rotation.from_euler("z", off[:, None]) * Rotation.from_quat(perfect.imu.quaternion)
    ).as_quat()
    whole = dead_reckon(perfect, rig, SIGMAS).trajectory
    found = dead_reckon(
        replace(perfect, imu=replace(perfect.imu, quaternion=turned)),
        rig,
        SIGMAS,
    ).trajectory
    sigma = np.sqrt(np.einsum("nii->ni", found.covariance))
    turn = (whole.poses().rotation.inv() * found.poses().rotation).magnitude()
    assert turn[-1] > np.radians(4.0)
    assert turn[-1] < 3 * np.linalg.norm(sigma[-1, 3:])
    before = whole.t_ns < perfect.imu.t_ns[0] + 28 * 10**9
    assert np.linalg.norm(sigma[before, 3:], axis=1).max() < np.radians(0.5)
    assert np.linalg.norm(found.translation[-1] - whole.translation[-1]) < 3 * np.linalg.norm(
        sigma[-1, :3]
    )
