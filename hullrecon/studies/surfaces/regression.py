# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces by other kernels, by triangles and by rays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy import sparse

from hullrecon.detection.as_found.hull_as_found import Unfused
from hullrecon.detection.as_found.shapes import find_shape_hits
from hullrecon.detection.options import MIN_OFFSET_M, DetectOptions
from hullrecon.detection.views import CameraViews
from hullrecon.errors import StageError
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.plane_chart import PlaneChart, fit_plane_chart
from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.robust import robust_sigma
from hullrecon.surface.build import MIN_FACING, Facts, SurfacePoints
from hullrecon.surface.gaussian import Kernel, NotPositiveDefiniteError, cell_means, compact
from hullrecon.surface.options import SurfaceOptions
from hullrecon.typing import Array, Ints

INDEPENDENT = "The CAD model's shape does not enter the regression of the returns."
MAX_FOLDED_SHARE = 0.01  # of the returns that may lie where the hull turns away from the plane


class RadialKernel(Kernel):
    """The Melkumyan-Ramos function of the radius, as printed: not positive definite in general."""

    NAME: ClassVar[str] = "radial"
    NORM: ClassVar[float] = 2.0

    def correlation(self, gap: Array) -> Array:
        """Compute correlations (k,) at gaps (k, 2) in units of the lengths."""
        return compact(np.linalg.norm(gap, axis=1))

    def covariance(self, at: Array) -> sparse.csr_array:
        """Compute the covariances (n, n) of points (n, 2) with each other.

        Raises NotPositiveDefiniteError where they are none, even if noise would hide it.
        """
        matrix = self.matrix(at, at)
        _require_covariance(matrix, self.sigma)
        return matrix


class WendlandKernel(Kernel):
    """Wendland's C2 function of the radius."""

    NAME: ClassVar[str] = "wendland"
    NORM: ClassVar[float] = 2.0

    def correlation(self, gap: Array) -> Array:
        """Compute correlations (k,) at gaps (k, 2) in units of the lengths."""
        return wendland(np.linalg.norm(gap, axis=1))


def wendland(r: Array) -> Array:
    """Evaluate Wendland's C2 function [Wendland1995], positive definite up to 3-D.

    r: (k,) distance over the radius, beyond which the function is zero.
    """
    return np.asarray(np.maximum(0.0, 1 - r) ** 4 * (4 * r + 1))


def _require_covariance(matrix: sparse.csr_array, sigma_m: float) -> None:
    """Raise NotPositiveDefiniteError for a matrix with a negative eigenvalue, beyond rounding."""
    from scipy.sparse.linalg import eigsh

    n = matrix.shape[0]
    small = n <= 400
    least = (
        np.linalg.eigvalsh(matrix.toarray())[0]
        if small
        else eigsh(matrix, k=1, which="SA", tol=1e-4, v0=np.ones(n))[0][0]
    )
    if least < -1e-9 * n * sigma_m**2:
        raise NotPositiveDefiniteError(
            f"the radial kernel is no covariance on these points (least eigenvalue {least:.2g} m2)",
            where="surface",
            remedy="use the product's kernel or Wendland's",
        )


def by_triangles(
    charted: Array, observed: SurfacePoints, wanted: Array, options: SurfaceOptions
) -> tuple[Array, Array, Facts]:
    """Interpolate returns between means over quarter cells, with one sigma by their scatter.

    Parameters
    ----------
    charted
        (n, 3) m of the returns: along, girth, offset.
    observed
        The returns with their noise.
    wanted
        (k, 2) m on the chart, where the offset is wanted.
    options
        Of the step `surface`, for the size of a cell.

    Returns
    -------
    Array, Array
        Offset and sigma (k,) m.
    Facts
        What surface.json says of the method.
    """
    seen = cell_means(charted[:, :2], charted[:, 2], observed.noise, 0.25 * options.cell_m)
    sigma = scatter_sigma(seen.at, seen.offset)
    facts: Facts = {"method": "linear", "observations": len(seen.at), "scatter_m": sigma}
    return interpolate(seen.at, seen.offset, wanted), np.full(len(wanted), sigma), facts


