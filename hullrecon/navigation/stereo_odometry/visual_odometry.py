# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stereo visual odometry: the path of a dive without a DVL, pair by pair.

g begins at the first pair. With an IMU its attitude there is the IMU's, and with pressure its depth; without, the vehicle is
taken to be level and at the surface, which is said.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.navigation.dead_reckoning.error_propagation import twist_by_pose_error
from hullrecon.navigation.stereo_odometry.stereo_frame import StereoFrame, StereoRig
from hullrecon.navigation.stereo_odometry.stereo_motion import StereoMotion, stereo_motion
from hullrecon.records.trajectory import TrajectoryErrorModel
from hullrecon.typing import Array, Ints

LOOK_BACK = 3  # pairs that a motion is sought from, the nearest first
LEAST_VARIANCE = 1e-8  # m2, rad2: keeps the covariance of the first pose invertible
LOST_SIGMA_M, LOST_SIGMA_RAD = 0.5, 0.2  # of a step that no pair could tell


@dataclass(frozen=True)
class Chain:
    """Steps between neighbouring pairs, T_i_j of camera_top (n - 1); covariance (n - 1, 6, 6) of (translation in i, rotation
    perturbed on the right); inliers (n - 1,); `lost` (k,): steps that were guessed."""

    step: Poses
    covariance: Array
    inliers: Ints
    lost: Ints


def follow(
    count: int,
    frame: Callable[[int], StereoFrame],
    rig: StereoRig,
    least_inliers: int,
    progress: Callable[[Sequence[int]], object],
) -> Chain:
    """The chain of `count` pairs; `frame` gives one, each is asked for once and in order. A step that the neighbour cannot give
    is taken from one of the pairs before it, else guessed to be like the step before."""
    recent: list[StereoFrame] = []
    steps: list[StereoMotion] = []
    lost = []
    for j in progress(range(count)):  # type: ignore[attr-defined]
        new = frame(j)
        if recent:
            found = _from_recent(recent, new, steps, rig, least_inliers)
            if found is None:
                lost.append(j - 1)
                found = _guessed(steps)
            steps.append(found)
        recent = [*recent, new][-LOOK_BACK:]
    pose = Poses(
        np.vstack([s.pose.quaternion for s in steps]).reshape(-1, 4),
        np.vstack([s.pose.translation for s in steps]).reshape(-1, 3),
    )
    return Chain(pose, np.stack([s.covariance for s in steps]), np.array([s.inliers for s in steps]), np.array(lost, np.int64))


def _from_recent(
    recent: list[StereoFrame], new: StereoFrame, steps: list[StereoMotion], rig: StereoRig, least: int
) -> StereoMotion | None:
    """The step from the last pair to the new one, through an older pair when they do not see enough in common."""
    for back in range(1, len(recent) + 1):
        found = stereo_motion(recent[-back], new, rig, least)
        if found is None:
            continue
        if back == 1:
            return found
        pose, covariance = found.pose, found.covariance
        for between in steps[len(steps) - back + 1 :]:
            rest = between.pose.inverse() @ pose
            covariance = _taken_off(between, rest, covariance)
            pose = rest
        return StereoMotion(pose, covariance, found.inliers)
    return None


def _taken_off(first: StereoMotion, rest: Poses, covariance: Array) -> Array:
    """Covariance of first^-1 * whole: that of the whole, turned into the axes of the later pair, and that of the first step."""
    back = first.pose.rotation.inv().as_matrix()[0]
    of_whole = np.eye(6)
    of_whole[:3, :3] = back
    of_first = np.zeros((6, 6))
    of_first[:3, :3] = -back
    of_first[:3, 3:] = cross_matrix(rest.translation)[0]
    of_first[3:, 3:] = -rest.rotation.inv().as_matrix()[0]
    return of_whole @ covariance @ of_whole.T + of_first @ first.covariance @ of_first.T


def _guessed(steps: list[StereoMotion]) -> StereoMotion:
    pose = steps[-1].pose if steps else Poses(np.array([[0.0, 0, 0, 1]]), np.zeros((1, 3)))
    sigma = np.repeat([LOST_SIGMA_M, LOST_SIGMA_RAD], 3)
    return StereoMotion(pose, np.diag(sigma**2), 0)


def in_vehicle(chain: Chain, T_v_ct: Poses) -> tuple[Poses, Array]:
    """Steps T_i_j of the vehicle (n - 1) and their covariance, from those of the camera: T_v_ct (n,) at each pair."""
    before, after = T_v_ct[np.arange(len(chain.step))], T_v_ct[np.arange(1, len(chain.step) + 1)]
    step = before @ chain.step @ after.inverse()
    J = np.zeros((len(step), 6, 6))
    lever = after.inverse().translation
    J[:, :3, :3] = before.rotation.as_matrix()
    J[:, :3, 3:] = -(before.rotation * chain.step.rotation).as_matrix() @ cross_matrix(lever)
    J[:, 3:, 3:] = after.rotation.as_matrix()
    return step, J @ chain.covariance @ np.swapaxes(J, 1, 2)


def compose(start: Poses, step: Poses) -> Poses:
    """T_g_v at every node from the first and the steps: (n,). A chain, one after the other."""
    found = [start]
    for k in range(len(step)):
        found.append(found[-1] @ step[k])
    return Poses(np.vstack([p.quaternion for p in found]), np.vstack([p.translation for p in found]))


def chain_errors(path: Poses, covariance: Array) -> TrajectoryErrorModel:
    """Return what makes T_g_v (n,) wrong relative to the first, from the covariance (n - 1, 6, 6) of the steps.

    Written as twists about the origin of g the steps' errors simply add: omega = R_j w, rho = R_i t + p_j x omega.
    """
    R, p = path.rotation.as_matrix(), path.translation
    to_twist = np.zeros((len(R) - 1, 6, 6))
    to_twist[:, 3:, 3:] = R[1:]
    to_twist[:, :3, :3] = R[:-1]
    to_twist[:, :3, 3:] = cross_matrix(p[1:]) @ R[1:]
    steps = to_twist @ covariance @ np.swapaxes(to_twist, 1, 2)
    at_node = twist_by_pose_error(path)
    return TrajectoryErrorModel(
        by_error=np.zeros((len(R), 6, 0)),
        error_covariance=np.zeros((0, 0)),
        walk=np.concatenate([np.zeros((1, 6, 6)), np.cumsum(steps, axis=0)]),
        white=LEAST_VARIANCE * at_node @ np.swapaxes(at_node, 1, 2),
    )
