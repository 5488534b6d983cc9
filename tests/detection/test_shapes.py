# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.detection.as_found.shapes import alpha_shape, dbscan, detect_shapes
from hullrecon.geometry.meshes.mesh import Mesh, face_areas


def _square(x: float, y: float, n: int = 5, step: float = 0.04) -> np.ndarray:
    grid = np.stack(np.meshgrid(np.arange(n), np.arange(n)), axis=-1).reshape(-1, 2) * step
    return grid + [x, y] + 1e-4 * np.random.default_rng(0).normal(size=grid.shape)


def test_two_groups_and_noise_are_told_apart() -> None:
    points = np.vstack([_square(0, 0), [[5.0, 5.0]], _square(1, 0)])
    label = dbscan(points, 0.06, 3)
    assert set(label[:25]) == {0}
    assert label[25] == -1
    assert set(label[26:]) == {1}


def test_a_rim_point_joins_the_cluster_whose_core_reaches_it() -> None:
    line = np.array([[0.0, 0], [1, 0], [2, 0], [2.9, 0]])
    assert dbscan(line, 1.0, 3).tolist() == [0, 0, 0, 0]
    assert dbscan(line, 0.95, 3).tolist() == [-1, -1, -1, -1]


def test_too_few_points_are_noise() -> None:
    assert dbscan(np.zeros((2, 2)), 1.0, 3).tolist() == [-1, -1]
    assert dbscan(np.zeros((0, 2)), 1.0, 3).shape == (0,)


def test_clusters_do_not_depend_on_the_order_of_points() -> None:
    points = np.vstack([_square(0, 0), _square(0.6, 0)])
    order = np.random.default_rng(1).permutation(50)
    label, turned = dbscan(points, 0.06, 3), dbscan(points[order], 0.06, 3)
    same = label[order][:, None] == label[order][None]
    assert np.array_equal(same, turned[:, None] == turned[None])


def test_an_alpha_shape_fills_a_square_and_leaves_its_hole() -> None:
    square = _square(0, 0, n=11)
    hole = (np.abs(square - 0.2) < 0.1).all(axis=1)
    full, ring = alpha_shape(square, 0.06), alpha_shape(square[~hole], 0.06)
    flat = lambda p: np.column_stack([p, np.zeros(len(p))])  # noqa: E731
    assert abs(face_areas(Mesh(flat(square), full)).sum() - 0.16) < 0.001
    assert abs(face_areas(Mesh(flat(square[~hole]), ring)).sum() - (0.16 - 0.24**2)) < 0.01


def test_points_on_one_line_have_no_shape() -> None:
    assert alpha_shape(np.array([[0.0, 0], [1, 1], [2, 2], [3, 3]]), 10.0).shape == (0, 3)
    assert alpha_shape(np.zeros((2, 2)), 1.0).shape == (0, 3)


def _features() -> tuple[np.ndarray, np.ndarray]:
    bump, hole, hull = _square(0, 0), _square(0.2, 0), _square(-0.5, -0.5, n=12)
    xy = np.vstack([bump, hole, hull])
    deviation = np.r_[np.full(25, 0.1), np.full(25, -0.1), np.zeros(144)]
    return np.column_stack([xy, 1.3 - deviation]), deviation


def test_only_features_off_the_hull_become_shapes() -> None:
    in_camera, deviation = _features()
    shapes = detect_shapes(in_camera, deviation, 0.03, 0.06, 3, 0.06)
    assert [round(float(s.vertices[:, 2].mean()), 3) for s in shapes] == [1.2, 1.4]


def test_a_bump_and_the_hole_beside_it_are_two_shapes() -> None:
    in_camera, deviation = _features()
    assert len(detect_shapes(in_camera, deviation, 0.03, 0.25, 3, 0.06)) == 2


def test_a_higher_threshold_finds_fewer_shapes() -> None:
    in_camera, deviation = _features()
    assert detect_shapes(in_camera, deviation, 0.11, 0.06, 3, 0.06) == []


def test_a_shape_keeps_the_places_of_its_features_in_the_camera() -> None:
    in_camera, deviation = _features()
    bump, hole = detect_shapes(in_camera, deviation, 0.03, 0.06, 3, 0.06)
    np.testing.assert_array_equal(bump.vertices, in_camera[:25])
    np.testing.assert_array_equal(hole.vertices, in_camera[25:50])
