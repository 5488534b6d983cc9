# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Relative pose of two stereo nodes: 3-point RANSAC on triangulated points, residuals in pixels, then Levenberg-Marquardt.

Residuals live in ideal coordinates; tolerances arrive divided by the focal length [Ozog2016 D.2.3], which has metres.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.geometry.rotations import cross
from hullrecon.typing import Array, Mask

BLOCK = 128  # hypotheses at a time
SMALLEST_STEP = 1e-7  # m, rad: far below what a pair tells


@dataclass(frozen=True, kw_only=True)
class ObservedPoints:
    """Points (n, 3) of one node and where another node's cameras saw them: xy (n, 2), NaN where that camera did not.

    camera_from_node (4, 4): the camera in the frame that the points are moved into. backward: the motion wanted carries these
    points with its inverse. baseline_m: of the rig that triangulated the points, for their uncertainty in depth.
    """

    points: Array
    xy: Array
    camera_from_node: Array
    backward: bool
    baseline_m: float


def ransac(
    first: Array, second: Array, views: list[ObservedPoints], tolerance: float, most_trials: int, seed: tuple[int, ...]
) -> Array | None:
    """Return the best motion (4, 4) of points (n, 3) onto (n, 3) by truncated squared error of the views; None with fewer
    than 3.

    Trials come in blocks until a triple of inliers has been drawn with 99.99 % or `most_trials` are spent.
    """
    if len(first) < 3:
        return None
    rng = np.random.default_rng(seed)
    best, least, spent, needed = np.eye(4), np.inf, 0, float(most_trials)
    while spent < min(needed, most_trials):
        triple = rng.integers(len(first), size=(BLOCK, 3))  # one that repeats a point fits nothing and loses
        motions = fit_rigid(first[triple], second[triple]).matrix()
        error = sum(np.minimum(squared_errors(motions, s), tolerance**2).sum(axis=1) for s in views)
        k = int(np.argmin(error))
        if error[k] < least:
            best, least = motions[k], float(error[k])
            needed = _trials(_share(best, views, tolerance))
        spent += BLOCK
    return np.asarray(best)


def _share(motion: Array, views: list[ObservedPoints], tolerance: float) -> float:
    seen = sum(int(np.isfinite(s.xy[:, 0]).sum()) for s in views)
    good = sum(int((squared_errors(motion[None], s)[0][np.isfinite(s.xy[:, 0])] < tolerance**2).sum()) for s in views)
    return good / max(seen, 1)


def _trials(share: float) -> float:
    hit = min(share, 0.999999) ** 3
    return float(np.log(1e-4) / np.log1p(-hit)) if hit > 0 else np.inf


def squared_errors(motions: Array, view: ObservedPoints) -> Array:
    """Return (s, n): squared distance in the image under each motion (s, 4, 4); inf behind the camera, 0 where not seen."""
    way = np.linalg.inv(motions) if view.backward else motions
    total = view.camera_from_node @ way
    moved = view.points @ total[:, :3, :3].swapaxes(1, 2) + total[:, None, :3, 3]
    ahead = moved[..., 2] > 1e-6
    across, down = (moved[..., k] / np.where(ahead, moved[..., 2], 1.0) - view.xy[:, k] for k in range(2))
    squared = np.where(ahead, across * across + down * down, np.inf)
    return np.where(np.isnan(view.xy[:, 0]), 0.0, squared)


def refine(motion: Array, views: list[ObservedPoints], tolerance: float, iterations: int = 12) -> tuple[Array, Array]:
    """Return the motion (4, 4) that minimises the inliers' errors in units of their sigma, and its covariance (6, 6) as
    Motion defines it.

    Inliers are chosen again in the first half of the iterations, then held. The covariance takes its scale from the residuals.
    """
    damping = 1e-6  # not geometry.pose_solver: a change of the inliers changes the cost, by which that would refuse the step
    seen = _stack(views)
    inlier = _inlier_rows(motion, seen, tolerance)
    rows = seen.take(inlier)
    normal, gradient, cost = _normal(motion, rows)
    for k in range(iterations):
        if 0 < k < iterations // 2:
            before, inlier = inlier, _inlier_rows(motion, seen, tolerance)
            if not np.array_equal(before, inlier):
                rows = seen.take(inlier)
                normal, gradient, cost = _normal(motion, rows)
        step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient)
        trial = _apply_step(motion, np.asarray(step))
        after = _normal(trial, rows)
        better = after[2] <= cost
        if better:
            motion, (normal, gradient, cost) = trial, after
        damping *= 0.1 if better else 100
        if better and np.abs(step).max() < SMALLEST_STEP:
            break
    freedom = max(1, 2 * len(rows.points) - 6)
    return motion, np.asarray(np.linalg.pinv(normal, hermitian=True) * (cost / freedom))


