# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.errors import StageError
from hullrecon.geometry import poses
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.dead_reckoning.dead_reckon import Navigated
from hullrecon.navigation.dead_reckoning.error_propagation import trajectory_covariance
from hullrecon.navigation.options import NavigateOptions
from hullrecon.navigation.stereo_odometry.stereo_frame import (
    Features,
    StereoFrame,
    StereoRig,
    epipolar_distance,
    find_features,
    mutual_best,
    stereo_matches,
    triangulate,
)
from hullrecon.navigation.stereo_odometry.stereo_motion import stereo_motion
from hullrecon.navigation.stereo_odometry.stereo_path import Aids, Views, stereo_navigate
from hullrecon.navigation.stereo_odometry.visual_odometry import chain_errors, compose
from hullrecon.records.sensors import ImuSamples, PressureSamples
from hullrecon.vision.pairs.camera_track import Survey

CAMERA = CameraModel(640, 512, 600.0, 600.0, 319.5, 255.5)
RIG = StereoRig(CAMERA, CAMERA, poses.from_mount([0.01, 0.12, 0.0, 1.0, -0.5, 0.7]), sigma_px=0.5)
START_NS = 10**15


class Seabed:
    """Points with descriptors of their own, seen by the rig from any pose, with pixel noise."""

    def __init__(self, count: int = 4000, seed: int = 0) -> None:
        self.rng = np.random.default_rng(seed)
        self.point = self.rng.uniform([-4, -2, 1.2], [6, 2, 2.2], (count, 3))
        raw = self.rng.random((count, 128))
        self.descriptor = np.sqrt(raw / raw.sum(1, keepdims=True)).astype(np.float32)

    def seen(self, T_w_c: Poses, sigma_px: float) -> tuple[Features, np.ndarray]:
        local = T_w_c.inverse().apply(self.point)
        pixel = CAMERA.project(local)
        inside = np.flatnonzero((pixel > 0).all(1) & (pixel < [640, 512]).all(1))
        noisy = pixel[inside] + sigma_px * self.rng.standard_normal((len(inside), 2))
        raw = self.descriptor[inside] + 0.01 * self.rng.standard_normal((len(inside), 128)).astype(np.float32)
        return Features(CAMERA.undistort(noisy), (raw / np.linalg.norm(raw, axis=1, keepdims=True)).astype(np.float32)), inside

    def frame(self, T_w_ct: Poses, sigma_px: float = 0.5) -> StereoFrame:
        top, _ = self.seen(T_w_ct, sigma_px)
        bottom, _ = self.seen(T_w_ct @ RIG.T_ct_cb, sigma_px)
        rows = stereo_matches(top, bottom, RIG)
        point, covariance = triangulate(top.ideal[rows[:, 0]], bottom.ideal[rows[:, 1]], RIG)
        good = np.isfinite(point).all(axis=1)
        return StereoFrame(top, bottom, rows[good], point[good], covariance[good])


MOVED = poses.from_mount([0.3, 0.05, -0.04, 2.0, -1.5, 4.0])


def test_a_point_is_triangulated_with_the_sigma_that_its_scatter_shows() -> None:
    point = np.array([0.2, -0.1, 1.6])
    rng = np.random.default_rng(1)
    pixels = [
        np.tile(CAMERA.project(local), (4000, 1)) + 0.5 * rng.standard_normal((4000, 2))
        for local in (point[None], RIG.T_ct_cb.inverse().apply(point[None]))
    ]
    found, covariance = triangulate(CAMERA.undistort(pixels[0]), CAMERA.undistort(pixels[1]), RIG)
    assert np.allclose(found.mean(axis=0), point, atol=5e-3)
    assert np.allclose(np.std(found, axis=0), np.sqrt(np.diag(covariance.mean(axis=0))), rtol=0.15)


def test_rays_that_part_have_no_point() -> None:
    xyz = np.array([[0.0, 0.0, 1.5]])
    a, b = CAMERA.undistort(CAMERA.project(xyz)), CAMERA.undistort(CAMERA.project(RIG.T_ct_cb.inverse().apply(xyz)))
    assert np.isfinite(triangulate(a, b, RIG)[0]).all()
    assert np.isnan(triangulate(a, b + np.array([0.0, 0.4]), RIG)[0]).all()


def test_a_true_pair_lies_on_its_epipolar_line_and_a_shifted_one_as_far_off_as_it_was_shifted() -> None:
    xyz = np.array([[0.1, 0.2, 1.5], [-0.3, 0.1, 2.0]])
    a, b = CAMERA.undistort(CAMERA.project(xyz)), CAMERA.undistort(CAMERA.project(RIG.T_ct_cb.inverse().apply(xyz)))
    assert np.abs(np.diag(epipolar_distance(a, b, RIG))).max() < 1e-6
    off = epipolar_distance(
        a, b + np.array([0.01, 0.0]), RIG
    )  # across the vertical baseline; Sampson shares it between both images
    assert np.allclose(np.diag(off), 0.01 / np.sqrt(2), rtol=0.1)


