# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.objects.footprint import outline
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.refinement import refine

FLOOR = Mesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)
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


def _turning(line: np.ndarray) -> float:
    """Sum of the turns at the corners of a closed line, whole turns: 1 where it is convex."""
    step = np.roll(line[:, :2], -1, axis=0) - line[:, :2]
    angle = np.arctan2(step[:, 1], step[:, 0])
    return float(
        np.abs((np.diff(np.append(angle, angle[0])) + np.pi) % (2 * np.pi) - np.pi).sum()
        / (2 * np.pi)
    )


@pytest.mark.parametrize("shape", ["disc", "turned square"])
def test_an_outline_is_not_ragged_and_keeps_its_area(shape: str) -> None:
    """A structure of 0.24 m on a mesh of 5 mm, as landmarks find it: its edge is known to some
    millimetres here and there, and its wall is steep.
    """
    rng = np.random.default_rng(3)
    mesh, _ = refine(Mesh(0.4 * FLOOR.vertices, FLOOR.faces), 0.007)
    x, y, _ = mesh.vertices.T - 0.2
    turned = np.abs(np.column_stack([x, y]) @ [[0.94, 0.34], [-0.34, 0.94]]).max(axis=1)
    within, area = (
        (0.12 - np.hypot(x, y), np.pi * 0.12**2) if shape == "disc" else (0.12 - turned, 0.24**2)
    )
    part = np.flatnonzero(within + rng.normal(0, 0.004, len(x)) > 0)
    wall = np.column_stack(
        [
            mesh.vertices[:, :2],
            0.1 * np.clip(0.5 + within / 0.01 + rng.normal(0, 0.2, len(x)), 0, 1),
        ]
    )
    line = outline(Mesh(wall, mesh.faces), part)
    # 1.0 and 2.1; every k-th point of the mesh's own line turns by 5 to 6
    assert _turning(line) < 2.5
    assert _area(line) == pytest.approx(area, rel=0.08)  # a face counts when all of it lies inside
    assert all((np.linalg.norm(wall - corner, axis=1) < 1e-12).any() for corner in line)
