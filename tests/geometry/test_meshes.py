# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import pickle

import numpy as np
import pytest
from geometry.spheres import sphere
from hypothesis import given
from hypothesis import strategies as st

from hullrecon.geometry.meshes.mesh import (
    Mesh,
    face_areas,
    face_normals,
    vertex_areas,
    vertex_normals,
)
from hullrecon.geometry.meshes.units import METRES_PER_UNIT, UNIT_NAMES
from hullrecon.geometry.poses import exp

FLOOR = Mesh(
    np.array([[0.0, 0, 0], [8, 0, 0], [8, 8, 0], [0, 8, 0]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)
ROOF = Mesh(
    np.array([[0.0, 0, 0], [1, 0, 1], [2, 0, 0], [0, 1, 0], [1, 1, 1], [2, 1, 0]]),
    np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]], np.int32),
)


def test_areas_add_up() -> None:
    assert face_areas(FLOOR).tolist() == [32, 32]
    assert vertex_areas(FLOOR).sum() == pytest.approx(64)
    assert np.allclose(vertex_areas(FLOOR), [64 / 3, 32 / 3, 64 / 3, 32 / 3])


def test_a_vertex_inside_has_a_third_of_all_faces_around_it() -> None:
    tent = Mesh(
        np.vstack([FLOOR.vertices, [[4.0, 4, 0]]]),
        np.array([[k, (k + 1) % 4, 4] for k in range(4)], np.int32),
    )
    assert vertex_areas(tent)[4] == pytest.approx(64 / 3)


def test_a_vertex_of_no_face_has_no_area() -> None:
    more = Mesh(np.vstack([FLOOR.vertices, [[9.0, 9, 9]]]), FLOOR.faces)
    assert vertex_areas(more)[4] == 0.0


def test_normals_at_a_ridge_point_up_between_its_sides() -> None:
    normal = vertex_normals(ROOF)
    assert np.allclose(normal[4], [0, 0, 1], atol=0.2)
    assert np.allclose(normal[0], [-np.sqrt(0.5), 0, np.sqrt(0.5)])
    assert np.allclose(np.linalg.norm(normal, axis=1), 1)


@pytest.mark.parametrize("radius", [0.5, 3.0])
def test_mesh_of_sphere_has_its_area_and_normals(radius: float) -> None:
    ball = sphere(4, radius)
    # 2048 flat faces
    assert face_areas(ball).sum() == pytest.approx(4 * np.pi * radius**2, rel=4e-3)
    assert vertex_areas(ball).sum() == pytest.approx(face_areas(ball).sum())
    # a tenth of the turn from face to face
    np.testing.assert_allclose(vertex_normals(ball), ball.vertices / radius, atol=0.01)
    middle = ball.vertices[ball.faces].mean(axis=1)
    np.testing.assert_allclose(
        face_normals(ball), middle / np.linalg.norm(middle, axis=1, keepdims=True), atol=0.02
    )


@given(st.integers(0, 10**6))
def test_normals_turn_with_the_mesh_and_areas_stay(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plain = Mesh(
        rng.normal(size=(8, 3)),
        np.array([rng.choice(8, 3, replace=False) for _ in range(6)], np.int32),
    )
    motion = exp(rng.normal(size=(1, 6)))
    moved = Mesh(motion.apply(plain.vertices), plain.faces)
    np.testing.assert_allclose(face_areas(moved), face_areas(plain), atol=1e-9)
    np.testing.assert_allclose(
        face_normals(moved), motion.rotation.apply(face_normals(plain)), atol=1e-9
    )
    np.testing.assert_allclose(vertex_areas(moved), vertex_areas(plain), atol=1e-9)


@given(st.integers(0, 10**6))
def test_turned_faces_have_the_opposite_normals(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plain = Mesh(rng.normal(size=(5, 3)), np.array([[0, 1, 2], [2, 3, 4], [4, 1, 0]], np.int32))
    turned = Mesh(plain.vertices, np.ascontiguousarray(plain.faces[:, ::-1]))
    np.testing.assert_allclose(face_normals(turned), -face_normals(plain), atol=1e-12)
    np.testing.assert_allclose(vertex_normals(turned), -vertex_normals(plain), atol=1e-9)


def test_vertex_normal_ignores_finer_cut_side() -> None:
    cube = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.3, 0.7, 0], [0.9, 0.1, 0]])
    whole = Mesh(cube, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2]], np.int32))
    finer = Mesh(cube, np.array([[0, 2, 4], [0, 4, 5], [0, 5, 1], [0, 1, 3], [0, 3, 2]], np.int32))
    np.testing.assert_allclose(vertex_normals(whole)[0], -np.ones(3) / np.sqrt(3))
    np.testing.assert_allclose(vertex_normals(finer)[0], vertex_normals(whole)[0], atol=1e-12)


def test_a_degenerate_face_has_no_normal_and_no_area() -> None:
    line = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]], np.int32))
    assert face_areas(line).tolist() == [0.0]
    assert face_normals(line).tolist() == [[0.0, 0.0, 0.0]]
    assert vertex_normals(line).tolist() == [[0.0] * 3] * 3


def test_units_of_a_mesh_are_named_and_of_the_right_length() -> None:
    assert METRES_PER_UNIT.keys() == UNIT_NAMES.keys()
    assert METRES_PER_UNIT["ft"] == pytest.approx(12 * METRES_PER_UNIT["in"])
    assert METRES_PER_UNIT["m"] == 100 * METRES_PER_UNIT["cm"] == 1000 * METRES_PER_UNIT["mm"]


def test_a_mesh_is_pickled_without_its_index() -> None:
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
    before = mesh.index.closest(np.zeros((1, 3))).distance
    again = pickle.loads(pickle.dumps(mesh))
    np.testing.assert_array_equal(again.index.closest(np.zeros((1, 3))).distance, before)
