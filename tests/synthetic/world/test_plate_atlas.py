# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.synthetic import atlas as atlas_module
from hullrecon.synthetic.atlas import PlateAtlas
from hullrecon.synthetic.items import Item
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.texture import PLATE_M

TEXEL_M = 0.004


def atlas(items: tuple[Item, ...] = (), seed: int = 1) -> PlateAtlas:
    return PlateAtlas(spec_from(seed=seed), items, TEXEL_M)


def colours(made: PlateAtlas, along: np.ndarray, girth: np.ndarray) -> np.ndarray:
    a, g = np.meshgrid(along.astype(np.float32), girth.astype(np.float32))
    return made.look_up(a, g, np.ones(a.shape, bool))


def test_view_at_either_end_of_long_hull_is_textured() -> None:
    for middle in (3.0, 250.0):
        seen = colours(atlas(), middle + np.arange(-0.5, 0.5, 0.01), np.arange(-0.4, 0.4, 0.01))
        assert seen.std(axis=(0, 1)).min() > 0.02
        assert 0.05 < seen.mean() < 0.8


def test_plate_painted_again_has_same_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(atlas_module, "KEPT_PLATES", 2)
    made = atlas()
    along, girth = np.arange(0.1, 2.2, 0.05), np.arange(0.1, 1.2, 0.05)
    before = colours(made, along, girth)
    for k in range(1, 4):
        colours(made, along[:1] + k * PLATE_M[0], girth[:1])
    np.testing.assert_array_equal(colours(made, along, girth), before)


def test_no_more_plates_are_kept_than_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(atlas_module, "KEPT_PLATES", 3)
    made = atlas()
    for k in range(5):
        colours(made, np.array([1.2 + k * PLATE_M[0]]), np.array([0.6]))
    assert len(made._plates) == 3


def test_plates_are_painted_apart_and_by_seed() -> None:
    along, girth = np.arange(0.3, 2.1, 0.02), np.arange(0.2, 1.1, 0.02)
    first, next_one = colours(atlas(), along, girth), colours(atlas(), along + PLATE_M[0], girth)
    other_seed = colours(atlas(seed=2), along, girth)
    for other in (next_one, other_seed):
        assert abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 0.5
        assert np.abs(first - other).mean() > 0.02


def test_edge_of_plate_is_dark_weld() -> None:
    girth = np.arange(0.2, 1.1, 0.004)
    weld = colours(atlas(), PLATE_M[0] + np.array([-0.003, 0.003]), girth).mean()
    beside = colours(atlas(), PLATE_M[0] + np.array([-0.05, 0.05]), girth).mean()
    assert weld < 0.8 * beside


def test_mark_across_weld_is_painted_on_both_plates() -> None:
    stripe = Item("stripe", PLATE_M[0], 0.6, 0.0, (0.4, 0.2))
    girth = np.arange(0.55, 0.65, 0.01)
    for side in (-0.1, 0.1):
        at = PLATE_M[0] + side + np.arange(-0.02, 0.02, 0.01)
        assert (colours(atlas((stripe,)), at, girth) - colours(atlas(), at, girth)).max(
            axis=2
        ).mean() > 0.2


def test_structure_has_one_tone_on_both_plates() -> None:
    box = Item("box", PLATE_M[0], 0.6, 0.1, (0.4, 0.2))
    made = atlas((box,))
    plain = atlas()
    girth = np.arange(0.52, 0.68, 0.004)
    tones = []
    for side in (-0.1, 0.1):
        at = PLATE_M[0] + side + np.arange(-0.04, 0.04, 0.004)
        tones.append((colours(made, at, girth) - 0.8 * colours(plain, at, girth)).mean() / 0.2)
    assert tones[0] == pytest.approx(tones[1], abs=0.02)
    assert 70 / 255 - 0.02 < tones[0] < 150 / 255 + 0.02


def test_nothing_seen_is_nothing_painted() -> None:
    made = atlas()
    nowhere = np.zeros((3, 4), np.float32)
    assert made.look_up(nowhere, nowhere, np.zeros((3, 4), bool)).max() == 0
    assert len(made._plates) == 0


@pytest.mark.parametrize(
    "corner", [(0.0, 0.0), (-PLATE_M[0], -2 * PLATE_M[1]), (40 * PLATE_M[0], -9 * PLATE_M[1])]
)
def test_view_across_plates_is_each_plates_own(corner: tuple[float, float]) -> None:
    """Also aft of the stern's zero and below the line of no girth."""
    made, eps = atlas(), 0.2
    along, girth = corner[0] + np.array([-eps, eps]), corner[1] + np.array([-eps, eps])
    together = colours(made, along, girth)
    for i in range(2):
        for j in range(2):
            np.testing.assert_array_equal(
                together[j : j + 1, i : i + 1], colours(made, along[i : i + 1], girth[j : j + 1])
            )
            column, row = np.floor(along[i] / PLATE_M[0]), np.floor(girth[j] / PLATE_M[1])
            assert (int(column), int(row)) in made._plates
