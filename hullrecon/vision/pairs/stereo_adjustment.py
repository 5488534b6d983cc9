# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The motion between two stereo nodes by bundle adjustment of both, their points eliminated, with the covariance that its
residuals show.

A feature seen by both cameras of both nodes has eight coordinates and three unknowns: five of them say something about the
motion. Counted as eight, as if triangulated points were known, the covariance is four times too small.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.rotations import cross
from hullrecon.typing import Array, Ints, Mask

ITERATIONS = 3
LEAST = 6  # features
CHI2_MEDIAN = 0.87  # of chi-square over its degrees of freedom, five of them
OUTLIER_SIGMAS = 3.9  # of a feature's whole residual: 0.9999 of a Gaussian's
CELLS = (0.1, 0.25)  # ideal units, rad: features nearer than that share blur, light and relief, or what the lens's model lacks
FIELD = 0.5  # ideal units: half the width of a common image
RIG, DISPARITY = 6, 6  # unknowns of the calibration: of the rig, and of the disparity over the image
POINT_DAMPING = 1e-9  # of a point's information: keeps a feature that only one camera saw from dividing by zero


@dataclass(frozen=True, kw_only=True)
class NodeObservations:
    """m features of one node. lead (m, 2): ideal coordinates in its leading camera; other (m, 2): in the bottom camera of its
    stereo match, NaN where none; point (m, 3): triangulated in the leading camera, m, NaN where none."""

    lead: Array
    other: Array
    point: Array

    def __getitem__(self, rows: Ints | Mask) -> NodeObservations:
        return NodeObservations(lead=self.lead[rows], other=self.other[rows], point=self.point[rows])


@dataclass(frozen=True, kw_only=True)
class CalibrationEvidence:
    """What one pair of nodes says of the errors of the calibration, twelve unknowns of the dive.

    The first RIG: an error of T_ct_cb, (translation, rotation vector) in the top camera's axes. The others: an error of the
    disparity, ideal units, as 1, x, y, x2, xy, y2 of the place in the leading image in units of FIELD: lenses and rig together.
    by_calibration (6, 12): derivative of the motion by them; information (12, 12), gradient (12,): of them, with points and
    motion eliminated and residuals in sigmas.
    """

    by_calibration: Array
    information: Array
    gradient: Array


@dataclass(frozen=True, kw_only=True)
class AdjustedMotion:
    """second_from_first (4, 4); covariance (6, 6) of (translation in second's axes, rotation perturbed on the right), as far as
    features are independent of each other or of other cells; calibration: what the cameras' calibration does to it."""

    second_from_first: Array
    covariance: Array
    calibration: CalibrationEvidence


def adjust_stereo_motion(
    motion: Array, first: NodeObservations, second: NodeObservations, bottom_from_top: Array
) -> AdjustedMotion | None:
    """Return the motion (4, 4) adjusted to the same m features of both nodes; None where too few have a stereo point, or too
    few agree."""
    known = np.isfinite(first.point[:, 0]) | np.isfinite(second.point[:, 0])
    first, second = first[known], second[known]
    if len(first.lead) < LEAST:
        return None
    back = (second.point - motion[:3, 3]) @ motion[:3, :3]
    points = np.where(np.isfinite(first.point), first.point, back)
    # Not geometry.pose_solver: every step moves the points as well, and chooses the features anew by what is left of them.
    for _ in range(ITERATIONS):
        system = _reduce(motion, points, first, second, bottom_from_top)
        good = _inliers(system)
        if good.sum() < LEAST:
            return None
        step = np.asarray(-np.linalg.solve(system.information[good].sum(axis=0), system.gradient[good].sum(axis=0)))
        points = points + system.point_step(step)
        motion = _apply_step(motion, step)
    system = _reduce(motion, points, first, second, bottom_from_top)
    good = _inliers(system)
    if good.sum() < LEAST:
        return None
    information = system.information[good].sum(axis=0)
    inverse = np.linalg.inv(information)
    variance = max(float(system.cost[good].sum()) / max(1, int(system.freedom[good].sum()) - 6), 1e-14)
    inflation = correlation_inflation(system.information[good], system.gradient[good], variance, first.lead[good])
    covariance = variance * inflation * inverse
    return AdjustedMotion(
        second_from_first=motion,
        covariance=covariance,
        calibration=_calibration_evidence(
            system[good],
            _linearise_calibration(motion, points, first, second, bottom_from_top)[good],
            inverse,
            variance * inflation,
        ),
    )


