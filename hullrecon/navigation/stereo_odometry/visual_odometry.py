# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stereo visual odometry: the path of a dive without a DVL, pair by pair.

Here a pair is a stereo pair, the images of both cameras at one time, and a step is the motion from
one pair to the next.

The path begins at the first pair. Attitude and depth there are those of IMU and pressure sensor.
Without these the vehicle is taken to be level and at the surface, and a remark says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, identity
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.navigation.dead_reckoning.error_propagation import twist_by_pose_error
from hullrecon.navigation.stereo_odometry.pair_motion import (
    CalibrationEffect,
    Frame,
    PairMotion,
    StereoMotion,
)
from hullrecon.records.trajectory import TrajectoryErrorModel
from hullrecon.typing import Array, Ints

LOOK_BACK = 3  # previous pairs from which a motion is measured, the nearest first
LEAST_VARIANCE = 1e-10  # m2, rad2: keeps the covariance of the first pose invertible
LOST_SIGMA_M, LOST_SIGMA_RAD = 0.5, 0.2  # sigmas of a guessed step of usual duration
LOST_M_S, LOST_RAD_S = 0.2, 0.05  # growth of these sigmas per second of longer duration
# largest of these sigmas: with it, the parts of the path on either side are practically independent
MOST_LOST_M, MOST_LOST_RAD = 10.0, 1.0


@dataclass(frozen=True, kw_only=True)
class StereoChain:
    """Steps of the top camera between neighbouring pairs (n - 1)."""

    step: Poses  # first_from_second
    # (n - 1, 6, 6) white, of (translation in first, rotation perturbed on the right)
    covariance: Array
    by_calibration: Array  # (n - 1, 6, k) derivative by the errors of the calibration
    evidence: list[CalibrationEffect]  # of each measured step, how its features show these errors
    inliers: Ints  # (n - 1,) features that agree on each step, 0 where it was guessed
    lost: Ints  # (k,) rows of steps that were guessed


@dataclass(frozen=True, kw_only=True)
class StepGuess:
    """Guesses steps that images do not show.

    The velocity of the previous step is kept, with a sigma that grows with the duration. The turn
    is the IMU's where there is one.
    """

    t_s: Array  # (n,) of the pairs
    camera: Rotation | None = None  # global_from_top (n) by the IMU, None without one
    turn_variance: Array | None = None  # (n - 1,) rad2 of its turns

    def motion(self, k: int, steps: Sequence[StereoMotion]) -> StereoMotion:
        """Guess the top camera's motion from pair k to the next (first_from_second).

        Without an earlier step the camera is taken to stand still. The calibration has no part in a
        guess, so that its derivatives are empty.

        steps: the motions between all pairs before.
        """
        duration_s = np.diff(self.t_s)
        # The longer the images show nothing, the less the camera keeps its motion: the sigmas grow
        # with the time beyond the usual step.
        longer_s = max(float(duration_s[k] - np.median(duration_s)), 0.0)
        before = steps[-1].pose if steps else identity()
        # the previous step, stretched to the duration of this one
        translation = before.translation * (duration_s[k] / duration_s[k - 1] if steps else 1.0)
        sigma_rad = min(LOST_SIGMA_RAD + LOST_RAD_S * longer_s, MOST_LOST_RAD)
        quaternion = before.quaternion  # of the previous step, or the turn that the IMU measured
        if self.camera is not None and self.turn_variance is not None:
            quaternion = (self.camera[k].inv() * self.camera[k + 1]).as_quat()[None]
            sigma_rad = min(float(np.sqrt(self.turn_variance[k])), sigma_rad)
        sigma = np.repeat([min(LOST_SIGMA_M + LOST_M_S * longer_s, MOST_LOST_M), sigma_rad], 3)
        none = CalibrationEffect(
            by_error=np.zeros((6, 0)), information=np.zeros((0, 0)), gradient=np.zeros(0)
        )
        pose = Poses(quaternion, translation)
        return StereoMotion(pose=pose, covariance=np.diag(sigma**2), inliers=0, calibration=none)


def measure_steps(
    images: Sequence[tuple[int, int]],
    motion: PairMotion[Frame],
    guess: StepGuess,
    progress: Callable[[Sequence[int]], Iterable[int]],
) -> StereoChain:
    """Measure the steps between neighbouring stereo pairs.

    A step that cannot be measured from the previous pair is measured from an earlier one, else
    guessed, so that the chain has no gap (`StereoChain.lost` lists the guesses). Each pair is read
    once.

    Parameters
    ----------
    images
        Rows of each pair in the indices of the top and the bottom camera, in time order.
    motion
        Reads pairs, and measures the motion between two of them.
    guess
        Guesses steps that cannot be measured.
    progress
        Shows how many pairs were read.
    """
    recent: list[Frame] = []
    steps: list[StereoMotion] = []
    lost = []
    for j in progress(range(len(images))):
        new = motion.frame(*images[j])
        if recent:
            found = _measure_from_recent(recent, new, steps, motion)
            if found is None:
                lost.append(j - 1)
                found = guess.motion(j - 1, steps)
            steps.append(found)
        recent = [*recent, new][-LOOK_BACK:]
    return StereoChain(
        step=Poses(
            np.vstack([s.pose.quaternion for s in steps]).reshape(-1, 4),
            np.vstack([s.pose.translation for s in steps]).reshape(-1, 3),
        ),
        covariance=np.stack([s.covariance for s in steps]),
        by_calibration=_stack_effects(steps),
        evidence=[s.calibration for s in steps if s.inliers],
        inliers=np.array([s.inliers for s in steps]),
        lost=np.array(lost, np.int64),
    )


