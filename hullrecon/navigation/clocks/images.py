# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The clocks of IMU and DVL against the cameras': how the camera turned and where it went from one
image to the next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, tray_poses
from hullrecon.navigation.clocks.time_shift import Disagreement
from hullrecon.navigation.dead_reckoning.integral import integral
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.servo import Servo
from hullrecon.navigation.sensors.velocity import Velocities
from hullrecon.records.clock import seconds
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

LEAST_MOTIONS = 10
TURN_SIGMA_RAD = 0.0015  # of the attitude's turn between two images
STEP_SIGMA_M = 0.003  # of the DVL's step
ASIDE_SIGMA_RAD = 0.02  # of the step's direction in the camera
MOUNT_SIGMA_RAD = 0.02  # of the DVL's mount to the camera's, which is found beside the shift
TRUSTED = 3.0  # sigmas; what differs by more says no more of the mount
TRAY_AXIS = np.array([0.0, 1.0, 0.0])  # of the tray's own frame


@dataclass(frozen=True, kw_only=True)
class ImageMotions:
    """What pairs of images of the upper camera, each and the next, say of its motion: their stamps
    first_ns, second_ns (m,); second_from_first, its translation of any length; sigma_rad (m, 2): of
    the turn, each axis, and of the direction.
    """

    first_ns: Ints
    second_ns: Ints
    second_from_first: Poses
    sigma_rad: Array

    def __len__(self) -> int:
        return len(self.first_ns)


def imu_beside_images(
    motions: ImageMotions, attitude: AttitudeHistory, servo: Servo, rig: Rig
) -> Disagreement | None:
    """Return how the attitude's turns, looked up at the images' stamps and a shift, differ from the
    camera's; None without any motions.

    Turns about the tray's axis are left aside, for the play of its servo looks like a clock that is
    late.
    """
    if not len(motions):
        return None
    tray_from_top = rig.tray_from(Camera.TOP).rotation
    axis = tray_from_top.inv().apply(TRAY_AXIS)
    seen = motions.second_from_first.rotation
    sigma = np.hypot(motions.sigma_rad[:, :1], TURN_SIGMA_RAD)

    def cameras(t_ns: Ints) -> Rotation:
        return (
            attitude.rotation(t_ns)
            * tray_poses(rig.tray_origin, servo.angle_at(t_ns)).rotation
            * tray_from_top
        )

    def residuals(shift_s: float) -> Array:
        shift_ns = round(shift_s * 1e9)
        first, second = (cameras(t_ns + shift_ns) for t_ns in (motions.first_ns, motions.second_ns))
        turn = (seen.inv() * second.inv() * first).as_rotvec()
        turn[_outside(motions, shift_ns, attitude.t_ns)] = np.nan
        return np.asarray((turn - (turn * axis).sum(axis=1, keepdims=True) * axis) / sigma)

    return Disagreement(
        residuals=residuals, block=np.arange(len(motions)), is_enough=len(motions) >= LEAST_MOTIONS
    )


def dvl_beside_images(
    motions: ImageMotions, velocities: Velocities, rig: Rig
) -> Disagreement | None:
    """Return how the directions of the DVL's steps, looked up at the images' stamps and a shift,
    differ from the camera's; None without any motions.

    Both sit on the tray, so that no attitude is needed, and what the lever arm between them sweeps
    follows from the images.
    """
    if not len(motions) or len(velocities.t_ns) < 2:
        return None
    start = int(velocities.t_ns[0])
    way = integral(seconds(velocities.t_ns, start), velocities.velocity)
    camera_from_dvl = rig.tray_from(Camera.TOP).rotation.inv() * rig.tray_from_dvl.rotation
    # In axes halfway between those of the two images, in which the DVL measured its step.
    halfway = Rotation.from_rotvec(0.5 * motions.second_from_first.rotation.as_rotvec())
    went = -_directions(halfway.inv().apply(motions.second_from_first.translation))
    lever = (rig.tray_from(Camera.TOP).inverse() @ rig.tray_from_dvl).translation
    swept = halfway.inv().apply(lever) - halfway.apply(lever)

    def step(shift_s: float) -> Array:
        first, second = (
            seconds(t_ns, start) + shift_s for t_ns in (motions.first_ns, motions.second_ns)
        )
        return np.asarray(camera_from_dvl.apply(way.at(second) - way.at(first)) - swept)

    # The same for all shifts: else those that promise the shortest steps would fit best.
    length = np.maximum(np.linalg.norm(step(0.0), axis=1), STEP_SIGMA_M)
    sigma = np.hypot(motions.sigma_rad[:, 1], STEP_SIGMA_M / length + ASIDE_SIGMA_RAD)

    weight = 1 / sigma[:, None, None] ** 2
    # by a small rotation between the mounts, of each direction
    turned = np.eye(3) - went[:, :, None] * went[:, None, :]
    information = (weight * turned).sum(axis=0) + np.eye(3) / MOUNT_SIGMA_RAD**2

    def residuals(shift_s: float) -> Array:
        aside = np.cross(went, _directions(step(shift_s)))
        unknown = _outside(motions, round(shift_s * 1e9), velocities.t_ns)
        aside[unknown] = 0.0
        trusted = np.clip(aside, -TRUSTED * sigma[:, None], TRUSTED * sigma[:, None])
        mount = np.linalg.solve(information, (weight[:, :, 0] * trusted).sum(axis=0))
        found = (aside - turned @ mount) / sigma[:, None]
        found[unknown] = np.nan
        return np.asarray(found)

    return Disagreement(
        residuals=residuals, block=np.arange(len(motions)), is_enough=len(motions) >= LEAST_MOTIONS
    )


def _outside(motions: ImageMotions, shift_ns: int, t_ns: Ints) -> Mask:
    """Return which motions (m,), moved by a shift, reach beyond a sensor's stamps in order."""
    return np.asarray(
        (motions.first_ns + shift_ns < t_ns[0]) | (motions.second_ns + shift_ns > t_ns[-1])
    )


def _directions(vectors: Array) -> Array:
    """Return unit vectors (n, 3); zeros of nothing."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9))
