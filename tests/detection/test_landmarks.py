# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.adjustment.results.covariance import points_in_hull
from hullrecon.detection.as_found.landmarks import measure_surface
from hullrecon.estimation.landmark_variance import MIN_SIGMA_M
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import exp
from hullrecon.records.solution import HullPose

WALL = Scene(
    Mesh(
        np.array([[0.0, 0, 0], [0, 0, 4], [4, 0, 4], [4, 0, 0]]),
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
    )
)


def _covariance(along_normal: float, n: int) -> np.ndarray:
    return np.tile(np.diag([1e-2, along_normal**2, 1e-2]), (n, 1, 1))


def _measure(points: list[list[float]], sigma: float = 0.003, views: int = 3):
    position = np.array(points)
    return measure_surface(
        WALL, position, _covariance(sigma, len(points)), np.full(len(points), views), 0.5, 0.012
    )


def test_offset_foot_and_normal_are_those_of_the_surface() -> None:
    seen = _measure([[1.0, 0.07, 2], [2, -0.03, 1]])
    assert np.allclose(seen.offset, [0.07, -0.03])
    assert np.allclose(seen.foot, [[1, 0, 2], [2, 0, 1]])
    assert np.allclose(seen.normal, [[0, 1, 0]] * 2)
    assert seen.row.tolist() == [0, 1]


def test_offset_is_orthogonal_and_not_along_the_ray_as_printed() -> None:
    """[Ozog2016 Fig. 4.8] has the deviation by the ray; Algorithm 4 the orthogonal distance."""
    camera, feature = np.array([1.0, 1.07, 1]), np.array([2.0, 0.07, 1])
    ray = (feature - camera) / np.linalg.norm(feature - camera)  # 45 degrees off the normal
    printed = WALL.cast(camera, ray[None]) - np.linalg.norm(feature - camera)
    assert np.allclose(printed, 0.07 * np.sqrt(2))
    assert np.allclose(_measure([feature.tolist()]).offset, 0.07)


def test_landmark_of_one_image_or_far_off_is_left_out() -> None:
    assert len(_measure([[1.0, 0.07, 2]], views=1)) == 0
    assert _measure([[np.nan, 0, 0], [1, 0.1, 1], [1, 0.8, 1]]).row.tolist() == [1]


def test_a_landmark_beside_the_rim_is_not_above_the_surface() -> None:
    seen = _measure([[-0.2, 0.05, 2], [-0.004, 0.05, 2], [1, 0.05, 2]])
    assert seen.row.tolist() == [1, 2]


def test_shared_sigma_does_not_reject_a_landmark() -> None:
    rng = np.random.default_rng(0)
    position = np.column_stack([rng.uniform(0, 4, 200), np.zeros(200), rng.uniform(0, 4, 200)])
    # the dive's place on the hull: 5 cm, far more than a landmark may have
    covariance = _covariance(0.05, 200)
    covariance[:, 1, 1] += 0.004**2
    covariance[::4, 1, 1] -= 0.004**2 - 0.001**2
    seen = measure_surface(WALL, position, covariance, np.full(200, 3), 0.5, 0.012)
    assert len(seen) == 200
    assert np.allclose(seen.common, 0.05, rtol=0.01)
    assert seen.sigma[1::4].max() < 0.005
    assert seen.sigma[::4].min() >= MIN_SIGMA_M


def test_wide_hull_pose_sigma_is_no_landmark_noise() -> None:
    rng = np.random.default_rng(1)
    position = np.column_stack([rng.uniform(0, 4, 200), np.zeros(200), rng.uniform(0, 4, 200)])
    pose = HullPose(
        global_from_hull=exp(np.array([3.0, -1, 2, 0.2, -0.1, 1.3])),
        covariance=np.diag([0.3, 0.3, 0.1, 0.03, 0.03, 0.05]) ** 2,
        survey_center=np.array([2.0, 0, 2]),
    )
    own, in_global = _covariance(0.003, 200), pose.global_from_hull.apply(position)
    turned, whole = (
        points_in_hull(
            own,
            np.zeros((200, 3, 6)),
            of_pose,
            in_global,
            pose.global_from_hull,
            pose.survey_center,
        )
        for of_pose in (np.zeros((6, 6)), pose.covariance)
    )
    alone = measure_surface(WALL, position, turned, np.full(200, 3), 0.5, 0.1)
    seen = measure_surface(WALL, position, whole, np.full(200, 3), 0.5, 0.1, pose)
    assert len(alone) == len(seen) == 200
    np.testing.assert_allclose(seen.sigma, alone.sigma, rtol=1e-6)
    assert seen.common.min() > 0.1
    # where it is taken for theirs
    assert len(measure_surface(WALL, position, whole, np.full(200, 3), 0.5, 0.012)) < 200


def test_an_uncertain_landmark_among_certain_ones_is_left_out() -> None:
    position = np.column_stack([np.linspace(0.5, 3.5, 50), np.zeros(50), np.full(50, 2.0)])
    covariance = _covariance(0.002, 50)
    covariance[20, 1, 1] = 0.03**2
    assert 20 not in measure_surface(WALL, position, covariance, np.full(50, 3), 0.5, 0.012).row


def test_no_landmark_is_measured_where_there_is_none() -> None:
    assert len(_measure([[np.nan, 0, 0]])) == 0
