# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.errors import InputError
from hullrecon.native import MeshIndex

CUBE_VERTICES = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
CUBE_FACES = np.array(
    [
        0,
        1,
        3,
        0,
        3,
        2,
        4,
        6,
        7,
        4,
        7,
        5,
        0,
        4,
        5,
        0,
        5,
        1,
        2,
        3,
        7,
        2,
        7,
        6,
        0,
        2,
        6,
        0,
        6,
        4,
        1,
        5,
        7,
        1,
        7,
        3,
    ],
    np.int32,
).reshape(-1, 3)


def bumpy_hull(n: int = 24, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """A closed ellipsoid with noise along its radius, outward faces."""
    rng = np.random.default_rng(seed)
    theta, phi = np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, 2 * n, endpoint=False)
    t, p = np.meshgrid(theta[1:-1], phi, indexing="ij")
    ring = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(
        -1, 3
    )
    ring *= 1 + 0.05 * rng.normal(size=(len(ring), 1))
    vertices = np.vstack([ring, [[0, 0, 1], [0, 0, -1]]]) * [5, 2, 1]
    wide, faces = 2 * n, []
    for i in range(n - 3):
        for j in range(wide):
            a, b = i * wide + j, i * wide + (j + 1) % wide
            faces += [[a, a + wide, b], [b, a + wide, b + wide]]
    top, bottom, last = len(ring), len(ring) + 1, (n - 3) * wide
    faces += [[top, j, (j + 1) % wide] for j in range(wide)]
    faces += [[bottom, last + (j + 1) % wide, last + j] for j in range(wide)]
    return vertices, np.array(faces, np.int32)


def twin_distance(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Unsigned distance by brute force: the plane's foot where it lies inside, else the nearest of
    the three edges.
    """
    a, b, c = (vertices[faces[:, k]][None] for k in range(3))
    p = points[:, None]
    normal = np.cross(b - a, c - a)
    foot = (
        p - ((p - a) * normal).sum(-1, keepdims=True) / (normal**2).sum(-1, keepdims=True) * normal
    )
    inside = np.ones(foot.shape[:2], bool)
    best = np.full(foot.shape[:2], np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(v - u, foot - u) * normal).sum(-1) >= 0
        share = np.clip(((p - u) * (v - u)).sum(-1) / ((v - u) ** 2).sum(-1), 0, 1)
        best = np.minimum(best, np.linalg.norm(p - u - share[..., None] * (v - u), axis=-1))
    return np.where(inside, np.linalg.norm(p - foot, axis=-1), best).min(axis=1)


def twin_cast(
    vertices: np.ndarray, faces: np.ndarray, origins: np.ndarray, directions: np.ndarray
) -> np.ndarray:
    """Range by brute force: each ray in each face's barycentric coordinates by a 3 x 3 solve."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    out = np.full(len(origins), np.inf)
    for i, (o, d) in enumerate(zip(origins, directions, strict=True)):
        system = np.stack([np.broadcast_to(-d, a.shape), b - a, c - a], axis=-1)
        t, u, v = np.linalg.solve(system, (o - a)[..., None])[..., 0].T
        hit = (t > 0) & (u >= 0) & (v >= 0) & (u + v <= 1)
        out[i] = t[hit].min(initial=np.inf)
    return out


def test_distances_equal_those_of_the_brute_force_twin() -> None:
    vertices, faces = bumpy_hull()
    points = np.random.default_rng(0).uniform(-6, 6, (300, 3))
    got = MeshIndex(vertices, faces).closest(points)
    np.testing.assert_allclose(
        np.abs(got.distance), twin_distance(vertices, faces, points), rtol=1e-12, atol=1e-12
    )
    np.testing.assert_allclose(
        np.linalg.norm(points - got.point, axis=1), np.abs(got.distance), rtol=1e-12, atol=1e-12
    )


def test_ranges_and_misses_equal_the_brute_force_twin() -> None:
    vertices, faces = bumpy_hull()
    rng = np.random.default_rng(1)
    origins, directions = rng.uniform(-6, 6, (300, 3)), rng.normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    got, expected = (
        MeshIndex(vertices, faces).cast(origins, directions),
        twin_cast(vertices, faces, origins, directions),
    )
    assert 20 < np.isinf(expected).sum() < 280
    np.testing.assert_allclose(got.range, expected, rtol=1e-10)
    assert ((got.face == -1) == np.isinf(expected)).all()


def test_sign_of_distance_is_right_around_a_bumpy_hull() -> None:
    vertices, faces = bumpy_hull()
    points = np.random.default_rng(2).uniform(-5, 5, (2000, 3)) * [1, 0.4, 0.2]
    index = MeshIndex(vertices, faces)
    apart = np.linalg.solve(np.diag([5.0, 2, 1]), points.T).T
    radius = np.linalg.norm(apart, axis=1)
    distance = index.closest(points).distance
    assert (distance[radius < 0.75] < 0).all()
    assert (distance[radius > 1.25] > 0).all()


@pytest.mark.parametrize(
    ("point", "distance", "gradient", "on"),
    [
        ([0.3, 0.4, 1.5], 0.5, [0, 0, 1], [0.3, 0.4, 1]),
        ([0.5, 0.4, 0.9], -0.1, [0, 0, 1], [0.5, 0.4, 1]),
        ([0.5, 1.3, 1.4], 0.5, [0, 0.6, 0.8], [0.5, 1, 1]),
        ([2, 2, 2], np.sqrt(3), np.ones(3) / np.sqrt(3), [1, 1, 1]),
    ],
    ids=["above a face", "under a face", "off an edge", "off a corner"],
)
def test_distance_and_gradient_about_a_cube_match_hand_values(
    point: list[float], distance: float, gradient: list[float], on: list[float]
) -> None:
    got = MeshIndex(CUBE_VERTICES, CUBE_FACES).closest([point])
    np.testing.assert_allclose(got.distance, [distance], rtol=1e-14)
    np.testing.assert_allclose(got.gradient, [gradient], atol=1e-14)
    np.testing.assert_allclose(got.point, [on], atol=1e-14)


@pytest.mark.parametrize(
    ("point", "gradient"),
    [
        ([0.3, 0.2, 1.0], [0, 0, 1]),
        ([0.5, 1, 1], [0, np.sqrt(0.5), np.sqrt(0.5)]),
        ([1, 1, 1], np.ones(3) / np.sqrt(3)),
    ],
    ids=["on a face", "on an edge", "on a corner"],
)
def test_on_the_surface_the_gradient_is_the_pseudonormal(
    point: list[float], gradient: list[float]
) -> None:
    got = MeshIndex(CUBE_VERTICES, CUBE_FACES).closest([point])
    assert abs(got.distance[0]) < 1e-15
    np.testing.assert_allclose(got.gradient, [gradient], atol=1e-12)


def test_point_beside_a_sharp_corner_is_outside() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.2, -0.2, 1.0], [0.0, 0, -1]])
    faces = np.array([[3, 0, 1], [3, 1, 2], [3, 2, 0], [4, 1, 0], [4, 2, 1], [4, 0, 2]], np.int32)
    point = np.array([-0.35, -0.35, 1.02])
    got = MeshIndex(vertices, faces).closest([point])
    np.testing.assert_allclose(got.point, [[-0.2, -0.2, 1.0]])
    normals = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    sides = ((point - vertices[faces[:3, 0]]) * normals[:3]).sum(axis=1)
    assert (sides < 0).any()
    assert (sides > 0).any()
    assert got.distance[0] > 0


