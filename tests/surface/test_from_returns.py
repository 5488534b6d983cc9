# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A vehicle that looks down at a level floor in g, without a CAD model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.errors import StageError
from hullrecon.geometry import poses
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import from_rpy, identity
from hullrecon.records.solution import Landmarks, Mounts, Solution
from hullrecon.records.trajectory import Returns, VehicleTrack
from hullrecon.rig import rig_from_settings
from hullrecon.surface.from_returns import (
    SurfaceInputs,
    UnknownHull,
    move_to_hull_frame,
    pose_sigma_along,
    statistical_inliers,
    surface_from_survey,
)
from hullrecon.surface.options import SurfaceOptions

FLOOR_M, HEIGHT_M, NODES = 6.0, 1.5, 40
OPTIONS = SurfaceOptions(fit=False, length_along_m=4.0, length_girth_m=4.0, outlier_sigmas=4.0)


def track(sigma_m: float = 0.002) -> VehicleTrack:
    x, y = np.tile(np.linspace(0, 4, 10), 4), np.repeat([0.0, 0.5, 1.0, 1.5], 10)
    return VehicleTrack(
        t_ns=np.arange(NODES),
        poses=from_rpy(
            np.column_stack([x, y, np.full(NODES, FLOOR_M - HEIGHT_M)]), np.zeros((NODES, 3))
        ),
        tray=np.zeros(NODES),
        covariance=np.tile(np.diag([sigma_m**2] * 3 + [0.0] * 3), (NODES, 1, 1)),
        image=np.full((NODES, 2), -1),
        frame=Frame.GLOBAL,
    )


def returns(noise_m: float = 0.004) -> Returns:
    """Four beams a node, 20 degrees off the vertical."""
    tilt, node = np.tan(np.radians(20)), np.repeat(np.arange(NODES), 4)
    beam = np.tile([[tilt, 0, 1], [-tilt, 0, 1], [0, tilt, 1], [0, -tilt, 1.0]], (NODES, 1))
    length = np.linalg.norm(beam, axis=1)
    n = len(node)
    return Returns(
        t_ns=node,
        node=node,
        quaternion=np.tile([0.0, 0, 0, 1], (n, 1)),
        translation=np.zeros((n, 3)),
        tray_offset=np.zeros(n),
        beam=beam / length[:, None],
        range_m=HEIGHT_M * length + np.random.default_rng(2).normal(0, noise_m, n),
        flagged=np.zeros(n, bool),
    )


def survey(sigma_m: float = 0.002) -> SurfaceInputs:
    return SurfaceInputs(
        hull=UnknownHull(),
        track=track(sigma_m),
        rig=rig_from_settings({"tray.origin": (0.0, 0.0, 0.0), "dvl.mount": (0.0,) * 6}),
        returns=returns(),
        range_sigma_m=0.004,
        solution=None,
        chart=None,
    )


def solution(marks: np.ndarray, views: int = 5) -> Solution:
    m, at = len(marks), track()
    landmarks = Landmarks(
        position=marks,
        covariance=np.tile(1e-6 * np.eye(3), (m, 1, 1)),
        label=np.zeros(m, np.int64),
        deviation=np.full(m, np.nan),
        views=np.full(m, views),
        color=np.zeros((m, 3), np.uint8),
    )
    return Solution(
        t_ns=at.t_ns,
        image=at.image,
        global_from_vehicle=at.poses,
        tray=at.tray,
        tray_sigma=at.tray,
        pose_covariance=at.covariance,
        landmarks=landmarks,
        mounts=Mounts(tray_from_dvl=identity(), tray_from_top=None, top_from_bottom=None),
        navigation_errors=np.zeros(6),
        hull_pose=None,
        deviation_field=None,
    )


def marks_on_floor(depth_m: float = FLOOR_M) -> np.ndarray:
    rng = np.random.default_rng(4)
    return np.column_stack(
        [rng.uniform(0, 4, 300), rng.uniform(0, 1.5, 300), np.full(300, depth_m)]
    )


