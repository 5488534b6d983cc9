# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The motion between two stereo nodes by bundle adjustment of both, with its covariance.

Points are eliminated. A feature seen by both cameras of both nodes has eight coordinates and three
unknowns, which leaves five to determine the motion. If triangulated points were taken as known, all
eight would count, and the covariance would be four times too small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon import native
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.pose_from_points import apply_step

ITERATIONS = 3  # of Gauss-Newton
LEAST = 6  # features that a motion needs
CHI2_MEDIAN = 0.87  # median of chi-square with five degrees of freedom, divided by five
# Limit of an inlier's residual norm, as sigmas of a Gaussian: 99.99 % of correct features are below
OUTLIER_SIGMAS = 3.9
# Sides of image cells within which features may have correlated errors, ideal coordinates: they
# share blur, light and relief (smaller cells), or errors of the lens model (larger ones).
CELLS = (0.1, 0.25)
FIELD = 0.5  # ideal coordinates: half the width of a common image
DISPARITY = 6  # unknowns of the disparity's error over the image, after the six of the rig


@dataclass(frozen=True, kw_only=True)
class NodeObservations(Rows):
    """Features of one node."""

    lead: Array  # (m, 2) in its leading camera, ideal coordinates
    other: Array  # (m, 2) of the stereo match in the bottom camera, NaN for none
    point: Array  # (m, 3) triangulated in the leading camera, m, NaN for none


@dataclass(frozen=True, kw_only=True)
class CalibrationEvidence:
    """The information of a pair of nodes on the twelve unknown errors of the dive's calibration.

    Six of top_from_bottom: (translation, rotation vector) in the top camera's axes. Six of the
    disparity, by lenses and rig together: the coefficients of 1, x, y, x^2, xy, y^2, with x and y
    the position in the leading image, ideal coordinates over FIELD.
    """

    by_calibration: Array  # (6, 12) derivative of the motion by the errors
    # Information (12, 12) and gradient (12,) of the errors, with points and motion eliminated, from
    # residuals divided by their sigma.
    information: Array
    gradient: Array


@dataclass(frozen=True, kw_only=True)
class AdjustedMotion:
    """A motion adjusted to features of two stereo nodes."""

    second_from_first: Array  # (4, 4)
    # (6, 6) as Motion defines it, from errors that are independent between features, or cells
    covariance: Array
    calibration: CalibrationEvidence


def adjust_stereo_motion(
    motion: Array, first: NodeObservations, second: NodeObservations, bottom_from_top: Array
) -> AdjustedMotion | None:
    """Adjust second_from_first (4, 4) together with the points of m features that both nodes saw.

    It refines a first guess, gives its covariance, and shows how errors of the stereo calibration
    would change it. Outliers are left out. None where too few features have a stereo point, or too
    few are inliers. bottom_from_top: (4, 4) as calibrated.
    """
    # Points start where either node triangulated them.
    known = np.isfinite(first.point[:, 0]) | np.isfinite(second.point[:, 0])
    first, second = first.take(known), second.take(known)
    if len(first) < LEAST:
        return None
    # The second node's points, in the first camera.
    back = (second.point - motion[:3, 3]) @ motion[:3, :3]
    points = np.where(np.isfinite(first.point), first.point, back)
    seen = np.hstack([first.lead, first.other, second.lead, second.other])
    # Not geometry.pose_solver: every step moves the points as well, and chooses the inliers anew.
    for _ in range(ITERATIONS):
        system = native.reduce_stereo(motion, bottom_from_top, points, seen)
        good = _inliers(system)
        if good.sum() < LEAST:
            return None
        step = np.asarray(
            -np.linalg.solve(
                system.information[good].sum(axis=0), system.gradient[good].sum(axis=0)
            )
        )
        points = points + _point_step(system, step)
        motion = apply_step(motion, step)
    system = native.reduce_stereo(motion, bottom_from_top, points, seen)
    good = _inliers(system)
    if good.sum() < LEAST:
        return None

    # The covariance is scaled by the residuals, and by correlated errors of neighbouring features.
    rows = native.linearise_stereo(motion, bottom_from_top, FIELD, points[good], seen[good])
    information = system.information[good].sum(axis=0)
    inverse = np.linalg.inv(information)
    variance = max(
        float(system.cost[good].sum()) / max(1, int(system.freedom[good].sum()) - 6), 1e-14
    )
    inflation = correlation_inflation(
        system.information[good], system.gradient[good], variance, first.lead[good]
    )
    covariance = variance * inflation * inverse
    return AdjustedMotion(
        second_from_first=motion,
        covariance=covariance,
        calibration=_calibration_evidence(system.take(good), rows, inverse, variance * inflation),
    )


def _point_step(system: native.ReducedFeatures, step: Array) -> Array:
    """Compute the step of the points (m, 3) that goes with a step (6,) of the motion.

    The points were eliminated from the normal equations: this is the back-substitution.
    """
    wanted = system.point_gradient + np.einsum("mji,j->mi", system.point_by_motion, step)
    return np.asarray(-np.einsum("mij,mj->mi", system.point_inverse, wanted))


