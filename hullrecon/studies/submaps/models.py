# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A car with a laser in the plane: motion, observation, and poses composed [Aulinas2011 A, 3.4.1].

A pose is an array (3,) of x, y and heading: m, m, rad. Odometry is speed and steering: m/s, rad.
A reading is range and bearing: m, rad. Every model is followed by its Jacobians.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array


def wrap(angle: Array | float) -> Array:
    """Bring angles into (-pi, pi]."""
    return np.asarray(np.pi - np.mod(np.pi - angle, 2 * np.pi))


def compose(first: Array, second: Array) -> Array:
    """Compose two poses: `second` in the frame of `first`, the result in the parent of `first`."""
    cos, sin = np.cos(first[2]), np.sin(first[2])
    return np.array(
        [
            first[0] + second[0] * cos - second[1] * sin,
            first[1] + second[0] * sin + second[1] * cos,
            float(wrap(first[2] + second[2])),
        ]
    )


def compose_jacobians(first: Array, second: Array) -> tuple[Array, Array]:
    """Differentiate `compose` by its first and by its second pose, (3, 3) each."""
    cos, sin = np.cos(first[2]), np.sin(first[2])
    by_first, by_second = np.eye(3), np.eye(3)
    by_first[0, 2] = -second[0] * sin - second[1] * cos
    by_first[1, 2] = second[0] * cos - second[1] * sin
    by_second[:2, :2] = rotation(first[2])
    return by_first, by_second


