# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.errors import StageError
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.neighbours import nearest
from hullrecon.surface.build import SurfacePoints, build_surface, supported_lattice
from hullrecon.surface.options import SurfaceOptions


def _bump(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    return 0.03 * np.sin(x / 1.5) + 0.02 * np.cos(z)


def _cloud(rng: np.random.Generator, n: int = 900, noise: float = 0.008) -> SurfacePoints:
    x, z = rng.uniform(0, 5, n), rng.uniform(0, 3, n)
    points = np.stack([x, 2 + _bump(x, z) + rng.normal(0, noise, n), z], axis=1)
    return SurfacePoints(
        point=points,
        noise=np.full(n, noise),
        pose_sigma=np.full(n, 0.004),
        gives_support=np.ones(n, bool),
    )


def test_the_surface_follows_the_returns(wall: PlaneChart, rng: np.random.Generator) -> None:
    surface, facts = build_surface(_cloud(rng), wall, SurfaceOptions())
    x, y, z = surface.vertices.T
    inside = (x > 0) & (x < 5) & (z > 0) & (z < 3)
    error = y - 2 - _bump(x, z)
    # measured over seeds: 2.0 to 2.6 mm
    assert np.sqrt(np.mean(error[inside] ** 2)) < 0.004
    assert facts["vertices"] == len(surface.vertices)


def test_sigma_covers_the_error_and_holds_the_shared_part(
    wall: PlaneChart, rng: np.random.Generator
) -> None:
    surface, _ = build_surface(_cloud(rng), wall, SurfaceOptions())
    x, y, z = surface.vertices.T
    inside = (x > 0) & (x < 5) & (z > 0) & (z < 3)
    assert (surface.sigma >= 0.004).all()
    assert np.mean(np.abs(y - 2 - _bump(x, z))[inside] < 1.96 * surface.sigma[inside]) > 0.9


def test_what_stands_off_the_hull_does_not_flatten_it(
    wall: PlaneChart, rng: np.random.Generator
) -> None:
    """Two structures of 12 cm, as of a survey by landmarks, for the likelihood is that of noise
    without outliers.
    """
    cloud = _cloud(rng)
    points = cloud.point.copy()
    on = np.min(
        [np.hypot(points[:, 0] - x, points[:, 2] - z) for x, z in ((1.2, 1), (3.5, 1.8))], axis=0
    )
    points[on < 0.25, 1] += 0.12
    surface, facts = build_surface(replace(cloud, point=points), wall, SurfaceOptions())
    assert 0.5 < facts["noise_scale"] < 1.5
    x, y, z = surface.vertices.T
    away = np.min([np.hypot(x - a, z - b) for a, b in ((1.2, 1), (3.5, 1.8))], axis=0) > 0.6
    inside = (x > 0) & (x < 5) & (z > 0) & (z < 3) & away
    assert np.sqrt(np.mean((y - 2 - _bump(x, z))[inside] ** 2)) < 0.004


def test_no_edge_is_long_and_faces_look_outward(wall: PlaneChart, rng: np.random.Generator) -> None:
    surface, _ = build_surface(_cloud(rng), wall, SurfaceOptions(max_edge_m=0.1))
    corner = surface.vertices[surface.faces]
    assert np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max() < 0.105
    assert (np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 1] > 0).all()


def test_only_what_returns_support_is_covered(wall: PlaneChart, rng: np.random.Generator) -> None:
    cloud = _cloud(rng)
    gap = (cloud.point[:, 0] > 2) & (cloud.point[:, 0] < 4)
    open_ = SurfacePoints(
        point=cloud.point[~gap],
        noise=cloud.noise[~gap],
        pose_sigma=cloud.pose_sigma[~gap],
        gives_support=cloud.gives_support[~gap],
    )
    surface, _ = build_surface(open_, wall, SurfaceOptions(reach_m=0.3))
    assert not ((surface.vertices[:, 0] > 2.31) & (surface.vertices[:, 0] < 3.69)).any()
    assert (surface.support >= 1).all()


