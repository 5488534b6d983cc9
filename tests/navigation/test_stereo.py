# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The path of a dive by its stereo cameras: a motion between pairs that is told, as vision tells
it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from navigation.instruments import SIGMAS
from scipy.spatial.transform import Rotation

from hullrecon.errors import StageError
from hullrecon.geometry import poses
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.dead_reckoning.dead_reckon import Navigated
from hullrecon.navigation.dead_reckoning.error_propagation import trajectory_covariance
from hullrecon.navigation.stereo_odometry.pair_motion import CalibrationEffect, StereoMotion
from hullrecon.navigation.stereo_odometry.stereo_path import Aids, Frames, stereo_navigate
from hullrecon.navigation.stereo_odometry.visual_odometry import (
    StepGuess,
    chain_errors,
    compose,
    measure_steps,
)
from hullrecon.records.sensors import ImuSamples, PressureSamples
from hullrecon.vision.pairs.camera_track import NavigationErrors

START_NS = 10**15
PATH = [poses.from_mount([0.15 * k, 0.01 * k, 0.0, 0.5 * k, 0.0, 1.0 * k]) for k in range(6)]
SIGMA = np.array([2e-3, 2e-3, 2e-3, 1e-3, 1e-3, 1e-3])
# Of one error of the calibration that changes nothing and of which nothing is seen.
EFFECT = CalibrationEffect(
    by_error=np.zeros((6, 1)), information=np.zeros((1, 1)), gradient=np.zeros(1)
)
NONE = np.zeros((8, 6, 0)), np.zeros((0, 0))
EVERY_SECOND = StepGuess(t_s=np.arange(6.0))


@dataclass
class KnownMotion:
    """Tells the true motion of the camera with noise of SIGMA; pairs in `blind` see nothing."""

    blind: tuple[int, ...] = ()
    read: list[int] = field(default_factory=list)

    def frame(self, top: int, bottom: int) -> int:
        assert top == bottom
        self.read.append(top)
        return top

    def between(self, first: int, second: int) -> StereoMotion | None:
        if {first, second} & set(self.blind):
            return None
        w = SIGMA * np.random.default_rng((first, second)).standard_normal(6)
        step = PATH[first].inverse() @ PATH[second]
        noisy = Poses(
            (step.rotation * Rotation.from_rotvec(w[3:])).as_quat(), step.translation + w[:3]
        )
        return StereoMotion(
            pose=noisy, covariance=np.diag(SIGMA**2), inliers=200, calibration=EFFECT
        )


def images(count: int) -> list[tuple[int, int]]:
    return [(k, k) for k in range(count)]


def test_each_pair_is_read_once_and_in_order() -> None:
    motion = KnownMotion()
    chain = measure_steps(images(6), motion, EVERY_SECOND, list)
    assert motion.read == list(range(6))
    assert len(chain.step) == 5
    assert chain.inliers.tolist() == [200] * 5
    assert len(chain.lost) == 0


def test_a_blind_pair_is_bridged_by_the_one_before_it() -> None:
    """The step into it is repeated; the step out of it takes up what is left of the motion from the
    pair before.
    """
    chain = measure_steps(images(6), KnownMotion(blind=(3,)), EVERY_SECOND, list)
    assert chain.lost.tolist() == [2]
    np.testing.assert_array_equal(chain.step.translation[2], chain.step.translation[1])
    both = chain.step[[2]] @ chain.step[[3]]
    told = KnownMotion().between(2, 4)
    assert told is not None
    np.testing.assert_allclose(both.translation, told.pose.translation, atol=1e-12)
    # as badly known as the guess that it makes up for
    assert np.sqrt(chain.covariance[3, 0, 0]) > 0.4


def test_the_first_step_of_all_is_guessed_as_none() -> None:
    chain = measure_steps(images(4), KnownMotion(blind=(1,)), EVERY_SECOND, list)
    assert chain.lost.tolist() == [0]
    np.testing.assert_array_equal(chain.step.translation[0], 0)


@dataclass
class TwoStretches(KnownMotion):
    """Pairs 3 and later see nothing that those before saw."""

    def between(self, first: int, second: int) -> StereoMotion | None:
        return None if first < 3 <= second else super().between(first, second)


def test_step_across_a_minute_without_images_has_wide_sigma() -> None:
    """The vehicle may have gone on, stood still or turned back: the step before, repeated once, was
    known to half a metre.
    """
    chain = measure_steps(
        images(6), TwoStretches(), StepGuess(t_s=np.array([0, 1, 2, 52, 53, 54.0])), list
    )
    assert chain.lost.tolist() == [2]
    np.testing.assert_allclose(chain.step.translation[2], 50 * chain.step.translation[1])
    sigma_m, sigma_rad = np.sqrt(np.diag(chain.covariance[2]))[[0, 3]]
    assert sigma_m == 10.0
    assert sigma_rad == 1.0


