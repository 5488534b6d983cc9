# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.blend import (
    VIEWS,
    ViewLimits,
    blend_tile,
    choose_views,
    crop_around,
    split_bands,
)
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.imagery.camera_views import CameraView
from hullrecon.mosaic.mosaic_surface import (
    MosaicSurface,
    SurfacePatch,
    find_unobstructed,
    sample_surface,
)
from hullrecon.typing import Array

GRID = TexelGrid(west=-0.4, north=0.3, step_m=0.004, height=150, width=200)
LIMITS = ViewLimits()
DOWN = [1.0, 0.0, 0.0, 0.0]


def painted(camera: CameraModel, pose: Poses, gain: float = 1.0) -> CameraView:
    """A camera over the plate, on which red grows with x, green with y, blue is even."""
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    x = (u - camera.cx) / camera.fx + pose.translation[0, 0]
    y = -(v - camera.cy) / camera.fy + pose.translation[0, 1]
    picture = (
        np.stack([125 + 200 * x, 125 + 200 * y, np.full(x.shape, 60.0)], axis=2).astype(np.float32)
        * gain
    )
    return CameraView(pose=pose, camera=camera, load=lambda: picture)


def test_overlapping_views_reproduce_what_is_painted(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel, above: Callable[..., Poses]
) -> None:
    image_views = [painted(camera, above(x, 0.0)) for x in (-0.15, 0.0, 0.15)]
    tile = blend_tile(flat_surface(), GRID, GRID.whole, image_views, [GRID.whole] * 3, LIMITS, 3)
    at = GRID.centers(np.arange(150.0), np.arange(200.0))
    inner = (np.abs(at[..., 0]) < 0.30) & (np.abs(at[..., 1]) < 0.13)
    np.testing.assert_allclose(tile.value[inner][:, 0], 125 + 200 * at[inner][:, 0], atol=1.5)
    np.testing.assert_allclose(tile.value[inner][:, 1], 125 + 200 * at[inner][:, 1], atol=1.5)
    assert tile.variance[inner].max() < 2
    assert tile.views[75, 100] == 3
    assert tile.views[0, 0] == 0


def test_disagreeing_views_leave_their_weighted_variance(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel, above: Callable[..., Poses]
) -> None:
    picture = [np.full((320, 400, 3), level, np.float32) for level in (100.0, 140.0)]
    image_views = [
        CameraView(pose=above(x, 0.0), camera=camera, load=lambda p=p: p)
        for x, p in zip((-0.1, 0.1), picture, strict=True)
    ]
    tile = blend_tile(flat_surface(), GRID, GRID.whole, image_views, [GRID.whole] * 2, LIMITS, 3)
    # half way between both the weights are equal: the mean is 120, the variance 20 squared
    column = 100
    np.testing.assert_allclose(tile.value[75, column], 120, atol=3)
    np.testing.assert_allclose(tile.variance[75, column], 400, atol=20)
    assert np.isnan(tile.variance[0, 0])


def test_at_most_four_views_are_kept_and_the_best_first(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel, above: Callable[..., Poses]
) -> None:
    shifts = (0.10, 0.0, 0.16, 0.04, 0.13, 0.07)
    image_views = {
        k: CameraView(pose=above(x, 0.0), camera=camera, load=lambda: None)
        for k, x in enumerate(shifts)
    }
    patch = sample_surface(flat_surface(), GRID, GRID.whole)
    choice = choose_views(
        flat_surface(),
        patch,
        GRID.whole,
        image_views,
        dict.fromkeys(image_views, GRID.whole),
        LIMITS,
    )
    assert choice.view.shape[0] == VIEWS
    np.testing.assert_array_equal(choice.view[:, 75, 100], [1, 3, 5, 0])
    assert (np.diff(choice.cost[:, 75, 100]) > 0).all()


def test_a_view_behind_a_block_is_not_chosen(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel, above: Callable[..., Poses]
) -> None:
    surface = flat_surface(([-0.02, -0.3, 0.0], [0.02, 0.3, 0.2]))
    image_views = {
        0: CameraView(pose=above(-0.15, 0.0), camera=camera, load=lambda: None),
        1: CameraView(pose=above(0.12, 0.0), camera=camera, load=lambda: None),
    }
    patch = sample_surface(surface, GRID, GRID.whole)
    choice = choose_views(
        surface, patch, GRID.whole, image_views, dict.fromkeys(image_views, GRID.whole), LIMITS
    )
    # 1 cm behind the block, seen from the first camera
    beside = round((0.03 - GRID.west) / GRID.step_m)
    np.testing.assert_array_equal(choice.view[:2, 75, beside], [1, -1])


def ranked(
    surface: MosaicSurface, patch: SurfacePatch, image_views: dict[int, CameraView]
) -> tuple[Array, Array]:
    """Return views and costs (4, h, w) by a ray for each texel of each view: the plain twin of
    choose_views.
    """
    point, normal = patch.point.reshape(-1, 3), patch.normal.reshape(-1, 3)
    cost = np.full((len(image_views), len(point)), np.inf, np.float32)
    for k, image_view in image_views.items():
        ratio = image_view.project(point)[1]
        away = image_view.center - point
        cosine = np.einsum("ni,ni->n", away, normal) / np.linalg.norm(away, axis=1)
        free = np.isfinite(ratio) & (cosine > LIMITS.min_cosine)
        free[free] = find_unobstructed(surface, point[free], normal[free], image_view.center)
        cost[k, free] = (ratio + LIMITS.slant * (1 - cosine))[free]
    order = np.argsort(cost, axis=0, kind="stable")[:VIEWS]
    cost = np.take_along_axis(cost, order, axis=0)
    return np.where(np.isfinite(cost), order, -1).reshape(VIEWS, *GRID.whole.shape), cost.reshape(
        VIEWS, *GRID.whole.shape
    )


