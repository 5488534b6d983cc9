# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How large an object's footprint is: the part of it above a quarter of its height, with what its edge leaves open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.objects.regions import Region
from hullrecon.geometry.charts.chart import Chart
from hullrecon.typing import Array

EDGE_SIGMA_M = 0.016  # of an edge's place: heights are regressed from landmarks some centimetres around

SHARED_EDGE = 0.6  # of the edge's sigma that is the same all around: heights are smoothed in the same way everywhere


@dataclass(frozen=True, kw_only=True)
class ObjectSize:
    """extent (two) m along the hull and in girth, area m2, volume m3 (negative for a recess), each with its sigma."""

    extent: list[float]
    extent_sigma: list[float]
    area: float
    area_sigma: float
    volume: float
    volume_sigma: float


def measure_size(
    found: HullAsFound, region: Region, area: Array, height_sigma: float, normal: Array, chart: Chart
) -> ObjectSize:
    """Return the size of a region's footprint; area (n,) m2 of the vertices, height_sigma m of the region's height."""
    foot = region.foot
    extent, size = _extent(found.base.vertices[foot], normal, chart), float(area[foot].sum())
    edge = float(np.sqrt(2) * EDGE_SIGMA_M)  # of two opposite edges, each on its own
    area_sigma = SHARED_EDGE * 2 * float(np.sqrt(np.pi * size)) * EDGE_SIGMA_M
    volume = float(((found.height[foot] - region.level) * area[foot]).sum())
    volume_sigma = float(np.hypot(size * height_sigma, 0.6 * abs(region.height) * area_sigma))
    return ObjectSize(
        extent=[round(float(v), 5) for v in extent],
        extent_sigma=[round(edge, 5)] * 2,
        area=round(size, 6),
        area_sigma=round(area_sigma, 6),
        volume=round(volume, 7),
        volume_sigma=round(volume_sigma, 7),
    )


def _extent(points: Array, normal: Array, chart: Chart) -> Array:
    """Size (2,) along the hull and around the girth."""
    middle = points.mean(axis=0)
    at = chart.to_chart(middle[None])[0, :2]
    ends, _ = chart.from_chart(at + np.array([[-0.05, 0], [0.05, 0]]))
    along = ends[1] - ends[0] if np.isfinite(ends).all() else np.array([1.0, 0, 0])
    along = along - normal * (along @ normal)
    along /= np.linalg.norm(along)
    flat = (points - middle) @ np.stack([along, np.cross(normal, along)], axis=1)
    return np.asarray(np.percentile(flat, 99, axis=0) - np.percentile(flat, 1, axis=0))
