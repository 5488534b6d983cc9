# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.as_found.hull_as_found import estimate_hull_as_found
from hullrecon.detection.as_found.shapes import ALPHA_RADIUS_M, detect_shapes
from hullrecon.detection.options import DetectOptions
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.studies.sessions.particles import candidates
from hullrecon.studies.sessions.particles_study import old_map
from hullrecon.studies.surfaces.regression import fuse_shapes, move_along_rays

OPTIONS = DetectOptions()


def _plate(height: float, n: int = 9) -> np.ndarray:
    """Features on a plate 0.24 m wide, `height` above the wall at (2, 1)."""
    x, z = np.meshgrid(np.linspace(-0.12, 0.12, n), np.linspace(-0.12, 0.12, n))
    return np.column_stack([2 + x.ravel(), np.full(x.size, 2 + height), 1 + z.ravel()])


VERTEX = np.array([[2.0, 2, 1], [2.05, 2, 1.02], [2.6, 2, 1.0]])


def test_the_first_observation_replaces_the_prior(views_at) -> None:
    features = _plate(0.1)
    fused = fuse_shapes(views_at([2.0]), features, np.full(len(features), 0.1), VERTEX, OPTIONS)
    assert fused.count.tolist() == [1, 1, 0]
    assert np.allclose(fused.vertex[0], [2, 2.1, 1], atol=1e-9)


def test_the_vertex_moves_along_the_ray_from_the_camera(views_at) -> None:
    features = _plate(0.1)
    fused = fuse_shapes(views_at([2.3]), features, np.full(len(features), 0.1), VERTEX[:1], OPTIONS)
    assert np.allclose(fused.vertex, [[2 + 0.3 * 0.1 / 1.3, 2.1, 1]], atol=1e-9)


def test_many_views_give_the_mean_of_their_intersections(views_at) -> None:
    features, views = _plate(0.1), views_at([1.9, 2.0, 2.3])
    fused = fuse_shapes(views, features, np.full(len(features), 0.1), VERTEX[:1], OPTIONS)
    each = [
        fuse_shapes(
            views_at([x]), features, np.full(len(features), 0.1), VERTEX[:1], OPTIONS
        ).vertex[0]
        for x in (1.9, 2.0, 2.3)
    ]
    assert fused.count.tolist() == [3]
    assert np.allclose(fused.vertex[0], np.mean(each, axis=0))


def test_vertex_without_hits_stays_on_the_cad_model(views_at) -> None:
    features = _plate(0.1)
    fused = fuse_shapes(views_at([2.0]), features, np.full(len(features), 0.1), VERTEX, OPTIONS)
    assert np.array_equal(fused.vertex[2], VERTEX[2])


def test_features_on_the_hull_move_nothing(views_at) -> None:
    features = _plate(0.01)
    fused = fuse_shapes(views_at([2.0]), features, np.full(len(features), 0.01), VERTEX, OPTIONS)
    assert fused.count.sum() == 0
    assert np.array_equal(fused.vertex, VERTEX)


def test_a_recess_moves_vertices_inward(views_at) -> None:
    features = _plate(-0.06)
    fused = fuse_shapes(
        views_at([2.0]), features, np.full(len(features), -0.06), VERTEX[:1], OPTIONS
    )
    assert np.allclose(fused.vertex, [[2, 1.94, 1]], atol=1e-9)


def test_rays_find_the_top_of_the_disc(scenery) -> None:
    found = estimate_hull_as_found(
        scenery.base,
        scenery.measured,
        scenery.background,
        scenery.views,
        OPTIONS,
        fusion=move_along_rays,
    )
    x, z = found.base.vertices[:, [0, 2]].T
    top = np.hypot(x - 1.2, z - 1.0) < 0.05
    # landmarks 3 mm noisy, 2 % wild: a wild one inside a shape lifts its triangles
    assert np.median(found.height[top]) == pytest.approx(0.10, abs=0.004)


def test_rays_meet_the_shapes_of_algorithm_4_not_the_key_frames_of_1_as_printed() -> None:
    """[Ozog2016 Algorithm 5, line 4] prints Algorithm 1 for what makes the shapes."""
    across, along = np.meshgrid(np.linspace(-0.12, 0.12, 9), np.linspace(-0.12, 0.12, 9))
    in_camera = np.column_stack([across.ravel(), along.ravel(), np.full(across.size, 1.2)])
    shapes = detect_shapes(in_camera, np.full(len(in_camera), 0.1), 0.03, 0.1, 4, ALPHA_RADIUS_M)
    met = Scene(shapes[0]).cast(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    np.testing.assert_allclose(met, 1.2)
    key_frames = candidates(old_map(np.random.default_rng(0)), np.zeros((1, 3)), 2.0)
    assert key_frames.dtype == np.int64  # numbers of images: nothing that a ray meets
    with pytest.raises(AttributeError):
        Scene(key_frames)