def interpolate(at: Array, values: Array, wanted: Array) -> Array:
    """Interpolate values (n,) at places (n, 2) on Delaunay triangles, to places wanted (k, 2).

    Outside of the triangles the nearest value is taken.
    """
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

    if len(at) < 4 or np.linalg.matrix_rank(at - at.mean(axis=0), tol=1e-6) < 2:
        return np.asarray(NearestNDInterpolator(at, values)(wanted))
    inside = np.asarray(LinearNDInterpolator(at, values)(wanted))
    return np.where(np.isfinite(inside), inside, NearestNDInterpolator(at, values)(wanted))


def scatter_sigma(at: Array, values: Array) -> float:
    """Estimate one robust sigma of values (n,) at places (n, 2) about their neighbours' mean."""
    count = min(6, len(at) - 1)
    if count < 1:
        return 0.0
    _, near = nearest(at, at, count + 1)
    off = values - values[near[:, 1:]].mean(axis=1)
    return float(robust_sigma(off, about=0.0) / np.sqrt(1 + 1 / count))


def offsets_from_plane(
    points: Array, chart: Chart, sensors: Array
) -> tuple[Chart, PlaneChart | None, Facts]:
    """Choose a plane through the points as the chart from which offsets are regressed.

    Parameters
    ----------
    points
        (n, 3) m in M, ends of the DVL's beams.
    chart
        Of the hull.
    sensors
        (n, 3) m in M, where the beams start, on the outer side of the plane.

    Raises StageError where the hull bends too far around for a plane.
    """
    plane = _plane(points, sensors)
    _, normals = chart.from_chart(chart.to_chart(points)[:, :2])
    facing = normals[np.isfinite(normals).all(axis=1)] @ plane.axes[2]
    if np.mean(facing < MIN_FACING) > MAX_FOLDED_SHARE:
        raise StageError(
            "the hull bends too far around for a plane",
            where="surface",
            remedy="take the CAD model as reference, or a shorter survey",
        )
    return plane, None, {"reference": "plane", "comparison": INDEPENDENT}


def heights_over_plane(
    points: Array, chart: Chart, sensors: Array
) -> tuple[Chart, PlaneChart | None, Facts]:
    """Regress heights over a plane through the points (n, 3), at places of the hull's chart.

    Parameters are as of `offsets_from_plane`.
    """
    return chart, _plane(points, sensors), {"reference": "none", "comparison": INDEPENDENT}


def _plane(points: Array, sensors: Array) -> PlaneChart:
    """Fit a plane to points (n, 3) m, whose normal points to the sensors (n, 3) m."""
    return fit_plane_chart(points, sensors.mean(axis=0), np.array([0.0, 0.0, 1.0]))


@dataclass(frozen=True, kw_only=True)
class FusedShapes:
    """Vertices moved to the shapes that rays to them met."""

    vertex: Array  # (n, 3), running means of the intersections, the prior's where there were none
    count: Ints  # (n,) views whose shapes met the ray to that vertex


def fuse_shapes(
    views: CameraViews,
    features: Array,
    deviation: Array,
    vertices: Array,
    options: DetectOptions,
    threshold_m: float = MIN_OFFSET_M,
) -> FusedShapes:
    """Move vertices (n, 3) to the shapes that features (m, 3) off the CAD model span.

    deviation (m,): signed distances m of features from the CAD model. [Ozog2016 eq. 4.15] is a
    running mean in which the first observation replaces the prior: the mean of all intersections.
    """
    total, count = np.zeros_like(vertices), np.zeros(len(vertices), np.int64)
    for rows, points in find_shape_hits(views, features, deviation, vertices, options, threshold_m):
        total[rows] += points
        count[rows] += 1
    vertex = np.where(count[:, None] > 0, total / np.maximum(count, 1)[:, None], vertices)
    return FusedShapes(vertex=vertex, count=count)


def move_along_rays(
    given: Unfused, views: CameraViews, options: DetectOptions
) -> tuple[Array, Array, Ints]:
    """Move vertices along rays that saw shapes, and leave the others on the hull.

    Returns the vertices (n, 3) m, their height over the hull (n,) m, 0 for those left, and the
    number of views (n,) that saw a shape there.
    """
    at = given.mesh.vertices
    fused = fuse_shapes(views, given.features, given.feature_height, at, options)
    taken = fused.count > 0
    moved = np.where(taken[:, None], fused.vertex, at + given.normal * given.hull[:, None])
    off = np.einsum("ni,ni->n", moved - at, given.normal) - given.hull
    return moved, np.where(taken, off, 0.0), fused.count
