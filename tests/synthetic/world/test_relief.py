# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.synthetic.items import Item, Kind, height_of, local


def at(item: Item, along: float, girth: float) -> float:
    return float(height_of(item, np.array([along]), np.array([girth]))[0])


@pytest.mark.parametrize("kind", ["cylinder", "dome", "box", "lump", "recess"])
def test_middle_has_full_height_and_outside_is_flat(kind: Kind) -> None:
    item = Item(kind, 5.0, 2.0, 0.1, (0.2, 0.3), 0.4)
    assert at(item, 5.0, 2.0) == pytest.approx(0.1)
    assert at(item, 5.25, 2.25) == 0


def test_recess_goes_inwards() -> None:
    assert at(Item("recess", 0.0, 0.0, -0.04, (0.2, 0.2)), 0.05, 0.0) == pytest.approx(-0.04)


def test_dome_is_half_ellipsoid() -> None:
    item = Item("dome", 0.0, 0.0, 0.12, (0.3, 0.3))
    assert at(item, 0.09, 0.0) == pytest.approx(0.12 * 0.8)  # 0.6 of the radius


def test_wall_is_half_way_up_at_edge() -> None:
    item = Item("cylinder", 0.0, 0.0, 0.11, (0.16, 0.16))
    assert at(item, 0.08, 0.0) == pytest.approx(0.055)
    assert at(item, 0.07, 0.0) == pytest.approx(0.11)
    assert at(item, 0.09, 0.0) == 0


def test_box_has_corners() -> None:
    item = Item("box", 0.0, 0.0, 0.1, (0.2, 0.1))
    assert at(item, 0.09, 0.04) == pytest.approx(0.1)
    assert at(item, 0.04, 0.09) == 0


def test_turned_box_is_turned_in_chart() -> None:
    item = Item("box", 0.0, 0.0, 0.1, (0.4, 0.1), np.pi / 2)
    assert at(item, 0.0, 0.15) == pytest.approx(0.1)
    assert at(item, 0.15, 0.0) == 0


def test_lump_is_highest_in_middle() -> None:
    item = Item("lump", 3.0, 1.0, 0.14, (0.4, 0.3))
    a, g = np.meshgrid(np.linspace(2.7, 3.3, 81), np.linspace(0.8, 1.2, 81))
    height = height_of(item, a.ravel(), g.ravel())
    assert height.max() == pytest.approx(0.14)
    assert height.min() == 0


@pytest.mark.parametrize("kind", ["digits", "stripe", "ring"])
def test_paint_has_no_height(kind: Kind) -> None:
    assert at(Item(kind, 0.0, 0.0, 0.0, (0.3, 0.3)), 0.0, 0.0) == 0


def test_barnacles_are_low_and_leave_steel_between_them() -> None:
    item = Item("barnacles", 2.0, 1.0, 0.016, (0.5, 0.4))
    a, g = np.meshgrid(np.linspace(1.7, 2.3, 200), np.linspace(0.75, 1.25, 200))
    height = height_of(item, a.ravel(), g.ravel())
    assert 0.008 < height.max() <= 0.016
    assert 0.1 < (height > 0.002).mean() < 0.6


def test_local_axes_are_one_at_edge() -> None:
    u, v = local(Item("box", 1.0, 1.0, 0.1, (0.4, 0.2)), np.array([1.2, 1.0]), np.array([1.0, 0.9]))
    np.testing.assert_allclose(u, [1, 0], atol=1e-12)
    np.testing.assert_allclose(v, [0, -1], atol=1e-12)
