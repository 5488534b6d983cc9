# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.detection.views import (
    find_visibility,
    find_visibility_by_cell,
    iterate_views,
    rows_in_image,
    visible_rows,
)
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh


def test_a_point_is_in_frame_where_the_image_is(views_at) -> None:
    views = views_at([2.0])
    half = 1.3 * 320 / 640  # half the width of the footprint
    points = np.array([[2.0, 2, 1], [2 + half - 0.01, 2, 1], [2 + half + 0.01, 2, 1], [2.0, 5, 1]])
    assert rows_in_image(views, 0, points, np.arange(4)).tolist() == [0, 1]


def test_views_that_see_nothing_are_passed_over(views_at) -> None:
    views = views_at([0.5, 2.0, 30.0])
    assert [view for view, _ in iterate_views(views, np.array([[2.0, 2, 1]]))] == [0, 1]


def test_views_are_counted_and_nearest_is_kept(views_at, wall) -> None:
    views = views_at([1.8, 2.0, 2.3, 3.5])
    seen = find_visibility(views, np.array([[2.0, 2, 1]]), np.array([[0.0, 1, 0]]), Scene(wall))
    assert seen.views.tolist() == [3]
    assert np.allclose(seen.distance, 1.3)
    assert np.allclose(seen.cosine, 1.0)


def test_a_surface_that_looks_away_is_not_seen(views_at, wall) -> None:
    seen = find_visibility(
        views_at([2.0]), np.array([[2.0, 2, 1]]), np.array([[0.0, -1, 0]]), Scene(wall)
    )
    assert seen.views.tolist() == [0]
    assert np.isnan(seen.distance[0])


def test_what_stands_in_front_hides(views_at, wall) -> None:
    board = np.array([[1.9, 2.5, 0.9], [1.9, 2.5, 1.1], [2.1, 2.5, 1.1], [2.1, 2.5, 0.9]])
    both = Mesh(
        np.vstack([wall.vertices, board]),
        np.vstack([wall.faces, np.array([[0, 1, 2], [0, 2, 3]], np.int32) + len(wall.vertices)]),
    )
    points, normals = np.array([[2.0, 2, 1], [2.4, 2, 1]]), np.tile([0.0, 1, 0], (2, 1))
    rows, distance, _ = visible_rows(
        np.array([2.0, 3.3, 1.0]), np.arange(2), points, normals, Scene(both)
    )
    assert rows.tolist() == [1]
    assert np.allclose(distance, np.hypot(1.3, 0.4))


def test_one_point_answers_for_its_cell(views_at, wall) -> None:
    rng = np.random.default_rng(0)
    points = np.column_stack(
        [rng.uniform(1, 3, 3000), np.full(3000, 2.0), rng.uniform(0.6, 1.4, 3000)]
    )
    normals, views, scene = np.tile([0.0, 1, 0], (3000, 1)), views_at([1.5, 2.0, 2.5]), Scene(wall)
    exact = find_visibility(views, points, normals, scene)
    quick = find_visibility_by_cell(views, points, normals, scene, np.full(3000, 0.02))
    assert np.mean(exact.views == quick.views) > 0.93  # cells on the images' rims differ
    assert np.abs(exact.views - quick.views).max() <= 2