def test_across_a_blank_the_turn_is_the_imus() -> None:
    camera = Rotation.from_euler("z", [[0.0], [0.1], [0.2], [1.7], [1.8], [1.9]])
    times = np.array([0, 1, 2, 52, 53, 54.0])
    chain = measure_steps(
        images(6),
        TwoStretches(),
        StepGuess(t_s=times, camera=camera, turn_variance=np.full(5, 1e-4)),
        list,
    )
    np.testing.assert_allclose(chain.step.rotation[2].as_rotvec(), [0, 0, 1.5], atol=1e-12)
    assert np.sqrt(chain.covariance[2, 5, 5]) == pytest.approx(0.01)


def test_chain_covariance_equals_spread_of_disturbed_chains() -> None:
    step = poses.exp(np.tile([0.4, 0.05, 0.0, 0.02, 0.05, 0.1], (8, 1)))
    sigma = np.array([0.004, 0.003, 0.002, 0.001, 0.002, 0.003])
    path = compose(poses.identity(), step)
    rng = np.random.default_rng(5)
    ends = []
    for _ in range(600):
        w = sigma * rng.standard_normal((8, 6))
        disturbed = Poses(
            (step.rotation * Rotation.from_rotvec(w[:, 3:])).as_quat(), step.translation + w[:, :3]
        )
        ends.append(compose(poses.identity(), disturbed)[[-1]])
    shift = np.vstack([e.translation for e in ends]) - path.translation[-1]
    turn = np.vstack([(path[[-1]].rotation.inv() * e.rotation).as_rotvec() for e in ends])
    spread = np.cov(np.hstack([shift, turn]).T)
    predicted = trajectory_covariance(
        chain_errors(path, np.tile(np.diag(sigma**2), (8, 1, 1)), *NONE), path
    )[-1]
    assert np.allclose(np.sqrt(np.diag(predicted)), np.sqrt(np.diag(spread)), rtol=0.12)
    assert predicted[0, 5] == pytest.approx(spread[0, 5], rel=0.25)


def test_calibration_error_grows_linearly_with_distance() -> None:
    """A share of 1 % too long: 1 % of the way at its end, where steps that err independently would
    leave a third of that.
    """
    step = poses.exp(np.tile([0.4, 0.0, 0.0, 0.0, 0.0, 0.0], (9, 1)))
    path = compose(poses.identity(), step)
    by_scale = np.zeros((9, 6, 1))
    by_scale[:, 0, 0] = 0.4
    errors = chain_errors(path, np.zeros((9, 6, 6)), by_scale, np.array([[0.01**2]]))
    sigma = np.sqrt(trajectory_covariance(errors, path)[:, 0, 0])
    np.testing.assert_allclose(sigma, 0.01 * 0.4 * np.arange(10), atol=1e-4)
    relative = NavigationErrors(global_from_camera=path, model=errors)
    assert np.sqrt(
        relative.relative_covariance(np.array([3]), np.array([4]))[0, 0, 0]
    ) == pytest.approx(0.004, rel=0.01)


def test_relative_covariance_ignores_steps_before_both_nodes() -> None:
    """Their relative covariance is that of a chain that starts at the first of the two."""
    step = poses.exp(np.tile([0.4, 0.05, 0.0, 0.02, 0.05, 0.1], (8, 1)))
    covariance = np.tile(np.diag([4e-3, 3e-3, 2e-3, 1e-3, 2e-3, 3e-3]) ** 2, (8, 1, 1))
    path = compose(poses.from_mount([50.0, -20.0, 3.0, 5.0, 10.0, 70.0]), step)
    errors = NavigationErrors(global_from_camera=path, model=chain_errors(path, covariance, *NONE))
    found = errors.relative_covariance(np.array([7]), np.array([3]))[0]
    anew = compose(poses.identity(), step[3:7])
    wanted = trajectory_covariance(
        chain_errors(anew, covariance[3:7], NONE[0][3:7], NONE[1]), anew
    )[-1]
    assert np.allclose(found, wanted, atol=1e-7)  # 1e-8 is new at each node
    assert np.sqrt(wanted[0, 0]) > 4e-3


# the whole path


def navigated(rig, aids: Aids, blind: tuple[int, ...] = (), count: int = 6) -> Navigated:
    rows = (START_NS + 10**9 * np.arange(count), np.arange(count))
    return stereo_navigate(
        Frames(top=rows, bottom=rows),
        aids,
        KnownMotion(blind),
        rig,
        SIGMAS,
        np.zeros(1),
    )


