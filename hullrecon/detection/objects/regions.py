# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Regions of the as-found mesh that stand off the hull, and the hull beneath each of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.as_found.shapes import dbscan
from hullrecon.detection.options import MIN_CLUSTER_POINTS, MIN_OFFSET_M, DetectOptions
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.geometry.neighbours import Around, nearest
from hullrecon.geometry.robust import NORMAL_MAD, robust_sigma, weighted_quantile
from hullrecon.typing import Array, Ints, Mask


def roughness(found: HullAsFound) -> float:
    """Estimate one robust sigma of the measured heights, m: hull and noise without structures."""
    height = found.height[found.measured]
    return robust_sigma(height) if len(height) else 0.0


def height_sigma(found: HullAsFound, region: Region) -> float:
    """Compute one sigma of a region's height, m: of its top and of the hull beneath it.

    Neighbouring vertices share landmarks, so the top counts as one vertex.
    """
    top = float(np.median(found.sigma[region.core]))
    hull = float(np.median(region.hull.sigma(found.base.vertices[region.core])))
    return float(np.hypot(top, hull))


def relief_left(over_m: Array, sigma_m: Array) -> float:
    """Estimate the relief that smoothing left out, m.

    It is the scatter of landmarks' heights (n,) over the surface beyond their own sigmas (n,).
    Where landmarks are too far apart for the relief, the surface passes between them. Zero without
    landmarks.
    """
    if not len(over_m):
        return 0.0
    return float(
        np.sqrt(max(0.0, robust_sigma(over_m, about=0.0) ** 2 - float(np.median(sigma_m)) ** 2))
    )


def p_value(height_m: float, sigma_m: float, roughness_m: float, places: float) -> float:
    """Compute the two-sided probability that bare hull reaches this height at any place.

    `places`: how many were looked at.
    """
    from scipy.special import ndtr  # not scipy.stats, which takes seconds to load

    score = abs(height_m) / max(np.hypot(sigma_m, roughness_m), 1e-6)
    return float(-np.expm1(max(1.0, places) * np.log1p(-min(2 * float(ndtr(-score)), 1 - 1e-16))))


SLOPE_SIGMA = 0.05  # prior of the slope of the hull's offset from the base, about zero
# 1/m, prior of its second-order terms, about zero: 10 mm of bulge between frames 0.7 m apart
BEND_SIGMA = 0.08
SIDES = 8  # the hull around counts as so many measurements at most: neighbours share landmarks
MIN_SCALE_M = 0.0005  # the scatter of the hull around is never taken for less
TUKEY = 4.0  # sigmas beyond which a vertex of the ring is no hull
ROUNDS = 4  # of weights by the last fit, and a fit by these weights
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
class HullAround:
    """A polynomial of second order of the hull's offset from the base, m."""

    middle: Array  # (3,) of the tangent plane
    axes: Array  # (2, 3) that span it
    coefficients: Array  # (6,)
    covariance: Array  # (6, 6) of the coefficients

    def offset(self, points: Array) -> Array:
        """Evaluate the hull's offset from the base (n,) m, outward positive, at (n, 3)."""
        return np.asarray(self._terms(points) @ self.coefficients)

    def sigma(self, points: Array) -> Array:
        """Return one sigma (n,) m of the offset at points (n, 3)."""
        terms = self._terms(points)
        return np.asarray(np.sqrt(np.einsum("ni,ij,nj->n", terms, self.covariance, terms)))

    def _terms(self, points: Array) -> Array:
        """Evaluate the (n, 6) terms of the polynomial at (n, 2) m: height, slopes, second order."""
        return _terms((points - self.middle) @ self.axes.T)


def fit_hull_around(ring: Array, offset: Array, weight: Array, normal: Array) -> HullAround:
    """Fit the hull through a ring of points (n, 3), robust to parts that are no hull.

    The deviation field is no measure of the hull there: the flanks of a structure that rises gently
    are landmarks on the hull to it, and draw it outward beneath the structure.

    Parameters
    ----------
    offset
        from the base (n,) m, outward positive.
    weight
        of each point relative to the others (n,).
    normal
        of the tangent plane (3,).
    """
    middle = np.average(ring, axis=0, weights=weight)
    axes = np.linalg.svd(normal[None])[2][1:]
    terms = _terms((ring - middle) @ axes.T)
    prior = np.diag([1e-6, *[SLOPE_SIGMA**-2] * 2, *[BEND_SIGMA**-2] * 3])
    fit = np.zeros(6)
    fit[0] = weighted_quantile(offset, weight, 0.5)
    share = weight * min(SIDES, len(ring)) / weight.sum()
    for _ in range(ROUNDS):
        off = offset - terms @ fit
        scale = max(MIN_SCALE_M, NORMAL_MAD * weighted_quantile(np.abs(off), weight, 0.5))
        counts = share * np.maximum(0.0, 1 - (off / (TUKEY * scale)) ** 2) ** 2 / scale**2
        information = terms.T @ (counts[:, None] * terms) + prior
        fit = np.linalg.solve(information, terms.T @ (counts * offset))
    return HullAround(
        middle=middle, axes=axes, coefficients=fit, covariance=np.linalg.inv(information)
    )


