# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare the clock of the images with those of IMU and DVL by the motion of the upper camera.

- images and attitude: the turn from one image to the next, without its part about the tray's axis,
  where the play of the servo looks like a time offset,
- images and DVL: the direction in which the camera went.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, tray_poses
from hullrecon.navigation.clocks.comparisons.comparison import (
    TRAY_AXIS,
    ClockComparison,
    ClockedSensor,
    Offsets,
    fast_rotation,
    shift_between_ns,
)
from hullrecon.navigation.dead_reckoning.integral import integral
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.servo import Servo
from hullrecon.navigation.sensors.velocity import Velocities
from hullrecon.records.clock import NS, seconds
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

# Sigmas of the systematic error of each comparison's offset, s. The largest offsets found on 56
# simulated dives with right clocks are 0.017 s of images and attitude, 0.14 of images and DVL.
TURN_S, DIRECTION_S = 0.01, 0.05
LEAST_MOTIONS = 10
TURN_SIGMA_RAD = 0.0015  # of the attitude's turn between two images
STEP_SIGMA_M = 0.003  # of the DVL's step between two images
DIRECTION_SIGMA_RAD = 0.02  # of the step's direction in the camera
MOUNT_SIGMA_RAD = 0.02  # of the DVL's mount relative to the camera, estimated with the offset
CLIP = 3.0  # sigmas; larger residuals are clipped when the mount is estimated


@dataclass(frozen=True, kw_only=True)
class ImageMotions:
    """Motions of the upper camera between neighbouring images."""

    first_ns: Ints  # (m,)
    second_ns: Ints  # (m,)
    second_from_first: Poses  # (m,), translations of any length
    sigma_rad: Array  # (m, 2) of the turn, each axis, and of the direction

    def __len__(self) -> int:
        return len(self.first_ns)


