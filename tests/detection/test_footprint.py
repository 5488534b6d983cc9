# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A footprint that ends because the survey does is told from one that ends on bare hull."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.objects.footprint import (
    EDGE_SIGMA_M,
    ObjectSize,
    OpenEdge,
    find_open_edge,
    measure_size,
    outline,
)
from hullrecon.detection.objects.regions import find_regions
from hullrecon.detection.options import DetectOptions
from hullrecon.geometry.meshes.mesh import Mesh, vertex_areas
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.geometry.neighbours import Around

FLOOR = Mesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)


@pytest.fixture(scope="module")
def sizes(scenery, found) -> list[ObjectSize]:
    return _sizes(scenery, found)


def _sizes(scenery, found) -> list[ObjectSize]:
    area, around, up = vertex_areas(found.base), Around(found.base.vertices), np.array([0.0, 1, 0])
    regions = find_regions(found, DetectOptions())
    edges = [find_open_edge(found, region, area, around) for region in regions]
    return [
        measure_size(found, r, edge, area, 0.004, up, scenery.chart)
        for r, edge in zip(regions, edges, strict=True)
    ]


def test_the_truth_lies_within_two_sigmas_of_every_size(sizes: list[ObjectSize]) -> None:
    true = ((0.24, np.pi * 0.12**2, np.pi * 0.12**2 * 0.10), (0.2, 0.04, -0.04 * 0.05))
    for size, (extent, area, volume) in zip(sizes, true, strict=True):
        assert np.abs(np.array(size.extent) - extent).max() < 2 * size.extent_sigma[0]
        assert abs(size.area - area) < 2 * size.area_sigma
        assert abs(size.volume - volume) < 2 * size.volume_sigma


def test_sizes_are_as_uncertain_as_the_edge_and_the_height(sizes: list[ObjectSize]) -> None:
    disc = sizes[0]
    assert disc.extent_sigma[0] == pytest.approx(EDGE_SIGMA_M * 2**0.5, abs=1e-5)
    assert 0.1 < disc.area_sigma / disc.area < 0.3
    assert disc.volume_sigma > disc.area * 0.004


@pytest.mark.parametrize("beyond_m", [0.07, 0.03, 0.0, -0.03])
def test_true_size_lies_within_sigmas_at_survey_edge(scenery, found, beyond_m: float) -> None:
    unseen = found.base.vertices[:, 0] > 1.2 + beyond_m
    cut = replace(
        found, measured=found.measured & ~unseen, height=np.where(unseen, 0.0, found.height)
    )
    size, whole = _sizes(scenery, cut)[0], _sizes(scenery, found)[0]
    off = np.abs(np.array(size.extent) - 0.24) / size.extent_sigma
    assert off.max() < 3
    assert abs(size.area - np.pi * 0.12**2) < 2 * size.area_sigma
    assert abs(size.volume - np.pi * 0.12**2 * 0.10) < 2 * size.volume_sigma
    assert size.extent_sigma[0] > 2 * whole.extent_sigma[0]
    assert size.volume_sigma > 4 * whole.volume_sigma


Unseen = Callable[[np.ndarray, np.ndarray], np.ndarray]


def _edge_of_disc(found: HullAsFound, unseen: Unseen) -> tuple[OpenEdge, HullAsFound]:
    """The disc 0.10 m high and 0.24 m wide at (1.2, 1), where vertices (x, z) about its middle were
    not measured.
    """
    hidden = unseen(found.base.vertices[:, 0] - 1.2, found.base.vertices[:, 2] - 1.0)
    cut = replace(
        found, measured=found.measured & ~hidden, height=np.where(hidden, 0.0, found.height)
    )
    disc = next(region for region in find_regions(cut, DetectOptions()) if region.sign > 0)
    return find_open_edge(cut, disc, vertex_areas(cut.base), Around(cut.base.vertices)), cut


def test_a_structure_with_hull_all_around_has_no_open_edge(found: HullAsFound) -> None:
    edge, _ = _edge_of_disc(found, lambda x, z: np.hypot(x, z) > 0.25)
    assert (edge.share, len(edge.beyond), edge.height) == (0.0, 0, 0.0)


def test_a_structure_cut_in_half_is_open_along_the_cut(found: HullAsFound) -> None:
    edge, cut = _edge_of_disc(found, lambda x, z: x > 0)
    # the diameter's share of the outline of a half disc
    assert edge.share == pytest.approx(2 / (2 + np.pi), abs=0.07)
    assert edge.height == pytest.approx(0.10, abs=0.01)
    x, z = (cut.base.vertices[edge.beyond][:, [0, 2]] - (1.2, 1.0)).T
    assert not cut.measured[edge.beyond].any()
    assert x.max() == pytest.approx(0.14, abs=0.03)  # as far as half a disc reaches from its middle
    assert np.abs(z).max() < 0.12 + 0.16


def test_a_gap_behind_measured_hull_opens_nothing(found: HullAsFound) -> None:
    edge, _ = _edge_of_disc(found, lambda x, z: x > 0.18)
    assert edge.share == 0.0


def test_small_gap_at_structure_hides_only_itself(found: HullAsFound) -> None:
    edge, cut = _edge_of_disc(found, lambda x, z: np.hypot(x - 0.12, z) < 0.05)
    assert 0.05 < edge.share < 0.3
    assert np.hypot(*(cut.base.vertices[edge.beyond][:, [0, 2]] - (1.32, 1.0)).T).max() < 0.05


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