def test_the_gradient_is_the_derivative_of_the_distance() -> None:
    vertices, faces = bumpy_hull()
    points = np.random.default_rng(4).uniform(-6, 6, (200, 3))
    index, step = MeshIndex(vertices, faces), 1e-6
    got = index.closest(points)
    for axis in np.eye(3):
        slope = (
            index.closest(points + step * axis).distance
            - index.closest(points - step * axis).distance
        ) / (2 * step)
        smooth = np.abs(slope - got.gradient @ axis) < 1e-5
        # the rest stands on the medial axis, where the distance has a crease
        assert smooth.mean() > 0.98


def test_triangle_soup_has_the_signs_of_the_welded_mesh() -> None:
    soup = CUBE_VERTICES[CUBE_FACES].reshape(-1, 3)
    points = np.random.default_rng(5).uniform(-0.5, 1.5, (500, 3))
    loose, welded = (
        MeshIndex(v, f).closest(points)
        for v, f in ((soup, np.arange(36).reshape(12, 3)), (CUBE_VERTICES, CUBE_FACES))
    )
    np.testing.assert_array_equal(loose.distance, welded.distance)
    np.testing.assert_array_equal(loose.gradient, welded.gradient)


def test_a_sliver_without_area_does_no_harm() -> None:
    faces = np.vstack([CUBE_FACES, [[0, 0, 7]], [[0, 1, 1]]])
    points = np.random.default_rng(6).uniform([-0.5, -0.5, 0.5], [1.5, 1.5, 2.5], (200, 3))
    with_sliver, plain = MeshIndex(CUBE_VERTICES, faces), MeshIndex(CUBE_VERTICES, CUBE_FACES)
    outside = plain.closest(points).distance > 0
    np.testing.assert_allclose(
        with_sliver.closest(points[outside]).distance, plain.closest(points[outside]).distance
    )
    np.testing.assert_array_equal(
        with_sliver.cast(points, -points).range, plain.cast(points, -points).range
    )


def test_bytes_do_not_depend_on_the_number_of_threads() -> None:
    vertices, faces = bumpy_hull()
    rng = np.random.default_rng(7)
    points, directions = rng.uniform(-6, 6, (3000, 3)), rng.normal(size=(3000, 3))
    one, two = MeshIndex(vertices, faces, threads=1), MeshIndex(vertices, faces, threads=2)
    for name in ("distance", "point", "gradient", "face"):
        assert (
            getattr(one.closest(points), name).tobytes()
            == getattr(two.closest(points), name).tobytes()
        )
    for name in ("range", "face", "normal"):
        assert (
            getattr(one.cast(points, directions), name).tobytes()
            == getattr(two.cast(points, directions), name).tobytes()
        )


