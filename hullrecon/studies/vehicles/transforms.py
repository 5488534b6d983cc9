# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rotations and poses of [Aulinas2011 A.3], with derivatives.

An attitude is (3,) roll, pitch, yaw, rad. A pose is (6,): position, m, and attitude.

The thesis prints the last factor of (A.5) as rotz(phi) with two equal cosines: it is rotx(phi). In
(A.4) it has a stray Delta: the inverse's translation is -R' t.
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array


def rotation(attitude: Array) -> Array:
    """Compute the rotation world_from_vehicle (3, 3) of an attitude (3,) (A.5)."""
    about_x, about_y, about_z = _factors(attitude)
    return np.asarray(about_z @ about_y @ about_x)


def rotation_derivatives(attitude: Array) -> Array:
    """Differentiate `rotation` by each angle of an attitude (3,): three matrices (3, 3, 3)."""
    about_x, about_y, about_z = _factors(attitude)
    turn_x = np.array([[0.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    turn_y = np.array([[0.0, 0, 1], [0, 0, 0], [-1, 0, 0]])
    turn_z = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 0]])
    return np.stack(
        [
            about_z @ about_y @ about_x @ turn_x,
            about_z @ about_y @ turn_y @ about_x,
            about_z @ turn_z @ about_y @ about_x,
        ]
    )


def _factors(attitude: Array) -> tuple[Array, Array, Array]:
    """Build the rotations (3, 3) about x, y and z of an attitude (3,)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(attitude), np.sin(attitude)
    return (
        np.array([[1.0, 0, 0], [0, cr, -sr], [0, sr, cr]]),
        np.array([[cp, 0, sp], [0, 1.0, 0], [-sp, 0, cp]]),
        np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1.0]]),
    )


def transform(pose: Array) -> Array:
    """Make i_from_j (4, 4) of the pose (6,) of j in i: translation, attitude (A.3)."""
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation(pose[3:]), pose[:3]
    return out


def inverse_transform(pose: Array) -> Array:
    """Make j_from_i (4, 4) of the pose (6,) of j in i (A.4)."""
    out = np.eye(4)
    back = rotation(pose[3:]).T
    out[:3, :3], out[:3, 3] = back, -back @ pose[:3]
    return out


def wrapped(angle: Array) -> Array:
    """Bring angles to -pi to pi."""
    return np.asarray(np.arctan2(np.sin(angle), np.cos(angle)))
