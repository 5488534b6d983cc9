# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.detection.objects.outline import outline
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.refinement import refine

FLOOR = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32))
FINE, _ = refine(FLOOR, 0.05)


def _area(line: np.ndarray) -> float:
    x, y = line[:, 0], line[:, 1]
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _within(radius: float, hole: float = 0.0) -> np.ndarray:
    distance = np.linalg.norm(FINE.vertices[:, :2] - 0.5, axis=1)
    return np.flatnonzero((distance <= radius) & (distance >= hole))


def test_the_outline_of_a_disc_goes_round_it_counter_clockwise() -> None:
    line = outline(FINE, _within(0.3))
    assert 0.85 * np.pi * 0.09 < _area(line) < np.pi * 0.09
    assert np.linalg.norm(line[:, :2] - 0.5, axis=1).max() <= 0.3


def test_of_a_ring_the_outer_line_counts() -> None:
    assert np.linalg.norm(outline(FINE, _within(0.4, hole=0.2))[:, :2] - 0.5, axis=1).min() > 0.3


def test_the_number_of_vertices_is_limited() -> None:
    assert 6 < len(outline(FINE, _within(0.45), most=12)) <= 12


def test_a_part_without_a_face_has_no_outline() -> None:
    assert outline(FINE, np.array([0, 2])).shape == (0, 3)


def test_of_two_parts_the_longer_line_counts() -> None:
    left = np.flatnonzero(np.linalg.norm(FINE.vertices[:, :2] - [0.25, 0.5], axis=1) < 0.12)
    right = np.flatnonzero(np.linalg.norm(FINE.vertices[:, :2] - [0.7, 0.5], axis=1) < 0.22)
    assert (outline(FINE, np.union1d(left, right))[:, 0] > 0.45).all()
