# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find regions of the as-found mesh that stand off the hull, and the hull beneath each of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.as_found.shapes import dbscan
from hullrecon.detection.objects.heights import quadratic_terms
from hullrecon.detection.options import MIN_CLUSTER_POINTS, MIN_OFFSET_M, DetectOptions
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.geometry.neighbours import Around, nearest
from hullrecon.geometry.robust import NORMAL_MAD, robust_sigma, weighted_quantile
from hullrecon.typing import Array, Ints, Mask


def roughness(found: HullAsFound) -> float:
    """Estimate the robust sigma of all measured heights, m: roughness of the hull, and noise."""
    height = found.height[found.measured]
    return robust_sigma(height) if len(height) else 0.0


def height_sigma(found: HullAsFound, region: Region) -> float:
    """Compute the sigma of a region's height, m, from those of its top and of the hull beneath it.

    Neighbouring vertices share landmarks, so the sigma of the top is that of a single vertex.
    """
    top = float(np.median(found.sigma[region.core]))
    hull = float(np.median(region.hull.sigma(found.base.vertices[region.core])))
    return float(np.hypot(top, hull))


def unresolved_relief(over_m: Array, sigma_m: Array) -> float:
    """Estimate the relief between landmarks that the as-found surface does not show, m.

    Where landmarks are too far apart to resolve the relief, the surface passes between the high and
    the low ones. The relief is what their scatter about the surface has beyond their own sigmas. It
    is a part of the sigma of an object's height. Zero without landmarks.

    Parameters
    ----------
    over_m
        Heights of landmarks (n,) above the as-found surface.
    sigma_m
        Their own sigmas (n,).
    """
    if not len(over_m):
        return 0.0
    return float(
        np.sqrt(max(0.0, robust_sigma(over_m, about=0.0) ** 2 - float(np.median(sigma_m)) ** 2))
    )


def p_value(height_m: float, sigma_m: float, roughness_m: float, places: float) -> float:
    """Compute the two-sided probability that bare hull reaches a height somewhere by chance.

    Heights of bare hull are taken as normal, and as independent between the places.

    Parameters
    ----------
    height_m, sigma_m
        Height and its sigma.
    roughness_m
        Sigma of the heights of bare hull (`roughness`).
    places
        Number of independent positions on the hull at which it might.
    """
    from scipy.special import ndtr  # not scipy.stats, which takes seconds to load

    # 1 - (1 - p)^places, with p the probability at one place, without loss of digits
    score = abs(height_m) / max(np.hypot(sigma_m, roughness_m), 1e-6)
    return float(-np.expm1(max(1.0, places) * np.log1p(-min(2 * float(ndtr(-score)), 1 - 1e-16))))


SLOPE_SIGMA = 0.05  # prior sigma of the slope of the hull's offset from the base, about zero
# Prior sigma of its second-order terms, 1/m, about zero: 10 mm of bulge between frames 0.7 m apart
BEND_SIGMA = 0.08
SIDES = 8  # largest number of independent measurements in the ring, as neighbours share landmarks
MIN_SCALE_M = 0.0005  # lower limit of the robust scale of the ring's vertices
TUKEY = 4.0  # sigmas beyond which a vertex of the ring is an outlier
ROUNDS = 4  # rounds of reweighting and fitting
# A region's height is that which this area of it reaches: small enough not to average a peak away,
# and larger than a single vertex
TOP_M2 = 0.0008
SPECK = 0.3  # share of the least area of an object, below which a region is noise
FOOTPRINT_SHARE, CORE_SHARE = 0.25, 0.5  # shares of the height, at which footprint and core end
SADDLE_STEP = 1.2  # factor between the levels at which saddles are looked for
RING_GAP_M = 0.04  # distance of the ring of bare hull from a region, whose edge smoothing blurs
# Width of the ring, as a share of the root of the region's area, and its limits
RING_WIDTH, RING_WIDTHS_M = 0.75, (0.12, 0.35)
MIN_RING = 10  # vertices of a ring; fewer do not determine the hull around


@dataclass(frozen=True, kw_only=True)
class HullAround:
    """The hull around and beneath a region, as a polynomial of its offset from the base, m."""

    middle: Array  # (3,) m, origin of the tangent plane
    axes: Array  # (2, 3) unit vectors that span the tangent plane
    coefficients: Array  # (6,) of the terms 1, a, b, a^2, a b, b^2, with a, b m along the axes
    covariance: Array  # (6, 6) of the coefficients

    def offset(self, points: Array) -> Array:
        """Compute the hull's offset from the base (n,) m, outward positive, at points (n, 3)."""
        return np.asarray(self._terms(points) @ self.coefficients)

    def sigma(self, points: Array) -> Array:
        """Compute the sigma (n,) m of the offset at points (n, 3)."""
        terms = self._terms(points)
        return np.asarray(np.sqrt(np.einsum("ni,ij,nj->n", terms, self.covariance, terms)))

    def _terms(self, points: Array) -> Array:
        """Evaluate the terms (n, 6) of the polynomial at points (n, 3)."""
        return quadratic_terms(*((points - self.middle) @ self.axes.T).T)


