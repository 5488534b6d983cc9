# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from geometry.spheres import sphere
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh, face_areas
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.geometry.meshes.topology import find_edges, find_shared_edges

QUICK = settings(max_examples=30, deadline=None, derandomize=True)

SQUARE = Mesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)


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


def test_new_faces_keep_orientation() -> None:
    fine, _ = refine(SQUARE, lambda middle: np.where(middle[:, 0] < 0.2, 0.03, np.inf))
    assert (_area(fine) > 0).all()
    assert (_area(fine) / _lengths(fine).max(axis=1) ** 2).min() > 0.05


def test_a_partly_refined_mesh_has_no_cracks() -> None:
    fine, _ = refine(SQUARE, lambda middle: np.where(middle[:, 0] < 0.3, 0.05, np.inf))
    sides = Counter(
        tuple(sorted(pair))
        for f in fine.faces.tolist()
        for pair in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))
    )
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


@QUICK
@given(longest=st.floats(0.15, 1.5), seed=st.integers(0, 10**6))
def test_a_closed_mesh_stays_closed_wherever_it_is_refined(longest: float, seed: int) -> None:
    ball, center = sphere(1), np.random.default_rng(seed).normal(size=3)
    center /= np.linalg.norm(center)
    fine, values = refine(
        ball,
        lambda at: np.where(np.linalg.norm(at - center, axis=1) < 0.6, longest, np.inf),
        ball.vertices @ np.eye(3)[:, :2],
    )
    edges = find_edges(fine.faces)
    assert (edges.face_count == 2).all()
    assert find_shared_edges(fine.faces).same_winding.all()
    assert len(fine.vertices) - len(edges.vertices) + len(fine.faces) == 2
    np.testing.assert_array_equal(fine.vertices[: len(ball.vertices)], ball.vertices)
    np.testing.assert_allclose(values, fine.vertices[:, :2], atol=1e-12)
    ends = fine.vertices[edges.vertices]
    near = np.linalg.norm(ends.mean(axis=1) - center, axis=1) < 0.6
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)[near].max(initial=0.0) <= longest


@QUICK
@given(longest=st.floats(0.1, 1.5))
def test_new_vertices_lie_on_the_old_faces_and_the_area_stays(longest: float) -> None:
    ball = sphere(1)
    fine, _ = refine(ball, longest)
    assert face_areas(fine).sum() == pytest.approx(face_areas(ball).sum(), rel=1e-12)
    assert np.abs(Scene(ball).closest(fine.vertices).distance).max() < 1e-12
    assert _lengths(fine).max() <= longest


@QUICK
@given(spared=st.floats(0.05, 0.99))
def test_edges_that_are_short_already_are_not_asked_about(spared: float) -> None:
    asked: list[np.ndarray] = []

    def everywhere(middle: np.ndarray) -> np.ndarray:
        asked.append(middle)
        return np.full(len(middle), 0.0)

    fine, _ = refine(SQUARE, everywhere, spared_m=spared)
    assert _lengths(fine).max() <= spared
    assert len(asked[0]) == 5
    assert len(asked[-1]) == 0


def test_a_mesh_that_is_fine_enough_comes_back_as_it_is() -> None:
    same, values = refine(SQUARE, 2.0)
    np.testing.assert_array_equal(same.vertices, SQUARE.vertices)
    np.testing.assert_array_equal(same.faces, SQUARE.faces)
    assert values.shape == (4, 0)
    assert same.vertices is not SQUARE.vertices


def test_narrow_face_is_cut_across() -> None:
    needle = Mesh(
        np.array([[0.0, 0, 0], [10, 0, 0], [10, 0.1, 0]]), np.array([[0, 1, 2]], np.int32)
    )
    fine, _ = refine(needle, 0.1)
    assert _lengths(fine).max() <= 0.1
    assert (_area(fine) > 0).all()
    assert _area(fine).sum() == pytest.approx(0.5, rel=1e-12)
    assert len(fine.faces) < 4 * 10 / 0.1
    wide = fine.vertices[fine.faces].mean(axis=1)[:, 0] > 5
    assert np.median((_area(fine) / _lengths(fine).max(axis=1) ** 2)[wide]) > 0.2


@QUICK
@given(seed=st.integers(0, 10**6), longest=st.floats(0.05, 0.5))
def test_the_parts_of_an_old_face_are_delaunay(seed: int, longest: float) -> None:
    corners = np.random.default_rng(seed).normal(size=(3, 2))
    if np.linalg.det(corners[1:] - corners[0]) < 0:
        corners = corners[::-1]
    fine, _ = refine(
        Mesh(np.hstack([corners, np.zeros((3, 1))]), np.array([[0, 1, 2]], np.int32)), longest
    )
    at = fine.vertices[:, :2]
    for a, b, c in fine.faces:
        (ux, uy), (vx, vy) = at[b] - at[a], at[c] - at[a]
        middle = np.linalg.solve(
            [[ux, uy], [vx, vy]], 0.5 * np.array([ux**2 + uy**2, vx**2 + vy**2])
        )
        radius = np.linalg.norm(middle)
        assert (np.linalg.norm(at - at[a] - middle, axis=1) >= radius * (1 - 1e-6)).all()