def test_rays_through_shared_edges_and_corners_hit() -> None:
    origins = np.array([[0.5, 0.5, 3.0], [1.0, 1, 3], [0.25, 0.25, 3], [0, 0.5, 3]])
    got = MeshIndex(CUBE_VERTICES, CUBE_FACES).cast(origins, np.tile([0, 0, -2.0], (4, 1)))
    np.testing.assert_allclose(got.range, 2.0)
    np.testing.assert_allclose(got.normal[0], [0, 0, 1])


def test_a_ray_from_inside_hits_the_back_of_a_face() -> None:
    got = MeshIndex(CUBE_VERTICES, CUBE_FACES).cast([[0.5, 0.4, 0.5]], [[0, 0, 1]])
    np.testing.assert_allclose(got.range, [0.5])
    np.testing.assert_allclose(got.normal, [[0, 0, 1]])


def test_no_points_give_empty_answers() -> None:
    index = MeshIndex(CUBE_VERTICES, CUBE_FACES)
    assert index.closest(np.zeros((0, 3))).point.shape == (0, 3)
    assert index.cast(np.zeros((0, 3)), np.zeros((0, 3))).range.shape == (0,)


@pytest.mark.parametrize(
    ("vertices", "faces", "where"),
    [
        (CUBE_VERTICES, np.zeros((0, 3), int), "faces"),
        (CUBE_VERTICES, [[0, 1, 8]], "faces"),
        (CUBE_VERTICES, [[0, -1, 2]], "faces"),
        (CUBE_VERTICES, [[0.0, 1.0, 2.0]], "faces"),
        (CUBE_VERTICES[:, :2], CUBE_FACES, "vertices"),
        (CUBE_VERTICES * np.nan, CUBE_FACES, "vertices"),
    ],
)
def test_a_mesh_that_cannot_be_is_refused_by_name(
    vertices: np.ndarray, faces: np.ndarray, where: str
) -> None:
    with pytest.raises(InputError) as caught:
        MeshIndex(vertices, faces)
    assert caught.value.where == where


def test_a_query_that_cannot_be_is_refused_by_name() -> None:
    index = MeshIndex(CUBE_VERTICES, CUBE_FACES)
    with pytest.raises(InputError, match="points"):
        index.closest([[np.nan, 0, 0]])
    with pytest.raises(InputError, match="directions"):
        index.cast([[0, 0, 2.0]], [[0, 0, 0.0]])
    with pytest.raises(InputError, match="directions"):
        index.cast([[0, 0, 2.0]], np.ones((2, 3)))


def test_answers_move_with_the_mesh_and_the_points() -> None:
    vertices, faces = bumpy_hull()
    rng = np.random.default_rng(11)
    points, rays = 4 * rng.normal(size=(200, 3)), rng.normal(size=(200, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))  # a mirror would turn the faces inside out
    shift = np.array([3.0, -40.0, 7.0])
    here, there = MeshIndex(vertices, faces), MeshIndex(vertices @ turn.T + shift, faces)
    before, after = here.closest(points), there.closest(points @ turn.T + shift)
    np.testing.assert_allclose(after.distance, before.distance, atol=1e-11)
    np.testing.assert_allclose(after.point, before.point @ turn.T + shift, atol=1e-11)
    np.testing.assert_allclose(after.gradient, before.gradient @ turn.T, atol=1e-8)
    first, second = here.cast(points, rays), there.cast(points @ turn.T + shift, rays @ turn.T)
    assert np.array_equal(first.face < 0, second.face < 0)
    met = first.face >= 0
    assert met.any()
    np.testing.assert_allclose(second.range[met], first.range[met], rtol=1e-10)
    np.testing.assert_allclose(second.normal[met], first.normal[met] @ turn.T, atol=1e-12)


def test_lines_are_free_where_no_cast_meets_a_face_before_their_end() -> None:
    vertices, faces = bumpy_hull()
    index, random = MeshIndex(vertices, faces), np.random.default_rng(8)
    starts, ends = random.uniform(-1.5, 1.5, (2, 400, 3))
    line = ends - starts
    length = np.linalg.norm(line, axis=1)
    free = index.is_free(starts, ends)
    np.testing.assert_array_equal(free, index.cast(starts, line).range >= length)
    assert 50 < free.sum() < 350
    # a face at the end does not count, one just before it does
    over = np.array([[0.3, 0.4, 2.0]])
    np.testing.assert_array_equal(
        MeshIndex(CUBE_VERTICES, CUBE_FACES).is_free(
            np.repeat(over, 2, axis=0), [[0.3, 0.4, 1.0], [0.3, 0.4, 0.999]]
        ),
        [True, False],
    )