@dataclass(frozen=True, kw_only=True)
class _Rows:
    """What several views saw, one row an observation, those of views that carry points forward first: points (m, 3), xy (m, 2),
    turn (m, 3, 3) and shift (m, 3) of the camera from its node, by_depth (m, 3): the points' error along their rays for a unit
    of error in the image, backward (m,)."""

    points: Array
    xy: Array
    turn: Array
    shift: Array
    by_depth: Array
    backward: Mask

    def take(self, which: Mask) -> _Rows:
        return _Rows(**{f.name: getattr(self, f.name)[which] for f in fields(self)})

    def carry(self, motion: Array) -> Array:
        """Return the points (m, 3) in the nodes that saw them."""
        rotation, translation, split = motion[:3, :3], motion[:3, 3], self.split
        return np.concatenate([self.points[:split] @ rotation.T + translation, (self.points[split:] - translation) @ rotation])

    @property
    def split(self) -> int:
        """The first row of a view that carries points backward."""
        return int(len(self.backward) - self.backward.sum())


def _stack(views: list[ObservedPoints]) -> _Rows:
    """Return what the views saw as rows.

    A triangulated depth is off by z^2 sqrt(2) / b for each unit of error in the image; unweighted, that bends wide pairs.
    """
    parts = []
    for view in sorted(views, key=lambda view: view.backward):
        points, xy = (values[np.isfinite(view.xy[:, 0])] for values in (view.points, view.xy))
        parts.append(
            _Rows(
                points=points,
                xy=xy,
                turn=np.broadcast_to(view.camera_from_node[:3, :3], (len(points), 3, 3)),
                shift=np.broadcast_to(view.camera_from_node[:3, 3], (len(points), 3)),
                by_depth=points * (np.sqrt(2) / view.baseline_m * points[:, 2:]),
                backward=np.full(len(points), view.backward),
            )
        )
    return _Rows(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(_Rows)})


def _inlier_rows(motion: Array, rows: _Rows, tolerance: float) -> Mask:
    image, depth = _project(rows.carry(motion), rows)
    gap = image - rows.xy
    return np.asarray(((gap * gap).sum(axis=1) < tolerance**2) & np.isfinite(depth))


def _project(moved: Array, rows: _Rows) -> tuple[Array, Array]:
    """Return where the cameras see points (m, 3) of their nodes (m, 2), and their depths (m,), inf behind the camera."""
    seen = np.einsum("nij,nj->ni", rows.turn, moved) + rows.shift
    depth = np.where(seen[:, 2] > 1e-6, seen[:, 2], np.inf)
    return seen[:, :2] / depth[:, None], depth


def _apply_step(motion: Array, step: Array) -> Array:
    out = motion.copy()
    out[:3, 3] += step[:3]
    out[:3, :3] = motion[:3, :3] @ Rotation.from_rotvec(step[3:]).as_matrix()
    return out


def _normal(motion: Array, rows: _Rows) -> tuple[Array, Array, float]:
    """Return normal matrix (6, 6), gradient (6,) and summed squared error."""
    residual, jacobian = _linearise(motion, rows)
    flat, left = jacobian.reshape(-1, 6), residual.ravel()
    return np.asarray(flat.T @ flat), np.asarray(flat.T @ left), float(left @ left)


def _linearise(motion: Array, rows: _Rows) -> tuple[Array, Array]:
    """Return whitened residuals (m, 2) and Jacobian (m, 2, 6).

    By t the image moves as by the point carried forward, by -R^T of it backward; by w on the right as p x b R forward, b x Y
    backward, where b (2, 3) is the derivative by the point carried, p the point and Y = R^T (p - t).
    """
    rotation, split = motion[:3, :3], rows.split
    moved = rows.carry(motion)
    image, depth = _project(moved, rows)
    by_moved = (rows.turn[:, :2] - image[:, :, None] * rows.turn[:, 2:]) / depth[:, None, None]
    by_point = np.concatenate([by_moved[:split] @ rotation, by_moved[split:] @ rotation.T])
    jacobian = np.empty((len(moved), 2, 6))
    jacobian[:split, :, :3], jacobian[split:, :, :3] = by_moved[:split], -by_point[split:]
    jacobian[:split, :, 3:] = cross(rows.points[:split, None], by_point[:split])
    jacobian[split:, :, 3:] = cross(by_moved[split:], moved[split:, None])
    by_depth = np.einsum("nij,nj->ni", by_point, rows.by_depth)
    residual = image - rows.xy
    return _whiten(residual[:, :, None], by_depth)[:, :, 0], _whiten(jacobian, by_depth)


def _whiten(values: Array, u: Array) -> Array:
    """Return values (n, 2, k) times the inverse root of I + u u^T: a pixel's own error, and u (n, 2), that of the point's depth
    as seen in the image."""
    square = np.maximum((u * u).sum(axis=1), 1e-12)
    shrink = (1 - 1 / np.sqrt(1 + square)) / square
    along = np.einsum("ni,nik->nk", u, values) * shrink[:, None]
    return np.asarray(values - u[:, :, None] * along[:, None, :])


def hide_unknown_points(view: ObservedPoints) -> ObservedPoints:
    """Return the same view with rows that lack a point marked as not seen."""
    unknown = np.isnan(view.points[:, 0])
    points, xy = np.where(unknown[:, None], 0.0, view.points), np.where(unknown[:, None], np.nan, view.xy)
    return replace(view, points=points, xy=xy)


def resect(points: Array, xy: Array, tolerance: float, trials: int) -> Array | None:
    """Return the motion (4, 4) that carries points (n, 3) to a camera that saw them at ideal coordinates (n, 2): P3P in
    RANSAC."""
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