def _measure_from_recent(
    recent: Sequence[Frame], new: Frame, steps: Sequence[StereoMotion], motion: PairMotion[Frame]
) -> StereoMotion | None:
    """Measure the step from the last pair to the new one.

    Where that fails, the motion from an older pair is measured, and the steps between that pair and
    the last one, some of which may be guesses, are taken off. None where no recent pair shows it.

    recent: the last pairs, the newest at the end. steps: motions between all pairs so far.
    """
    for back in range(1, len(recent) + 1):
        found = motion.between(recent[-back], new)
        if found is None:
            continue
        for between in steps[len(steps) - back + 1 :]:
            found = _remaining_motion(between, found)
        return found
    return None


def _remaining_motion(first: StereoMotion, whole: StereoMotion) -> StereoMotion:
    """Compute first^-1 whole: what remains of a motion after its first part.

    With it a step is got from a motion that was measured over several steps. Covariances and
    derivatives of both are propagated to it.
    """
    rest = first.pose.inverse() @ whole.pose
    # derivatives (translation, rotation on the right) of the rest by the whole and by the first
    back = first.pose.rotation.inv().as_matrix()[0]
    of_whole = np.eye(6)
    of_whole[:3, :3] = back
    of_first = np.zeros((6, 6))
    of_first[:3, :3] = -back
    of_first[:3, 3:] = cross_matrix(rest.translation)[0]
    of_first[3:, 3:] = -rest.rotation.inv().as_matrix()[0]
    by_error = of_whole @ whole.calibration.by_error
    if first.inliers:  # a guess knows nothing of the calibration
        by_error = by_error + of_first @ first.calibration.by_error
    return replace(
        whole,
        pose=rest,
        covariance=of_whole @ whole.covariance @ of_whole.T
        + of_first @ first.covariance @ of_first.T,
        calibration=replace(whole.calibration, by_error=by_error),
    )


def _stack_effects(steps: Sequence[StereoMotion]) -> Array:
    """Stack the derivatives (n - 1, 6, k) by the calibration's errors. Zero for guessed steps."""
    count = max(s.calibration.by_error.shape[1] for s in steps)
    return np.stack([s.calibration.by_error if s.inliers else np.zeros((6, count)) for s in steps])


def in_vehicle(chain: StereoChain, vehicle_from_top: Poses) -> tuple[Poses, Array, Array]:
    """Convert the steps of the top camera to those of the vehicle.

    The camera moves relative to the vehicle where the tray turns.

    vehicle_from_top (n): at each pair.

    Returns
    -------
    tuple
        Steps of the vehicle (first_from_second), their white covariance (n - 1, 6, 6), and their
        derivatives (n - 1, 6, k) by the calibration's errors.
    """
    before, after = (
        vehicle_from_top[np.arange(len(chain.step))],
        vehicle_from_top[np.arange(1, len(chain.step) + 1)],
    )
    step = before @ chain.step @ after.inverse()
    # of the vehicle's step by the camera's; a turn of the camera also swings the lever arm
    jacobian = np.zeros((len(step), 6, 6))
    lever = after.inverse().translation
    jacobian[:, :3, :3] = before.rotation.as_matrix()
    jacobian[:, :3, 3:] = -(before.rotation * chain.step.rotation).as_matrix() @ cross_matrix(lever)
    jacobian[:, 3:, 3:] = after.rotation.as_matrix()
    return (
        step,
        jacobian @ chain.covariance @ np.swapaxes(jacobian, 1, 2),
        jacobian @ chain.by_calibration,
    )


def compose(start: Poses, step: Poses) -> Poses:
    """Chain T_g_v (n) at every node from the first pose and the steps (n - 1) of the vehicle."""
    found = [start]
    for k in range(len(step)):
        found.append(found[-1] @ step[k])
    return Poses(
        np.vstack([p.quaternion for p in found]), np.vstack([p.translation for p in found])
    )


def chain_errors(
    path: Poses, covariance: Array, by_calibration: Array, calibration: Array
) -> TrajectoryErrorModel:
    """Propagate the errors of steps to the poses of a path, relative to its first pose.

    Written as twists about the origin of g, the errors of the steps simply add up:
    omega = R_j w, rho = R_i t + p_j x omega.

    Parameters
    ----------
    path
        global_from_vehicle (n).
    covariance
        White covariance (n - 1, 6, 6) of the steps.
    by_calibration
        Derivatives (n - 1, 6, k) of the steps by the calibration's errors.
    calibration
        Covariance (k, k) of these errors.
    """
    rotation, p = path.rotation.as_matrix(), path.translation
    to_twist = np.zeros((len(rotation) - 1, 6, 6))
    to_twist[:, 3:, 3:] = rotation[1:]
    to_twist[:, :3, :3] = rotation[:-1]
    to_twist[:, :3, 3:] = cross_matrix(p[1:]) @ rotation[1:]
    steps = to_twist @ covariance @ np.swapaxes(to_twist, 1, 2)
    at_node = twist_by_pose_error(path)
    # The derivative is that of the measured motion. The true motion is without it, hence the minus.
    by_error = -np.cumsum(to_twist @ by_calibration, axis=0)
    return TrajectoryErrorModel(
        by_error=np.concatenate([np.zeros((1, *by_error.shape[1:])), by_error]),
        error_covariance=calibration,
        walk=np.concatenate([np.zeros((1, 6, 6)), np.cumsum(steps, axis=0)]),
        white=LEAST_VARIANCE * at_node @ np.swapaxes(at_node, 1, 2),
    )