def invert(pose: Array) -> Array:
    """Invert a pose (3,): the parent frame's pose in the frame of `pose`."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.array(
        [-pose[0] * cos - pose[1] * sin, pose[0] * sin - pose[1] * cos, float(wrap(-pose[2]))]
    )


def invert_jacobian(pose: Array) -> Array:
    """Differentiate `invert` by its pose (3, 3).

    Its upper right corner is x sin - y cos, where the thesis prints -x sin - y cos.
    """
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.array(
        [
            [-cos, -sin, pose[0] * sin - pose[1] * cos],
            [sin, -cos, pose[0] * cos + pose[1] * sin],
            [0.0, 0.0, -1.0],
        ]
    )


def rotation(heading: float) -> Array:
    """Build the rotation matrix (2, 2) of a heading."""
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array([[cos, -sin], [sin, cos]])


def place(pose: Array, points: Array) -> Array:
    """Move points (n, 2) of the frame `pose` into the frame that the pose is given in."""
    return np.asarray(pose[:2] + points @ rotation(pose[2]).T)


def place_by_pose(pose: Array, points: Array) -> Array:
    """Differentiate `place` of points (n, 2) by the pose (2n, 3): a row for each x and y."""
    turned = points @ rotation(pose[2]).T
    jacobian = np.zeros((2 * len(points), 3))
    jacobian[0::2, 0] = 1.0
    jacobian[1::2, 1] = 1.0
    jacobian[0::2, 2] = -turned[:, 1]
    jacobian[1::2, 2] = turned[:, 0]
    return jacobian


def place_by_points(pose: Array, count: int) -> Array:
    """Differentiate `place` of `count` points by the points (2 count, 2 count).

    It is block diagonal: each point is turned by the pose's heading.
    """
    return block_diagonal(np.broadcast_to(rotation(pose[2]), (count, 2, 2)))


def block_diagonal(blocks: Array) -> Array:
    """Put blocks (n, k, k) on the diagonal of a matrix of zeros (nk, nk)."""
    count, size = len(blocks), blocks.shape[-1]
    matrix = np.zeros((count, size, count, size))
    index = np.arange(count)
    matrix[index, :, index] = blocks
    return matrix.reshape(count * size, count * size)


@dataclass(frozen=True, kw_only=True)
class Car:
    """A car steered by its front wheels [Aulinas2011 Fig. 3.3].

    The thesis gives no sizes. These are of the vehicle of Victoria Park, by its public files.
    """

    wheelbase_m: float = 2.83  # L
    encoder_m: float = 0.76  # H, from the axle's middle to the wheel that counts
    laser_ahead_m: float = 3.78  # a, of the rear axle
    laser_left_m: float = 0.5  # b

    def axle_speed(self, wheel_speed: Array, steering: Array) -> Array:
        """Compute the speed of the axle's middle from that of the left wheel, m/s.

        In a curve the wheel is slower or faster than the axle. wheel_speed: (n,) m/s. steering:
        (n,) rad, positive to the left.
        """
        lever = self.encoder_m / self.wheelbase_m
        return np.asarray(wheel_speed / (1.0 - lever * np.tan(steering)))

    def move(self, pose: Array, speed: float, steering: float, step_s: float) -> Array:
        """Move the laser's pose (3,) by one step of speed, m/s, and steering, rad (3.17).

        The thesis prints tan(phi) for tan(alpha).
        """
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        turn = speed / self.wheelbase_m * np.tan(steering)  # rad/s
        a, b = self.laser_ahead_m, self.laser_left_m  # the laser swings about the axle's middle
        rate = [
            speed * cos - turn * (a * sin + b * cos),
            speed * sin + turn * (a * cos - b * sin),
            turn,
        ]
        moved = pose + step_s * np.array(rate)
        moved[2] = wrap(moved[2])
        return moved

    def move_steps(
        self, pose: Array, odometry: Array, step_s: Array, noise: Array
    ) -> tuple[Array, Array, Array]:
        """Move the laser by many steps (3.17), all at once: the same as one after the other.

        Parameters
        ----------
        pose
            Before the steps.
        odometry
            Speed and steering (k, 2).
        step_s
            Duration (k,) of each step.
        noise
            Covariance (2, 2) of a step's speed and steering.

        Returns
        -------
        Array
            The pose after them.
        Array
            Derivative (3, 3) by the pose: F of (3.8), of a single step (3.18).
        Array
            Covariance (3, 3) that the odometry adds, G Q G' of (3.7).
        """
        moves, _, heading = self._steps(pose, odometry, step_s)
        after = np.array([*(pose[:2] + moves.sum(axis=1)), float(wrap(heading[-1]))])
        by_pose = np.eye(3)
        by_pose[0, 2], by_pose[1, 2] = pose[1] - after[1], after[0] - pose[0]
        return after, by_pose, self.spread(pose, odometry, step_s, noise)

    def spread(
        self,
        pose: Array,
        odometry: Array,
        step_s: Array,
        noise: Array,
        with_product: bool = False,
    ) -> Array:
        """Compute the covariance (3, 3) that the odometry of many steps adds to the laser's pose.

        G Q G' of (3.7) is of first order: the turn of a step, v tan(alpha) / L, errs by the product
        of both errors, too. `with_product` adds that. The other parameters are as in `move_steps`.
        """
        moves, swing, heading = self._steps(pose, odometry, step_s)
        speed, steering = odometry.T
        ahead = moves.sum(axis=1, keepdims=True) - moves.cumsum(axis=1)  # what follows a step
        # by the turn of each step: the laser moves, and what follows is turned
        lever = swing + np.array([-ahead[1], ahead[0]])
        by_turn = step_s * np.vstack([lever, np.ones(len(step_s))])
        straight = step_s * np.array([np.cos(heading[:-1]), np.sin(heading[:-1]), 0 * step_s])
        sharper = by_turn / (self.wheelbase_m * np.cos(steering) ** 2)
        by_speed = straight + by_turn * np.tan(steering) / self.wheelbase_m
        by_odometry = np.stack([by_speed, sharper * speed])  # each step errs by itself
        spread = np.einsum("ij,iak,jbk->ab", noise, by_odometry, by_odometry)
        if with_product:
            spread += noise[0, 0] * noise[1, 1] * sharper @ sharper.T
        return np.asarray(spread)

    def _steps(self, pose: Array, odometry: Array, step_s: Array) -> tuple[Array, Array, Array]:
        """Compute what each of k steps moves the laser. Parameters are as in `move_steps`.

        Returns
        -------
        Array
            Displacement of the laser in each step (2, k) m.
        Array
            Its displacement for a turn of one radian at each step (2, k) m.
        Array
            Heading before each step, and after the last (k + 1,) rad.
        """
        speed, steering = odometry.T
        turn = speed / self.wheelbase_m * np.tan(steering)
        heading = pose[2] + np.concatenate([[0.0], np.cumsum(step_s * turn)])
        cos, sin = np.cos(heading[:-1]), np.sin(heading[:-1])
        a, b = self.laser_ahead_m, self.laser_left_m
        swing = np.array([-(a * sin + b * cos), a * cos - b * sin])
        return step_s * (speed * np.array([cos, sin]) + turn * swing), swing, heading


def observe(pose: Array, points: Array) -> Array:
    """Predict the readings (n, 2) of points (n, 2) from the laser's pose (3,) (3.19).

    A bearing counts from the car's right: pi / 2 is straight ahead. The thesis prints the arc
    tangent of a quotient, which folds what lies behind the car.
    """
    off = points - pose[:2]
    bearing = np.arctan2(off[:, 1], off[:, 0]) - pose[2] + np.pi / 2
    return np.column_stack([np.hypot(off[:, 0], off[:, 1]), wrap(bearing)])


def observe_jacobians(pose: Array, points: Array) -> tuple[Array, Array]:
    """Differentiate `observe` by the pose (n, 2, 3) and by each point (n, 2, 2), as (3.20).

    The thesis prints -dx/D for the range by the point's x.
    """
    off = points - pose[:2]
    range_m = np.hypot(off[:, 0], off[:, 1])
    by_point = np.empty((len(points), 2, 2))
    by_point[:, 0] = off / range_m[:, None]
    by_point[:, 1] = np.column_stack([-off[:, 1], off[:, 0]]) / range_m[:, None] ** 2
    by_pose = np.concatenate([-by_point, np.zeros((len(points), 2, 1))], axis=2)
    by_pose[:, 1, 2] = -1.0
    return by_pose, by_point


def sighted_points(readings: Array) -> Array:
    """Turn readings (n, 2) into points (n, 2) m in the laser's frame, x ahead and y to the left."""
    angle = readings[:, 1] - np.pi / 2  # from straight ahead
    return np.asarray(readings[:, :1] * np.column_stack([np.cos(angle), np.sin(angle)]))


def sighted_covariance(readings: Array, noise: Array) -> Array:
    """Compute the covariance (n, 2, 2) m^2 of each of `sighted_points`.

    noise: covariance (2, 2) of one reading's range and bearing.
    """
    angle, range_m = readings[:, 1] - np.pi / 2, readings[:, 0]
    cos, sin = np.cos(angle), np.sin(angle)
    jacobian = np.stack([cos, -range_m * sin, sin, range_m * cos], axis=1).reshape(-1, 2, 2)
    return np.asarray(jacobian @ noise @ jacobian.transpose(0, 2, 1))