def _terms(at: Array) -> Array:
    """Return the (n, 6) terms of the polynomial at (n, 2) m: height, slopes, second order."""
    a, b = at.T
    return np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1)


@dataclass(frozen=True, kw_only=True)
class Region:
    """One structure."""

    side: float  # +1 raised, -1 sunken
    foot: Ints  # vertices of the footprint
    core: Ints  # vertices of its part above half height
    ring: Ints  # vertices of the hull around it
    hull: HullAround  # the hull beneath it
    height: float  # m above that hull, signed
    bluntness: float  # m, how much lower it is where three times as much of the footprint reaches

    def rise(self, found: HullAsFound, vertices: Ints) -> Array:
        """Measure vertices (n,) above the hull around, m, positive on the region's side."""
        return self.rise_of(found.base.vertices[vertices], found.deviation_at(vertices))

    def rise_of(self, feet: Array, offset: Array) -> Array:
        """Measure points above the hull around, m, positive on the region's side.

        `feet`: of the points on the base (n, 3). `offset`: from the base (n,) m.
        """
        return self.side * (offset - self.hull.offset(feet))


@dataclass(frozen=True, kw_only=True)
class _Relief:
    """The hull as found with what is asked of it again and again."""

    found: HullAsFound
    area: Array  # (n,) m2 of its vertices
    off: Mask  # (n,) whether they stand off the hull by the threshold
    around: Around  # index of its vertices
    options: DetectOptions

    def clusters(self, rows: Ints) -> list[Ints]:
        """Cluster vertices closer than `cluster_reach_m`."""
        label = dbscan(
            self.found.base.vertices[rows],
            self.options.cluster_reach_m,
            MIN_CLUSTER_POINTS,
        )
        return [rows[label == k] for k in range(int(label.max(initial=-1)) + 1)]


def find_regions(found: HullAsFound, options: DetectOptions) -> list[Region]:
    """Find raised and sunken regions of measured vertices, the highest first.

    Parts nearer than `cluster_reach_m` are one.
    """
    off = found.measured & (np.abs(found.height) >= MIN_OFFSET_M)
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
    """Yield the vertices of each region on that side, and those of neighbours split from it."""
    for cluster in relief.clusters(np.flatnonzero(relief.off & (side * relief.found.height > 0))):
        parts = _split_at_saddles(relief, cluster, side)
        for k, seed in enumerate(parts):
            if relief.area[seed].sum() >= SPECK * relief.options.min_area_m2:
                yield seed, np.concatenate([np.zeros(0, np.int64), *parts[:k], *parts[k + 1 :]])


def _split_at_saddles(relief: _Relief, rows: Ints, side: float) -> list[Ints]:
    """Split a cluster whose peaks are parted by a saddle below half of either.

    Smoothing bridges the hull between neighbours, so that clusters at the threshold may hold both.
    """
    # Raise the level until the cluster falls apart. Each part then takes the vertices nearest it.
    height, vertices = side * relief.found.height[rows], relief.found.base.vertices
    level = SADDLE_STEP * MIN_OFFSET_M
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
    """Check that a part is wide enough and twice as high as the level that cuts it off."""
    area = relief.area[rows]
    wide = area.sum() >= SPECK * relief.options.min_area_m2
    return bool(
        wide and _height_of_top(side * relief.found.height[rows], area, TOP_M2) >= 2 * level
    )


def _region(relief: _Relief, seed: Ints, foreign: Ints, side: float) -> Region | None:
    """Grow a seed to a region. None if no hull was measured around it to count from.

    `foreign`: vertices of its neighbours.
    """
    # A ring of bare hull around the seed.
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
    """Find the height above which `top_m2` of the area lies, or half of it if that is less."""
    return weighted_quantile(height, area, 1 - min(0.5, top_m2 / area.sum()))
