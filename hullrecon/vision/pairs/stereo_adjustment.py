# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The motion between two stereo nodes by bundle adjustment of both, with its covariance.

Points are eliminated. A feature seen by both cameras of both nodes has eight coordinates and three
unknowns, which leaves five for the motion. Counted as eight, as if triangulated points were known,
the covariance is four times too small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon import native
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.pose_from_points import apply_step

ITERATIONS = 3
LEAST = 6  # features of a motion
CHI2_MEDIAN = 0.87  # median of chi-square over its five degrees of freedom
OUTLIER_SIGMAS = 3.9  # of a feature's whole residual: 0.9999 of a Gaussian's
# Sizes of cells whose features may err together, ideal coordinates: nearer ones share blur, light
# and relief, or what the lens's model lacks.
CELLS = (0.1, 0.25)
FIELD = 0.5  # ideal coordinates: half the width of a common image
DISPARITY = 6  # unknowns of the disparity over the image, after those of the rig


@dataclass(frozen=True, kw_only=True)
class NodeObservations:
    """Features of one node."""

    lead: Array  # (m, 2) in its leading camera, ideal coordinates
    other: Array  # (m, 2) of the stereo match in the bottom camera, NaN for none
    point: Array  # (m, 3) triangulated in the leading camera, m, NaN for none

    def __getitem__(self, rows: Ints | Mask) -> NodeObservations:
        return NodeObservations(
            lead=self.lead[rows], other=self.other[rows], point=self.point[rows]
        )


@dataclass(frozen=True, kw_only=True)
class CalibrationEvidence:
    """The information of a pair of nodes on the twelve unknown errors of the dive's calibration.

    Six of top_from_bottom: (translation, rotation vector) in the top camera's axes. Six of the
    disparity, of lenses and rig together: 1, x, y, x2, xy, y2 of the place in the leading image in
    units of FIELD, ideal coordinates.
    """

    by_calibration: Array  # (6, 12) derivative of the motion by the errors
    # Information (12, 12) and gradient (12,) of them, with points and motion eliminated, residuals
    # in sigmas.
    information: Array
    gradient: Array


@dataclass(frozen=True, kw_only=True)
class AdjustedMotion:
    """A motion adjusted to features of two stereo nodes."""

    second_from_first: Array  # (4, 4)
    # (6, 6) as Motion defines it, as far as features, or cells of them, are independent
    covariance: Array
    calibration: CalibrationEvidence


def adjust_stereo_motion(
    motion: Array, first: NodeObservations, second: NodeObservations, bottom_from_top: Array
) -> AdjustedMotion | None:
    """Adjust a motion (4, 4) and the points of m features that both nodes saw.

    None where too few have a stereo point, or too few agree.
    """
    # Points start where either node triangulated them.
    known = np.isfinite(first.point[:, 0]) | np.isfinite(second.point[:, 0])
    first, second = first[known], second[known]
    if len(first.lead) < LEAST:
        return None
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

    # The covariance holds residuals that are larger than expected, and features that err together.
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
    """Compute the step of the points (m, 3) that goes with a step (6,) of the motion."""
    wanted = system.point_gradient + np.einsum("mji,j->mi", system.point_by_motion, step)
    return np.asarray(-np.einsum("mij,mj->mi", system.point_inverse, wanted))


def _calibration_evidence(
    system: native.ReducedFeatures, rows: native.StereoRows, inverse: Array, variance: float
) -> CalibrationEvidence:
    """Eliminate points and motion, given the inverse (6, 6) of the motion's information."""
    turned = rows.by_calibration.swapaxes(1, 2)
    of_point = turned @ rows.by_point
    carried = of_point @ system.point_inverse
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
    """Estimate by how much features that err together inflate the variance, at least 1.

    The larger factor of two sizes of cells.

    Parameters
    ----------
    information, gradient
        (m, k, k) and (m, k) of each feature at the solution.
    variance
        Of a residual.
    xy
        Places (m, 2) of the features, ideal coordinates.
    """
    return max(
        _cluster_factor(information, gradient, variance, image_cells(xy, size)) for size in CELLS
    )


def _cluster_factor(information: Array, gradient: Array, variance: float, cell: Ints) -> float:
    """Compute the factor where features of one cell (m,) may share errors [Liang1986].

    The gradients of a cell add up to more than their sum of squares where its features err together
    (one point found at two scales, light from one side, a wrong lens). This is the cluster-robust
    covariance, as one factor, over what independent features of that variance would leave once the
    motion is fitted to them.
    """
    whole = np.linalg.inv(information.sum(axis=0))
    size, order = len(whole), np.argsort(cell, kind="stable")
    first = np.flatnonzero(np.diff(cell[order], prepend=-1))
    summed = np.add.reduceat(gradient[order], first)
    own = np.add.reduceat(information[order], first)
    share = whole @ own
    expected = variance * (size - float(np.einsum("cij,cji->", share, share)))
    found = float(np.einsum("ci,ij,cj->", summed, whole, summed))
    return max(found / expected, 1.0) if expected > 0.5 * variance else 1.0


def image_cells(xy: Array, size: float) -> Ints:
    """Assign ideal coordinates (m, 2) to cells of that size, by number."""
    return np.asarray(
        np.unique(np.floor(xy / size), axis=0, return_inverse=True)[1], np.int64
    ).ravel()


def _inliers(system: native.ReducedFeatures) -> Mask:
    """Select features within a chi-square's tail (Wilson-Hilferty), scaled by the median one."""
    freedom = np.maximum(system.freedom, 1)
    variance = float(np.median(system.cost / freedom)) / CHI2_MEDIAN
    limit = freedom * (1 - 2 / (9 * freedom) + OUTLIER_SIGMAS * np.sqrt(2 / (9 * freedom))) ** 3
    return np.asarray((system.freedom > 0) & (system.cost <= max(variance, 1e-14) * limit))
