# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Expected error of the CAD model as the covariance of distances to it, and outliers under it.

The sigma and the correlation lengths of the smooth error are those that the package states. Fitted
by likelihood instead, they would follow what neighbouring points have in common for other reasons
(facets, smoothed landmarks): docs/adr/0010. An offset of the whole hull is always possible.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve

from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.meshes.tessellation import tessellation_error
from hullrecon.typing import Array, CholeskyFactor, Mask

POINT_NOISE_M = 0.005  # sigma of the mean of a voxel of landmarks and returns
OFFSET_SHARE = 0.7  # sigma of the common offset, as a share of the CAD model's deviation_sigma
OUTLIER_SIGMAS = 4.0  # of a leave-one-out residual


@dataclass(frozen=True, kw_only=True)
class CadError:
    """The stated error of the CAD model."""

    sigma: float  # m, of the smooth error
    length: tuple[float, float]  # m, its correlation length along and over the girth
    noise: float  # m, sigma of a point
    offset: float  # m, sigma of an error common to the whole CAD model


def expected_cad_error(cad_model: CadModel) -> CadError:
    """Make the expected error of the CAD model from the package's sigma and correlation lengths."""
    sigma = cad_model.deviation_sigma
    return CadError(
        sigma=sigma,
        length=cad_model.deviation_length,
        noise=POINT_NOISE_M,
        offset=OFFSET_SHARE * sigma,
    )


def distance_covariance(cad_error_model: CadError, cad_model: CadModel, at: Array) -> Array:
    """Compute the covariance (n, n) of signed distances of points (n, 3) in M to the CAD model.

    Used to weigh the distances when the hull's pose is fitted. Four errors add up: the smooth error
    of the CAD model, an offset of the whole hull, the noise of each point, and the mesh's facets,
    flat faces that cut into a curved hull.

    The facets make a pattern that repeats over the survey, which no stationary covariance
    describes. Instead their error is taken as independent from point to point, with a variance so
    much larger that all points of one facet together weigh as a single one (`facet_variance`,
    docs/methods.md 9). Its sigma is tripled, because otherwise a slide by one facet looks like a
    better pose.
    """
    along_girth = chart_coordinates(cad_model, at)
    return _covariance(cad_error_model, along_girth, facet_variance(cad_model, at, sigmas=3.0))


def matern32(along_girth: Array, sigma: float, length: tuple[float, float]) -> Array:
    """Compute the covariance (n, n), m2, of a Matern 3/2 field at chart points (n, 2) m.

    length: correlation lengths along and in girth, m. It is sigma^2 (1 + sqrt3 r) exp(-sqrt3 r),
    with r in correlation lengths.
    """
    scaled = along_girth / np.array(length)
    squared = np.sum(scaled**2, 1)
    r = np.sqrt(np.maximum(squared[:, None] + squared[None] - 2 * scaled @ scaled.T, 0))
    return np.asarray(sigma**2 * (1 + np.sqrt(3) * r) * np.exp(-np.sqrt(3) * r))


def chart_coordinates(cad_model: CadModel, at: Array) -> Array:
    """Compute along and girth (n, 2) m of points (n, 3) in M, zero where the chart has none."""
    return np.nan_to_num(cad_model.chart.to_chart(at)[:, :2])


def facet_variance(cad_model: CadModel, at: Array, sigmas: float) -> float:
    """Compute the variance (m2) of a point's distance to the CAD model due to its facets.

    It is (sigmas * facet sigma)^2 times the mean number of points on a facet, so that they together
    have the information of a single point.

    Parameters
    ----------
    cad_model
        The mesh, of whose facets size and error are measured near the points.
    at
        Points (n, 3) m in M.
    sigmas
        Factor of the facets' sigma.
    """
    facets = tessellation_error(cad_model.mesh, at)
    # Facets that have a point, counted as cells of a facet's size
    cells = len(
        np.unique(
            np.floor(chart_coordinates(cad_model, at) / facets.length_m).astype(np.int64), axis=0
        )
    )
    return float((sigmas * facets.sigma_m) ** 2 * len(at) / cells)


def _covariance(cad_error_model: CadError, along_girth: Array, facet_variance: float) -> Array:
    """Sum smooth error, offset, facets and noise to a covariance (n, n) at chart points (n, 2) m.

    Facets and noise are taken as independent from point to point. facet_variance: m2, of a point.
    """
    out = (
        matern32(along_girth, cad_error_model.sigma, cad_error_model.length)
        + cad_error_model.offset**2
    )
    out[np.diag_indices(len(out))] += facet_variance + cad_error_model.noise**2
    return out


def find_outliers(factor: CholeskyFactor, distance: Array) -> Mask:
    """Find points (n,) whose leave-one-out residual is beyond OUTLIER_SIGMAS.

    The worst point is removed first, and the others are predicted without it. Otherwise a point on
    a structure would make its neighbours outliers too.

    Parameters
    ----------
    factor
        Cholesky factor of the distances' covariance.
    distance
        (n,) m, signed, to the CAD model.
    """
    inverse = cho_solve(factor, np.eye(len(distance)))
    # A leave-one-out residual in its sigma is (C^-1 d)_i / sqrt((C^-1)_ii). To remove a point is a
    # rank-one update of the inverse.
    weighted, removed = inverse @ distance, np.zeros(len(distance), bool)
    while not removed.all():
        variance = np.where(removed, 1.0, np.diag(inverse))
        sigmas = np.where(removed, 0.0, np.abs(weighted)) / np.sqrt(variance)
        worst = int(np.argmax(sigmas))
        if sigmas[worst] <= OUTLIER_SIGMAS:
            break
        column = inverse[:, worst] / inverse[worst, worst]
        weighted = weighted - column * weighted[worst]
        inverse -= np.outer(column, inverse[worst])
        removed[worst] = True
    return removed
