# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.imagery.camera_views import CameraView
from hullrecon.mosaic.mosaic_surface import MosaicSurface


def test_point_ahead_of_camera_is_at_best_middle(
    camera: CameraModel, above: Callable[..., Poses]
) -> None:
    image_view = CameraView(pose=above(0.3, 0.2), camera=camera, load=lambda: None)
    pixel, ratio = image_view.project(np.array([[0.3, 0.2, 0.0], [0.4, 0.2, 0.0], [0.3, 0.3, 0.0]]))
    np.testing.assert_allclose(pixel, [[199.5, 159.5], [299.5, 159.5], [199.5, 59.5]], atol=1e-9)
    np.testing.assert_allclose(
        ratio, np.array([0.0, 100.0, 100.0]) / (0.5 * np.hypot(400, 320)), atol=1e-12
    )


def test_point_outside_image_or_behind_is_nan(
    camera: CameraModel, above: Callable[..., Poses]
) -> None:
    image_view = CameraView(pose=above(0.0, 0.0), camera=camera, load=lambda: None)
    _, ratio = image_view.project(np.array([[0.21, 0.0, 0.0], [0.0, 0.0, 1.5], [0.0, -0.17, 0.0]]))
    assert np.isnan(ratio).all()


def test_folding_distortion_keeps_far_points_outside(
    above: Callable[..., Poses],
) -> None:
    folding = CameraModel(width=400, height=320, fx=1000.0, fy=1000.0, cx=199.5, cy=159.5, k1=-1.0)
    image_view = CameraView(pose=above(0.0, 0.0), camera=folding, load=lambda: None)
    # the polynomial alone would hold it
    assert abs(folding.project([[1.0, 0.0, 1.0]])[0, 0] - 199.5) < 1
    assert np.isnan(image_view.project(np.array([[1.0, 0.0, 0.0]]))[1][0])


@pytest.mark.parametrize(
    "lens", [{}, {"k1": -0.3, "k2": 0.1, "p1": 0.004}, {"k1": 0.2, "k3": -0.4, "p2": -0.01}]
)
def test_no_point_of_a_ball_is_nearer_than_its_bound(lens: dict[str, float]) -> None:
    camera = CameraModel(width=400, height=320, fx=300.0, fy=310.0, cx=190.0, cy=165.0, **lens)
    turned = Rotation.from_euler("xyz", [170, 20, 30], degrees=True).as_quat()
    image_view = CameraView(
        pose=Poses(turned[None], np.array([[0.1, -0.2, 1.0]])), camera=camera, load=lambda: None
    )
    random = np.random.default_rng(5)
    center = random.uniform(-1.2, 1.2, (400, 3)) * [1, 1, 0.2]
    radius = random.uniform(0.01, 0.3, 400)
    way = random.normal(size=(400, 200, 3))
    way *= random.uniform(0, 1, (400, 200, 1)) / np.linalg.norm(way, axis=2, keepdims=True)
    points = center[:, None] + radius[:, None, None] * way
    ratio = image_view.project(points.reshape(-1, 3))[1].reshape(400, 200)
    nearest = np.where(np.isfinite(ratio), ratio, np.inf).min(axis=1)
    least = image_view.least_ratio(center, radius)
    assert (least <= nearest + 1e-12).all()
    held = np.isfinite(nearest)
    assert held.sum() > 50
    assert np.median(nearest[held] - least[held]) < 0.2  # and yet it tells near from far


def test_a_ball_behind_the_camera_is_out_of_reach(
    camera: CameraModel, above: Callable[..., Poses]
) -> None:
    image_view = CameraView(pose=above(0.0, 0.0), camera=camera, load=lambda: None)
    behind, around = np.array([[0, 0, 1.4], [0, 0, 1.1]])
    least = image_view.least_ratio(np.stack([behind, around]), np.array([0.3, 0.3]))
    np.testing.assert_array_equal(least, [np.inf, 0.0])


def test_the_outline_spans_the_footprint(
    camera: CameraModel, above: Callable[..., Poses], flat_surface: Callable[..., MosaicSurface]
) -> None:
    outline = CameraView(pose=above(0.0, 0.0), camera=camera, load=lambda: None).outline(
        flat_surface()
    )
    np.testing.assert_allclose(np.ptp(outline, axis=0), [0.397, 0.317, 0.0], atol=1e-5)


def test_the_outline_off_the_surface_is_lost(
    camera: CameraModel, above: Callable[..., Poses], flat_surface: Callable[..., MosaicSurface]
) -> None:
    outline = CameraView(pose=above(0.9, 0.0), camera=camera, load=lambda: None).outline(
        flat_surface()
    )
    lost = np.isnan(outline[:, 0])
    assert 0 < lost.sum() < len(outline)
    assert np.nanmax(outline[:, 0]) <= 1.0 + 1e-6