def _calibration_evidence(
    system: _ReducedSystem, by_calibration: Array, inverse: Array, variance: float
) -> CalibrationEvidence:
    """Return what m features say of the calibration; by_calibration (m, 8, 12): derivative of their residuals by it."""
    turned = by_calibration.swapaxes(1, 2)
    of_point = turned @ system.by_point
    carried = of_point @ system.point_inverse
    with_motion = (turned @ system.by_motion - carried @ system.point_by_motion.swapaxes(1, 2)).sum(axis=0).T
    own = (turned @ by_calibration - carried @ of_point.swapaxes(1, 2)).sum(axis=0)
    gradient = np.einsum("mri,mr->i", by_calibration, system.residual) - np.einsum("mij,mj->i", carried, system.point_gradient)
    return CalibrationEvidence(
        by_calibration=-inverse @ with_motion,
        information=(own - with_motion.T @ inverse @ with_motion) / variance,
        gradient=(gradient - system.gradient.sum(axis=0) @ inverse @ with_motion) / variance,
    )


def correlation_inflation(information: Array, gradient: Array, variance: float, xy: Array) -> float:
    """Return by how much the variance of a motion exceeds that of independent features, at least 1.

    information (m, k, k), gradient (m, k) of each feature at the solution; xy (m, 2): where it lies, ideal coordinates. The
    larger factor of two sizes of cells.
    """
    return max(_cluster_factor(information, gradient, variance, image_cells(xy, size)) for size in CELLS)


def _cluster_factor(information: Array, gradient: Array, variance: float, cell: Ints) -> float:
    """Return the factor, at least 1, where features of one cell (m,) may share errors.

    The gradients of a cell add up to more than their sum of squares where its features err together (one point found at two
    scales, light from one side, a wrong lens): the cluster-robust covariance [Liang1986], as one factor, against what
    independent features of that variance would leave once the motion is fitted to them.
    """
    whole = np.linalg.inv(information.sum(axis=0))
    count, size = int(cell.max()) + 1, len(whole)
    summed, own = np.zeros((count, size)), np.zeros((count, size, size))
    np.add.at(summed, cell, gradient)
    np.add.at(own, cell, information)
    share = whole @ own
    expected = variance * (size - float(np.einsum("cij,cji->", share, share)))
    found = float(np.einsum("ci,ij,cj->", summed, whole, summed))
    return max(found / expected, 1.0) if expected > 0.5 * variance else 1.0


def image_cells(xy: Array, size: float) -> Ints:
    """Return the number of the cell of that size in which each of the ideal coordinates (m, 2) lies."""
    return np.asarray(np.unique(np.floor(xy / size), axis=0, return_inverse=True)[1], np.int64).ravel()


