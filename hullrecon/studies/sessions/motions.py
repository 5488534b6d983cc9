# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Poses and planes in each other's frames, with derivatives [Ozog2016 A, B].

Six numbers of a pose are its translation and a rotation perturbed on the right, as everywhere in
hullrecon. A plane is three numbers pi, m: its unit normal towards the origin of its frame times its
distance from it, so that pi . x = -|pi|^2 for x on it.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, exp
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array


def moved(poses: Poses, steps: Array) -> Poses:
    """Move poses (n) by steps (n, 6): translation in the parent frame, rotation on the right."""
    turned = poses.rotation * Rotation.from_rotvec(steps[:, 3:])
    return Poses(turned.as_quat(), poses.translation + steps[:, :3])


def compose(outer: Poses, inner: Poses) -> tuple[Poses, Array, Array]:
    """Compute a_from_c of a_from_b and b_from_c, with derivatives (n, 6, 6) by either."""
    turn = outer.rotation.as_matrix()
    by_outer, by_inner = np.zeros((2, len(outer), 6, 6))
    by_outer[:, :3, :3] = np.eye(3)
    by_outer[:, :3, 3:] = -turn @ cross_matrix(inner.translation)
    by_outer[:, 3:, 3:] = inner.rotation.inv().as_matrix()
    by_inner[:, :3, :3] = turn
    by_inner[:, 3:, 3:] = np.eye(3)
    return outer @ inner, by_outer, by_inner


def between(first: Poses, second: Poses) -> tuple[Poses, Array, Array]:
    """Compute first_from_second of poses in one frame, with derivatives (n, 6, 6) by either."""
    relative = first.inverse() @ second
    back = first.rotation.inv().as_matrix()
    by_first, by_second = np.zeros((2, len(first), 6, 6))
    by_first[:, :3, :3] = -back
    by_first[:, :3, 3:] = cross_matrix(relative.translation)
    by_first[:, 3:, 3:] = -relative.rotation.inv().as_matrix()
    by_second[:, :3, :3] = back
    by_second[:, 3:, 3:] = np.eye(3)
    return relative, by_first, by_second


def errors(measured: Poses, poses: Poses) -> tuple[Array, Array]:
    """Compute the errors of poses against measured ones (n, 6), with derivatives by the poses.

    The error is translation and rotation vector of measured_from_pose, the derivative (n, 6, 6).
    """
    off = measured.inverse() @ poses
    turn = off.rotation.as_rotvec()
    derivative = np.zeros((len(poses), 6, 6))
    derivative[:, :3, :3] = measured.rotation.inv().as_matrix()
    derivative[:, 3:, 3:] = _by_perturbation(turn)
    return np.hstack([off.translation, turn]), derivative


def plane_in(poses: Poses, planes: Array) -> tuple[Array, Array, Array]:
    """Compute planes (n, 3) m, given in the poses' parent frame, in the poses' frames: x ⊟ pi.

    Returns them with their derivatives by pose (n, 3, 6) and by plane (n, 3, 3).
    """
    back = poses.rotation.inv().as_matrix()
    squared = np.sum(planes**2, axis=1)[:, None]
    along = np.sum(poses.translation * planes, axis=1)[:, None] / squared
    turned = np.einsum("nij,nj->ni", back, planes)
    seen = (1 + along) * turned
    by_pose = np.zeros((len(poses), 3, 6))
    by_pose[:, :, :3] = turned[:, :, None] * (planes / squared)[:, None]
    by_pose[:, :, 3:] = cross_matrix(seen)
    slope = (poses.translation - 2 * along * planes) / squared
    by_plane = (1 + along)[:, :, None] * back + turned[:, :, None] * slope[:, None]
    return seen, by_pose, by_plane


def plane_out(poses: Poses, planes: Array) -> Array:
    """Compute planes (n, 3), given in the poses' frames, in the poses' parent frame: x ⊞ pi."""
    return plane_in(poses.inverse(), planes)[0]


def drawn(sigma: Array, rng: np.random.Generator, count: int) -> Poses:
    """Draw motions (count) with sigmas (6,) of translation and rotation."""
    return exp(rng.standard_normal((count, 6)) * sigma)


def _by_perturbation(turn: Array) -> Array:
    """Compute the derivative (n, 3, 3) of Log(Exp(turn) Exp(w)) by w at zero."""
    angle = np.linalg.norm(turn, axis=1)[:, None, None]
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    factor = np.where(small, 1 / 12, 1 / safe**2 - (1 + np.cos(safe)) / (2 * safe * np.sin(safe)))
    cross = cross_matrix(turn)
    return np.asarray(np.eye(3) + 0.5 * cross + factor * (cross @ cross))
