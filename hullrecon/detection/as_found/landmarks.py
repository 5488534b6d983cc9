# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks that measure the hull, and the hull without structures between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hullrecon.estimation.landmark_variance import variance_along_normals
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.robust import robust_sigma
from hullrecon.records.solution import DeviationField, HullPose
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class SurfaceLandmarks(Rows):
    """Landmarks (n) that measure the base surface, in its frame."""

    row: Ints  # (n,) in the Solution
    position: Array  # (n, 3)
    foot: Array  # (n, 3) on the base
    normal: Array  # (n, 3) of the base there, outward
    offset: Array  # (n,) m, signed distance to the base
    sigma: Array  # (n,) m along the normal, of each on its own
    common: Array  # (n,) m, what it shares with its neighbours: the dive's place on the hull
    covariance: Array  # (n, 3, 3)
    views: Ints  # (n,)


def measure_surface(
    scene: Scene,
    position: Array,
    covariance: Array,
    views: Ints,
    farthest_m: float,
    largest_sigma_m: float,
    hull_pose: HullPose | None = None,
) -> SurfaceLandmarks:
    """Measure the surface of `scene` by landmarks near it.

    Left out are landmarks that are not finite, seen by one image only, farther off than
    `farthest_m`, less certain along the normal than `largest_sigma_m`, and those whose closest
    point is the rim of the base, beside which they lie rather than above it.

    Parameters
    ----------
    position
        of the landmarks (n, 3).
    covariance
        of the landmarks (n, 3, 3).
    hull_pose
        whose error is part of the covariances, None where it is not. It moves all landmarks as
        one, and is no noise of theirs however large it is.
    """
    row = np.flatnonzero(np.isfinite(position).all(axis=1) & (views >= 2))
    near = scene.closest(position[row])
    gap = position[row] - near.foot
    sideways = np.linalg.norm(
        gap - near.normal * np.einsum("ni,ni->n", gap, near.normal)[:, None], axis=1
    )
    variance = np.einsum("ni,nij,nj->n", near.normal, covariance[row], near.normal)
    near_it = (np.abs(near.distance) <= farthest_m) & (
        sideways <= 0.005 + 0.7 * np.abs(near.distance)
    )
    good = np.flatnonzero(near_it & (variance > 0))
    # By the normals of the facets, the variance that the hull's pose adds would jump at each edge.
    along = variance_along_normals(
        position[row[good]],
        scene.smooth_normals(near.take(good)),
        covariance[row[good]],
        hull_pose,
    )
    sigma = np.sqrt(along.own)
    kept = SurfaceLandmarks(
        row=row[good], position=position[row[good]], foot=near.foot[good], normal=near.normal[good],
        offset=near.distance[good], sigma=sigma, common=np.sqrt(along.common),
        covariance=covariance[row[good]], views=views[row[good]],
    )  # fmt: skip
    return kept.take(sigma <= largest_sigma_m)


# sigma of a median of many normal values over that of their mean: sqrt(pi / 2)
MEDIAN_OVER_MEAN = 1.2533
UNKNOWN_SIGMA_M = 0.05  # of a median of one value or none


class Background(Protocol):
    """Offset of the hull from the base surface and its sigma at points (n, 3): two of (n,) m."""

    def at(self, points: Array) -> tuple[Array, Array]: ...


@dataclass(frozen=True, kw_only=True)
class FieldBackground:
    """The adjustment's deviation field, zero with its largest sigma outside the grid."""

    chart: Chart
    field: DeviationField

    def at(self, points: Array) -> tuple[Array, Array]:
        """See `Background`."""
        at = self.chart.to_chart(points)[:, :2]
        inside, field = self.field.covers(at), self.field
        return np.where(inside, field.value_at(at), 0.0), np.where(
            inside, field.sigma_at(at), field.sigma.max()
        )


@dataclass(frozen=True, kw_only=True)
class MedianBackground:
    """Median offsets of the landmarks around nodes, smooth between them."""

    node: Array
    value: Array
    spread: Array
    reach_m: float

    def at(self, points: Array) -> tuple[Array, Array]:
        """See `Background`. The nearest nodes count by a Gaussian of half the reach."""
        distance, row = nearest(self.node, points, min(8, len(self.node)))
        weight = np.exp(-0.5 * (distance / (0.5 * self.reach_m)) ** 2) + 1e-12
        weight /= weight.sum(axis=1, keepdims=True)
        return (weight * self.value[row]).sum(axis=1), (weight * self.spread[row]).sum(axis=1)


def median_background(feet: Array, offset: Array, width_m: float) -> Background:
    """Estimate the hull by running medians over discs `width_m` wide.

    What covers less than half a disc is not hull. Landmarks are first thinned to medians of small
    cells, so that a richly textured structure does not outvote the hull around it. `feet`: of the
    landmarks on the base (n, 3). `offset`: of the landmarks from the base (n,) m.
    """
    from scipy.spatial import cKDTree

    cell = np.floor(feet / (width_m / 15)).astype(np.int64)
    at, value = _cell_medians(cell, feet, offset)
    coarse = np.floor(at / (width_m / 4)).astype(np.int64)
    node, _ = _cell_medians(coarse, at, value)
    around = cKDTree(at).query_ball_point(node, width_m / 2, return_sorted=True)
    middle = np.array([np.median(value[rows]) if rows else 0.0 for rows in around])
    spread = np.array([_robust_error(value[rows]) for rows in around])
    return MedianBackground(node=node, value=middle, spread=spread, reach_m=width_m / 4)


def _cell_medians(cell: Ints, at: Array, value: Array) -> tuple[Array, Array]:
    """Compute the mean place and median value of each cell, in the cells' order."""
    _, number = np.unique(cell, axis=0, return_inverse=True)
    number = number.reshape(-1)
    order = np.lexsort((value, number))
    start = np.flatnonzero(np.r_[True, np.diff(number[order]) > 0])
    count = np.diff(np.r_[start, len(number)])
    ranked = value[order]
    median = 0.5 * (ranked[start + (count - 1) // 2] + ranked[start + count // 2])
    mean = np.stack(
        [np.bincount(number, at[:, k]) / np.bincount(number) for k in range(at.shape[1])], axis=1
    )
    return mean, median


def _robust_error(values: Array) -> float:
    """Estimate one sigma of the median of these values."""
    if len(values) < 2:
        return UNKNOWN_SIGMA_M
    return float(robust_sigma(values) * MEDIAN_OVER_MEAN / np.sqrt(len(values)))