@dataclass(frozen=True, kw_only=True)
class _ReducedSystem:
    """Of m features, their points eliminated: information (m, 6, 6), gradient (m, 6); cost (m,), the sum of squares at the best
    points; freedom (m,); what brings the points along with a step of the motion; and what was reduced: residual (m, 8) with its
    derivatives by the point (m, 8, 3) and the motion (m, 8, 6)."""

    information: Array
    gradient: Array
    cost: Array
    freedom: Ints
    point_inverse: Array
    point_gradient: Array
    point_by_motion: Array
    residual: Array
    by_point: Array
    by_motion: Array

    def __getitem__(self, rows: Mask) -> _ReducedSystem:
        return _ReducedSystem(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    def point_step(self, step: Array) -> Array:
        """Return how far the points (m, 3) move when the motion does by (6,)."""
        wanted = self.point_gradient + np.einsum("mji,j->mi", self.point_by_motion, step)
        return np.asarray(-np.einsum("mij,mj->mi", self.point_inverse, wanted))


def _reduce(
    motion: Array, points: Array, first: NodeObservations, second: NodeObservations, bottom_from_top: Array
) -> _ReducedSystem:
    residual, by_point, by_motion = _linearise(motion, points, first, second, bottom_from_top)
    own = by_point.swapaxes(1, 2) @ by_point
    trace = np.trace(own, axis1=1, axis2=2)
    damping = POINT_DAMPING * np.where(trace > 0, trace, 1.0)  # a point that came to lie behind every camera says nothing
    inverse = np.asarray(np.linalg.inv(own + damping[:, None, None] * np.eye(3)), float)
    gradient = np.einsum("mri,mr->mi", by_point, residual)
    there = by_motion[:, 4:]  # the first node's residuals do not move
    of_motion = there.swapaxes(1, 2) @ by_point[:, 4:]
    carried = of_motion @ inverse
    return _ReducedSystem(
        information=there.swapaxes(1, 2) @ there - carried @ of_motion.swapaxes(1, 2),
        gradient=np.einsum("mri,mr->mi", there, residual[:, 4:]) - np.einsum("mij,mj->mi", carried, gradient),
        cost=(residual**2).sum(axis=1) - np.einsum("mi,mij,mj->m", gradient, inverse, gradient),
        freedom=np.asarray((by_point != 0).any(axis=2).sum(axis=1) - 3),
        point_inverse=inverse,
        point_gradient=gradient,
        point_by_motion=of_motion,
        residual=residual,
        by_point=by_point,
        by_motion=by_motion,
    )


def _linearise(
    motion: Array, points: Array, first: NodeObservations, second: NodeObservations, bottom_from_top: Array
) -> tuple[Array, Array, Array]:
    """Return residuals (m, 8) and their derivatives by the points (m, 8, 3) and the motion (m, 8, 6); rows that were not seen
    are zero."""
    count, turn = len(points), motion[:3, :3]
    residual, by_point = np.empty((count, 4, 2)), np.empty((count, 4, 2, 3))
    by_motion = np.zeros((count, 4, 2, 6))
    for k, (seen_from_lead, camera, xy) in enumerate(_views(motion, points, first, second, bottom_from_top)):
        image, by_lead = _project(seen_from_lead, camera)
        residual[:, k] = image - xy
        by_point[:, k] = by_lead if k < 2 else by_lead @ turn
        if k >= 2:
            by_motion[:, k, :, :3] = by_lead
            by_motion[:, k, :, 3:] = cross(points[:, None], by_point[:, k])
    hidden = ~np.isfinite(residual)
    residual[hidden], by_point[hidden], by_motion[hidden] = 0, 0, 0
    return residual.reshape(count, 8), by_point.reshape(count, 8, 3), by_motion.reshape(count, 8, 6)


def _linearise_calibration(
    motion: Array, points: Array, first: NodeObservations, second: NodeObservations, bottom_from_top: Array
) -> Array:
    """Return the derivative (m, 8, 12) of the residuals by the calibration; rows that were not seen are zero."""
    count = len(points)
    out = np.zeros((count, 4, 2, RIG + DISPARITY))
    views = _views(motion, points, first, second, bottom_from_top)
    for k in (1, 3):
        seen_from_lead, camera, xy = views[k]
        image, by_lead = _project(seen_from_lead, camera)
        out[:, k, :, :3] = -by_lead
        out[:, k, :, 3:RIG] = cross(by_lead, (seen_from_lead + camera[:3, :3].T @ camera[:3, 3])[:, None])
        along = np.einsum("mij,mj->mi", by_lead, seen_from_lead)  # where a point goes that is nearer or farther
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
        out[:, k, :, RIG:] = along[:, :, None] * _disparity_field(views[k - 1][2])[:, None]
        out[:, k][~np.isfinite(image - xy)] = 0
    return out.reshape(count, 8, RIG + DISPARITY)


def _views(
    motion: Array, points: Array, first: NodeObservations, second: NodeObservations, bottom_from_top: Array
) -> tuple[tuple[Array, Array, Array], ...]:
    """Return of each camera of each node: the points in the node's leading one, its pose from that, what it saw."""
    there = points @ motion[:3, :3].T + motion[:3, 3]
    return (
        (points, np.eye(4), first.lead), (points, bottom_from_top, first.other),
        (there, np.eye(4), second.lead), (there, bottom_from_top, second.other),
    )  # fmt: skip


def _project(seen_from_lead: Array, camera: Array) -> tuple[Array, Array]:
    """Return the image (m, 2) of points (m, 3) of the leading camera in another, NaN behind it, with its derivative."""
    turn = camera[:3, :3]
    seen = seen_from_lead @ turn.T + camera[:3, 3]
    depth = np.where(seen[:, 2] > 1e-6, seen[:, 2], np.nan)
    image = seen[:, :2] / depth[:, None]
    return image, (turn[:2] - image[:, :, None] * turn[2]) / depth[:, None, None]


def _disparity_field(xy: Array) -> Array:
    """Return 1, x, y, x2, xy, y2 (m, 6) of ideal coordinates (m, 2) in units of FIELD."""
    x, y = xy.T / FIELD
    return np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], axis=1)


def _inliers(system: _ReducedSystem) -> Mask:
    """Return the features whose residuals fit to the scale of the median one. A chi-square's tail, by Wilson and Hilferty."""
    freedom = np.maximum(system.freedom, 1)
    variance = float(np.median(system.cost / freedom)) / CHI2_MEDIAN
    limit = freedom * (1 - 2 / (9 * freedom) + OUTLIER_SIGMAS * np.sqrt(2 / (9 * freedom))) ** 3
    return np.asarray((system.freedom > 0) & (system.cost <= max(variance, 1e-14) * limit))


def _apply_step(motion: Array, step: Array) -> Array:
    out = motion.copy()
    out[:3, 3] += step[:3]
    out[:3, :3] = motion[:3, :3] @ Rotation.from_rotvec(step[3:]).as_matrix()
    return out
