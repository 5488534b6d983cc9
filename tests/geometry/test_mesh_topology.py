# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from geometry.spheres import sphere
from hypothesis import given
from hypothesis import strategies as st

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.topology import find_edges, find_shared_edges, weld_vertices

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], np.int32)


def test_tetrahedron_has_six_edges_of_two_faces() -> None:
    edges = find_edges(TETRAHEDRON)
    assert edges.vertices.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
    assert edges.face_count.tolist() == [2] * 6
    shared = find_shared_edges(TETRAHEDRON)
    assert len(shared.first) == 6
    assert shared.same_winding.all()


def test_edges_of_a_face_are_named_in_the_order_of_its_corners() -> None:
    edges = find_edges(TETRAHEDRON)
    for face, of_face in zip(TETRAHEDRON, edges.of_face, strict=True):
        for k in range(3):
            assert set(edges.vertices[of_face[k]]) == {face[k], face[(k + 1) % 3]}


def test_a_turned_face_disagrees_with_all_its_neighbours() -> None:
    faces = TETRAHEDRON.copy()
    faces[2] = faces[2][::-1]
    shared = find_shared_edges(faces)
    touches = (shared.first == 2) | (shared.second == 2)
    assert not shared.same_winding[touches].any()
    assert shared.same_winding[~touches].all()


def test_an_edge_of_three_faces_is_shared_by_no_two() -> None:
    fin = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]], np.int32)
    assert len(find_shared_edges(fin).first) == 0
    assert find_edges(fin).face_count.max() == 3


def test_a_mesh_without_faces_has_no_edges() -> None:
    assert len(find_edges(np.zeros((0, 3), np.int32)).vertices) == 0
    assert len(find_shared_edges(np.zeros((0, 3), np.int32)).first) == 0


@given(st.integers(0, 10**6))
def test_shared_edges_are_those_that_a_plain_count_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    faces = np.array([rng.choice(7, 3, replace=False) for _ in range(9)], np.int32)
    owners: dict[tuple[int, int], list[int]] = {}
    for number, face in enumerate(faces):
        for k in range(3):
            a, b = sorted((int(face[k]), int(face[(k + 1) % 3])))
            owners.setdefault((a, b), []).append(number)
    expected = {(edge, *faces_of) for edge, faces_of in owners.items() if len(faces_of) == 2}
    shared = find_shared_edges(faces)
    found = {
        ((int(v[0]), int(v[1])), int(a), int(b))
        for v, a, b in zip(shared.vertices, shared.first, shared.second, strict=True)
    }
    assert found == expected


def test_welding_merges_corners_and_keeps_face_order() -> None:
    vertices = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 1e-9], [0, 1, 0], [1, 1, 0]], float
    )
    welded = weld_vertices(Mesh(vertices, np.array([[0, 1, 2], [3, 5, 4]], np.int32)))
    assert len(welded.vertices) == 4
    assert np.allclose(welded.vertices[welded.faces], vertices[[[0, 1, 2], [3, 5, 4]]], atol=1e-8)
    assert len(find_shared_edges(welded.faces).first) == 1


@pytest.mark.parametrize("rounds", [0, 1, 3])
def test_a_sphere_is_closed_and_has_eulers_number(rounds: int) -> None:
    ball = sphere(rounds)
    edges = find_edges(ball.faces)
    assert len(ball.vertices) - len(edges.vertices) + len(ball.faces) == 2
    assert (edges.face_count == 2).all()
    assert find_shared_edges(ball.faces).same_winding.all()


@given(st.integers(0, 10**6))
def test_edges_do_not_depend_on_the_order_of_the_faces(seed: int) -> None:
    rng = np.random.default_rng(seed)
    faces = np.array([rng.choice(9, 3, replace=False) for _ in range(7)], np.int32)
    order = rng.permutation(7)
    plain, mixed = find_edges(faces), find_edges(faces[order])
    np.testing.assert_array_equal(mixed.vertices, plain.vertices)
    np.testing.assert_array_equal(mixed.face_count, plain.face_count)
    np.testing.assert_array_equal(mixed.of_face, plain.of_face[order])
    np.testing.assert_array_equal(mixed.forward, plain.forward[order])
    np.testing.assert_array_equal(
        np.where(plain.forward, *plain.vertices[plain.of_face].transpose(2, 0, 1)), faces
    )


def test_welding_undoes_taking_a_mesh_apart() -> None:
    ball = sphere(2)
    apart = Mesh(
        ball.vertices[ball.faces].reshape(-1, 3),
        np.arange(3 * len(ball.faces), dtype=np.int32).reshape(-1, 3),
    )
    assert len(find_shared_edges(apart.faces).first) == 0
    welded = weld_vertices(apart)
    assert len(welded.vertices) == len(ball.vertices)
    np.testing.assert_array_equal(welded.vertices[welded.faces], ball.vertices[ball.faces])
    assert (find_edges(welded.faces).face_count == 2).all()


def test_a_wider_tolerance_welds_what_a_narrow_one_leaves_apart() -> None:
    near = Mesh(
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0.002]]),
        np.array([[0, 1, 2], [0, 3, 1]], np.int32),
    )
    assert len(weld_vertices(near).vertices) == 4
    assert len(weld_vertices(near, tolerance_m=0.01).vertices) == 3
