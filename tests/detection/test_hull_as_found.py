# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.as_found.hull_as_found import estimate_hull_as_found
from hullrecon.detection.options import DetectOptions

OFF = -0.012  # of the whole wall


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


def test_the_mesh_is_fine_where_seen_finer_at_structures_and_coarse_beyond(
    found, height_at
) -> None:
    length, middle = _edges(found.base)
    structure = height_at(middle[:, 0], middle[:, 2]) != 0
    seen = (np.abs(middle[:, 0] - 2) < 1.5) & (np.abs(middle[:, 2] - 1) < 0.4)
    assert length[structure].max() <= 0.012
    assert length[seen].max() <= 0.03
    assert length.max() > 0.1


def test_where_no_landmark_is_near_the_smooth_hull_holds_and_sigma_says_so(found) -> None:
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


def test_where_all_is_high_the_mesh_is_not_refined_beyond_its_limit(scenery) -> None:
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
