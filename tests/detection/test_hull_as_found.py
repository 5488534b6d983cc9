# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.as_found.hull_as_found import (
    affordable_edge,
    as_found_surface,
    estimate_hull_as_found,
    refine_near,
    surface_on_cad_model,
)
from hullrecon.detection.options import DetectOptions
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.surface import Surface

OFF = -0.012  # of the whole wall
FLOOR = Mesh(
    np.array([[0.0, 0, 0], [8, 0, 0], [8, 8, 0], [0, 8, 0]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)


def _edges(mesh) -> tuple[np.ndarray, np.ndarray]:
    corner = mesh.vertices[mesh.faces]
    return np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2).max(axis=1), corner.mean(
        axis=1
    )


def test_the_hull_as_found_is_where_the_landmarks_put_it(found, height_at) -> None:
    x, z = found.base.vertices[found.measured][:, [0, 2]].T
    rim = np.abs(np.hypot(x - 1.2, z - 1.0) - 0.12) < 0.02
    rim |= (np.abs(np.maximum(np.abs(x - 2.2), np.abs(z - 1.0)) - 0.1)) < 0.02
    error = found.deviation[found.measured] - OFF - height_at(x, z)
    assert np.sqrt(np.mean(error[~rim] ** 2)) < 0.002
    assert np.abs(np.median(error[~rim])) < 0.0002


def test_the_mesh_is_moved_by_its_deviation(found) -> None:
    assert np.allclose(found.mesh.vertices[:, 1], 2 + found.deviation)
    assert np.allclose(found.mesh.vertices[:, [0, 2]], found.base.vertices[:, [0, 2]])


def test_mesh_is_fine_where_seen_and_finer_at_structures(found, height_at) -> None:
    length, middle = _edges(found.base)
    structure = height_at(middle[:, 0], middle[:, 2]) != 0
    seen = (np.abs(middle[:, 0] - 2) < 1.5) & (np.abs(middle[:, 2] - 1) < 0.4)
    assert length[structure].max() <= 0.012
    assert length[seen].max() <= 0.03
    assert length.max() > 0.1


def test_longer_edges_make_a_coarser_mesh(scenery, found) -> None:
    coarse = estimate_hull_as_found(
        scenery.base,
        scenery.measured,
        scenery.background,
        scenery.views,
        DetectOptions(max_edge_m=0.06),
    )
    assert len(coarse.mesh.vertices) < 0.7 * len(found.mesh.vertices)


def test_hull_far_from_landmarks_is_smooth_with_wide_sigma(found) -> None:
    beyond = found.base.vertices[:, 2] > 1.7
    assert not found.measured[beyond].any()
    assert np.allclose(found.deviation[beyond], OFF)
    assert found.sigma[beyond].min() > 5 * np.median(found.sigma[found.measured])


def test_views_that_the_structure_hides_do_not_count(found) -> None:
    at = found.base.vertices
    floor = (np.hypot(at[:, 0] - 1.2, at[:, 2] - 1.0) > 0.125) & (
        np.hypot(at[:, 0] - 1.2, at[:, 2] - 1.0) < 0.15
    )
    free = (np.abs(at[:, 0] - 1.2) < 0.15) & (np.abs(at[:, 2] - 1.3) < 0.02)
    assert found.seen.views[floor].mean() < found.seen.views[free].mean() - 0.5


def test_shapes_of_several_views_show_each_structure(found, height_at) -> None:
    x, z = found.base.vertices[:, [0, 2]].T
    inside = np.hypot(x - 1.2, z - 1.0) < 0.08
    assert np.median(found.shapes[inside]) >= 3
    # wild landmarks that lie close together by chance
    assert np.mean(found.shapes[np.abs(x - 3.0) < 0.2] > 0) < 0.05


def test_regression_finds_the_top_of_the_disc(found) -> None:
    x, z = found.base.vertices[:, [0, 2]].T
    top = np.hypot(x - 1.2, z - 1.0) < 0.05
    # landmarks 3 mm noisy, 2 % wild, which the regression leaves out
    assert np.median(found.height[top]) == pytest.approx(0.10, abs=0.004)


def test_the_mesh_is_coarser_rather_than_too_large(scenery, found) -> None:
    """The limit is held as far as areas tell how many vertices an edge needs."""
    few = DetectOptions(max_vertices=2000)
    coarse = estimate_hull_as_found(
        scenery.base, scenery.measured, scenery.background, scenery.views, few
    )
    assert len(coarse.mesh.vertices) < 2 * few.max_vertices < 0.5 * len(found.mesh.vertices)


def test_mesh_of_all_high_hull_keeps_to_its_limit(scenery) -> None:
    raised = replace(scenery.measured, offset=scenery.measured.offset + 0.2)
    few = DetectOptions(max_vertices=2000)
    coarse = estimate_hull_as_found(scenery.base, raised, scenery.background, scenery.views, few)
    assert len(coarse.mesh.vertices) < 2 * few.max_vertices


def test_the_same_input_gives_the_same_bytes(scenery, found) -> None:
    again = estimate_hull_as_found(
        scenery.base, scenery.measured, scenery.background, scenery.views, DetectOptions()
    )
    assert again.mesh.vertices.tobytes() == found.mesh.vertices.tobytes()
    assert again.shapes.tobytes() == found.shapes.tobytes()


def test_edges_are_short_near_the_points_and_long_elsewhere() -> None:
    mesh = refine_near(FLOOR, np.array([[2.0, 2.0, 0.0]]), 0.1, 0.3)
    corner = mesh.vertices[mesh.faces]
    length = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2).max(axis=1)
    distance = np.linalg.norm(corner.mean(axis=1) - [2, 2, 0], axis=1)
    assert length[distance < 0.3].max() <= 0.1
    assert length[distance > 4].min() > 0.5
    assert len(mesh.faces) < 4000