def _calibration_evidence(
    system: native.ReducedFeatures, rows: native.StereoRows, inverse: Array, variance: float
) -> CalibrationEvidence:
    """Reduce the normal equations of points, motion and calibration to the calibration.

    Summed over all pairs, they determine the errors of the calibration. Points and motion are
    eliminated by Schur complements.

    Parameters
    ----------
    system
        Equations of points and motion of the m inliers, points eliminated.
    rows
        Residuals of the same features and their derivatives.
    inverse
        Inverse (6, 6) of the motion's information, unscaled, by which the motion is eliminated.
    variance
        Variance of a residual, enlarged for correlated errors, by which the result is scaled.
    """
    # Blocks of the normal equations by feature: calibration with point, and the same times the
    # inverse of the point's block, which eliminates the points from all other blocks.
    turned = rows.by_calibration.swapaxes(1, 2)
    of_point = turned @ rows.by_point
    carried = of_point @ system.point_inverse
    # Summed over the features: motion with calibration (6, 12), calibration (12, 12), its gradient.
    with_motion = (
        (turned @ rows.by_motion - carried @ system.point_by_motion.swapaxes(1, 2)).sum(axis=0).T
    )
    own = (turned @ rows.by_calibration - carried @ of_point.swapaxes(1, 2)).sum(axis=0)
    gradient = np.einsum("mri,mr->i", rows.by_calibration, rows.residual)
    gradient -= np.einsum("mij,mj->i", carried, system.point_gradient)
    return CalibrationEvidence(
        by_calibration=-inverse @ with_motion,
        information=(own - with_motion.T @ inverse @ with_motion) / variance,
        gradient=(gradient - system.gradient.sum(axis=0) @ inverse @ with_motion) / variance,
    )


def correlation_inflation(information: Array, gradient: Array, variance: float, xy: Array) -> float:
    """Estimate by what factor correlated errors of neighbouring features inflate the covariance.

    Without it, many features that share an error would look like as many measurements. Features are
    grouped by square image cells, as those of a cell may share an error. The factor is the largest
    over the cells' sizes in CELLS, at least 1.

    Parameters
    ----------
    information, gradient
        (m, k, k) and (m, k) by each feature at the solution, of the k unknowns.
    variance
        Variance of a residual at the solution.
    xy
        Positions (m, 2) of the features, ideal coordinates.
    """
    return max(
        _cluster_factor(information, gradient, variance, image_cells(xy, size)) for size in CELLS
    )


def _cluster_factor(information: Array, gradient: Array, variance: float, cell: Ints) -> float:
    """Compute the factor where features of one cell may have correlated errors [Liang1986].

    Where they are correlated (one point found at two scales, light from one side, a wrong lens),
    the square of a cell's summed gradient is larger than the sum of its features' squared
    gradients. The factor is the trace of the cluster-robust covariance, relative to the
    information, over its expectation for independent features. The expectation accounts for the
    motion having been fitted to them. cell: (m,) number of each feature's cell. Other parameters
    are those of `correlation_inflation`.
    """
    # Covariance of the unknowns over the variance, and sums of each cell's features.
    whole = np.linalg.inv(information.sum(axis=0))
    size, order = len(whole), np.argsort(cell, kind="stable")
    first = np.flatnonzero(np.diff(cell[order], prepend=-1))
    summed = np.add.reduceat(gradient[order], first)
    own = np.add.reduceat(information[order], first)
    # The share of each cell in the solution, which is the share of the cell's errors that the fit
    # absorbs.
    share = whole @ own
    expected = variance * (size - float(np.einsum("cij,cji->", share, share)))
    found = float(np.einsum("ci,ij,cj->", summed, whole, summed))
    return max(found / expected, 1.0) if expected > 0.5 * variance else 1.0


def image_cells(xy: Array, size: float) -> Ints:
    """Assign ideal coordinates (m, 2) to square cells of that size.

    Returns the numbers (m,) of the cells, column by column. A cell without features has one, too.
    """
    column, row = np.floor(xy / size).astype(np.int64).T
    row = row - row.min(initial=0)
    return np.asarray((column - column.min(initial=0)) * (row.max(initial=0) + 1) + row)


def _inliers(system: native.ReducedFeatures) -> Mask:
    """Select features (m,) whose cost is no outlier of chi-square.

    The cost is the squared error that is left with the feature's point at its best. The variance of
    a residual is estimated by the median feature. The limit is the quantile of chi-square at
    OUTLIER_SIGMAS, by the Wilson-Hilferty approximation.
    """
    degrees = np.maximum(system.freedom, 1)  # of freedom
    variance = float(np.median(system.cost / degrees)) / CHI2_MEDIAN
    limit = degrees * (1 - 2 / (9 * degrees) + OUTLIER_SIGMAS * np.sqrt(2 / (9 * degrees))) ** 3
    return np.asarray((system.freedom > 0) & (system.cost <= max(variance, 1e-14) * limit))
