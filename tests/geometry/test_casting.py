# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
from geometry.spheres import sphere
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh, face_normals

QUICK = settings(max_examples=30, deadline=None, derandomize=True)

FLOOR = Mesh(
    np.array([[40.0, 0, 2], [41, 0, 2], [41, 1, 2], [40, 1, 2]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)


def test_the_distance_is_positive_on_the_side_of_the_normal() -> None:
    near = Scene(FLOOR).closest(np.array([[40.25, 0.5, 2.3], [40.25, 0.5, 1.9]]))
    assert np.allclose(near.distance, [0.3, -0.1], atol=1e-6)
    assert np.allclose(near.foot, [[40.25, 0.5, 2], [40.25, 0.5, 2]], atol=1e-6)
    assert np.allclose(near.normal, [[0, 0, 1], [0, 0, 1]])


def test_the_closest_point_beyond_the_rim_lies_on_the_rim() -> None:
    near = Scene(FLOOR).closest(np.array([[39.7, 0.5, 2.4]]))
    assert np.allclose(near.foot, [[40, 0.5, 2]], atol=1e-6)
    assert np.allclose(near.distance, 0.5, atol=1e-6)


def test_a_point_that_is_not_finite_has_no_distance() -> None:
    near = Scene(FLOOR).closest(np.array([[40.5, 0.5, 2.1], [np.nan, 0, 0]]))
    assert np.isfinite(near.distance).tolist() == [True, False]


def test_a_ray_that_misses_is_infinite() -> None:
    met = Scene(FLOOR).cast(
        np.array([40.5, 0.2, 3.0]), np.array([[0.0, 0, -1], [0, 0, 1], [0.6, 0, -0.8]])
    )
    assert np.isclose(met[0], 1.0, atol=1e-6)
    assert np.isinf(met[1:]).all()


def brute_ranges(mesh: Mesh, origin: np.ndarray, direction: np.ndarray) -> float:
    """Range of the first face met by one ray, by solving origin + t d = a + u (b - a) + v (c - a)
    for every face.
    """
    found = np.inf
    for a, b, c in mesh.vertices[mesh.faces]:
        system = np.stack([b - a, c - a, -direction], axis=1)
        if abs(np.linalg.det(system)) > 1e-12:
            u, v, t = np.linalg.solve(system, origin - a)
            if min(u, v, t) >= 0 and u + v <= 1:
                found = min(found, t)
    return found


def brute_distance(mesh: Mesh, point: np.ndarray) -> float:
    """Distance to the closest face: to its plane where the foot is inside, else to its nearest
    side.
    """
    found = np.inf
    for triangle in mesh.vertices[mesh.faces]:
        for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            share = np.clip((point - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            found = min(found, np.linalg.norm(a + share * (b - a) - point))
        a, b, c = triangle
        (u, v), *_ = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), point - a, rcond=None)
        if min(u, v) >= 0 and u + v <= 1:
            found = min(found, np.linalg.norm(a + u * (b - a) + v * (c - a) - point))
    return float(found)


def soup(seed: int) -> Mesh:
    rng = np.random.default_rng(seed)
    return Mesh(rng.normal(size=(36, 3)), np.arange(36, dtype=np.int32).reshape(-1, 3))


@QUICK
@given(st.integers(0, 10**6))
def test_rays_meet_what_every_face_tried_in_turn_says(seed: int) -> None:
    mesh, rng = soup(seed), np.random.default_rng(seed + 1)
    origins, directions = 2 * rng.normal(size=(12, 3)), rng.normal(size=(12, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    expected = [
        brute_ranges(mesh, origin, direction)
        for origin, direction in zip(origins, directions, strict=True)
    ]
    np.testing.assert_allclose(Scene(mesh).cast(origins, directions), expected, rtol=1e-9)


@QUICK
@given(st.integers(0, 10**6))
def test_the_closest_point_is_that_of_every_face_tried_in_turn(seed: int) -> None:
    mesh, points = soup(seed), 2 * np.random.default_rng(seed + 1).normal(size=(12, 3))
    near = Scene(mesh).closest(points)
    np.testing.assert_allclose(
        np.abs(near.distance),
        [brute_distance(mesh, point) for point in points],
        rtol=1e-9,
        atol=1e-9,
    )
    np.testing.assert_allclose(
        np.linalg.norm(points - near.foot, axis=1), np.abs(near.distance), rtol=1e-9, atol=1e-9
    )
    np.testing.assert_array_equal(near.normal, face_normals(mesh)[near.face])


@QUICK
@given(st.integers(0, 10**6))
def test_inside_a_sphere_is_negative_and_outside_positive(seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(30, 3))
    reach = np.linalg.norm(points, axis=1)
    near = Scene(sphere(3)).closest(points)
    np.testing.assert_allclose(near.distance, reach - 1, atol=0.02)
    assert (near.distance[reach > 1] > 0).all()
    assert (near.distance[reach < 0.97] < 0).all()


def test_one_origin_serves_many_rays_and_no_ray_meets_nothing() -> None:
    scene, directions = Scene(sphere(2)), np.vstack([np.eye(3), -np.eye(3)])
    np.testing.assert_allclose(scene.cast(np.zeros(3), directions), 1.0)
    np.testing.assert_array_equal(
        scene.cast(np.zeros(3), directions), scene.cast(np.zeros((6, 3)), directions)
    )
    assert scene.cast(np.zeros(3), np.zeros((0, 3))).shape == (0,)


def test_an_unknown_point_has_no_face_foot_nor_normal() -> None:
    near = Scene(FLOOR).closest(np.full((2, 3), np.inf))
    assert near.face.tolist() == [-1, -1]
    assert np.isnan(np.hstack([near.foot, near.normal])).all()


def test_beside_an_edge_the_distance_is_not_that_to_the_triangles_plane() -> None:
    """[Ozog2016 eq. 4.5] prints the distance to the plane of the closest triangle."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, -1], [0, 1, -1]])
    step = Mesh(corners, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]], np.int32))
    point = np.array([[-0.3, 0.5, 0.4]])
    near = Scene(step).closest(point)
    np.testing.assert_allclose(near.distance, 0.5)
    printed = (point - near.foot)[0] @ near.normal[0]
    assert abs(printed) < 0.41  # 0.4 m above the one, or 0.3 m beside the other
