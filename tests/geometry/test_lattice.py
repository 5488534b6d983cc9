# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.charts.lattice import Lattice, lattice_around

LATTICE = Lattice(origin=np.array([10.0, -1.0]), step_m=0.5, shape=(9, 5))


def test_cells_have_their_middles() -> None:
    points = LATTICE.points()
    assert points.shape == (9, 5, 2)
    assert points[2, 4].tolist() == [11.0, 1.0]


def test_a_point_is_in_the_cell_whose_middle_is_nearest() -> None:
    cell, inside = LATTICE.cells(np.array([[10.2, -1.1], [13.9, 0.9]]))
    assert cell.tolist() == [[0, 0], [8, 4]]
    assert inside.all()


def test_points_off_the_lattice_or_lost_are_in_no_cell() -> None:
    _, inside = LATTICE.cells(np.array([[9.0, 0.0], [12.0, 2.0], [np.nan, 0.0]]))
    assert not inside.any()


def test_a_polygon_and_its_outline_are_each_others_inverse() -> None:
    box = np.array([[11.0, -0.5], [13.0, -0.5], [13.0, 0.5], [11.0, 0.5]])
    mask = LATTICE.polygon(box)
    assert mask.sum() == 5 * 3
    line = LATTICE.outline(mask)
    assert line.min(axis=0) == pytest.approx([11.0, -0.5])
    assert line.max(axis=0) == pytest.approx([13.0, 0.5])


def test_nothing_has_no_outline_and_no_cells() -> None:
    assert LATTICE.outline(np.zeros((9, 5), bool)).shape == (0, 2)
    assert not LATTICE.polygon(np.zeros((0, 2))).any()


def test_a_lattice_around_points_holds_them_with_a_margin() -> None:
    points = np.array([[10.07, 2.0], [11.0, 2.93], [np.nan, 5.0]])
    lattice = lattice_around(points, 0.1, 0.2)
    cell, inside = lattice.cells(points[:2])
    assert inside.all()
    assert (cell >= 1).all()
    assert lattice.points()[-1, -1] == pytest.approx([11.2, 3.2])
