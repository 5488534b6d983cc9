# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.ground import Ground, patch_of, unobstructed
from hullrecon.mosaic.skyline import skyline_of

GRID = TexelGrid(west=-1.0, north=1.0, step_m=0.02, height=100, width=100)
BLOCK = ([-0.2, -0.2, 0.0], [0.2, 0.2, 0.15])


def test_a_bare_plate_hides_nothing_from_any_incidence(flat_ground: Callable[..., Ground]) -> None:
    patch = patch_of(flat_ground().with_skyline(GRID, 2.0), GRID, GRID.whole)
    assert np.isinf(patch.hidden_from).all()


def test_the_flatter_the_view_the_farther_a_block_may_hide(flat_ground: Callable[..., Ground]) -> None:
    patch = patch_of(flat_ground(BLOCK).with_skyline(GRID, 2.0), GRID, GRID.whole)
    assert patch.hidden_from[50, 61] == 0  # 3 cm off: any view may be blocked
    along = patch.hidden_from[50, 62:]
    assert (np.diff(along) >= 0).all()
    distance = -1 + 99.5 * 0.02 - 0.2
    assert 0.4 * distance / 0.15 < along[-1] <= distance / 0.15


def test_what_stands_behind_every_instrument_hides_nothing(flat_ground: Callable[..., Ground]) -> None:
    patch = patch_of(flat_ground(BLOCK).with_skyline(GRID, 0.3), GRID, GRID.whole)
    assert np.isinf(patch.hidden_from[50, 98])
    assert patch.hidden_from[50, 61] == 0


@pytest.mark.parametrize("thick_m", [0.004, 0.15])
def test_no_texel_that_a_ray_finds_hidden_is_taken_for_safe(flat_ground: Callable[..., Ground], thick_m: float) -> None:
    """A blade thinner than any raster cell counts as well: the bound is held against rays to random eyes."""
    rng = np.random.default_rng(5)
    ground = flat_ground(([-0.3, -0.7, 0.0], [-0.3 + thick_m, 0.7, 0.2])).with_skyline(GRID, 4.0)
    patch = patch_of(ground, GRID, GRID.whole)
    point, normal = patch.point.reshape(-1, 3), patch.normal.reshape(-1, 3)
    bound = patch.hidden_from.ravel()
    blocked = 0
    for eye in rng.uniform([-1.5, -1.0, 0.2], [1.5, 1.0, 1.2], (40, 3)):
        on_plate = point[:, 2] < 0.001
        away = eye - point
        tangent = np.linalg.norm(away[:, :2], axis=1) / away[:, 2]
        hidden = on_plate & ~unobstructed(ground, point, normal, eye)
        blocked += int(hidden.sum())
        assert (tangent[hidden] >= bound[hidden]).all()
    assert blocked > 1000


def test_a_structure_beyond_the_texels_but_within_reach_belongs_to_the_skyline(flat_ground: Callable[..., Ground]) -> None:
    ground = flat_ground(([0.5, -0.1, 0.0], [0.6, 0.1, 0.3]))
    texels = np.array([[-0.5, -0.5], [0.0, 0.5]])
    assert skyline_of(ground.mesh, ground.chart, texels, 1.0).top[:, 2].max() == pytest.approx(0.3)
    far = skyline_of(ground.mesh, ground.chart, texels, 0.3)
    assert far.top[:, 2].max() == pytest.approx(0.0)
