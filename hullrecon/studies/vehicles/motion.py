# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Constant velocity in six and in four degrees of freedom [Aulinas2011 (5.2), (5.15)]."""

from __future__ import annotations

import numpy as np

from hullrecon.studies.vehicles.transforms import rotation, rotation_derivatives
from hullrecon.typing import Array

POSITION, ATTITUDE, VELOCITY = slice(0, 3), slice(3, 6), slice(6, 9)  # of a state


def move(state: Array, step_s: float) -> tuple[Array, Array]:
    """Move a vehicle in six degrees of freedom (5.2), (5.3). The print has roll in pitch's row.

    Parameters
    ----------
    state
        Position in the world, roll, pitch, yaw, velocity in the vehicle (9,).
    step_s
        Duration of the motion.

    Returns
    -------
    Array
        The state (9,) after it.
    Array
        F (9, 9), its Jacobian (5.3).
    """
    turn, by_angle = rotation(state[ATTITUDE]), rotation_derivatives(state[ATTITUDE])
    moved = state.copy()
    moved[POSITION] += turn @ state[VELOCITY] * step_s
    jacobian = np.eye(9)
    jacobian[POSITION, ATTITUDE] = (by_angle @ state[VELOCITY]).T * step_s
    jacobian[POSITION, VELOCITY] = turn * step_s
    return moved, jacobian


def move_level(state: Array, step_s: float) -> tuple[Array, Array]:
    """Move a vehicle that neither rolls nor pitches (5.15).

    The thesis prints z and yaw in one row, z + v_z dt yaw, so that six rows stand for seven.

    Parameters
    ----------
    state
        x, y, z, yaw, velocity in the vehicle (7,).
    step_s
        Time.

    Returns
    -------
    Array
        The state (7,) after it.
    Array
        Its Jacobian (7, 7).
    """
    c, s = np.cos(state[3]), np.sin(state[3])
    vx, vy, vz = state[4:]
    moved = state.copy()
    moved[:3] += np.array([vx * c - vy * s, vx * s + vy * c, vz]) * step_s
    jacobian = np.eye(7)
    jacobian[:2, 3] = np.array([-vx * s - vy * c, vx * c - vy * s]) * step_s
    jacobian[:2, 4:6] = np.array([[c, -s], [s, c]]) * step_s
    jacobian[2, 6] = step_s
    return moved, jacobian
