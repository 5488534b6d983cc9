# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.mosaic_surface import MosaicSurface, find_unobstructed, sample_surface
from hullrecon.mosaic.occlusion_horizon import build_occlusion_horizon

GRID = TexelGrid(west=-1.0, north=1.0, step_m=0.02, height=100, width=100)
BLOCK = ([-0.2, -0.2, 0.0], [0.2, 0.2, 0.15])


def test_a_bare_plate_hides_nothing_from_any_incidence(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    patch = sample_surface(flat_surface().with_occlusion_horizon(GRID, 2.0), GRID, GRID.whole)
    assert np.isinf(patch.free_below).all()


def test_the_flatter_the_view_the_farther_a_block_may_hide(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    patch = sample_surface(flat_surface(BLOCK).with_occlusion_horizon(GRID, 2.0), GRID, GRID.whole)
    assert patch.free_below[50, 61] == 0  # 3 cm off: any view may be blocked
    along = patch.free_below[50, 62:]
    assert (np.diff(along) >= 0).all()
    distance = -1 + 99.5 * 0.02 - 0.2
    assert 0.4 * distance / 0.15 < along[-1] <= distance / 0.15


def test_what_stands_behind_every_instrument_hides_nothing(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    patch = sample_surface(flat_surface(BLOCK).with_occlusion_horizon(GRID, 0.3), GRID, GRID.whole)
    assert np.isinf(patch.free_below[50, 98])
    assert patch.free_below[50, 61] == 0


@pytest.mark.parametrize("thick_m", [0.004, 0.15])
def test_no_texel_that_a_ray_finds_hidden_is_taken_for_safe(
    flat_surface: Callable[..., MosaicSurface], thick_m: float
) -> None:
    """A blade thinner than any raster cell counts as well: the bound is held against rays to random
    eyes.
    """
    rng = np.random.default_rng(5)
    surface = flat_surface(([-0.3, -0.7, 0.0], [-0.3 + thick_m, 0.7, 0.2])).with_occlusion_horizon(
        GRID, 4.0
    )
    patch = sample_surface(surface, GRID, GRID.whole)
    point, normal = patch.point.reshape(-1, 3), patch.normal.reshape(-1, 3)
    bound = patch.free_below.ravel()
    blocked = 0
    for sensor in rng.uniform([-1.5, -1.0, 0.2], [1.5, 1.0, 1.2], (40, 3)):
        on_plate = point[:, 2] < 0.001
        away = sensor - point
        tangent = np.linalg.norm(away[:, :2], axis=1) / away[:, 2]
        hidden = on_plate & ~find_unobstructed(surface, point, normal, sensor)
        blocked += int(hidden.sum())
        assert (tangent[hidden] >= bound[hidden]).all()
    assert blocked > 1000


def test_structure_within_reach_belongs_to_horizon(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    surface = flat_surface(([0.5, -0.1, 0.0], [0.6, 0.1, 0.3]))
    texels = np.array([[-0.5, -0.5], [0.0, 0.5]])
    assert build_occlusion_horizon(surface.mesh, surface.chart, texels, 1.0).top[
        :, 2
    ].max() == pytest.approx(0.3)
    far = build_occlusion_horizon(surface.mesh, surface.chart, texels, 0.3)
    assert far.top[:, 2].max() == pytest.approx(0.0)
