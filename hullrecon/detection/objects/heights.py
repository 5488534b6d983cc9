# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Regress heights from landmarks, locally and robustly: smooth on the hull, sharp at edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.rows import Rows
from hullrecon.threads import in_threads
from hullrecon.typing import Array, Ints

CHUNK, CHUNKS_AT_A_TIME = 10_000, 2  # vertices of a thread, and threads, to limit memory
# Prior sigma of the slope, m/m, about zero: without it, fits to few landmarks extrapolate
SLOPE_SIGMA = 0.5
# Prior sigma of the second-order terms, 1/m, about zero. A plane alone would cut off a lump's top.
BEND_SIGMA = 5.0
ROUNDS = 4  # of reweighting and fitting
# Limits of the robust scale: landmarks that differ by less than the least are no outliers. Without
# the largest, both sides of a step would be inliers.
MIN_SCALE_M = 0.003
MAX_SCALE_M = 0.012


@dataclass(frozen=True)
class Heights(Rows):
    """Regressed heights at n vertices."""

    value: Array  # (n,) m
    sigma: Array  # (n,) m
    count: Ints  # (n,) landmarks within reach
    agreement: Array  # (n,) share of the landmarks, by weight, that are inliers of the fit


def local_heights(
    at: Array,
    normal: Array,
    feet: Array,
    height: Array,
    sigma: Array,
    neighbours: int,
    reach_m: float,
) -> Heights:
    """Regress the heights of landmarks at vertices.

    At each vertex a polynomial of second order in the tangent plane is fitted to the nearest
    landmarks, with Tukey's weights. The start is the median of the nearest few, so that at a step
    the fit stays on the side on which the vertex lies. Priors hold slope and second-order terms
    near zero. NaN where fewer than three landmarks are within reach.

    Parameters
    ----------
    at, normal
        Vertices (n, 3) m with outward normals (n, 3).
    feet
        Points (l, 3) m of the base nearest to the landmarks.
    height, sigma
        Heights (l,) m of the landmarks above the hull without structures, and their own sigmas.
    neighbours
        Number of nearest landmarks that are used, at most.
    reach_m
        Largest distance of a landmark's foot from the vertex.
    """

    def regress(first: int) -> tuple[Array, Array, Array, Array]:
        rows = slice(first, first + CHUNK)
        return _heights(at[rows], normal[rows], feet, height, sigma, neighbours, reach_m)

    parts = list(in_threads(regress, range(0, len(at), CHUNK), most=CHUNKS_AT_A_TIME))
    value, error, count, agreement = (
        np.concatenate([np.zeros(0), *(part[k] for part in parts)]) for k in range(4)
    )
    return Heights(value, error, count.astype(np.int64), agreement)


def _heights(
    at: Array,
    normal: Array,
    feet: Array,
    height: Array,
    sigma: Array,
    neighbours: int,
    reach_m: float,
) -> tuple[Array, Array, Array, Array]:
    """Regress heights at a block of vertices, as `local_heights` does.

    Parameters
    ----------
    at, normal
        Vertices (n, 3) m, and their unit normals.
    feet, height, sigma
        Landmarks: feet on the hull (l, 3) m, heights over it (l,) m, and their sigmas.
    neighbours, reach_m
        Landmarks of a vertex at most, and their largest distance.

    Returns
    -------
    height, error, count, agreement
        The fields of `Heights`, (n,) each.
    """
    # Weights by distance, to zero a little beyond the farthest neighbour, and by the landmarks'
    # sigmas.
    distance, row = nearest(feet, at, min(neighbours, len(feet)), reach_m)
    near = np.isfinite(distance)
    row = np.where(near, row, 0)
    count = near.sum(axis=1)
    width = np.where(near, distance, 0.0).max(axis=1, initial=1e-3, keepdims=True) * 1.05
    weight = np.where(
        near,
        (1 - np.minimum(1, distance / width) ** 2) ** 2 / (sigma[row] ** 2 + MIN_SCALE_M**2),
        0.0,
    )
    # Start from the median of the nearest few, with the scatter of all about it.
    h = np.where(near, height[row], np.nan)
    start = _median(h[:, :7])
    scale = np.clip(NORMAL_MAD * _median(np.abs(h - start[:, None])), MIN_SCALE_M, MAX_SCALE_M)
    # Refit the polynomial in the tangent plane with Tukey's weights.
    first_axis, second_axis = _tangents(normal)
    from_vertex = feet[row] - at[:, None, :]
    terms = quadratic_terms(
        np.einsum("nki,ni->nk", from_vertex, first_axis),
        np.einsum("nki,ni->nk", from_vertex, second_axis),
    )
    fit = np.concatenate([np.nan_to_num(start)[:, None], np.zeros((len(at), 5))], axis=1)
    h = np.nan_to_num(h)
    for _ in range(ROUNDS):
        # A landmark 4 robust sigmas off the fit is an outlier, and has no weight
        off = (h - np.einsum("nkj,nj->nk", terms, fit)) / (4.0 * scale[:, None])
        robust = weight * np.maximum(0.0, 1 - off**2) ** 2
        fit, variance = _solve(terms, h, robust, fit)
    error = _sigma_of_heights(terms, h, fit, robust, sigma[row], variance)
    agreement = (weight * (np.abs(off) < 1)).sum(axis=1) / (weight.sum(axis=1) + 1e-12)
    known = count >= 3
    return (
        np.where(known, fit[:, 0], np.nan),
        np.where(known, error, np.nan),
        count.astype(float),
        np.where(known, agreement, 0.0),
    )


