# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How wrong the drawing is where the dive was: sigma and lengths of its smooth error and the points' own noise.

They decide how sure the place on the hull is, and no package knows them. They are found by restricted likelihood (the six
freedoms of T_g_M integrated out) with log-normal priors about what the package says; a point that its neighbours do not
predict (structure, a stray return) is left out. An offset of the whole hull stays possible, whatever the field looks like.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from hullrecon.adjustment.facets import facets_near
from hullrecon.adjustment.model import Drawing

Array = NDArray[np.float64]
PRIOR_LOG_SIGMA = np.array([0.7, 0.5, 0.7])  # of field sigma, lengths and noise: a factor of two is well possible
START_NOISE_M = 0.005  # of the mean of a voxel of landmarks and returns
OFFSET_SHARE = 0.7  # sigma of the common offset in the drawing's deviation_sigma
STRAY_SIGMAS = 4.0
MOST_POINTS = 400  # of the likelihood: its cost grows with the cube


@dataclass(frozen=True)
class Misfit:
    """sigma: of the smooth error, m; length: along and over the girth, m; noise: of a point, m; offset: sigma of an error
    common to the whole drawing, m."""

    sigma: float
    length: tuple[float, float]
    noise: float
    offset: float


def expected(drawing: Drawing) -> Misfit:
    """What the package says, before anything was measured."""
    sigma = drawing.deviation_sigma
    return Misfit(sigma, drawing.deviation_length, START_NOISE_M, OFFSET_SHARE * sigma)


def covariance(misfit: Misfit, drawing: Drawing, at: Array) -> Array:
    """Covariance (n, n) of the signed distances of points (n, 3) in M to the drawing: smooth error, offset, facets, noise.

    The facets' pattern repeats all over a survey, which no stationary covariance says: the points on one facet share out the
    information of one (METHODS 5), with three of its sigmas, lest a slide by one facet look like a better place.
    """
    along_girth = np.nan_to_num(drawing.chart.to_chart(at)[:, :2])
    return _covariance(misfit, along_girth, _facet_variance(drawing, at, along_girth))


def matern32(along_girth: Array, sigma: float, length: tuple[float, float]) -> Array:
    """Covariance (n, n) of a field at chart points (n, 2): sigma^2 (1 + sqrt3 r) exp(-sqrt3 r), r in correlation lengths."""
    scaled = along_girth / np.array(length)
    squared = np.sum(scaled**2, 1)
    r = np.sqrt(np.maximum(squared[:, None] + squared[None] - 2 * scaled @ scaled.T, 0))
    return np.asarray(sigma**2 * (1 + np.sqrt(3) * r) * np.exp(-np.sqrt(3) * r))


def _facet_variance(drawing: Drawing, at: Array, along_girth: Array) -> float:
    facets = facets_near(drawing.mesh, at)
    cells = len(np.unique(np.floor(along_girth / facets.length).astype(np.int64), axis=0))
    return float((3 * facets.sigma) ** 2 * len(at) / cells)


def _covariance(misfit: Misfit, along_girth: Array, facet_variance: float) -> Array:
    out = matern32(along_girth, misfit.sigma, misfit.length) + misfit.offset**2
    out[np.diag_indices(len(out))] += facet_variance + misfit.noise**2
    return out


def fitted(start: Misfit, drawing: Drawing, at: Array, distance: Array, by_place: Array, prior: Array) -> Misfit:
    """The likeliest misfit of signed distances (n,) at points (n, 3) in M.

    by_place (n, 6): their derivatives by T_g_M; prior (6, 6): its information. Priors are about what `drawing` says.
    """
    some = np.unique(np.linspace(0, len(at) - 1, MOST_POINTS).astype(int))
    along_girth = np.nan_to_num(drawing.chart.to_chart(at[some])[:, :2])
    facet = _facet_variance(drawing, at, np.nan_to_num(drawing.chart.to_chart(at)[:, :2]))
    middle = _logs(expected(drawing), drawing)

    def cost(logs: Array) -> float:
        trial = _from_logs(logs, drawing)
        likelihood = _restricted(_covariance(trial, along_girth, facet), distance[some], by_place[some], prior)
        return likelihood + 0.5 * float(np.sum(((logs - middle) / PRIOR_LOG_SIGMA) ** 2))

    first = _logs(start, drawing)
    simplex = first + np.vstack([np.zeros(3), 0.3 * np.eye(3)])
    found = minimize(
        cost, first, method="Nelder-Mead", options={"initial_simplex": simplex, "maxfev": 100, "xatol": 0.02, "fatol": 0.05}
    )
    return _from_logs(found.x, drawing)


def stray(factor: Any, distance: Array) -> NDArray[np.bool_]:
    """Points (n,) that the others do not predict: leave-one-out residuals beyond four of their sigmas, the worst first and the
    rest without it, lest a point on a structure take its neighbours along.

    factor: Cholesky factor of the distances' covariance.
    """
    inverse = cho_solve(factor, np.eye(len(distance)))
    right, gone = inverse @ distance, np.zeros(len(distance), bool)
    while not gone.all():
        sigmas = np.where(gone, 0.0, np.abs(right)) / np.sqrt(np.where(gone, 1.0, np.diag(inverse)))
        worst = int(np.argmax(sigmas))
        if sigmas[worst] <= STRAY_SIGMAS:
            break
        column = inverse[:, worst] / inverse[worst, worst]
        right = right - column * right[worst]
        inverse -= np.outer(column, inverse[worst])
        gone[worst] = True
    return gone


def with_misfit(drawing: Drawing, misfit: Misfit) -> Drawing:
    """The drawing, known to be as wrong as was found."""
    return replace(drawing, deviation_sigma=misfit.sigma, deviation_length=misfit.length)


def _restricted(covariance: Array, distance: Array, by_place: Array, prior: Array) -> float:
    """Minus the logarithm of the restricted likelihood, but for a constant."""
    factor = cho_factor(covariance, lower=True)
    solved = cho_solve(factor, np.c_[by_place, distance])
    information, right = by_place.T @ solved[:, :6] + prior, by_place.T @ solved[:, 6]
    misfit = distance @ solved[:, 6] - right @ np.linalg.solve(information, right)
    return float(np.log(np.diag(factor[0])).sum() + 0.5 * np.linalg.slogdet(information)[1] + 0.5 * misfit)


def _logs(misfit: Misfit, drawing: Drawing) -> Array:
    return np.log([misfit.sigma, misfit.length[0] / drawing.deviation_length[0], misfit.noise])


def _from_logs(logs: Array, drawing: Drawing) -> Misfit:
    sigma, scale, noise = np.exp(logs).tolist()
    along, girth = drawing.deviation_length
    return Misfit(sigma, (scale * along, scale * girth), noise, OFFSET_SHARE * drawing.deviation_sigma)