def fit_hull_around(ring: Array, offset: Array, weight: Array, normal: Array) -> HullAround:
    """Fit a second-order polynomial to a ring of vertices around a region, robustly.

    It gives the hull beneath the region, above which its height is counted. The deviation field
    does not serve for that: landmarks on the flanks of a structure that rises gently were labelled
    as hull, and draw the field outward beneath the structure. Outliers (TUKEY) get no weight, and
    priors hold slope and second-order terms near zero.

    Parameters
    ----------
    ring
        Points of the ring on the base (n, 3) m.
    offset
        Their offsets from the base (n,) m, outward positive.
    weight
        How much each point counts relative to the others (n,).
    normal
        Normal (3,) of the tangent plane over which the polynomial is fitted.
    """
    middle = np.average(ring, axis=0, weights=weight)
    axes = np.linalg.svd(normal[None])[2][1:]
    terms = quadratic_terms(*((ring - middle) @ axes.T).T)
    prior = np.diag([1e-6, *[SLOPE_SIGMA**-2] * 2, *[BEND_SIGMA**-2] * 3])
    fit = np.zeros(6)
    fit[0] = weighted_quantile(offset, weight, 0.5)
    share = weight * min(SIDES, len(ring)) / weight.sum()
    # Each round weighs the ring's points by their residuals of the round before (Tukey)
    for _ in range(ROUNDS):
        off = offset - terms @ fit
        scale = max(MIN_SCALE_M, NORMAL_MAD * weighted_quantile(np.abs(off), weight, 0.5))
        counts = share * np.maximum(0.0, 1 - (off / (TUKEY * scale)) ** 2) ** 2 / scale**2
        information = terms.T @ (counts[:, None] * terms) + prior
        fit = np.linalg.solve(information, terms.T @ (counts * offset))
    return HullAround(
        middle=middle, axes=axes, coefficients=fit, covariance=np.linalg.inv(information)
    )


@dataclass(frozen=True, kw_only=True)
class Region:
    """A part of the surface that stands off the hull around it."""

    sign: float  # +1 raised, -1 sunken
    footprint: Ints  # its vertices
    core: Ints  # vertices of its part above half height
    ring: Ints  # vertices of the hull around it
    hull: HullAround  # the hull beneath it
    height: float  # m above that hull, signed
    bluntness: float  # m, by how much lower the height is that three times TOP_M2 reaches

    def rise(self, found: HullAsFound, vertices: Ints) -> Array:
        """Compute the heights (k,) m of vertices (k,) above the hull around.

        Positive away from it: outward if the region is raised, inward if it is a recess.
        """
        return self.rise_of(found.base.vertices[vertices], found.deviation_at(vertices))

    def rise_of(self, feet: Array, offset: Array) -> Array:
        """Compute heights (n,) m of points above the hull around, with the sign of `rise`.

        `feet`: of the points on the base (n, 3). `offset`: of the points from the base (n,) m.
        """
        return self.sign * (offset - self.hull.offset(feet))


@dataclass(frozen=True, kw_only=True)
class _Relief:
    """The hull as found, with derived quantities that are used many times."""

    found: HullAsFound
    area: Array  # (n,) m2 of its vertices
    off: Mask  # (n,) whether they were measured and stand off the hull by MIN_OFFSET_M
    around: Around  # index of its vertices
    options: DetectOptions

    def clusters(self, rows: Ints) -> list[Ints]:
        """Cluster vertices, rows (k,) of the base, by DBSCAN with the radius `cluster_reach_m`.

        Vertices with too few others around are noise, and in no cluster.
        """
        label = dbscan(
            self.found.base.vertices[rows],
            self.options.cluster_reach_m,
            MIN_CLUSTER_POINTS,
        )
        return [rows[label == k] for k in range(int(label.max(initial=-1)) + 1)]