def test_the_blocks_of_the_matcher_do_not_show() -> None:
    rng = np.random.default_rng(2)
    a = rng.random((700, 128)).astype(np.float32)
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    order = rng.permutation(700)
    assert np.array_equal(mutual_best(a, a[order])[:, 1], np.argsort(order))
    allowed = rng.random((700, 700)) < 0.5
    kept = mutual_best(a, a[order], lambda rows: allowed[rows])
    assert allowed[kept[:, 0], kept[:, 1]].all()
    assert len(mutual_best(a, a[:0])) == 0


def test_a_twin_that_looks_as_good_is_no_match() -> None:
    one = np.eye(128, dtype=np.float32)[:1]
    assert len(mutual_best(one, np.vstack([one, one]))) == 0


def test_a_feature_lies_in_the_middle_of_a_spot() -> None:
    picture = np.full((256, 256, 3), 40, np.uint8)
    picture[100:130, 150:180] = 200
    camera = CameraModel(256, 256, 300.0, 300.0, 127.5, 127.5)
    found = find_features(picture, camera, 50)
    pixel = camera.distort(found.ideal)
    assert np.abs(pixel - [164.5, 114.5]).max(axis=1).min() < 0.5  # pixels 150 to 179 and 100 to 129
    assert np.allclose(np.linalg.norm(found.descriptor, axis=1), 1, atol=1e-5)
    assert len(find_features(None, camera, 50).ideal) == 0
    assert len(find_features(np.zeros((64, 64, 3), np.uint8), camera, 50).ideal) == 0


def test_the_motion_between_pairs_is_found_within_its_sigma() -> None:
    found = stereo_motion(Seabed().frame(poses.identity()), Seabed(seed=0).frame(MOVED), RIG, 15)
    assert found is not None
    error = np.concatenate(
        [
            (MOVED.translation - found.pose.translation)[0],
            (found.pose.rotation.inv() * MOVED.rotation).as_rotvec()[0],
        ]
    )
    assert np.abs(error[:3]).max() < 5e-3
    assert found.inliers > 100
    assert 0.5 < error @ np.linalg.solve(found.covariance, error) < 20  # chi2 of six


def test_motion_errors_are_as_large_as_their_covariance_says() -> None:
    chi2 = []
    for seed in range(12):
        world = Seabed(1500, seed)
        found = stereo_motion(world.frame(poses.identity()), world.frame(MOVED), RIG, 15)
        assert found is not None
        turn = (found.pose.rotation.inv() * MOVED.rotation).as_rotvec()[0]
        error = np.concatenate([(MOVED.translation - found.pose.translation)[0], turn])
        chi2.append(error @ np.linalg.solve(found.covariance, error))
    assert 0.4 < np.mean(chi2) / 6 < 2.0


def test_pairs_with_nothing_in_common_have_no_motion() -> None:
    assert stereo_motion(Seabed(seed=0).frame(poses.identity()), Seabed(seed=9).frame(MOVED), RIG, 15) is None


def test_the_covariance_of_a_chain_is_the_spread_of_disturbed_chains() -> None:
    step = poses.exp(np.tile([0.4, 0.05, 0.0, 0.02, 0.05, 0.1], (8, 1)))
    sigma = np.array([0.004, 0.003, 0.002, 0.001, 0.002, 0.003])
    path = compose(poses.identity(), step)
    rng = np.random.default_rng(5)
    ends = []
    for _ in range(600):
        w = sigma * rng.standard_normal((8, 6))
        disturbed = Poses((step.rotation * Rotation.from_rotvec(w[:, 3:])).as_quat(), step.translation + w[:, :3])
        ends.append(compose(poses.identity(), disturbed)[[-1]])
    shift = np.vstack([e.translation for e in ends]) - path.translation[-1]
    turn = np.vstack([(path[[-1]].rotation.inv() * e.rotation).as_rotvec() for e in ends])
    spread = np.cov(np.hstack([shift, turn]).T)
    predicted = trajectory_covariance(chain_errors(path, np.tile(np.diag(sigma**2), (8, 1, 1))), path)[-1]
    assert np.allclose(np.sqrt(np.diag(predicted)), np.sqrt(np.diag(spread)), rtol=0.12)
    assert predicted[0, 5] == pytest.approx(spread[0, 5], rel=0.25)


def test_two_nodes_of_a_chain_know_nothing_of_the_steps_before_them() -> None:
    """Their relative covariance is that of a chain that starts at the first of the two."""
    step = poses.exp(np.tile([0.4, 0.05, 0.0, 0.02, 0.05, 0.1], (8, 1)))
    covariance = np.tile(np.diag([4e-3, 3e-3, 2e-3, 1e-3, 2e-3, 3e-3]) ** 2, (8, 1, 1))
    path = compose(poses.from_mount([50.0, -20.0, 3.0, 5.0, 10.0, 70.0]), step)
    survey = Survey(global_from_camera=path, errors=chain_errors(path, covariance))
    found = survey.relative_covariance(np.array([7]), np.array([3]))[0]
    anew = compose(poses.identity(), step[3:7])
    wanted = trajectory_covariance(chain_errors(anew, covariance[3:7]), anew)[-1]
    assert np.allclose(found, wanted, atol=1e-7)  # 1e-8 is new at each node
    assert np.sqrt(wanted[0, 0]) > 4e-3