def compare_turns(
    motions: ImageMotions, attitude: AttitudeHistory, servo: Servo, rig: Rig
) -> ClockComparison:
    """Compare attitude and images by the turns of the upper camera between images.

    The residual is the rotation that images and attitude disagree by, in sigmas, without its part
    about the tray's axis. It is NaN where a motion begins or ends beyond the attitude's readings.
    """
    tray_from_top = rig.tray_from(Camera.TOP).rotation
    axis = tray_from_top.inv().apply(TRAY_AXIS)
    sigma = np.hypot(motions.sigma_rad[:, :1], TURN_SIGMA_RAD)
    attitude_at, seen = fast_rotation(attitude), motions.second_from_first.rotation.inv()

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the disagreement (n, 3) of rows, in sigmas."""
        shift_ns = shift_between_ns(offsets, ClockedSensor.IMU, ClockedSensor.IMAGES)
        t_ns = np.concatenate([motions.first_ns[rows], motions.second_ns[rows]]) + shift_ns
        tray = tray_poses(rig.tray_origin, servo.angle_at(t_ns)).rotation
        camera = attitude_at(t_ns) * tray * tray_from_top
        first, second = camera[: len(rows)], camera[len(rows) :]
        # second_from_first by the attitude, undone by that of the images: nil if both agree
        turn = (seen[rows] * second.inv() * first).as_rotvec()
        turn[_outside(motions, rows, shift_ns, attitude.t_ns)] = np.nan
        return np.asarray((turn - (turn * axis).sum(axis=1, keepdims=True) * axis) / sigma[rows])

    return _compare_with_images(motions, ClockedSensor.IMU, TURN_S, evaluate)


def compare_directions(
    motions: ImageMotions, velocities: Velocities, rig: Rig
) -> ClockComparison | None:
    """Compare DVL and images by the camera's directions of motion.

    Both sit on the tray, so that no attitude is needed. The motion of the lever arm between them
    follows from the rotation that the images measured. A small rotation between their mounts is
    estimated. None for fewer than two pings.

    The residual, (n, 3), is the small rotation from the direction in which the images saw the top
    camera go to the one by the DVL, in sigmas, both in axes halfway between those of the two
    images.

    velocities: of the DVL in its own frame.
    """
    if len(velocities.t_ns) < 2:
        return None
    start = int(velocities.t_ns[0])
    path = integral(seconds(velocities.t_ns, start), velocities.velocity)
    top_from_dvl = rig.tray_from(Camera.TOP).inverse() @ rig.tray_from_dvl
    # in axes halfway between those of the two images, in which the DVL measured its step
    halfway = Rotation.from_rotvec(0.5 * motions.second_from_first.rotation.as_rotvec())
    # the translation of second_from_first is where the first camera lies seen from the second: the
    # motion is its negative
    seen = -_directions(halfway.inv().apply(motions.second_from_first.translation))
    lever, turned = top_from_dvl.translation, top_from_dvl.rotation
    # by how much the DVL moves relative to the camera, as the rig turns
    swept = halfway.inv().apply(lever) - halfway.apply(lever)

    def step(shift_s: float, rows: Ints) -> Array:
        """Compute the camera's step (n, 3), m, between two images by the DVL, in halfway axes."""
        t_ns = np.concatenate([motions.first_ns[rows], motions.second_ns[rows]])
        at = path.at(seconds(t_ns, start) + shift_s)
        return np.asarray(turned.apply(at[len(rows) :] - at[: len(rows)]) - swept[rows])

    # sigmas are the same for all offsets: else the offsets with the shortest steps would fit best
    length = np.linalg.norm(step(0.0, np.arange(len(motions))), axis=1)
    of_step = STEP_SIGMA_M / np.maximum(length, STEP_SIGMA_M) + DIRECTION_SIGMA_RAD
    sigma = np.hypot(motions.sigma_rad[:, 1], of_step)[:, None]
    # derivative of `angle` by a small rotation between the mounts: its part about the direction
    # itself does not show
    by_mount = np.eye(3) - seen[:, :, None] * seen[:, None, :]

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the angle between the direction seen and that of the DVL's step, in sigmas.

        A small rotation between both mounts is fitted at each offset, and taken off.
        """
        shift_ns = shift_between_ns(offsets, ClockedSensor.DVL, ClockedSensor.IMAGES)
        angle = np.cross(seen[rows], _directions(step(shift_ns / NS, rows)))
        unknown = _outside(motions, rows, shift_ns, velocities.t_ns)
        angle[unknown] = 0.0
        # the rotation of the mounts by least squares, of angles clipped so that none counts much
        own, turned_by = sigma[rows], by_mount[rows]
        clipped = np.clip(angle, -CLIP * own, CLIP * own)
        information = (turned_by / own[:, :, None] ** 2).sum(axis=0)
        information = information + np.eye(3) / MOUNT_SIGMA_RAD**2
        mount = np.linalg.solve(information, (clipped / own**2).sum(axis=0))
        found = (angle - turned_by @ mount) / own
        found[unknown] = np.nan
        return np.asarray(found)

    return _compare_with_images(motions, ClockedSensor.DVL, DIRECTION_S, evaluate)


def _compare_with_images(
    motions: ImageMotions,
    first: ClockedSensor,
    systematic_s: float,
    evaluate: Callable[[Offsets, Ints], Array],
) -> ClockComparison:
    """Make a comparison of a sensor with images, a row for each motion between two images.

    Errors of different motions are taken to be independent, so each row is a block of its own.
    """
    rows = np.arange(len(motions))
    return ClockComparison(
        first=first,
        second=ClockedSensor.IMAGES,
        systematic_s=systematic_s,
        begin_ns=motions.first_ns,
        end_ns=motions.second_ns,
        block=rows,
        evaluate=evaluate,
        rows=rows,
        least_rows=LEAST_MOTIONS,
    )


def _outside(motions: ImageMotions, rows: Ints, shift_ns: int, t_ns: Ints) -> Mask:
    """Find the motions (of `rows`) that begin or end beyond a sensor's stamps when shifted."""
    first, second = motions.first_ns[rows] + shift_ns, motions.second_ns[rows] + shift_ns
    return np.asarray((first < t_ns[0]) | (second > t_ns[-1]))


def _directions(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9))
