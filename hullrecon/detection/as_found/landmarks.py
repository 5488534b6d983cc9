# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks as measurements of the hull, and the hull without structures estimated from them."""

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
    """The n landmarks near the base surface, in its frame."""

    row: Ints  # (n,) rows among the landmarks of the Solution
    position: Array  # (n, 3) m
    foot: Array  # (n, 3) m, nearest point on the base
    normal: Array  # (n, 3) of the base there, outward
    offset: Array  # (n,) m, signed distance to the base
    sigma: Array  # (n,) m along the normal, the part that is independent of other landmarks
    common: Array  # (n,) m along the normal, the part common to all, from the hull pose
    covariance: Array  # (n, 3, 3) m2
    views: Ints  # (n,) number of observations


def measure_surface(
    scene: Scene,
    position: Array,
    covariance: Array,
    views: Ints,
    farthest_m: float,
    largest_sigma_m: float,
    hull_pose: HullPose | None = None,
) -> SurfaceLandmarks:
    """Select the landmarks near a surface, and compute their signed distances to it with sigmas.

    Left out are landmarks that are not finite, that have a single observation, that are farther off
    than `farthest_m` or less certain along the normal than `largest_sigma_m`, and those that lie
    beside the rim of the surface rather than above it.

    Parameters
    ----------
    scene
        The base surface.
    position
        Positions (n, 3) m of the landmarks, in the frame of the surface.
    covariance
        Covariances (n, 3, 3) m2 of these positions.
    views
        Number of observations of each landmark (n,).
    farthest_m, largest_sigma_m
        Largest distance from the surface, and largest sigma along its normal, of a landmark that is
        kept.
    hull_pose
        Its covariance is part of that of each landmark. As it moves all landmarks alike, it is kept
        apart from their own sigmas. None where their covariances do not contain it (in g).
    """
    row = np.flatnonzero(np.isfinite(position).all(axis=1) & (views >= 2))
    near = scene.closest(position[row])
    from_foot = position[row] - near.foot
    # Distance from the line along the normal through the foot. Beside the rim it is larger than
    # 5 mm and 35 degrees off the normal explain
    sideways = np.linalg.norm(
        from_foot - near.normal * np.einsum("ni,ni->n", from_foot, near.normal)[:, None], axis=1
    )
    variance = np.einsum("ni,nij,nj->n", near.normal, covariance[row], near.normal)
    is_above = (np.abs(near.distance) <= farthest_m) & (
        sideways <= 0.005 + 0.7 * np.abs(near.distance)
    )
    good = np.flatnonzero(is_above & (variance > 0))
    # Smooth normals: with those of the facets, the hull pose's variance would jump at each edge.
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


# Ratio of the sigmas of median and mean of many normally distributed values: sqrt(pi / 2)
MEDIAN_OVER_MEAN = 1.2533
UNKNOWN_SIGMA_M = 0.05  # sigma of a median of fewer than two values


class Background(Protocol):
    """The hull without structures, as an offset from the base surface."""

    def at(self, points: Array) -> tuple[Array, Array]:
        """Compute the offset and its sigma, both (n,) m, at points (n, 3) m."""


@dataclass(frozen=True, kw_only=True)
class FieldBackground:
    """The adjustment's deviation field. Outside its grid, zero with the field's largest sigma."""

    chart: Chart
    field: DeviationField

    def at(self, points: Array) -> tuple[Array, Array]:
        """Look up the field and its sigma (n,) m at points (n, 3) m.

        Outside of the field it is zero, with the largest sigma.
        """
        at = self.chart.to_chart(points)[:, :2]
        inside, field = self.field.covers(at), self.field
        return np.where(inside, field.value_at(at), 0.0), np.where(
            inside, field.sigma_at(at), field.sigma.max()
        )


@dataclass(frozen=True, kw_only=True)
class MedianBackground:
    """Median offsets of the landmarks around nodes, interpolated between them."""

    node: Array  # (k, 3) m
    value: Array  # (k,) m, median offset
    spread: Array  # (k,) m, sigma of the median
    reach_m: float  # about the distance between nodes

    def at(self, points: Array) -> tuple[Array, Array]:
        """Average the hull's height and its sigma (n,) m at points (n, 3) m over the nearest nodes.

        Nodes are weighted by a Gaussian of half the reach.
        """
        distance, row = nearest(self.node, points, min(8, len(self.node)))
        weight = np.exp(-0.5 * (distance / (0.5 * self.reach_m)) ** 2) + 1e-12
        weight /= weight.sum(axis=1, keepdims=True)
        return (weight * self.value[row]).sum(axis=1), (weight * self.spread[row]).sum(axis=1)


def median_background(feet: Array, offset: Array, width_m: float) -> Background:
    """Estimate the hull without structures by running medians over discs.

    It stands in for the deviation field where the adjustment has none. A structure that covers less
    than half of a disc does not change its median. Landmarks are first thinned to medians of small
    cells, as a structure with much texture would outweigh the hull around it.

    Parameters
    ----------
    feet
        Points (n, 3) m of the base nearest to the landmarks.
    offset
        Signed distances (n,) m of the landmarks from the base.
    width_m
        Diameter of a disc. Structures narrower than about half of it are left out.
    """
    from scipy.spatial import cKDTree

    # Medians of small cells, nodes a quarter of a disc apart, and the median of the cells in a disc
    # around each node
    cell = np.floor(feet / (width_m / 15)).astype(np.int64)
    at, value = _cell_medians(cell, feet, offset)
    coarse = np.floor(at / (width_m / 4)).astype(np.int64)
    node, _ = _cell_medians(coarse, at, value)
    around = cKDTree(at).query_ball_point(node, width_m / 2, return_sorted=True)
    middle = np.array([np.median(value[rows]) if rows else 0.0 for rows in around])
    spread = np.array([_robust_error(value[rows]) for rows in around])
    return MedianBackground(node=node, value=middle, spread=spread, reach_m=width_m / 4)


def _cell_medians(cell: Ints, at: Array, value: Array) -> tuple[Array, Array]:
    """Compute the mean position and the median value of each cell, in the cells' order.

    cell (n, 3): of each point. at (n, 3), value (n,): positions and values of the points.
    """
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
    """Estimate the sigma of the median of values (n,), m. UNKNOWN_SIGMA_M for fewer than two."""
    if len(values) < 2:
        return UNKNOWN_SIGMA_M
    return float(robust_sigma(values) * MEDIAN_OVER_MEAN / np.sqrt(len(values)))
