# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The footprint of an object on the hull: its open edge, its size and its outline.

An edge is open where the survey ends there, so that the object may go on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.objects.regions import Region
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.neighbours import Around, is_near, nearest
from hullrecon.typing import Array, Ints

BAND_M = 0.018  # width of a band around a footprint: one and a half edges of the mesh there
# Root mean square of a quantity that is uniform between zero and one
UNIFORM = 1 / np.sqrt(3)
# Sigma of an edge's position: heights are regressed from landmarks some centimetres around
EDGE_SIGMA_M = 0.016
# Part of that sigma that is common all around, as heights are smoothed in the same way everywhere
SHARED_EDGE = 0.6
LEAST_SHARE = 0.02  # of the outlined area: a triangle of a larger share is never a tooth


@dataclass(frozen=True, kw_only=True)
class OpenEdge:
    """The part of a footprint's edge beyond which the hull was not measured."""

    share: float  # unmeasured share of a narrow band around the footprint
    beyond: Ints  # unmeasured vertices onto which the structure may go on
    # m, signed: height of the structure above the hull beside the open edge; 0 without one
    height: float


def find_open_edge(found: HullAsFound, region: Region, area: Array, around: Around) -> OpenEdge:
    """Find where a region's footprint borders on vertices that no landmark measured.

    A structure may go on there as far as its footprint reaches from its middle, which adds to the
    sigmas of its size. The share is 0 where all of the band around the footprint was measured.

    Parameters
    ----------
    found, region
        The hull as found, which says what was measured, and the region.
    area
        (n,) m2 of the vertices of the base.
    around
        Search tree of these vertices.
    """
    at, footprint = found.base.vertices, region.footprint
    reach = max(
        BAND_M, float(np.linalg.norm(at[footprint] - at[footprint].mean(axis=0), axis=1).max())
    )
    near = np.setdiff1d(around.ball(at[footprint], reach), footprint)
    unmeasured = ~found.measured[near]
    # Unmeasured vertices in a band around the footprint
    band = nearest(at[footprint], at[near], 1)[0][:, 0] <= BAND_M
    gap = near[band & unmeasured]
    if not len(gap):
        return OpenEdge(share=0.0, beyond=np.zeros(0, np.int64), height=0.0)
    # Unmeasured vertices within reach of the gap, and the height of the footprint next to it
    hidden = near[unmeasured]
    beside = is_near(at[gap], at[footprint], BAND_M)
    return OpenEdge(
        share=float(area[gap].sum() / area[near[band]].sum()),
        beyond=hidden[is_near(at[gap], at[hidden], reach)],
        # the rise is positive away from the hull around, the height outward
        height=region.sign * float(np.mean(region.rise(found, footprint[beside]))),
    )


@dataclass(frozen=True, kw_only=True)
class ObjectSize:
    """The size of an object, with sigmas."""

    extent: list[float]  # (2,) m along the hull and in girth
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
    """Measure the extent, area and volume of a region.

    Their sigmas contain the part that may lie beyond an open edge.

    Parameters
    ----------
    found, region
        The hull as found, and the region.
    open_edge
        Where its footprint ends with the survey.
    area
        (n,) m2 of the vertices of the base.
    height_sigma
        Sigma of the region's height, m, for that of the volume.
    normal
        Outward normal (3,) at the region: the extent is measured across it.
    chart
        Gives the direction along the hull.
    """
    footprint, at = region.footprint, found.base.vertices[region.footprint]
    extent, size = _extent(at, at, normal, chart), float(area[footprint].sum())
    longer, hidden = (
        hidden_extent(found, region, open_edge, normal, chart),
        UNIFORM * float(area[open_edge.beyond].sum()),
    )
    edge = float(np.sqrt(2) * EDGE_SIGMA_M)  # of two opposite edges, each on its own
    # Sigma of the area: that of the edge's position times the circumference of a disc of this area
    edge_area = SHARED_EDGE * 2 * float(np.sqrt(np.pi * size)) * EDGE_SIGMA_M
    volume = region.sign * float((region.rise(found, footprint) * area[footprint]).sum())
    # By the height, by the edge (where the structure has about 0.6 of its height), and by what is
    # hidden
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
    """Compute the sigma (2,) m of a region's extent due to the part beyond its open edge.

    What is added to the extent is taken as uniform between nothing and all of that part. normal,
    chart: as for `measure_size`.
    """
    vertices, footprint = found.base.vertices, region.footprint
    seen, all_of_it = vertices[footprint], vertices[np.append(footprint, open_edge.beyond)]
    more = _extent(all_of_it, seen, normal, chart) - _extent(seen, seen, normal, chart)
    return np.asarray(UNIFORM * np.maximum(0.0, more))


