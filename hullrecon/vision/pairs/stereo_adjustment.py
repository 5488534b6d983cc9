# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The motion between two stereo nodes by bundle adjustment of both, their points eliminated, with
the covariance that its residuals show.

A feature seen by both cameras of both nodes has eight coordinates and three unknowns: five of them
say something about the motion. Counted as eight, as if triangulated points were known, the
covariance is four times too small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.typing import Array, Ints, Mask

ITERATIONS = 3
LEAST = 6  # features
CHI2_MEDIAN = 0.87  # of chi-square over its degrees of freedom, five of them
OUTLIER_SIGMAS = 3.9  # of a feature's whole residual: 0.9999 of a Gaussian's
# ideal units, rad: features nearer than that share blur, light and relief, or what the lens's model
# lacks
CELLS = (0.1, 0.25)
FIELD = 0.5  # ideal units: half the width of a common image
DISPARITY = 6  # unknowns of the disparity over the image, after those of the rig


@dataclass(frozen=True, kw_only=True)
class NodeObservations:
    """m features of one node. lead (m, 2): ideal coordinates in its leading camera; other (m, 2):
    in the bottom camera of its stereo match, NaN where none; point (m, 3): triangulated in the
    leading camera, m, NaN where none.
    """

    lead: Array
    other: Array
    point: Array

    def __getitem__(self, rows: Ints | Mask) -> NodeObservations:
        return NodeObservations(
            lead=self.lead[rows], other=self.other[rows], point=self.point[rows]
        )


@dataclass(frozen=True, kw_only=True)
class CalibrationEvidence:
    """What one pair of nodes says of the errors of the calibration, twelve unknowns of the dive.

    The first six: an error of T_ct_cb, (translation, rotation vector) in the top camera's axes. The
    others: an error of the disparity, ideal units, as 1, x, y, x2, xy, y2 of the place in the
    leading image in units of FIELD: lenses and rig together. by_calibration (6, 12): derivative of
    the motion by them; information (12, 12), gradient (12,): of them, with points and motion
    eliminated and residuals in sigmas.
    """

    by_calibration: Array
    information: Array
    gradient: Array


@dataclass(frozen=True, kw_only=True)
class AdjustedMotion:
    """second_from_first (4, 4); covariance (6, 6) of (translation in second's axes, rotation
    perturbed on the right), as far as features are independent of each other or of other cells;
    calibration: what the cameras' calibration does to it.
    """

    second_from_first: Array
    covariance: Array
    calibration: CalibrationEvidence


def adjust_stereo_motion(
    motion: Array, first: NodeObservations, second: NodeObservations, bottom_from_top: Array
) -> AdjustedMotion | None:
    """Return the motion (4, 4) adjusted to the same m features of both nodes; None where too few
    have a stereo point, or too few agree.
    """
    known = np.isfinite(first.point[:, 0]) | np.isfinite(second.point[:, 0])
    first, second = first[known], second[known]
    if len(first.lead) < LEAST:
        return None
    back = (second.point - motion[:3, 3]) @ motion[:3, :3]
    points = np.where(np.isfinite(first.point), first.point, back)
    seen = np.hstack([first.lead, first.other, second.lead, second.other])
    # Not geometry.pose_solver: every step moves the points as well, and chooses the features anew
    # by what is left of them.
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
        motion = _apply_step(motion, step)
    system = native.reduce_stereo(motion, bottom_from_top, points, seen)
    good = _inliers(system)
    if good.sum() < LEAST:
        return None
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
    """Return how far the points (m, 3) move when the motion does by (6,)."""
    wanted = system.point_gradient + np.einsum("mji,j->mi", system.point_by_motion, step)
    return np.asarray(-np.einsum("mij,mj->mi", system.point_inverse, wanted))


def _calibration_evidence(
    system: native.ReducedFeatures, rows: native.StereoRows, inverse: Array, variance: float
) -> CalibrationEvidence:
    """Return what features say of the calibration. inverse (6, 6): of the information of the
    motion.
    """
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
    """Return by how much the variance of a motion exceeds that of independent features, at least 1.

    information (m, k, k), gradient (m, k) of each feature at the solution; xy (m, 2): where it
    lies, ideal coordinates. The larger factor of two sizes of cells.
    """
    return max(
        _cluster_factor(information, gradient, variance, image_cells(xy, size)) for size in CELLS
    )


def _cluster_factor(information: Array, gradient: Array, variance: float, cell: Ints) -> float:
    """Return the factor, at least 1, where features of one cell (m,) may share errors.

    The gradients of a cell add up to more than their sum of squares where its features err together
    (one point found at two scales, light from one side, a wrong lens): the cluster-robust
    covariance [Liang1986], as one factor, against what independent features of that variance would
    leave once the motion is fitted to them.
    """
    whole = np.linalg.inv(information.sum(axis=0))
    size, order = len(whole), np.argsort(cell, kind="stable")
    first = np.flatnonzero(np.diff(cell[order], prepend=-1))
    summed, own = (
        np.add.reduceat(gradient[order], first),
        np.add.reduceat(information[order], first),
    )
    share = whole @ own
    expected = variance * (size - float(np.einsum("cij,cji->", share, share)))
    found = float(np.einsum("ci,ij,cj->", summed, whole, summed))
    return max(found / expected, 1.0) if expected > 0.5 * variance else 1.0


def image_cells(xy: Array, size: float) -> Ints:
    """Return the number of the cell of that size in which each of the ideal coordinates (m, 2)
    lies.
    """
    return np.asarray(
        np.unique(np.floor(xy / size), axis=0, return_inverse=True)[1], np.int64
    ).ravel()


def _inliers(system: native.ReducedFeatures) -> Mask:
    """Return the features whose residuals fit to the scale of the median one. A chi-square's tail,
    by Wilson and Hilferty.
    """
    freedom = np.maximum(system.freedom, 1)
    variance = float(np.median(system.cost / freedom)) / CHI2_MEDIAN
    limit = freedom * (1 - 2 / (9 * freedom) + OUTLIER_SIGMAS * np.sqrt(2 / (9 * freedom))) ** 3
    return np.asarray((system.freedom > 0) & (system.cost <= max(variance, 1e-14) * limit))


def _apply_step(motion: Array, step: Array) -> Array:
    out = motion.copy()
    out[:3, 3] += step[:3]
    out[:3, :3] = motion[:3, :3] @ Rotation.from_rotvec(step[3:]).as_matrix()
    return out