def test_the_best_views_are_those_of_rays_for_all(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel, above: Callable[..., Poses]
) -> None:
    surface = flat_surface(([-0.02, -0.3, 0.0], [0.02, 0.3, 0.2]))
    # no texel lies half way between two
    shifts = (-0.1503, -0.0807, 0.0311, 0.1219, 0.1623, -0.0191, 0.0927)
    image_views = {
        k: CameraView(pose=above(x, 0.0), camera=camera, load=lambda: None)
        for k, x in enumerate(shifts)
    }
    patch = sample_surface(surface, GRID, GRID.whole)
    choice = choose_views(
        surface, patch, GRID.whole, image_views, dict.fromkeys(image_views, GRID.whole), LIMITS
    )
    view, cost = ranked(surface, patch, image_views)
    np.testing.assert_array_equal(choice.view, view)
    np.testing.assert_allclose(choice.cost, cost, rtol=1e-6)
    free = ranked(flat_surface(), sample_surface(flat_surface(), GRID, GRID.whole), image_views)[0]
    assert (view != free).sum() > 1_000  # the block decides somewhere


def test_rays_are_cast_for_the_views_that_are_chosen(
    flat_surface: Callable[..., MosaicSurface],
    camera: CameraModel,
    above: Callable[..., Poses],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    surface = flat_surface()
    patch = sample_surface(surface, GRID, GRID.whole)
    shifts = np.linspace(-0.2, 0.2, 12)
    image_views = {
        k: CameraView(pose=above(x, 0.0), camera=camera, load=lambda: None)
        for k, x in enumerate(shifts)
    }
    rays: list[int] = []
    is_free = surface.scene.is_free
    monkeypatch.setattr(
        surface.scene, "is_free", lambda start, end: rays.append(len(start)) or is_free(start, end)
    )
    choice = choose_views(
        surface, patch, GRID.whole, image_views, dict.fromkeys(image_views, GRID.whole), LIMITS
    )
    assert 0 < sum(rays) == (choice.view >= 0).sum()


def test_an_image_that_cannot_be_read_is_left_out(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel, above: Callable[..., Poses]
) -> None:
    image_views = [
        CameraView(pose=above(0.0, 0.0), camera=camera, load=lambda: None),
        painted(camera, above(0.02, 0.0)),
    ]
    tile = blend_tile(flat_surface(), GRID, GRID.whole, image_views, [GRID.whole] * 2, LIMITS, 3)
    assert tile.views.max() == 1
    np.testing.assert_allclose(tile.value[75, 100, 2], 60, atol=0.5)


def test_where_a_view_grazes_the_surface_it_is_not_chosen(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    turned = Rotation.from_euler("y", -85, degrees=True) * Rotation.from_quat(DOWN)
    flat = CameraView(
        pose=Poses(turned.as_quat()[None], np.array([[-0.5, 0.0, 0.05]])),
        camera=camera,
        load=lambda: None,
    )
    patch = sample_surface(flat_surface(), GRID, GRID.whole)
    seen = np.isfinite(flat.project(patch.point.reshape(-1, 3))[1])
    choice = choose_views(flat_surface(), patch, GRID.whole, {0: flat}, {0: GRID.whole}, LIMITS)
    far = patch.point.reshape(-1, 3)[seen][:, 0].max()
    chosen = patch.point[choice.view[0] == 0][:, 0]
    limit = -0.5 + 0.05 * np.tan(np.arccos(LIMITS.min_cosine))
    assert far > limit + 0.1
    assert limit - 0.02 < chosen.max() < limit


def test_the_bands_sum_to_the_picture() -> None:
    picture = np.random.default_rng(1).uniform(0, 255, (61, 83, 3)).astype(np.float32)
    np.testing.assert_allclose(sum(split_bands(picture)), picture, atol=1e-3)


@pytest.mark.parametrize("size", [(640, 512), (642, 511)])
def test_part_of_an_image_has_the_bands_of_the_whole(size: tuple[int, int]) -> None:
    random = np.random.default_rng(2)
    picture = random.uniform(0, 255, (size[1], size[0], 3)).astype(np.float32)
    pixel = random.uniform([300, 10], [390, 120], (500, 2))
    part, at = crop_around(pixel, size)
    near = np.rint(at).astype(int)
    far = np.rint(pixel).astype(int)
    assert (picture[part].size < picture.size) == (size == (640, 512))
    for band, whole in zip(split_bands(picture[part]), split_bands(picture), strict=True):
        np.testing.assert_allclose(
            band[near[:, 1], near[:, 0]], whole[far[:, 1], far[:, 0]], atol=1e-3
        )


def test_an_even_picture_is_all_in_the_coarsest_band() -> None:
    low, middle, fine = split_bands(np.full((40, 48, 1), 77, np.float32))
    np.testing.assert_allclose(low, 77, atol=1e-3)
    np.testing.assert_allclose(middle, 0, atol=1e-3)
    np.testing.assert_allclose(fine, 0, atol=1e-3)


def test_a_single_bright_pixel_shows_in_the_finest_band() -> None:
    picture = np.zeros((41, 41, 1), np.float32)
    picture[20, 20] = 200
    assert split_bands(picture)[2][20, 20, 0] > 180
