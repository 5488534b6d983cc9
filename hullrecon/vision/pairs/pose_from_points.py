# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Relative pose of two stereo nodes: 3-point RANSAC on their points, then Levenberg-Marquardt.

Residuals are reprojection errors in ideal coordinates, and tolerances come divided by the focal
length. [Ozog2016 D.2.3] has residuals in metres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.typing import Array, Mask

BLOCK = 128  # RANSAC hypotheses computed at a time
ITERATIONS = 12  # of Levenberg-Marquardt
SMALLEST_STEP = 1e-7  # m, rad: far below the sigma of a pair's motion
MISSED = 1e-4  # probability that RANSAC draws no triple of inliers


@dataclass(frozen=True, kw_only=True)
class ObservedPoints:
    """Points of one node as a camera of another node saw them."""

    points: Array  # (n, 3) in the leading camera of the node that triangulated them, m
    xy: Array  # (n, 2) observations in the other node's camera, ideal coordinates, NaN if not seen
    camera_from_node: Array  # (4, 4) observing camera from the leading camera of its node
    backward: bool  # the points are the second node's: the inverse of second_from_first moves them
    baseline_m: float  # of the rig that triangulated the points, for their uncertainty in depth


def ransac(
    first: Array,
    second: Array,
    views: list[ObservedPoints],
    tolerance: float,
    most_trials: int,
    seed: tuple[int, ...],
) -> Array | None:
    """Find second_from_first of least truncated squared error by RANSAC on triples of points.

    It is (4, 4), a first guess for `refine`. Trials come in blocks, until a triple of
    inliers has been drawn with the probability 1 - MISSED. None with fewer than three points.

    Parameters
    ----------
    first, second
        The same points (n, 3) triangulated by both nodes.
    views
        Observations by whose reprojection errors a motion is scored.
    tolerance
        Largest error of an inlier, ideal coordinates.
    most_trials
        Trials at most.
    seed
        Seeds the random draws, so that a pair always gives the same result.
    """
    if len(first) < 3:
        return None
    rng = np.random.default_rng(seed)
    best, least, spent, needed = np.eye(4), np.inf, 0, float(most_trials)
    while spent < min(needed, most_trials):
        # A triple that repeats a point fits nothing and loses.
        triple = rng.integers(len(first), size=(BLOCK, 3))
        motions = fit_rigid(first[triple], second[triple]).matrix()
        error = sum(np.minimum(squared_errors(motions, s), tolerance**2).sum(axis=1) for s in views)
        k = int(np.argmin(error))
        if error[k] < least:
            best, least = motions[k], float(error[k])
            needed = _trials_needed(_inlier_share(best, views, tolerance))
        spent += BLOCK
    return np.asarray(best)


def _inlier_share(motion: Array, views: list[ObservedPoints], tolerance: float) -> float:
    """Compute the share of observations that are inliers of second_from_first, 0 without any."""
    seen = sum(int(np.isfinite(s.xy[:, 0]).sum()) for s in views)
    good = sum(int(rows.sum()) for rows in _inliers(motion, views, tolerance))
    return good / max(seen, 1)


def _trials_needed(share: float) -> float:
    """Compute the trials after which a triple of inliers was drawn with 1 - MISSED."""
    hit = min(share, 0.999999) ** 3  # below 1, so that its logarithm is finite
    return float(np.log(MISSED) / np.log1p(-hit)) if hit > 0 else np.inf


def squared_errors(motions: Array, view: ObservedPoints) -> Array:
    """Compute squared reprojection errors (s, n) under each motion second_from_first (s, 4, 4).

    They are in squared ideal coordinates, infinite behind the camera, 0 where not seen.
    """
    # From the node that triangulated the points to the one that observed them
    moved = np.linalg.inv(motions) if view.backward else motions
    return native.squared_reprojections(view.camera_from_node @ moved, view.points, view.xy)


