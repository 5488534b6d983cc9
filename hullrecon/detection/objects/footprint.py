# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The footprint of an object: where it is open, how large it is, and its outline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.objects.regions import Region
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.neighbours import Around, nearest
from hullrecon.typing import Array, Ints

BAND_M = 0.018  # around a footprint: one and a half edges of the mesh at structures
# root mean square, over its range, of what lies anywhere between nothing and that
UNIFORM = 1 / np.sqrt(3)
# of an edge's place: heights are regressed from landmarks some centimetres around
EDGE_SIGMA_M = 0.016
# of the edge's sigma that is the same all around: heights are smoothed in the same way everywhere
SHARED_EDGE = 0.6
LEAST_SHARE = 0.02  # of the outlined area: what is larger is a shape, however small the part


@dataclass(frozen=True, kw_only=True)
class OpenEdge:
    """Where a footprint ends only because the survey does."""

    share: float  # of a narrow band around the footprint, what was not measured
    beyond: Ints  # unmeasured vertices onto which the structure may go on
    # m above the hull around, signed, how high it stands beside them; 0 without an open edge
    height: float


def find_open_edge(found: HullAsFound, region: Region, area: Array, around: Around) -> OpenEdge:
    """Find where a region's footprint borders on vertices that no landmark decides.

    As much of a structure may be hidden as is seen: it may go on as far as its footprint reaches
    from its middle. `area`: of the vertices of the base (n,) m2.
    """
    at, foot = found.base.vertices, region.foot
    reach = max(BAND_M, float(np.linalg.norm(at[foot] - at[foot].mean(axis=0), axis=1).max()))
    near = np.setdiff1d(around.ball(at[foot], reach), foot)
    unmeasured = ~found.measured[near]
    # unmeasured vertices in a band around the footprint
    band = nearest(at[foot], at[near], 1)[0][:, 0] <= BAND_M
    gap = near[band & unmeasured]
    if not len(gap):
        return OpenEdge(share=0.0, beyond=np.zeros(0, np.int64), height=0.0)
    # what lies behind the gap, and the height of the footprint next to it
    hidden = near[unmeasured]
    beside = np.isfinite(nearest(at[gap], at[foot], 1, BAND_M)[0][:, 0])
    return OpenEdge(
        share=float(area[gap].sum() / area[near[band]].sum()),
        beyond=hidden[np.isfinite(nearest(at[gap], at[hidden], 1, reach)[0][:, 0])],
        height=region.side * float(np.mean(region.rise(found, foot[beside]))),
    )


@dataclass(frozen=True, kw_only=True)
class ObjectSize:
    """How large an object is, with sigmas."""

    extent: list[float]  # (two) m along the hull and in girth
    extent_sigma: list[float]
    area: float  # m2
    area_sigma: float
    volume: float  # m3, negative for a recess
    volume_sigma: float


def measure_size(
    found: HullAsFound,
    region: Region,
    open_edge: OpenEdge,
    area: Array,
    height_sigma: float,
    normal: Array,
    chart: Chart,
) -> ObjectSize:
    """Measure a region's footprint.

    Its sigmas hold what may lie beyond the open edge. `area`: of the vertices (n,) m2.
    `height_sigma`: m, of the region's height.
    """
    foot, at = region.foot, found.base.vertices[region.foot]
    extent, size = _extent(at, at, normal, chart), float(area[foot].sum())
    longer, hidden = (
        hidden_extent(found, region, open_edge, normal, chart),
        UNIFORM * float(area[open_edge.beyond].sum()),
    )
    edge = float(np.sqrt(2) * EDGE_SIGMA_M)  # of two opposite edges, each on its own
    edge_area = SHARED_EDGE * 2 * float(np.sqrt(np.pi * size)) * EDGE_SIGMA_M
    volume = region.side * float((region.rise(found, foot) * area[foot]).sum())
    volume_sigma = np.linalg.norm(
        [size * height_sigma, 0.6 * region.height * edge_area, hidden * open_edge.height]
    )
    return ObjectSize(
        extent=[round(float(v), 5) for v in extent],
        extent_sigma=[round(float(v), 5) for v in np.hypot(edge, longer)],
        area=round(size, 6),
        area_sigma=round(float(np.hypot(edge_area, hidden)), 6),
        volume=round(volume, 7),
        volume_sigma=round(float(volume_sigma), 7),
    )


