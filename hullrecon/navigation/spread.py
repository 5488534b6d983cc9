# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How far dead reckoning may be off at each node: errors that persist as unknowns, J P J', plus what is white."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hullrecon.navigation.dead_reckoning import MOUNT, PLAY, TILT, UP_DOWN, Instant, Reckoning
from hullrecon.navigation.depth import Depth
from hullrecon.navigation.edges import velocity_variance
from hullrecon.navigation.vehicle import cross_matrix

Array = NDArray[np.float64]
UNKNOWN_DEPTH_M = 10.0  # without a pressure sensor the depth of the start is anyone's guess


def trajectory_covariance(path: Reckoning, at: Instant, depth: Depth | None) -> Array:
    """(n, 6, 6) of (translation in g, rotation perturbed on the right in v), relative to the start in x, y and heading.

    Depth is absolute: its bias and the smoothed noise of the pressure; without pressure it drifts like x and y.
    """
    v = path.vehicle
    J = _derivatives(at)
    J[:, :3] -= _derivatives(path.at(np.array([path.start_ns])))[:, :3]  # the path is counted from there
    sigma = np.concatenate(
        [[v.sigma_scale, v.sigma_drift], v.sigma_mount[3:], [v.sigma_tray], np.full(2, v.sigma_tilt_bias), [v.sigma_tilt]]
    )
    if depth is not None:
        J[:, 2] = 0.0
    out: Array = (J * sigma**2) @ np.swapaxes(J, 1, 2)
    drift = velocity_variance(path, np.full(len(at.t_ns), path.start_ns), at.t_ns)
    turn = path.attitude.sigma_rad**2
    diagonal = np.arange(3)
    out[:, diagonal, diagonal] += np.maximum(drift, 0)[:, None] + 1e-8
    out[:, diagonal + 3, diagonal + 3] += turn
    if depth is None:
        out[:, 2, 2] += UNKNOWN_DEPTH_M**2
    else:
        out[:, 2, 2] = depth.sigma**2 + v.sigma_depth_bias**2
    return out


def _derivatives(at: Instant) -> Array:
    """(n, 6, 9) by scale, heading drift, mount (3), play, roll and pitch bias, heading at the start."""
    swung = -at.rotation.as_matrix() @ cross_matrix(at.lever)
    turned = np.cross(UP_DOWN, at.t_s[:, None] * at.instrument - at.sums[:, :, 1] + _lever_drift(at))
    play = at.sums[:, :, PLAY][:, :, 0] - at.direction[:, None] * at.rotation.apply(at.lever_by_tray)
    tilt = at.sums[:, :, TILT][:, :, :2] - swung[:, :, :2]
    J = np.zeros((len(at.t_ns), 6, 9))
    J[:, :3, 0] = at.instrument
    J[:, :3, 1] = turned
    J[:, :3, 2:5] = at.sums[:, :, MOUNT]
    J[:, :3, 5] = play
    J[:, :3, 6:8] = tilt
    J[:, :3, 8] = np.cross(UP_DOWN, at.poses().translation)
    J[:, 3:, 1] = at.rotation.as_matrix()[:, 2] * at.t_s[:, None]
    J[:, 3, 6] = J[:, 4, 7] = 1.0
    J[:, 3:, 8] = at.rotation.as_matrix()[:, 2]
    return J


def _lever_drift(at: Instant) -> Array:
    return -at.t_s[:, None] * at.rotation.apply(at.lever)
