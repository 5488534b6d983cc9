# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the hull as found stands off the hull: regions of the mesh, each evidence of one object."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.objects.hull_around import HullAround, fit_hull_around
from hullrecon.detection.objects.shapes import dbscan
from hullrecon.detection.options import DetectOptions
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.geometry.neighbours import Around, nearest
from hullrecon.geometry.robust import weighted_quantile
from hullrecon.typing import Array, Ints, Mask

# the top is what so much of the footprint reaches: a lump's peak is not averaged away, one vertex
# is no peak
TOP_M2 = 0.0008
SPECK = 0.3  # of the least area: smaller regions are noise, not candidates
FOOT_SHARE, CORE_SHARE = 0.25, 0.5  # of the height, where the footprint and its core end
SADDLE_STEP = 1.2  # from one level at which a saddle is looked for to the next
RING_GAP_M = 0.04  # the ring of hull begins so far from the footprint, beyond what edges blur
# of the root of the footprint's area, within these limits
RING_WIDTH, RING_WIDTHS_M = 0.75, (0.12, 0.35)
MIN_RING = 10  # vertices; fewer do not say where the hull around lies


@dataclass(frozen=True, kw_only=True)
class Region:
    """One structure. side +1 raised, -1 sunken; foot, core, ring: vertices of the footprint, of its
    part above half height, and of the hull around it; hull: that beneath it; height m above that,
    signed; bluntness m, how much lower it is where three times as much of the footprint reaches.
    """

    side: float
    foot: Ints
    core: Ints
    ring: Ints
    hull: HullAround
    height: float
    bluntness: float

    def rise(self, found: HullAsFound, vertices: Ints) -> Array:
        """Return how far vertices (n,) of the hull as found stand off the hull around the
        structure, m, its side positive.
        """
        return self.rise_of(found.base.vertices[vertices], found.deviation_at(vertices))

    def rise_of(self, feet: Array, offset: Array) -> Array:
        """Return the same of points, by their feet (n, 3) on the base and their offsets (n,) m from
        it.
        """
        return self.side * (offset - self.hull.offset(feet))


@dataclass(frozen=True, kw_only=True)
class _Relief:
    """The hull as found, and what is asked of it again and again: area (n,) m2 of its vertices, off
    (n,) whether they stand off the hull by the threshold, around: where its vertices lie.
    """

    found: HullAsFound
    area: Array
    off: Mask
    around: Around
    options: DetectOptions

    def clusters(self, rows: Ints) -> list[Ints]:
        """Return those vertices in clusters; what is nearer than `cluster_reach` is one."""
        label = dbscan(
            self.found.base.vertices[rows],
            self.options.cluster_reach_m,
            self.options.min_cluster_points,
        )
        return [rows[label == k] for k in range(int(label.max(initial=-1)) + 1)]


def find_regions(found: HullAsFound, options: DetectOptions) -> list[Region]:
    """Return raised and sunken regions of measured vertices, the highest first; parts nearer than
    `cluster_reach` are one.
    """
    off = found.measured & (np.abs(found.height) >= options.min_offset_m)
    relief = _Relief(
        found=found,
        area=vertex_areas(found.base),
        off=off,
        around=Around(found.base.vertices),
        options=options,
    )
    regions = [
        _region(relief, seed, foreign, side)
        for side in (1.0, -1.0)
        for seed, foreign in _seeds(relief, side)
    ]
    return sorted(
        (r for r in regions if r is not None), key=lambda r: (-abs(r.height), int(r.foot[0]))
    )


def _seeds(relief: _Relief, side: float) -> Iterator[tuple[Ints, Ints]]:
    """Return the vertices of each evidence on that side, and those of its neighbours that were
    parted from it.
    """
    for cluster in relief.clusters(np.flatnonzero(relief.off & (side * relief.found.height > 0))):
        parts = _split_at_saddles(relief, cluster, side)
        for k, seed in enumerate(parts):
            if relief.area[seed].sum() >= SPECK * relief.options.min_area_m2:
                yield seed, np.concatenate([np.zeros(0, np.int64), *parts[:k], *parts[k + 1 :]])


def _split_at_saddles(relief: _Relief, rows: Ints, side: float) -> list[Ints]:
    """Return a cluster, or its parts: two peaks are two structures when the saddle between them is
    lower than half of either. Smoothing bridges the hull between neighbours, so that clusters at
    the threshold may hold both.
    """
    height, vertices = side * relief.found.height[rows], relief.found.base.vertices
    level = SADDLE_STEP * relief.options.min_offset_m
    while level < 0.5 * height.max():
        peaks = [
            p for p in relief.clusters(rows[height > level]) if _is_peak(relief, p, side, level)
        ]
        if len(peaks) > 1:
            gap = np.stack([nearest(vertices[p], vertices[rows], 1)[0][:, 0] for p in peaks])
            owner = gap.argmin(axis=0)
            return [
                part
                for k in range(len(peaks))
                for part in _split_at_saddles(relief, rows[owner == k], side)
            ]
        level *= SADDLE_STEP
    return [rows]


def _is_peak(relief: _Relief, rows: Ints, side: float, level: float) -> bool:
    """Tell whether it is wide enough to be told from noise, and twice as high as the level that
    cuts it off.
    """
    area = relief.area[rows]
    wide = area.sum() >= SPECK * relief.options.min_area_m2
    return bool(
        wide and _height_of_top(side * relief.found.height[rows], area, TOP_M2) >= 2 * level
    )


def _region(relief: _Relief, seed: Ints, foreign: Ints, side: float) -> Region | None:
    """Return the region, None where no hull was measured around it to count from. foreign: its
    neighbours' vertices.
    """
    found, area, base = relief.found, relief.area, relief.found.base.vertices
    width = float(np.clip(RING_WIDTH * np.sqrt(area[seed].sum()), *RING_WIDTHS_M))
    near = relief.around.ball(base[seed], RING_GAP_M + width)
    distance = nearest(base[seed], base[near], 1)[0][:, 0]
    bare = (
        (distance > RING_GAP_M)
        & (distance < RING_GAP_M + width)
        & found.measured[near]
        & ~relief.off[near]
    )
    ring = near[bare]
    if len(ring) < MIN_RING:
        return None
    normal = np.average(found.normal[seed], axis=0, weights=np.maximum(area[seed], 1e-12))
    # Structures may rise gently: the farther from where it stands off, the more a vertex is hull
    clear = (distance[bare] - RING_GAP_M) / width
    hull = fit_hull_around(base[ring], found.deviation_at(ring), area[ring] * clear**2, normal)
    above = side * (found.deviation_at(near) - hull.offset(base[near]))
    within = np.isin(near, seed)
    height, shoulder = (
        _height_of_top(above[within], area[near[within]], top) for top in (TOP_M2, 3 * TOP_M2)
    )
    own = (
        (distance <= relief.options.cluster_reach_m)
        & found.measured[near]
        & ~np.isin(near, foreign)
    )
    foot, core = (near[own & (above >= share * height)] for share in (FOOT_SHARE, CORE_SHARE))
    if not len(core):
        return None
    return Region(
        side=side,
        foot=foot,
        core=core,
        ring=ring,
        hull=hull,
        height=side * height,
        bluntness=height - shoulder,
    )


def _height_of_top(height: Array, area: Array, top_m2: float) -> float:
    """Return the height that so much of the area reaches, half of it at most."""
    return weighted_quantile(height, area, 1 - min(0.5, top_m2 / area.sum()))