def test_the_surface_lies_on_the_floor_and_has_no_deviation() -> None:
    result = surface_from_survey(survey(), OPTIONS)
    np.testing.assert_allclose(result.surface.vertices[:, 2], FLOOR_M, atol=0.01)
    assert np.isnan(result.surface.deviation).all()
    assert result.facts["returns"] == 4 * NODES
    assert result.facts["comparison"] is None


def test_what_the_poses_share_is_in_the_sigma() -> None:
    sure, unsure = (
        surface_from_survey(survey(s), OPTIONS).surface.sigma.min() for s in (0.002, 0.05)
    )
    assert sure < 0.02
    assert unsure >= 0.05


def test_a_flagged_return_and_one_that_stands_apart_are_left_out() -> None:
    given = survey()
    range_m, flagged = given.returns.range_m.copy(), given.returns.flagged.copy()
    range_m[[8, 50]] += 4.0
    flagged[8] = True
    result = surface_from_survey(
        replace(given, returns=replace(given.returns, range_m=range_m, flagged=flagged)), OPTIONS
    )
    assert result.facts["flagged"] == 1
    assert result.facts["outliers"] == 1
    np.testing.assert_allclose(result.surface.vertices[:, 2], FLOOR_M, atol=0.015)


def test_landmarks_join_only_when_asked() -> None:
    given = replace(survey(), solution=solution(marks_on_floor(FLOOR_M - 0.05)))
    without, joined = (
        surface_from_survey(given, o) for o in (OPTIONS, SurfaceOptions(fit=False, landmarks=True))
    )
    assert np.abs(np.median(without.surface.vertices[:, 2]) - FLOOR_M) < 0.005
    assert np.median(joined.surface.vertices[:, 2]) < FLOOR_M - 0.02  # many landmarks draw it up


def test_landmarks_alone_make_a_surface() -> None:
    given = replace(survey(), returns=None, solution=solution(marks_on_floor()))
    result = surface_from_survey(given, OPTIONS)
    assert result.facts["returns"] == 0
    np.testing.assert_allclose(result.surface.vertices[:, 2], FLOOR_M, atol=1e-3)
    assert (result.surface.support >= 1).all()


def test_what_all_landmarks_share_is_in_the_sigma_and_no_noise() -> None:
    marks = marks_on_floor()
    noise_m = np.random.default_rng(5).normal(0, 0.002, len(marks))
    known = solution(marks + np.outer(noise_m, [0, 0, 1]))
    covariance = np.tile(np.diag([0.3, 0.3, 0.05]) ** 2 + 0.002**2 * np.eye(3), (len(marks), 1, 1))
    covariance[::4] -= 0.0019**2 * np.eye(3)
    shared = replace(known, landmarks=replace(known.landmarks, covariance=covariance))
    surface = surface_from_survey(replace(survey(), returns=None, solution=shared), OPTIONS).surface
    np.testing.assert_allclose(surface.sigma, 0.05, rtol=0.05)
    np.testing.assert_allclose(surface.vertices[:, 2], FLOOR_M, atol=4e-3)


def test_landmarks_that_two_images_saw_do_not_count() -> None:
    given = replace(survey(), returns=None, solution=solution(marks_on_floor(), views=2))
    with pytest.raises(StageError, match="neither DVL returns nor landmarks"):
        surface_from_survey(given, OPTIONS)


def test_the_adjustments_chart_is_kept() -> None:
    first = surface_from_survey(survey(), OPTIONS)
    again = surface_from_survey(replace(survey(), chart=first.chart), OPTIONS)
    assert again.chart is first.chart
    np.testing.assert_allclose(again.surface.vertices, first.surface.vertices)


def test_fewer_than_four_returns_are_refused() -> None:
    given = survey()
    flagged = np.arange(4 * NODES) > 2
    with pytest.raises(StageError, match="fewer than four returns"):
        surface_from_survey(
            replace(given, returns=replace(given.returns, flagged=flagged)), OPTIONS
        )


def _grid() -> np.ndarray:
    x, z = np.meshgrid(np.arange(20) * 0.1, np.arange(20) * 0.1)
    return np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)


def test_a_return_far_from_its_neighbours_is_an_outlier() -> None:
    points = np.vstack([_grid(), [[1.0, 3.0, 1.0]]])
    kept = statistical_inliers(points)
    assert not kept[-1]
    assert kept[:-1].all()


