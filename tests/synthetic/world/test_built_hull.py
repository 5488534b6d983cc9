# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A hull in one block and the same hull in several are one hull."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from hullrecon.geometry.meshes.mesh import Mesh, face_areas
from hullrecon.synthetic.built_hull import KEPT_BLOCKS, BuiltHull
from hullrecon.synthetic.hull_patch import MARGIN_M, HullSkin
from hullrecon.synthetic.hull_shapes import ship_form
from hullrecon.synthetic.items import Item
from hullrecon.synthetic.options import Ship, spec_from

SPAN_M = (24.0, 44.0)
STEP_M = 0.06  # twice the default: a quarter of the work
DOME, BOX = Item("dome", 30.6, -0.3, 0.12, (0.3, 0.3)), Item("box", 37.5, -0.6, 0.1, (0.3, 0.2))


def skin(block_cells: float) -> HullSkin:
    return HullSkin(
        ship_form(Ship()),
        SPAN_M,
        zero_z_m=2.0,
        top_z_m=3.0,
        down_m=1.5,
        step_m=STEP_M,
        block_cells=block_cells,
    )


@pytest.fixture(scope="module")
def whole() -> BuiltHull:
    return BuiltHull(spec_from(), skin(1e9), (DOME, BOX))


@pytest.fixture(scope="module")
def parted() -> BuiltHull:
    return BuiltHull(spec_from(), skin(5e3), (DOME, BOX))


def test_large_hull_has_blocks_of_about_size_asked_for(whole: BuiltHull, parted: BuiltHull) -> None:
    assert len(whole.skin) == 1
    assert len(parted.skin) == 3
    cores = [parted.skin.core_m(k) for k in range(3)]
    assert cores[0][0] == pytest.approx(SPAN_M[0])
    assert cores[-1][1] == pytest.approx(SPAN_M[1], abs=STEP_M)
    assert all(before[1] == after[0] for before, after in pairwise(cores))


def test_place_belongs_to_block_whose_core_holds_it(parted: BuiltHull) -> None:
    along = np.array([-5.0, 24.1, 30.0, 34.0, 43.9, 80.0])
    found = parted.skin.block_of(along)
    np.testing.assert_array_equal(found, [0, 0, 0, 1, 2, 2])


def test_patch_reaches_beyond_its_core_by_margin(parted: BuiltHull) -> None:
    low, high = parted.skin.core_m(1)
    middle = parted.skin.patch(1)
    assert middle.along_m[0] == pytest.approx(low - MARGIN_M, abs=1.5 * STEP_M)
    assert middle.along_m[-1] == pytest.approx(high + MARGIN_M, abs=1.5 * STEP_M)


def test_path_follows_same_surface(whole: BuiltHull, parted: BuiltHull) -> None:
    along, girth = np.linspace(25, 43, 400), np.linspace(-1.0, 0.5, 400)
    for one, several in zip(
        whole.skin.follow(along, girth, 0.5), parted.skin.follow(along, girth, 0.5), strict=True
    ):
        np.testing.assert_allclose(several, one, atol=1e-9)


def test_middle_is_same(whole: BuiltHull, parted: BuiltHull) -> None:
    np.testing.assert_allclose(parted.skin.middle, whole.skin.middle, atol=1e-9)
    np.testing.assert_allclose(
        whole.skin.middle, whole.skin.patch(0).point.reshape(-1, 3).mean(0), atol=1e-12
    )


def test_ranges_are_same_and_empty_where_there_is_no_hull(
    whole: BuiltHull, parted: BuiltHull
) -> None:
    along = np.linspace(25, 43, 60)
    patch = whole.near(0.0).patch
    point, normal = (
        patch.sample(grid, along, np.full(60, -0.3)) for grid in (patch.point, patch.normal)
    )
    away = np.tile([0.0, 1.0, 0.0], (60, 1))
    directions = np.stack([-normal, away], axis=1)
    one, several = (hull.ranges(point + 1.2 * normal, directions) for hull in (whole, parted))
    np.testing.assert_allclose(several, one, atol=2e-6)
    assert np.isnan(one[:, 1]).all()
    assert (np.abs(one[:, 0] - 1.2) < 0.2).all()


def test_items_stand_in_whichever_block_is_asked(whole: BuiltHull, parted: BuiltHull) -> None:
    for item in (DOME, BOX):
        point = np.array([item.along_m]), np.array([item.girth_m])
        patch = whole.near(item.along_m).patch
        at, out = patch.sample(patch.point, *point), patch.sample(patch.normal, *point)
        ranges = [hull.ranges(at + out, -out[:, None])[0, 0] for hull in (whole, parted)]
        assert ranges[0] == pytest.approx(ranges[1], abs=2e-6)
        assert ranges[0] < 1 - 0.5 * item.height_m


def test_pieces_of_window_join_without_gap_or_overlap(whole: BuiltHull, parted: BuiltHull) -> None:
    window = (25.0, 43.0), (-1.0, 0.6)
    (one,), several = list(whole.window(*window)), list(parted.window(*window))
    assert len(several) == 3
    assert sum(face_areas(piece).sum() for piece in several) == pytest.approx(
        face_areas(one).sum(), rel=1e-9
    )
    assert sum(len(piece.faces) for piece in several) == len(one.faces)
    joined = np.unique(np.round(np.vstack([piece.vertices for piece in several]), 7), axis=0)
    np.testing.assert_allclose(joined, np.unique(np.round(one.vertices, 7), axis=0), atol=2e-7)


def test_window_leaves_out_blocks_beside_it(parted: BuiltHull) -> None:
    pieces: list[Mesh] = list(parted.window((25.0, 28.0), (-1.0, 0.6)))
    assert len(pieces) == 1
    assert pieces[0].vertices[:, 0].max() < 28.1


def test_no_more_blocks_are_kept_than_said(parted: BuiltHull) -> None:
    for along in (25.0, 34.0, 43.0, 34.0):
        assert parted.near(along) is parted.near(along)
    assert len(parted._blocks) == KEPT_BLOCKS