def test_landmarks_inform_but_do_not_extend_the_surface(
    wall: PlaneChart, rng: np.random.Generator
) -> None:
    cloud = _cloud(rng)
    mixed = replace(cloud, gives_support=cloud.point[:, 0] < 2)
    surface, facts = build_surface(mixed, wall, SurfaceOptions(reach_m=0.3))
    assert surface.vertices[:, 0].max() < 2.31
    assert int(str(facts["observations"])) > 200


def test_given_lengths_are_kept(wall: PlaneChart, rng: np.random.Generator) -> None:
    options = SurfaceOptions(fit=False, length_along_m=6.0, length_girth_m=2.0, offset_sigma_m=0.05)
    _, facts = build_surface(_cloud(rng), wall, options)
    assert facts["lengths_m"] == [6.0, 2.0]
    assert facts["sigma_m"] == 0.05


def test_returns_off_the_chart_are_refused(wall: PlaneChart) -> None:
    lost = SurfacePoints(
        point=np.full((5, 3), np.nan),
        noise=np.ones(5),
        pose_sigma=np.ones(5),
        gives_support=np.ones(5, bool),
    )
    with pytest.raises(StageError, match="no return lies on the chart"):
        build_surface(lost, wall, SurfaceOptions())


def test_returns_too_sparse_are_refused_and_the_remedy_heals(wall: PlaneChart) -> None:
    place = np.arange(0.1, 3.0, 0.9)
    along, deep = (axis.ravel() for axis in np.meshgrid(place, place))
    sparse = SurfacePoints(
        point=np.column_stack([along, np.full(len(along), 2.0), deep]),
        noise=np.full(len(along), 0.01),
        pose_sigma=np.full(len(along), 0.01),
        gives_support=np.ones(len(along), bool),
    )
    with pytest.raises(StageError, match=r"raise surface\.reach_m"):
        build_surface(sparse, wall, SurfaceOptions(reach_m=0.05))
    assert len(build_surface(sparse, wall, SurfaceOptions(reach_m=1.0))[0].vertices)


def test_heights_over_a_plane_equal_offsets_from_it(
    wall: PlaneChart, rng: np.random.Generator
) -> None:
    cloud = _cloud(rng)
    by_offset, _ = build_surface(cloud, wall, SurfaceOptions())
    by_height, _ = build_surface(cloud, wall, SurfaceOptions(), datum=wall)
    np.testing.assert_allclose(by_height.vertices, by_offset.vertices, atol=1e-9)
    np.testing.assert_allclose(by_height.sigma, by_offset.sigma, atol=1e-9)


def test_chart_on_edge_over_the_datum_gives_no_surface(
    wall: PlaneChart, rng: np.random.Generator
) -> None:
    floor = PlaneChart(np.zeros(3), np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]]))
    surface, _ = build_surface(_cloud(rng), wall, SurfaceOptions(fit=False), datum=floor)
    assert len(surface.faces) == 0


def test_every_vertex_is_near_a_return() -> None:
    at = np.array([[0.0, 0.0], [3.0, 1.0]])
    mesh = supported_lattice(at, 0.1, 0.5)
    assert nearest(at, mesh.vertices[:, :2], 1)[0].max() <= 0.5
    area = len(mesh.faces) * 0.005
    assert 0.6 * 2 * np.pi * 0.25 < area < 2 * np.pi * 0.25


def test_every_vertex_belongs_to_a_face_and_faces_look_one_way() -> None:
    mesh = supported_lattice(np.array([[0.03, -0.02]]), 0.1, 0.4)
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    assert np.array_equal(np.unique(mesh.faces), np.arange(len(mesh.vertices)))


def test_a_reach_below_the_spacing_gives_no_surface() -> None:
    assert len(supported_lattice(np.array([[0.05, 0.05]]), 0.1, 0.02).faces) == 0