def quadratic_terms(a: Array, b: Array) -> Array:
    """Evaluate the terms (..., 6) of a polynomial at a, b (...) m: 1, a, b, a^2, a b, b^2."""
    return np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=-1)


def _sigma_of_heights(
    terms: Array, h: Array, fit: Array, weight: Array, sigma: Array, variance: Array
) -> Array:
    """Compute the sigma (n,) m of the fitted heights.

    The variance of one landmark (stated, or by the scatter if that is larger) is divided by the
    effective number of landmarks. It is multiplied by the leverage, as the constant term of a
    polynomial is determined less well than a mean.

    Parameters
    ----------
    terms, h
        Terms (n, k, 6) and heights (n, k) of the k neighbours.
    fit
        Coefficients (n, 6) of the polynomial at each vertex.
    weight, sigma
        Weights (n, k), with those of Tukey, and sigmas (n, k) m of the neighbours.
    variance
        (n,) of the constant term as the weights give it, from which the leverage follows.
    """
    total = weight.sum(axis=1) + 1e-12
    scatter = np.einsum("nk,nk->n", weight, (h - np.einsum("nkj,nj->nk", terms, fit)) ** 2) / total
    claimed = np.einsum("nk,nk->n", weight, sigma**2) / total
    effective = np.maximum(1.0, total**2 / (np.einsum("nk,nk->n", weight, weight) + 1e-12))
    leverage = np.maximum(1.0, variance * total)
    return np.asarray(np.sqrt(np.maximum(scatter, claimed) * leverage / effective))


def _solve(terms: Array, h: Array, weight: Array, before: Array) -> tuple[Array, Array]:
    """Fit the coefficients of each vertex by weighted least squares with priors.

    One round of the reweighted fit of `_heights`.

    Parameters
    ----------
    terms, h, weight
        Terms (n, k, 6), heights (n, k) and weights (n, k) of the k neighbours.
    before
        Coefficients (n, 6) that are returned where all weights are zero.

    Returns
    -------
    coefficients
        (n, 6).
    variance
        (n,) of the height, the first coefficient.
    """
    normal_matrix = np.einsum("nki,nk,nkj->nij", terms, weight, terms, optimize=True)
    normal_matrix[:, [1, 2], [1, 2]] += 1 / SLOPE_SIGMA**2
    normal_matrix[:, [3, 4, 5], [3, 4, 5]] += 1 / BEND_SIGMA**2
    normal_matrix[:, 0, 0] += 1e-6
    right_side = np.einsum("nki,nk,nk->ni", terms, weight, h, optimize=True)
    inverse = np.linalg.inv(normal_matrix)
    fit = np.einsum("nij,nj->ni", inverse, right_side)
    empty = weight.sum(axis=1) <= 0
    fit[empty] = before[empty]
    return fit, np.where(empty, MAX_SCALE_M**2, inverse[:, 0, 0])


def _median(values: Array) -> Array:
    """Compute the median (n,) of each row of values (n, k) without its NaN. NaN where all are."""
    ranked = np.sort(values, axis=1)
    count = np.isfinite(values).sum(axis=1)
    rows = np.arange(len(values))
    low, high = np.maximum(count - 1, 0) // 2, count // 2
    return np.asarray(
        0.5 * (ranked[rows, low] + ranked[rows, np.minimum(high, values.shape[1] - 1)])
    )


def _tangents(normal: Array) -> tuple[Array, Array]:
    """Make two unit vectors (n, 3) perpendicular to each normal (n, 3) and to each other.

    Any direction in the tangent plane will do.
    """
    helper = np.where(np.abs(normal[:, :1]) < 0.7, np.array([[1.0, 0, 0]]), np.array([[0, 1.0, 0]]))
    first_axis = np.cross(helper, normal)
    first_axis /= np.maximum(np.linalg.norm(first_axis, axis=1, keepdims=True), 1e-12)
    return first_axis, np.cross(normal, first_axis)