def _extent(points: Array, middle_of: Array, normal: Array, chart: Chart) -> Array:
    """Measure the extent (2,) m of points along the hull and in girth.

    It is measured in the tangent plane with `normal` at the mean of the points `middle_of`, between
    the percentiles 1 and 99. Beyond the chart, x stands in for along.
    """
    middle = middle_of.mean(axis=0)
    at = chart.to_chart(middle[None])[0, :2]
    # the direction along the hull, from 5 cm behind the middle to 5 cm ahead
    ends, _ = chart.from_chart(at + np.array([[-0.05, 0], [0.05, 0]]))
    along = ends[1] - ends[0] if np.isfinite(ends).all() else np.array([1.0, 0, 0])
    along = along - normal * (along @ normal)
    along /= np.linalg.norm(along)
    flat = (points - middle) @ np.stack([along, np.cross(normal, along)], axis=1)
    return np.asarray(np.percentile(flat, 99, axis=0) - np.percentile(flat, 1, axis=0))


def outline(mesh: Mesh, part: Ints, most: int = 60) -> Array:
    """Trace the longest closed line (k, 3) around the faces of a part of the mesh.

    It runs counter-clockwise seen from outside, through at most `most` vertices of the mesh. Teeth
    smaller than the uncertainty of an edge are left out. It is empty when the part has no face.

    part: vertices. A face belongs to the part if its three vertices do.
    """
    inside = np.zeros(len(mesh.vertices), bool)
    inside[part] = True
    faces = mesh.faces[inside[mesh.faces].all(axis=1)].astype(np.int64)
    # Directed edges of the faces. One whose reverse is no edge of another face is of the rim.
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    size = len(mesh.vertices)
    key = sides[:, 0] * size + sides[:, 1]
    rim = sides[~np.isin(key, sides[:, 1] * size + sides[:, 0])]
    loop = max(_loops(rim), key=lambda rows: _length(mesh.vertices[rows]), default=[])
    line = mesh.vertices[loop]
    return line[_simplify_line(_flatten(line), most)]


def _flatten(line: Array) -> Array:
    """Project a closed line (k, 3) onto its mean plane, (k, 2).

    An outline goes up and down along the walls of its structure, which is no part of its shape seen
    from above.
    """
    centred = line - line.mean(axis=0) if len(line) else line
    # The vector area of a closed line points along the normal of its mean plane
    area = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    normal = area / max(float(np.linalg.norm(area)), 1e-12)
    across = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    across /= max(float(np.linalg.norm(across)), 1e-12)
    return np.asarray(centred @ np.stack([across, np.cross(normal, across)], axis=1))


def _simplify_line(line: Array, most: int) -> list[int]:
    """Simplify a closed line (k, 2) and return the rows that are kept [VisvalingamWhyatt1993].

    The point that spans the smallest triangle with its neighbours is removed first. A triangle
    smaller than the square of an edge's sigma, and than LEAST_SHARE of the outlined area, is a
    tooth. It ends when at most `most` points are left, none of them a tooth, or when four are left.
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
    """Chain the directed edges (e, 2) of a rim to closed lines of vertices, to trace an outline.

    At a vertex from which several edges start, they are taken in their order.
    """
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
