# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the hull as found stands off the hull: regions of the mesh, each a candidate for one object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.detection.found import Found
from hullrecon.detection.mesh import vertex_areas
from hullrecon.detection.options import DetectOptions
from hullrecon.detection.shapes import dbscan
from hullrecon.geometry.neighbours import Around, nearest

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
TOP_M2 = 0.0008  # the top is what so much of the footprint reaches: a lump's peak is not averaged away, one vertex is no peak
SPECK = 0.3  # of the least area: smaller regions are noise, not candidates
FOOT_SHARE = 0.25  # of the height, where the footprint ends
SADDLE_STEP = 1.2  # from one level at which a saddle is looked for to the next
RING_GAP_M = 0.04  # the ring of hull begins so far from the footprint, beyond what edges blur


@dataclass(frozen=True)
class Region:
    """One structure. side +1 raised, -1 sunken; foot, core, ring: vertices of the footprint, of its part above half height, and
    of the hull around it; level m, the hull around it; height m above that, signed; bluntness m, how much lower it is where
    three times as much of the footprint reaches."""

    side: float
    foot: Ints
    core: Ints
    ring: Ints
    level: float
    height: float
    bluntness: float


def find_regions(found: Found, options: DetectOptions) -> list[Region]:
    """Raised and sunken regions of measured vertices, the highest first; parts nearer than `cluster_reach` are one."""
    area = vertex_areas(found.base)
    off = found.measured & (np.abs(found.height) >= options.threshold)
    regions = []
    around = Around(found.base.vertices)
    for side in (1.0, -1.0):
        rows = np.flatnonzero(off & (side * found.height > 0))
        label = dbscan(found.base.vertices[rows], options.cluster_reach, options.cluster_points)
        for cluster in range(int(label.max(initial=-1)) + 1):
            parts = _parted(found, area, rows[label == cluster], side, options)
            for k, seed in enumerate(parts):
                if area[seed].sum() < SPECK * options.least_area:
                    continue
                foreign = np.concatenate([np.zeros(0, np.int64), *parts[:k], *parts[k + 1 :]])
                region = _region(found, area, off, around, seed, foreign, side, options)
                if region is not None:
                    regions.append(region)
    return sorted(regions, key=lambda r: (-abs(r.height), int(r.foot[0])))


def _parted(found: Found, area: Array, rows: Ints, side: float, options: DetectOptions) -> list[Ints]:
    """A cluster, or its parts: two peaks are two structures when the saddle between them is lower than half of either.
    Smoothing bridges the hull between neighbours, so that clusters at the threshold may hold both."""
    height = side * found.height[rows]
    level = SADDLE_STEP * options.threshold
    while level < 0.5 * height.max():
        high = rows[height > level]
        label = dbscan(found.base.vertices[high], options.cluster_reach, options.cluster_points)
        peaks = [high[label == k] for k in range(int(label.max(initial=-1)) + 1)]
        peaks = [p for p in peaks if _is_peak(side * found.height[p], area[p], level, options)]
        if len(peaks) > 1:
            gap = np.stack([nearest(found.base.vertices[p], found.base.vertices[rows], 1)[0][:, 0] for p in peaks])
            owner = gap.argmin(axis=0)
            return [part for k in range(len(peaks)) for part in _parted(found, area, rows[owner == k], side, options)]
        level *= SADDLE_STEP
    return [rows]


def _is_peak(height: Array, area: Array, level: float, options: DetectOptions) -> bool:
    """Wide enough to be told from noise, and twice as high as the level that cuts it off."""
    wide = area.sum() >= SPECK * options.least_area
    return bool(wide and weighted_quantile(height, area, 1 - min(0.5, TOP_M2 / area.sum())) >= 2 * level)


def _region(
    found: Found,
    area: Array,
    off: NDArray[np.bool_],
    around: Around,
    seed: Ints,
    foreign: Ints,
    side: float,
    options: DetectOptions,
) -> Region | None:
    """None when no hull was measured around it to count the height from. foreign: vertices of its neighbours."""
    base = found.base.vertices
    width = float(np.clip(0.5 * np.sqrt(area[seed].sum()), 0.08, 0.25))
    near = around.ball(base[seed], RING_GAP_M + width)
    distance = nearest(base[seed], base[near], 1)[0][:, 0]
    ring = near[(distance > RING_GAP_M) & (distance < RING_GAP_M + width) & found.measured[near] & ~off[near]]
    if len(ring) < 10:
        return None
    level = weighted_quantile(found.height[ring], area[ring], 0.5)
    above = side * (found.height - level)
    height, shoulder = (
        weighted_quantile(above[seed], area[seed], 1 - min(0.5, share * TOP_M2 / area[seed].sum())) for share in (1, 3)
    )
    own = (distance <= options.cluster_reach) & found.measured[near] & ~np.isin(near, foreign)
    foot = near[own & (above[near] >= FOOT_SHARE * height)]
    core = foot[above[foot] >= 0.5 * height]
    return Region(side, foot, core, ring, level, side * height, height - shoulder) if len(core) else None


def weighted_quantile(values: Array, weight: Array, share: float) -> float:
    """The value below which that share of the weight lies."""
    order = np.argsort(values, kind="stable")
    total = np.cumsum(weight[order])
    at = np.searchsorted(total, share * total[-1])
    return float(values[order][min(int(at), len(values) - 1)])