def test_a_stricter_threshold_keeps_fewer() -> None:
    points = np.vstack(
        [_grid(), np.random.default_rng(2).uniform([0, 0.3, 0], [2, 2.3, 2], (40, 3))]
    )
    strict = statistical_inliers(points, deviations=0.5)
    loose = statistical_inliers(points, deviations=3.0)
    assert strict.sum() < loose.sum()
    assert not (strict & ~loose).any()


def test_the_mean_distance_is_that_to_the_neighbours_asked_for() -> None:
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [10, 0, 0]])
    # mean distance to two neighbours: 1.5, 1, 1, 1.5, 7.5; mean 2.5, deviation 2.51
    assert statistical_inliers(line, neighbours=2, deviations=1.0).tolist() == [
        True,
        True,
        True,
        True,
        False,
    ]
    assert statistical_inliers(line, neighbours=2, deviations=2.0).all()


def test_a_single_point_is_kept() -> None:
    assert statistical_inliers(np.zeros((1, 3))).tolist() == [True]


def test_a_position_sigma_counts_along_the_normal_only() -> None:
    covariance = np.diag([0.04, 0.01, 0.09, 0, 0, 0])[None]
    sigma = pose_sigma_along(
        np.array([[0.0, 1, 0]]), np.array([[0, 2.0, 0]]), covariance, np.eye(3)[None]
    )
    assert np.allclose(sigma, 0.1)


def test_attitude_sigma_counts_by_its_lever() -> None:
    covariance = np.diag([0, 0, 0, 0, 0, 0.01**2])[None]  # heading
    ahead = pose_sigma_along(
        np.array([[0.0, 1, 0]]), np.array([[3.0, 0, 0]]), covariance, np.eye(3)[None]
    )
    along_normal = pose_sigma_along(
        np.array([[0.0, 1, 0]]), np.array([[0, 3.0, 0]]), covariance, np.eye(3)[None]
    )
    assert np.allclose(ahead, 0.03)
    assert np.allclose(along_normal, 0.0)


def test_the_sigma_equals_numeric_propagation(rng: np.random.Generator) -> None:
    pose = poses.exp(rng.normal(size=(1, 6)))
    point_v, normal = rng.normal(size=(1, 3)), rng.normal(size=(1, 3))
    normal /= np.linalg.norm(normal)
    root = 1e-2 * rng.normal(size=(6, 6))
    lever = pose.rotation.apply(point_v)
    sigma = pose_sigma_along(normal, lever, (root @ root.T)[None], pose.rotation.as_matrix())

    def along(w: np.ndarray) -> float:
        moved = poses.Poses(
            (pose.rotation * poses.exp([[0, 0, 0, *w[3:]]]).rotation).as_quat(),
            pose.translation + w[:3],
        )
        return float((moved.apply(point_v) @ normal.T).item())

    gradient = np.array([(along(h) - along(-h)) / 2e-6 for h in 1e-6 * np.eye(6)])
    assert sigma[0] == pytest.approx(np.sqrt(gradient @ root @ root.T @ gradient), rel=1e-6)


def test_track_in_hull_frame_has_sigma_of_pose_guess() -> None:
    quarter_turn = poses.from_mount([10.0, 0, 0, 0, 0, 90])  # x of M points along y of g
    track = VehicleTrack(
        t_ns=np.arange(2),
        poses=poses.from_rpy([[10.0, 3, 1], [9.0, 3, 1]], np.zeros((2, 3))),
        tray=np.zeros(2),
        covariance=np.tile(np.diag([0.04, 0.01, 0.0, 1e-4, 0, 0]), (2, 1, 1)),
        image=np.full((2, 2), -1),
        frame=Frame.GLOBAL,
    )
    moved = move_to_hull_frame(track, quarter_turn, np.array([0.3, 0.5, 0.1]))
    assert moved.frame is Frame.HULL
    assert np.allclose(moved.poses.translation, [[3, 0, 1], [3, 1, 1]])
    assert np.allclose(moved.covariance, np.diag([0.01 + 0.09, 0.04 + 0.25, 0.01, 1e-4, 0, 0]))