def true_path(rig) -> Poses:
    vehicle_from_top = poses.tray_poses(rig.tray_origin, np.zeros(1)) @ rig.tray_from(Camera.TOP)
    world = (
        Poses(np.vstack([p.quaternion for p in PATH]), np.vstack([p.translation for p in PATH]))
        @ vehicle_from_top.inverse()
    )
    return world[[0]].inverse() @ world


def test_stereo_path_starts_at_first_pair_and_follows_vehicle(rig) -> None:
    found = navigated(rig, Aids())
    error = found.trajectory.translation - true_path(rig).translation
    sigma = np.sqrt(np.diagonal(found.trajectory.covariance, axis1=1, axis2=2))[:, :3]
    assert np.abs(error).max() < 0.02
    assert (np.abs(error) < 4 * sigma).all()
    assert found.trajectory.image.tolist() == [[k, k] for k in range(6)]
    assert any("level" in sentence for sentence in found.remarks)


def test_without_imu_and_pressure_only_tray_direction_is_known(rig) -> None:
    found = navigated(rig, Aids())
    assert len(found.attitude.node) == 0
    assert len(found.attitude.tray_direction) == 6
    assert len(found.returns.t_ns) == 0
    assert found.odometry.by_mount.shape == (5, 6, 3)


def test_an_imu_and_a_pressure_sensor_give_the_start(rig) -> None:
    t = START_NS + 10**8 * np.arange(-5, 60)
    tilt = Rotation.from_euler("xyz", [0.1, -0.2, 0.7])
    nothing = np.full((65, 3), np.nan)
    aids = Aids(
        imu=ImuSamples(
            t_ns=t,
            quaternion=np.tile(tilt.as_quat(), (65, 1)),
            angular_velocity=nothing,
            acceleration=nothing,
        ),
        pressure=PressureSamples(t_ns=t, depth=np.full(65, 3.0)),
    )
    found = navigated(rig, aids)
    first = found.trajectory.poses()[[0]]
    assert np.allclose((tilt.inv() * first.rotation).as_rotvec(), 0, atol=1e-9)
    assert first.apply(rig.pressure_origin)[0, 2] == pytest.approx(3.0)
    assert np.allclose(found.attitude.depth, 3.0)
    assert np.allclose(found.attitude.roll, 0.1)


def test_stopped_pressure_sensor_holds_no_depth_under_cameras(rig) -> None:
    t = START_NS + 10**8 * np.arange(-5, 25)
    found = navigated(rig, Aids(pressure=PressureSamples(t_ns=t, depth=np.full(30, 3.0))))
    assert found.attitude.sigma[:3, 0].tolist() == [SIGMAS.depth_m] * 3
    assert (found.attitude.sigma[3:, 0] >= 100.0).all()
    assert (
        "pressure: no reading for 2.6 s of the path's 5.0; there the depth is "
        "counted on by the cameras"
    ) in found.remarks


def test_nodes_share_the_information_of_a_pressure_reading(rig) -> None:
    slow = PressureSamples(t_ns=START_NS + 3 * 10**9 * np.arange(-4, 8), depth=np.full(12, 3.0))
    found = navigated(rig, Aids(pressure=slow))
    assert found.attitude.sigma[:, 0] == pytest.approx(
        np.full(6, SIGMAS.depth_m * np.sqrt(6 / 5)), rel=1e-9
    )


def test_a_pair_that_sees_nothing_is_stepped_over(rig) -> None:
    found = navigated(rig, Aids(), blind=(3,))
    assert found.facts["lost_steps"] == [2]
    error = found.trajectory.translation - true_path(rig).translation
    assert np.abs(error[[0, 1, 2, 4, 5]]).max() < 0.05
    assert found.odometry.covariance[2, 0, 0] > 0.1
    (named,) = [sentence for sentence in found.remarks if "guessed" in sentence]
    assert named.endswith("the longest 1.0 s")


def test_pairs_that_do_not_join_are_an_error_in_words(rig) -> None:
    with pytest.raises(StageError, match="do not join"):
        navigated(rig, Aids(), blind=(1,), count=2)


def test_one_pair_is_no_path(rig) -> None:
    with pytest.raises(StageError, match="fewer than two stereo pairs"):
        navigated(rig, Aids(), count=1)


def test_an_imu_without_orientation_does_not_stop_the_cameras(rig) -> None:
    t = START_NS + 10**8 * np.arange(60)
    nothing = np.full((60, 3), np.nan)
    found = navigated(
        rig,
        Aids(
            imu=ImuSamples(
                t_ns=t,
                quaternion=np.full((60, 4), np.nan),
                angular_velocity=nothing,
                acceleration=nothing,
            )
        ),
        count=3,
    )
    assert len(found.trajectory.t_ns) == 3
