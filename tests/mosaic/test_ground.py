# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.ground import Ground, patch_of, unobstructed

GRID = TexelGrid(west=-1.2, north=1.2, step_m=0.02, height=120, width=120)


def test_texels_lie_on_the_surface_at_their_chart_coordinates(flat_ground: Callable[..., Ground]) -> None:
    patch = patch_of(flat_ground(), GRID, Window(20, 90, 15, 100))
    want = GRID.centers(np.arange(20.0, 90.0), np.arange(15.0, 100.0))
    np.testing.assert_allclose(patch.point[..., :2], want, atol=1e-6)
    np.testing.assert_allclose(patch.point[..., 2], 0, atol=1e-6)


def test_texels_beyond_the_surface_are_not_known(flat_ground: Callable[..., Ground]) -> None:
    patch = patch_of(flat_ground(), GRID, GRID.whole)
    known = np.isfinite(patch.point[..., 0])
    assert not known[:9].any()
    assert known[11:109, 11:109].all()


def test_the_top_of_a_block_is_what_is_seen(flat_ground: Callable[..., Ground]) -> None:
    patch = patch_of(flat_ground(([-0.2, -0.2, 0.0], [0.2, 0.2, 0.15])), GRID, GRID.whole)
    np.testing.assert_allclose(patch.point[60, 60, 2], 0.15, atol=1e-6)
    np.testing.assert_allclose(patch.point[60, 75, 2], 0.0, atol=1e-6)


def test_only_beside_a_block_can_something_be_hidden(flat_ground: Callable[..., Ground]) -> None:
    patch = patch_of(flat_ground(([-0.2, -0.2, 0.0], [0.2, 0.2, 0.15])), GRID, GRID.whole)
    assert patch.hidden_from[60, 60] == np.inf  # on top
    assert patch.hidden_from[60, 71] == 0.0  # 1 cm off: any view may be blocked
    assert 0.1 < patch.hidden_from[60, 80] < 1.0  # 20 cm off: only flat views, at least 0.1 / 0.15
    assert patch.hidden_from[60, 100] == np.inf


def test_a_block_stands_in_the_line_of_a_slanted_view(flat_ground: Callable[..., Ground]) -> None:
    ground = flat_ground(([-0.2, -0.2, 0.0], [0.2, 0.2, 0.15]))
    points = np.array([[0.25, 0.0, 0.0], [0.8, 0.0, 0.0]])
    normals = np.tile([0.0, 0.0, 1.0], (2, 1))
    np.testing.assert_array_equal(unobstructed(ground, points, normals, np.array([-1.0, 0.0, 1.0])), [False, True])
    np.testing.assert_array_equal(unobstructed(ground, points, normals, np.array([0.25, 0.0, 1.0])), [True, True])
