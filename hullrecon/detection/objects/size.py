# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How large an object's footprint is: the part of it above a quarter of its height, with what its
edge and that of the survey leave open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.objects.open_edge import UNIFORM, OpenEdge
from hullrecon.detection.objects.regions import Region
from hullrecon.geometry.charts.chart import Chart
from hullrecon.typing import Array

# of an edge's place: heights are regressed from landmarks some centimetres around
EDGE_SIGMA_M = 0.016

# of the edge's sigma that is the same all around: heights are smoothed in the same way everywhere
SHARED_EDGE = 0.6


@dataclass(frozen=True, kw_only=True)
class ObjectSize:
    """extent (two) m along the hull and in girth, area m2, volume m3 (negative for a recess), each
    with its sigma.
    """

    extent: list[float]
    extent_sigma: list[float]
    area: float
    area_sigma: float
    volume: float
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
    """Return the size of a region's footprint, as far as it was measured; area (n,) m2 of the
    vertices, height_sigma m of the region's height. The sigmas hold what may lie beyond its open
    edge.
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
    """Return one sigma (2,) m of how much farther a region may reach, along the hull and in girth,
    than was measured.
    """
    seen, at = (
        found.base.vertices[region.foot],
        found.base.vertices[np.append(region.foot, open_edge.beyond)],
    )
    return np.asarray(
        UNIFORM
        * np.maximum(0.0, _extent(at, seen, normal, chart) - _extent(seen, seen, normal, chart))
    )


def _extent(points: Array, middle_of: Array, normal: Array, chart: Chart) -> Array:
    """Return the size (2,) along the hull and around the girth, in the tangent plane at the middle
    of those points.
    """
    middle = middle_of.mean(axis=0)
    at = chart.to_chart(middle[None])[0, :2]
    ends, _ = chart.from_chart(at + np.array([[-0.05, 0], [0.05, 0]]))
    along = ends[1] - ends[0] if np.isfinite(ends).all() else np.array([1.0, 0, 0])
    along = along - normal * (along @ normal)
    along /= np.linalg.norm(along)
    flat = (points - middle) @ np.stack([along, np.cross(normal, along)], axis=1)
    return np.asarray(np.percentile(flat, 99, axis=0) - np.percentile(flat, 1, axis=0))