def find_regions(found: HullAsFound, options: DetectOptions) -> list[Region]:
    """Find raised and sunken regions of measured vertices, the highest first.

    Parts of one region are at most `cluster_reach_m` apart. Specks are left out, and regions around
    which too little bare hull was measured, as their height is unknown.
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
        _measure_region(relief, seed, foreign, sign)
        for sign in (1.0, -1.0)
        for seed, foreign in _seeds(relief, sign)
    ]
    return sorted(
        (r for r in regions if r is not None), key=lambda r: (-abs(r.height), int(r.footprint[0]))
    )


def _seeds(relief: _Relief, sign: float) -> Iterator[tuple[Ints, Ints]]:
    """Yield for each structure its seed, and the vertices of those that were split from it.

    A seed is the vertices of a structure that stand off the hull by MIN_OFFSET_M. Seeds whose area
    is below SPECK of the least of an object are noise and left out. sign: +1 raised, -1 sunken.
    """
    for cluster in relief.clusters(np.flatnonzero(relief.off & (sign * relief.found.height > 0))):
        parts = _split_at_saddles(relief, cluster, sign)
        for k, seed in enumerate(parts):
            if relief.area[seed].sum() >= SPECK * relief.options.min_area_m2:
                yield seed, np.concatenate([np.zeros(0, np.int64), *parts[:k], *parts[k + 1 :]])


def _split_at_saddles(relief: _Relief, rows: Ints, sign: float) -> list[Ints]:
    """Split a cluster of vertices between peaks that are at least twice as high as the saddle.

    Smoothing fills the gap between two neighbouring structures, so that one cluster may have both.
    A cluster without such a saddle is returned as it is. rows: the cluster's vertices (k,). sign:
    +1 raised, -1 sunken.
    """
    # Raise the height above which vertices are kept (level) until two or more peaks are apart.
    # Each vertex then goes to the nearest peak, and each part is split again.
    height, vertices = sign * relief.found.height[rows], relief.found.base.vertices
    level = SADDLE_STEP * MIN_OFFSET_M
    while level < 0.5 * height.max():
        peaks = [
            p for p in relief.clusters(rows[height > level]) if _is_peak(relief, p, sign, level)
        ]
        if len(peaks) > 1:
            gap = np.stack([nearest(vertices[p], vertices[rows], 1)[0][:, 0] for p in peaks])
            owner = gap.argmin(axis=0)
            return [
                part
                for k in range(len(peaks))
                for part in _split_at_saddles(relief, rows[owner == k], sign)
            ]
        level *= SADDLE_STEP
    return [rows]


def _is_peak(relief: _Relief, rows: Ints, sign: float, level: float) -> bool:
    """Tell whether a part of a cluster is a peak: no speck, and its top twice as high as the level.

    rows: vertices of the part. sign: +1 raised, -1 sunken. level: m, height above which all of them
    lie.
    """
    area = relief.area[rows]
    wide = area.sum() >= SPECK * relief.options.min_area_m2
    return bool(
        wide and _height_of_top(sign * relief.found.height[rows], area, TOP_M2) >= 2 * level
    )


def _measure_region(relief: _Relief, seed: Ints, foreign: Ints, sign: float) -> Region | None:
    """Measure a structure at a seed: the bare hull around it, its height above that, its vertices.

    Footprint and core are the vertices near the seed above a quarter and a half of the height.

    Parameters
    ----------
    relief
        The hull as found.
    seed
        Vertices of the structure that stand off the hull by MIN_OFFSET_M.
    foreign
        Vertices of structures that were split from it at a saddle. They are left out.
    sign
        +1 raised, -1 sunken.

    Returns
    -------
    Region or None
        None if too little bare hull was measured around it, or if nothing reaches half its height.
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
    # A structure may rise gently: vertices of the ring weigh more, the farther from it they are
    clear = (distance[bare] - RING_GAP_M) / width
    hull = fit_hull_around(base[ring], found.deviation_at(ring), area[ring] * clear**2, normal)
    above = sign * (found.deviation_at(near) - hull.offset(base[near]))
    within = np.isin(near, seed)
    # How much lower a three times larger area lies shows how pointed the top is: a pointed one may
    # be higher than was measured
    height, shoulder = (
        _height_of_top(above[within], area[near[within]], top) for top in (TOP_M2, 3 * TOP_M2)
    )
    own = (
        (distance <= relief.options.cluster_reach_m)
        & found.measured[near]
        & ~np.isin(near, foreign)
    )
    footprint, core = (
        near[own & (above >= share * height)] for share in (FOOTPRINT_SHARE, CORE_SHARE)
    )
    if not len(core):
        return None
    return Region(
        sign=sign,
        footprint=footprint,
        core=core,
        ring=ring,
        hull=hull,
        height=sign * height,
        bluntness=height - shoulder,
    )


def _height_of_top(height: Array, area: Array, top_m2: float) -> float:
    """Find the height (m) of a structure: that above which `top_m2` of its area lies.

    Of a small one half of the area is taken. height, area: (n,) m and m2 of its vertices.
    """
    return weighted_quantile(height, area, 1 - min(0.5, top_m2 / area.sum()))
