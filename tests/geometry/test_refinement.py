# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections import Counter

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.refinement import refine

SQUARE = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def _lengths(mesh: Mesh) -> np.ndarray:
    corners = mesh.vertices[mesh.faces]
    return np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)


def _area(mesh: Mesh) -> np.ndarray:
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return 0.5 * np.cross(b - a, c - a)[:, 2]


def test_no_edge_stays_longer_than_wanted_and_the_area_is_kept() -> None:
    fine, _ = refine(SQUARE, 0.1)
    assert _lengths(fine).max() <= 0.1
    assert np.isclose(_area(fine).sum(), 1.0)


def test_every_new_face_keeps_its_orientation_and_no_triangle_degenerates() -> None:
    fine, _ = refine(SQUARE, lambda middle: np.where(middle[:, 0] < 0.2, 0.03, np.inf))
    assert (_area(fine) > 0).all()
    assert (_area(fine) / _lengths(fine).max(axis=1) ** 2).min() > 0.05


def test_a_partly_refined_mesh_has_no_cracks() -> None:
    fine, _ = refine(SQUARE, lambda middle: np.where(middle[:, 0] < 0.3, 0.05, np.inf))
    sides = Counter(tuple(sorted(pair)) for f in fine.faces.tolist() for pair in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0])))
    alone = np.array([pair for pair, n in sides.items() if n == 1])
    middle = fine.vertices[alone].mean(axis=1)
    on_rim = (np.abs(middle[:, :2] - 0.5).max(axis=1)) > 0.5 - 1e-12
    assert set(sides.values()) <= {1, 2}
    assert on_rim.all()


def test_a_face_far_from_where_it_matters_stays_as_it_was() -> None:
    away = SQUARE.vertices + np.array([10.0, 0.0, 0.0])
    far = Mesh(np.vstack([SQUARE.vertices, away]), np.vstack([SQUARE.faces, SQUARE.faces + 4]))
    fine, _ = refine(far, lambda middle: np.where(middle[:, 0] < 5, 0.2, np.inf))
    assert (fine.vertices[:, 0] > 5).sum() == 4


def test_attributes_are_averaged_at_the_midpoints() -> None:
    fine, values = refine(SQUARE, 0.3, SQUARE.vertices[:, :1] * 3 + 1)
    assert np.allclose(values[:, 0], fine.vertices[:, 0] * 3 + 1)


def test_one_long_edge_gives_two_faces_and_two_long_edges_three() -> None:
    thin = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 0.6, 0]]), np.array([[0, 1, 2]], np.int32))
    wide = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0.6, 0.75, 0]]), np.array([[0, 1, 2]], np.int32))
    assert len(refine(thin, 0.9)[0].faces) == 2
    assert len(refine(wide, 0.9)[0].faces) == 3
