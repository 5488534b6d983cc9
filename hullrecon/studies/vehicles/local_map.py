# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A submap: one extended Kalman filter over a vehicle and the landmarks that it sees.

A submap starts where the vehicle is, as its origin. Attitude stays that of the world, as the IMU
measures it, and so does depth where pressure is measured: submaps differ by a shift alone.
"""

from __future__ import annotations

import numpy as np

from hullrecon.studies.submaps.ekf_slam import update_state
from hullrecon.studies.vehicles.motion import move
from hullrecon.typing import Array, Ints


class LocalMap:
    """State (5.1) and covariance of a vehicle, then of its landmarks, `size` numbers each."""

    def __init__(self, vehicle: Array, covariance: Array, size: int) -> None:
        """Start with a vehicle's state and covariance, and no landmarks.

        vehicle: position, attitude, velocity (9,), and what else a mission estimates. size: numbers
        that make a landmark.
        """
        self.mean, self.covariance = vehicle.copy(), covariance.copy()
        self._rows, self._size = len(vehicle), size
        self.count = 0  # of landmarks
        self.labels: list[int] = []  # true number of each landmark, -1 for a false one

    @property
    def vehicle(self) -> Array:
        """State of the vehicle."""
        return self.mean[: self._rows]

    def rows_of(self, landmark: int) -> Ints:
        """Find the rows of a landmark."""
        start = self._rows + landmark * self._size
        return np.arange(start, start + self._size)

    def landmark(self, k: int) -> Array:
        """State of a landmark."""
        return self.mean[self.rows_of(k)]

    def predict(self, step_s: float, noise: Array) -> None:
        """Move the vehicle by constant velocity. Landmarks, and what else it has, stay.

        noise: variances that a step adds to the vehicle's state.
        """
        n = self._rows
        moved, jacobian = move(self.mean[:9], step_s)
        self.mean[:9] = moved
        by_state = np.eye(n)
        by_state[:9, :9] = jacobian
        self.covariance[:n] = by_state @ self.covariance[:n]
        self.covariance[:, :n] = self.covariance[:, :n] @ by_state.T
        self.covariance[np.arange(n), np.arange(n)] += noise

    def innovation(self, rows: Ints, jacobian: Array, noise: Array) -> tuple[Array, Array]:
        """Compute P H' and the innovation's covariance S = H P H' + R of a measurement.

        Parameters are as of `update`.
        """
        carried = self.covariance[:, rows] @ jacobian.T
        return carried, jacobian @ carried[rows] + noise

    def update(self, rows: Ints, jacobian: Array, residual: Array, noise: Array) -> None:
        """Update by a measurement.

        Parameters
        ----------
        rows
            Of the state (k,) that it depends on.
        jacobian
            H (m, k) by these.
        residual
            Measured less predicted (m,).
        noise
            R (m, m).
        """
        carried, spread = self.innovation(rows, jacobian, noise)
        update_state(self.mean, self.covariance, carried, spread, residual)

    def add(self, landmark: Array, by_vehicle: Array, noise: Array, label: int) -> None:
        """Add a landmark.

        Parameters
        ----------
        landmark
            Its state.
        by_vehicle
            Its Jacobian by the vehicle's state.
        noise
            Covariance that the measurement gives it, besides the vehicle's.
        label
            Its true number.
        """
        across = by_vehicle @ self.covariance[: self._rows]
        own = across[:, : self._rows] @ by_vehicle.T + noise
        self.mean = np.concatenate([self.mean, landmark])
        self.covariance = np.block([[self.covariance, across.T], [across, own]])
        self.labels.append(label)
        self.count += 1