# the whole path


PATH = [poses.from_mount([0.15 * k, 0.01 * k, 0.0, 0.5 * k, 0.0, 1.0 * k]) for k in range(6)]
T_s_ct = poses.from_mount([0.05, 0.0, -0.02, 90.0, 0.0, 90.0])


def navigated(vehicle, aids: Aids, blind: tuple[int, ...] = (), count: int = 6) -> Navigated:
    world, elsewhere = Seabed(), Seabed(seed=77)
    t = START_NS + 10**9 * np.arange(count)
    rows = (t, np.arange(count))

    def frame(top: int, bottom: int) -> StereoFrame:
        assert top == bottom
        return (elsewhere if top in blind else world).frame(PATH[top])

    return stereo_navigate(Views(rows, rows, frame, T_s_ct), aids, RIG, vehicle, NavigateOptions())


def true_path(vehicle) -> Poses:
    T_v_ct = poses.tray_poses(vehicle.tray_origin, np.zeros(1)) @ T_s_ct
    world = Poses(np.vstack([p.quaternion for p in PATH]), np.vstack([p.translation for p in PATH])) @ T_v_ct.inverse()
    return world[[0]].inverse() @ world


def test_stereo_gives_the_path_of_the_vehicle_from_its_first_pair(vehicle) -> None:
    found = navigated(vehicle, Aids())
    error = found.trajectory.translation - true_path(vehicle).translation
    sigma = np.sqrt(np.diagonal(found.trajectory.covariance, axis1=1, axis2=2))[:, :3]
    assert np.abs(error).max() < 0.02
    assert (np.abs(error) < 4 * sigma).all()
    assert found.trajectory.image.tolist() == [[k, k] for k in range(6)]
    assert any("level" in words for words in found.remarks)


def test_without_imu_and_pressure_there_is_no_attitude_but_the_trays_direction(vehicle) -> None:
    found = navigated(vehicle, Aids())
    assert len(found.attitude.node) == 0
    assert len(found.attitude.tray_direction) == 6
    assert len(found.returns.t_ns) == 0
    assert found.odometry.by_mount.shape == (5, 6, 3)


def test_an_imu_and_a_pressure_sensor_give_the_start(vehicle) -> None:
    t = START_NS + 10**8 * np.arange(-5, 60)
    tilt = Rotation.from_euler("xyz", [0.1, -0.2, 0.7])
    nothing = np.full((65, 3), np.nan)
    aids = Aids(
        ImuSamples(t_ns=t, quaternion=np.tile(tilt.as_quat(), (65, 1)), angular_velocity=nothing, acceleration=nothing),
        PressureSamples(t_ns=t, depth=np.full(65, 3.0)),
    )
    found = navigated(vehicle, aids)
    first = found.trajectory.poses()[[0]]
    assert np.allclose((tilt.inv() * first.rotation).as_rotvec(), 0, atol=1e-9)
    assert first.apply(vehicle.pressure_origin)[0, 2] == pytest.approx(3.0)
    assert np.allclose(found.attitude.depth, 3.0)
    assert np.allclose(found.attitude.roll, 0.1)


def test_a_pair_that_sees_nothing_is_stepped_over(vehicle) -> None:
    found = navigated(vehicle, Aids(), blind=(3,))
    assert found.facts["lost_steps"] == [2]
    error = found.trajectory.translation - true_path(vehicle).translation
    assert np.abs(error[[0, 1, 2, 4, 5]]).max() < 0.05
    assert found.odometry.covariance[2, 0, 0] > 0.1
    assert any("guessed" in words for words in found.remarks)


def test_pairs_that_do_not_join_are_an_error_in_words(vehicle) -> None:
    with pytest.raises(StageError, match="do not join"):
        navigated(vehicle, Aids(), blind=(1,), count=2)


def test_one_pair_is_no_path(vehicle) -> None:
    with pytest.raises(StageError, match="fewer than two stereo pairs"):
        navigated(vehicle, Aids(), count=1)


def test_an_imu_without_orientation_does_not_stop_the_cameras(vehicle) -> None:
    t = START_NS + 10**8 * np.arange(60)
    nothing = np.full((60, 3), np.nan)
    found = navigated(
        vehicle,
        Aids(ImuSamples(t_ns=t, quaternion=np.full((60, 4), np.nan), angular_velocity=nothing, acceleration=nothing)),
        count=3,
    )
    assert len(found.trajectory.t_ns) == 3


def test_a_rig_that_is_known_less_well_takes_wider_lines() -> None:
    world = Seabed()
    top, _ = world.seen(poses.identity(), 0.5)
    bent = replace(RIG, T_ct_cb=RIG.T_ct_cb @ poses.from_mount([0, 0, 0, 0, 0.4, 0]))
    bottom, _ = world.seen(bent.T_ct_cb, 0.5)
    assert len(stereo_matches(top, bottom, replace(RIG, slack_px=6.0))) > 2 * len(stereo_matches(top, bottom, RIG))