def refine(motion: Array, views: list[ObservedPoints], tolerance: float) -> tuple[Array, Array]:
    """Minimise the inliers' reprojection errors in units of their sigma, by Levenberg-Marquardt.

    Inliers are chosen again in the first half of the iterations, then held. tolerance: largest
    error of an inlier, ideal coordinates.

    Returns
    -------
    motion
        second_from_first (4, 4).
    covariance
        (6, 6) as Motion defines it, scaled by the residuals.
    """
    # Not geometry.pose_solver, which refuses steps that raise the cost: a change of the inliers may
    # raise it.
    damping = 1e-6
    inlier = _inliers(motion, views, tolerance)
    normal, gradient, cost = _normal_equations(motion, views, inlier)
    for k in range(ITERATIONS):
        if 0 < k < ITERATIONS // 2:
            before, inlier = inlier, _inliers(motion, views, tolerance)
            if any(not np.array_equal(*pair) for pair in zip(before, inlier, strict=True)):
                normal, gradient, cost = _normal_equations(motion, views, inlier)
        step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient)
        trial = apply_step(motion, np.asarray(step))
        after = _normal_equations(trial, views, inlier)
        better = after[2] <= cost
        if better:
            motion, (normal, gradient, cost) = trial, after
        damping *= 0.1 if better else 100
        if better and np.abs(step).max() < SMALLEST_STEP:
            break
    degrees_of_freedom = max(1, 2 * sum(int(rows.sum()) for rows in inlier) - 6)
    return motion, np.asarray(np.linalg.pinv(normal, hermitian=True) * (cost / degrees_of_freedom))


def _inliers(motion: Array, views: list[ObservedPoints], tolerance: float) -> list[Mask]:
    """Select in each view the points (n,) that were seen where the motion puts them."""
    return [
        np.isfinite(v.xy[:, 0]) & (squared_errors(motion[None], v)[0] < tolerance**2) for v in views
    ]


def _normal_equations(
    motion: Array, views: list[ObservedPoints], inlier: list[Mask]
) -> tuple[Array, Array, float]:
    """Sum normal matrix (6, 6), gradient (6,) and squared error of the inliers of all views.

    motion: second_from_first (4, 4). inlier: a mask for each view. Each is weighted by the sigma of
    observation and triangulated point: a depth z errs by z^2 sqrt(2) / baseline for each unit of
    error in the image. Without these weights, the motion between distant nodes is biased.
    """
    normal, gradient, cost = np.zeros((6, 6)), np.zeros(6), 0.0
    for v, rows in zip(views, inlier, strict=True):
        more = native.normal_of_reprojections(
            motion, v.points, v.xy, v.camera_from_node, v.backward, v.baseline_m, rows
        )
        normal, gradient, cost = normal + more[0], gradient + more[1], cost + more[2]
    return normal, gradient, cost


def apply_step(motion: Array, step: Array) -> Array:
    """Move a motion (4, 4) by a step (6,): its translation, and a turn on the right."""
    out = motion.copy()
    out[:3, 3] += step[:3]
    out[:3, :3] = motion[:3, :3] @ Rotation.from_rotvec(step[3:]).as_matrix()
    return out


def hide_unknown_points(view: ObservedPoints) -> ObservedPoints:
    """Mark rows that lack a point as not seen, so that no residual counts them."""
    unknown = np.isnan(view.points[:, 0])[:, None]
    return replace(
        view,
        points=np.where(unknown, 0.0, view.points),
        xy=np.where(unknown, np.nan, view.xy),
    )


def resect(points: Array, xy: Array, tolerance: float, trials: int) -> Array | None:
    """Find the motion (4, 4), camera_from_points, of a camera that saw known points, by P3P RANSAC.

    It serves where only one of two nodes has triangulated points. None with fewer than four points,
    or where no motion fits.

    points: (n, 3) m. xy: (n, 2) where the camera saw them, ideal coordinates. tolerance: largest
    error of an inlier, ideal coordinates. trials: of RANSAC at most.
    """
    import cv2

    if len(points) < 4:
        return None
    found, turn, shift, inlier = cv2.solvePnPRansac(
        points,
        xy,
        np.eye(3),
        None,
        iterationsCount=trials,
        reprojectionError=tolerance,
        confidence=0.9999,
        flags=cv2.SOLVEPNP_AP3P,
    )
    if not found or inlier is None:
        return None
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = Rotation.from_rotvec(turn.ravel()).as_matrix(), shift.ravel()
    return out
