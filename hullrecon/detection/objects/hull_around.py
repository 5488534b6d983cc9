# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull beneath a structure, carried on from the hull around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import NORMAL_MAD, weighted_quantile
from hullrecon.typing import Array

SLOPE_SIGMA = 0.05  # prior of the slope of the hull's offset from the base, about zero
# 1/m, prior of its second-order terms, about zero: 10 mm of bulge between frames 0.7 m apart
BEND_SIGMA = 0.08
SIDES = 8  # the hull around counts as so many measurements at most: neighbours share landmarks
MIN_SCALE_M = 0.0005  # the scatter of the hull around is never taken for less
TUKEY = 4.0  # sigmas beyond which a vertex of the ring is no hull
ROUNDS = 4  # of weights by the last fit, and a fit by these weights


@dataclass(frozen=True, kw_only=True)
class HullAround:
    """A polynomial of second order of the hull's offset m from the base in the tangent plane at
    `middle` (3,), spanned by `axes` (2, 3), with the covariance (6, 6) of its coefficients (6,).
    """

    middle: Array
    axes: Array
    coefficients: Array
    covariance: Array

    def offset(self, points: Array) -> Array:
        """Return the hull's offset from the base (n,) m, outward positive, at points (n, 3)."""
        return np.asarray(self._terms(points) @ self.coefficients)

    def sigma(self, points: Array) -> Array:
        """Return one sigma (n,) m of that."""
        terms = self._terms(points)
        return np.asarray(np.sqrt(np.einsum("ni,ij,nj->n", terms, self.covariance, terms)))

    def _terms(self, points: Array) -> Array:
        return _terms((points - self.middle) @ self.axes.T)


def fit_hull_around(ring: Array, offset: Array, weight: Array, normal: Array) -> HullAround:
    """Return the hull through a ring of points (n, 3) with offsets (n,) m from the base, outward
    positive, robust to a part of the ring that is no hull. weight (n,): how much each counts beside
    the others; normal (3,): of the tangent plane.

    The deviation field is no measure of the hull there: the flanks of a structure that rises gently
    are landmarks on the hull to it, and draw it outward beneath the structure.
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