def test_without_points_the_mesh_stays() -> None:
    assert refine_near(FLOOR, np.zeros((0, 3)), 0.1, 0.3) is FLOOR


def test_a_large_survey_gets_a_coarser_mesh() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(0, 10, (20000, 3)) * [1, 1, 0]  # 100 m2
    assert affordable_edge(points, 0.03, 1_000_000) == 0.03
    assert affordable_edge(points, 0.03, 10_000) == pytest.approx(np.sqrt(100 / 4300), rel=0.05)


def test_support_is_zero_where_nothing_was_measured(scenery, found) -> None:
    surface = as_found_surface(found, scenery.measured)
    assert (surface.support[~found.measured] == 0).all()
    assert np.median(surface.support[found.measured]) >= 3
    assert np.allclose(surface.deviation, surface.vertices[:, 1] - 2)


def test_sigma_holds_what_all_landmarks_share(scenery, found) -> None:
    surface = as_found_surface(found, scenery.measured)
    assert surface.sigma[found.measured].min() >= 0.004
    assert np.allclose(
        surface.sigma[found.measured] ** 2, found.sigma[found.measured] ** 2 + 0.004**2
    )


def _dvl(deviation: float) -> Surface:
    x, z = np.meshgrid(np.arange(1, 2.01, 0.1), np.arange(0.5, 1.51, 0.1))
    vertices = np.column_stack([x.ravel(), np.full(x.size, 2 + deviation), z.ravel()])
    n = len(vertices)
    return Surface(
        vertices=vertices,
        faces=np.zeros((0, 3), np.int32),
        deviation=np.full(n, deviation),
        sigma=np.full(n, 0.01),
        support=np.full(n, 4),
    )


def test_cad_model_moves_to_dvl_surface_near_it(wall) -> None:
    moved = surface_on_cad_model(wall, _dvl(0.03), 0.12)
    x, y, z = moved.vertices.T
    inside = (x > 1) & (x < 2) & (z > 0.5) & (z < 1.5)
    assert np.allclose(y[inside], 2.03)
    assert (moved.support[inside] == 4).all()
    assert np.allclose(moved.sigma[inside], np.hypot(0.01, 0.01))


def test_cad_model_far_from_dvl_surface_stays_unseen(wall) -> None:
    moved = surface_on_cad_model(wall, _dvl(0.03), 0.12)
    far = moved.vertices[:, 0] > 2.5
    assert np.allclose(moved.vertices[far, 1], 2.0)
    assert (moved.support[far] == 0).all()
    assert np.isnan(moved.sigma[far]).all()
    assert moved.deviation[far] == pytest.approx(0.0)
