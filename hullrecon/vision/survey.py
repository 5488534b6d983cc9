# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the cameras stood by navigation's word, how well two nodes' relative pose is known, and how far the scene was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hullrecon.dive.records import Returns, Trajectory
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.poses import tray as tray_pose
from hullrecon.vision.transfer import Motion
from hullrecon.vision.views import DepthPrior

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
# What the difference of two nodes' covariances does not hold: errors that are white from node to node.
WHITE_TRANSLATION_M = 0.01
WHITE_ROTATION_RAD = np.radians(0.2)


@dataclass(frozen=True)
class Survey:
    """global_from_camera: T_g_ct by node (of the bottom camera where that leads). covariance (n, 6, 6): of (translation in g,
    rotation perturbed on the right in the camera), accumulated along the dive. jitter (n, 3): variance of the rotation about
    the camera's axes that is new at each node (servo)."""

    global_from_camera: Poses
    covariance: Array
    jitter: Array

    def __len__(self) -> int:
        return len(self.global_from_camera)

    def motion(self, first: int, second: int) -> Motion:
        """second_from_first of the cameras with the covariance of that relative pose.

        Dead reckoning's error only grows, so what two nodes do not share is the difference of their covariances.
        """
        a, b = self.global_from_camera[first], self.global_from_camera[second]
        relative = (b.inverse() @ a).matrix()[0]
        gained = _positive(self.covariance[second] - self.covariance[first])
        rotation_b = b.rotation.as_matrix()[0]
        out = np.zeros((6, 6))
        out[:3, :3] = rotation_b.T @ gained[:3, :3] @ rotation_b + np.eye(3) * WHITE_TRANSLATION_M**2
        turn = relative[:3, :3]
        white = np.diag(self.jitter[first]) + turn.T @ np.diag(self.jitter[second]) @ turn
        out[3:, 3:] = gained[3:, 3:] + white + np.eye(3) * WHITE_ROTATION_RAD**2
        return Motion(relative, out)


def survey_of(
    trajectory: Trajectory, tray_origin_m: ArrayLike, tray_from_top: Poses, top_from_bottom: Poses | None, tray_sigma_rad: float
) -> Survey:
    """The leading camera of every node: the top one, or the bottom one at nodes that have no top image."""
    tray = tray_pose(tray_origin_m, trajectory.tray)
    vehicle_from_camera = tray @ tray_from_top
    if top_from_bottom is not None:
        lower = (trajectory.image[:, 0] < 0) & (trajectory.image[:, 1] >= 0)
        bottom = vehicle_from_camera @ top_from_bottom
        vehicle_from_camera = Poses(
            np.where(lower[:, None], bottom.quaternion, vehicle_from_camera.quaternion),
            np.where(lower[:, None], bottom.translation, vehicle_from_camera.translation),
        )
    turn = vehicle_from_camera.rotation.as_matrix()
    covariance = np.zeros((len(trajectory.t_ns), 6, 6))
    covariance[:, :3, :3] = trajectory.covariance[:, :3, :3]
    covariance[:, 3:, 3:] = turn.swapaxes(1, 2) @ trajectory.covariance[:, 3:, 3:] @ turn
    axis = turn[:, 1, :]  # the servo turns about the vehicle's y
    return Survey(trajectory.poses() @ vehicle_from_camera, covariance, (axis * tray_sigma_rad) ** 2)


def depth_priors(
    survey: Survey, trajectory: Trajectory, returns: Returns, tray_origin_m: ArrayLike, tray_from_dvl: Poses, margin: float
) -> list[DepthPrior | None]:
    """Depth along each camera's axis from the unflagged returns of the node and its neighbours; None where there are none."""
    good = ~returns.flagged & np.isfinite(returns.range_m)
    node = returns.node[good]
    at_ping = trajectory.poses()[node] @ Poses(returns.quaternion[good], returns.translation[good])
    tray = tray_pose(tray_origin_m, trajectory.tray[node] + returns.tray_offset[good])
    points = (at_ping @ tray @ tray_from_dvl).apply(returns.beam[good] * returns.range_m[good][:, None])
    order = np.argsort(node, kind="stable")
    points, node = points[order], node[order]
    window = 4  # nodes to either side: some seconds, a footprint's width
    start = np.searchsorted(node, np.arange(len(survey)) - window)
    stop = np.searchsorted(node, np.arange(len(survey)) + window, side="right")
    camera_from_global = survey.global_from_camera.inverse()
    return [_prior(camera_from_global[k].apply(points[a:b])[:, 2], margin) if b > a else None
            for k, (a, b) in enumerate(zip(start, stop, strict=True))]  # fmt: skip


def _prior(depth: Array, margin: float) -> DepthPrior | None:
    ahead = depth[depth > 0.05]
    if len(ahead) == 0:
        return None
    middle = float(np.median(ahead))
    low, high = np.percentile(ahead, [2, 98])
    sigma = max(0.15 * middle, 0.5 * float(high - low))
    return DepthPrior(middle, sigma, float(low) / margin, float(high) * margin)


def _positive(matrix: Array) -> Array:
    """The symmetric matrix with its eigenvalues made positive: of a difference only the size counts."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return np.asarray((vectors * np.abs(values)) @ vectors.T)
