# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What REMUS' sensors measure of its state [Aulinas2011 (5.4) to (5.14)].

The state (5.1): position, attitude and velocity (9,), the depth of the floor, landmarks (3 each).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.vehicles.transforms import rotation, rotation_derivatives
from hullrecon.typing import Array

FLOOR = 9  # row of the floor's depth; the thesis calls it the distance from vehicle to floor
VEHICLE = 10  # rows before the landmarks


@dataclass(frozen=True, kw_only=True)
class Sigmas:
    """Noise of the sensors. The thesis prints none."""

    attitude_rad: tuple[float, float, float] = (0.005, 0.005, 0.015)  # R_o (5.6)
    velocity_mps: float = 0.04  # R_v (5.8)
    depth_m: float = 0.05  # R_d (5.10)
    altitude_m: float = 0.15  # of the floor below the vehicle (5.14)
    target_m: tuple[float, float, float] = (0.2, 0.3, 0.4)  # along, across, down: R_s (5.12)

    def scaled(self, by: float) -> Sigmas:
        """Multiply all sigmas by a factor, as a filter that trusts its sensors less or more."""
        roll, pitch, yaw = (by * sigma for sigma in self.attitude_rad)
        forward, across, down = (by * sigma for sigma in self.target_m)
        return Sigmas(
            attitude_rad=(roll, pitch, yaw),
            velocity_mps=by * self.velocity_mps,
            depth_m=by * self.depth_m,
            altitude_m=by * self.altitude_m,
            target_m=(forward, across, down),
        )

    def navigation(self) -> Array:
        """Make the variances (8,) of attitude, velocity, depth and altitude."""
        sigma = [*self.attitude_rad, *[self.velocity_mps] * 3, self.depth_m, self.altitude_m]
        return np.square(sigma)

    def target(self) -> Array:
        """Make the covariance (3, 3) of a target's place, R_s: (5.12) prints R_v."""
        return np.diag(np.square(self.target_m))


def navigation_rows() -> Array:
    """Make the Jacobian H (8, VEHICLE) of what navigation measures by the vehicle's state.

    Attitude (5.5), velocity (5.7), depth (5.9) and altitude (5.13). Altitude is the tenth state
    less z, so the tenth state is the floor's depth. (5.9) prints eight columns before the
    landmarks.
    """
    rows = np.zeros((8, VEHICLE))
    rows[:3, 3:6] = np.eye(3)
    rows[3:6, 6:9] = np.eye(3)
    rows[6, 2] = 1.0
    rows[7, [2, FLOOR]] = [-1.0, 1.0]
    return rows


def see_target(vehicle: Array, landmark: Array) -> tuple[Array, Array, Array]:
    """Predict a landmark in the vehicle's frame, as side-scan measures it (5.11).

    Corrected here: (5.11) prints the derivatives of W_T_V, which leads out of that frame; those of
    its inverse are meant. The text's point lies in the vehicle's YZ plane: the forward number,
    zero there, is measured too, with the first sigma of R_s (5.12).

    Parameters
    ----------
    vehicle
        State (VEHICLE,).
    landmark
        Its place in the world (3,).

    Returns
    -------
    Array
        Forward, starboard, down from the vehicle (3,).
    Array
        Jacobian (3, VEHICLE) by the vehicle's state.
    Array
        Jacobian (3, 3) by the landmark.
    """
    back = rotation(vehicle[3:6]).T
    off = landmark - vehicle[:3]
    by_vehicle = np.zeros((3, VEHICLE))
    by_vehicle[:, :3] = -back
    by_vehicle[:, 3:6] = np.einsum("ajk,j->ka", rotation_derivatives(vehicle[3:6]), off)
    return back @ off, by_vehicle, back


def place_target(vehicle: Array, seen: Array) -> tuple[Array, Array, Array]:
    """Place a landmark (3,) m in the world from where it was seen: the inverse of `see_target`.

    seen: (3,) m forward, starboard, down. Returns the landmark with its Jacobians by the vehicle's
    state (3, VEHICLE) and by the measurement (3, 3).
    """
    turn = rotation(vehicle[3:6])
    by_vehicle = np.zeros((3, VEHICLE))
    by_vehicle[:, :3] = np.eye(3)
    by_vehicle[:, 3:6] = (rotation_derivatives(vehicle[3:6]) @ seen).T
    return vehicle[:3] + turn @ seen, by_vehicle, turn
