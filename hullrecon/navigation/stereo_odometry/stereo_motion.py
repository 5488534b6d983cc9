# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The motion between two stereo pairs: points of the first seen again in the second [Ozog2016 D.2.3].

Samples of three, the residual in pixels; then features are sought again where the motion says, and all are adjusted together
with the points' own covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses, exp
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.navigation.stereo_odometry.stereo_frame import Features, StereoFrame, StereoRig, mutual_best, pinhole_derivative
from hullrecon.typing import Array, Mask

CHI2_99 = 9.21  # two degrees of freedom
GUIDED_PX = 12.0
GOOD_PX = 4.0


@dataclass(frozen=True)
class StereoMotion:
    """T_i_j of camera_top, one pose; covariance (6, 6) of (translation in i, rotation perturbed right); features agreeing."""

    pose: Poses
    covariance: Array
    inliers: int


@dataclass(frozen=True)
class Sightings:
    """Points (m, 3) of frame i with covariance, where camera `T_ct_c` of frame j saw them: ideal (m, 2), focal length px."""

    point: Array
    covariance: Array
    ideal: Array
    T_ct_c: Poses
    focal_px: float


def stereo_motion(i: StereoFrame, j: StereoFrame, rig: StereoRig, least_inliers: int) -> StereoMotion | None:
    """T_i_j, or None where too few features agree on one."""
    match = mutual_best(i.top.descriptor[i.rows[:, 0]], j.top.descriptor)
    start = _three_point(i.point[match[:, 0]], j.top.ideal[match[:, 1]], GOOD_PX * rig.sigma_px / rig.top.fx)
    if start is None:
        return None
    found = None
    for radius_px in (2 * GUIDED_PX, GUIDED_PX):
        sightings = [
            _seen_again(i, 0, j.top, start, Poses(np.array([[0.0, 0, 0, 1]]), np.zeros((1, 3))), rig.top.fx, radius_px),
            _seen_again(i, 1, j.bottom, start, rig.T_ct_cb, rig.bottom.fx, radius_px),
        ]
        found = _adjusted(sightings, start, rig.sigma_px)
        if found is None or found.inliers < least_inliers:
            return None
        start = found.pose.inverse()
    return found


def _three_point(points: Array, ideal: Array, reach: float) -> Poses | None:
    """T_j_i by RANSAC over samples of three points and a fourth that chooses among their solutions."""
    import cv2

    if len(points) < 6:
        return None
    done, turn, shift, inliers = cv2.solvePnPRansac(
        points,
        ideal,
        np.eye(3),
        None,
        iterationsCount=5000,
        reprojectionError=reach,
        confidence=0.9999,
        flags=cv2.SOLVEPNP_AP3P,
    )
    if not done or inliers is None or len(inliers) < 6:
        return None
    return exp(np.concatenate([shift.ravel(), turn.ravel()])[None])


def _seen_again(
    i: StereoFrame, side: int, features: Features, T_j_i: Poses, T_ct_c: Poses, focal_px: float, radius_px: float
) -> Sightings:
    """Points of frame i matched to features of one image of frame j within a radius of where they should be."""
    there = T_ct_c.inverse().apply(T_j_i.apply(i.point))
    expected = there[:, :2] / np.where(there[:, 2:] > 0, there[:, 2:], np.nan)
    near = _within(expected, features.ideal, radius_px / focal_px)
    own = (i.top, i.bottom)[side].descriptor[i.rows[:, side]]
    match = mutual_best(own, features.descriptor, lambda rows: near[rows])
    row = match[:, 0]
    return Sightings(i.point[row], i.covariance[row], features.ideal[match[:, 1]], T_ct_c, focal_px)


def _within(a: Array, b: Array, reach: float) -> Mask:
    """(n, m): whether points of the plane are nearer than that; never where one is NaN. By trees, since few pairs are."""
    from scipy.spatial import KDTree

    out = np.zeros((len(a), len(b)), bool)
    known = np.flatnonzero(np.isfinite(a).all(axis=1))
    if len(known) and len(b):
        pairs = KDTree(a[known]).sparse_distance_matrix(KDTree(b), reach, output_type="ndarray")
        out[known[pairs["i"]], pairs["j"]] = True
    return out


def _adjusted(sightings: list[Sightings], T_j_i: Poses, sigma_px: float, rounds: int = 15) -> StereoMotion | None:
    """Gauss-Newton over both images with Cauchy weights; T_i_j and its covariance from the agreeing sightings."""
    pose = T_j_i
    for _ in range(rounds):
        pieces = [_linearised(s, pose, sigma_px) for s in sightings]
        J, r = np.concatenate([p[0] for p in pieces]), np.concatenate([p[1] for p in pieces])
        chi2 = (r**2).sum(axis=1)
        weight = 1 / (1 + chi2 / CHI2_99)
        H = np.einsum("nki,nkj,n->ij", J, J, weight)
        if len(J) < 6 or np.linalg.cond(H) > 1e14:
            return None
        step = -np.linalg.solve(H, np.einsum("nki,nk,n->i", J, r, weight))
        pose = Poses((pose.rotation * exp(step[None]).rotation).as_quat(), pose.translation + step[:3])
    good = chi2 < CHI2_99
    if good.sum() < 6:
        return None
    spread = max(1.0, float(np.sum(chi2[good]) / max(1, 2 * good.sum() - 6)))
    inverse = np.linalg.inv(np.einsum("nki,nkj->ij", J[good], J[good])) * spread
    return StereoMotion(pose.inverse(), _of_inverse(pose, inverse), int(good.sum()))


def _linearised(s: Sightings, T_j_i: Poses, sigma_px: float) -> tuple[Array, Array]:
    """Whitened derivative (n, 2, 6) by (translation, right-perturbed rotation) of T_j_i, and residual (n, 2)."""
    R, from_top = T_j_i.rotation.as_matrix()[0], s.T_ct_c.inverse()
    camera = from_top.rotation.as_matrix()[0]
    there = from_top.apply(T_j_i.apply(s.point))
    there[:, 2] = np.maximum(there[:, 2], 1e-3)
    by_point = pinhole_derivative(there) @ camera
    residual = there[:, :2] / there[:, 2:] - s.ideal
    by_own = by_point @ R
    noise = by_own @ s.covariance @ np.swapaxes(by_own, 1, 2) + (sigma_px / s.focal_px) ** 2 * np.eye(2)
    white = np.linalg.inv(np.linalg.cholesky(noise))
    J = np.concatenate([by_point, -by_point @ R @ cross_matrix(s.point)], axis=2)
    return white @ J, np.einsum("nij,nj->ni", white, residual)


def _of_inverse(T_j_i: Poses, covariance: Array) -> Array:
    """Covariance of T_i_j from that of T_j_i: t' = -R' t, so dt' = -R' dt + [t']x dw... with R' = Exp(-w) R_j_i'."""
    back = T_j_i.rotation.inv().as_matrix()[0]
    inverse = T_j_i.inverse()
    J = np.zeros((6, 6))
    J[:3, :3] = -back
    J[:3, 3:] = cross_matrix(inverse.translation)[0]
    J[3:, 3:] = -T_j_i.rotation.as_matrix()[0]
    return J @ covariance @ J.T