def hidden_extent(
    found: HullAsFound, region: Region, open_edge: OpenEdge, normal: Array, chart: Chart
) -> Array:
    """Estimate one sigma (2,) m of how much farther a region may reach, where its edge is open."""
    seen, at = (
        found.base.vertices[region.foot],
        found.base.vertices[np.append(region.foot, open_edge.beyond)],
    )
    return np.asarray(
        UNIFORM
        * np.maximum(0.0, _extent(at, seen, normal, chart) - _extent(seen, seen, normal, chart))
    )


def _extent(points: Array, middle_of: Array, normal: Array, chart: Chart) -> Array:
    """Measure how far points reach along the hull and in girth (2,), m.

    In the tangent plane at the middle of `middle_of`.
    """
    middle = middle_of.mean(axis=0)
    at = chart.to_chart(middle[None])[0, :2]
    ends, _ = chart.from_chart(at + np.array([[-0.05, 0], [0.05, 0]]))
    along = ends[1] - ends[0] if np.isfinite(ends).all() else np.array([1.0, 0, 0])
    along = along - normal * (along @ normal)
    along /= np.linalg.norm(along)
    flat = (points - middle) @ np.stack([along, np.cross(normal, along)], axis=1)
    return np.asarray(np.percentile(flat, 99, axis=0) - np.percentile(flat, 1, axis=0))


def outline(mesh: Mesh, part: Ints, most: int = 60) -> Array:
    """Trace the longest closed line (k, 3) around the faces of a part of the mesh.

    It runs counter-clockwise seen from outside, through vertices of the mesh, without teeth smaller
    than an edge is known, through at most `most` of them. It is empty when the part holds no face.
    """
    inside = np.zeros(len(mesh.vertices), bool)
    inside[part] = True
    faces = mesh.faces[inside[mesh.faces].all(axis=1)].astype(np.int64)
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    size = len(mesh.vertices)
    key = sides[:, 0] * size + sides[:, 1]
    rim = sides[~np.isin(key, sides[:, 1] * size + sides[:, 0])]
    loop = max(_loops(rim), key=lambda rows: _length(mesh.vertices[rows]), default=[])
    line = mesh.vertices[loop]
    return line[_without_teeth(_flatten(line), most)]


def _flatten(line: Array) -> Array:
    """Project a closed line (k, 3) onto the plane that it spans, (k, 2).

    An outline follows the wall of its structure up and down. That is no part of its shape from
    above.
    """
    centred = line - line.mean(axis=0) if len(line) else line
    area = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    normal = area / max(float(np.linalg.norm(area)), 1e-12)
    across = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    across /= max(float(np.linalg.norm(across)), 1e-12)
    return np.asarray(centred @ np.stack([across, np.cross(normal, across)], axis=1))


def _without_teeth(line: Array, most: int) -> list[int]:
    """Simplify a closed line (k, 2) and return the rows that are left.

    The point that spans the smallest triangle with its neighbours goes first
    [VisvalingamWhyatt1993], until none is smaller than the square of an edge's sigma and at most
    `most` are left.
    """
    tooth = min(
        EDGE_SIGMA_M**2, LEAST_SHARE * abs(_double_area(line, np.roll(line, -1, axis=0)).sum()) / 2
    )
    left = list(range(len(line)))
    while len(left) > 4:
        here = line[left]
        to_last, to_next = np.roll(here, 1, axis=0) - here, np.roll(here, -1, axis=0) - here
        area = 0.5 * np.abs(_double_area(to_last, to_next))
        least = int(np.argmin(area))
        if area[least] > tooth and len(left) <= most:
            break
        del left[least]
    return left


def _double_area(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _loops(rim: Ints) -> list[list[int]]:
    """Join directed edges (e, 2) to closed lines. Where two touch, the first begun goes on."""
    follow: dict[int, list[int]] = {}
    for a, b in rim.tolist():
        follow.setdefault(a, []).append(b)
    loops = []
    for start in sorted(follow):
        while follow[start]:
            loop, at = [start], follow[start].pop(0)
            while at != start and follow.get(at):
                loop.append(at)
                at = follow[at].pop(0)
            loops.append(loop)
    return loops


def _length(line: Array) -> float:
    return float(np.linalg.norm(line - np.roll(line, 1, axis=0), axis=1).sum())
