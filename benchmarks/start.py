# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where a field problem starts: a dead-reckoned track, landmarks triangulated from it."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.survey import STEP_M
from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array, Ints

SPEED_MPS = 0.25
# m, rad a step: a DVL ping of 5 mm/s, a gyro of 0.4 deg/sqrt(h)
SIGMA_ODOMETRY = np.r_[np.full(3, 0.004), 2e-4, 2e-4, 1e-4]
DVL_SCALE, DVL_MOUNT_RAD = 0.003, np.radians(0.3)
GYRO_BIAS_RADPS = np.radians(0.05) / 3600


def steps(nodes: Poses) -> Poses:
    """Compute T_i_j of neighbouring nodes (n - 1)."""
    return nodes[:-1].inverse() @ nodes[1:]


def measure(nodes: Poses, rng: np.random.Generator) -> Poses:
    """Add the odometry's white noise to the steps.

    The translation is in the axes of the first node, the rotation is perturbed on the right.
    """
    true = steps(nodes)
    noise = SIGMA_ODOMETRY * rng.standard_normal((len(true), 6))
    turned = true.rotation * Rotation.from_rotvec(noise[:, 3:])
    return Poses(turned.as_quat(), true.translation + noise[:, :3])


def dead_reckoned(nodes: Poses, measured: Poses, rng: np.random.Generator) -> Poses:
    """Reckon the track (T_g_v, n) before any calibration.

    Its errors are the white noise of the factors, and errors that the factors do not model: a scale
    error of 0.3 %, a mounting angle of 0.3 deg and a gyro bias of 0.05 deg/h. Depth, roll and pitch
    stay bounded, with slow errors of 1 cm and 0.05 deg.
    """
    number = np.arange(len(nodes))
    turn = np.r_[
        0, np.cumsum((measured.rotation.as_rotvec() - steps(nodes).rotation.as_rotvec())[:, 2])
    ]
    heading = turn + GYRO_BIAS_RADPS * STEP_M / SPEED_MPS * number
    tilt = np.stack([_slow(number, rng), _slow(number, rng)], 1) * np.radians(0.05)
    wrong = Rotation.from_rotvec(np.c_[tilt, np.zeros(len(nodes))])
    rotation = Rotation.from_euler("z", heading[:, None]) * nodes.rotation * wrong
    raw = Rotation.from_euler("z", DVL_MOUNT_RAD).apply(measured.translation * (1 + DVL_SCALE))
    position = nodes.translation[0] + np.vstack(
        [np.zeros(3), np.cumsum(rotation[:-1].apply(raw), 0)]
    )
    position[:, 2] = nodes.translation[:, 2] + 0.01 * _slow(number, rng)
    return Poses(rotation.as_quat(), position)


def _slow(number: Ints, rng: np.random.Generator, every: int = 200) -> Array:
    """Draw unit noise with a new value every 200 poses (40 m), linear between."""
    knots = rng.standard_normal(number[-1] // every + 2)
    return np.asarray(np.interp(number / every, np.arange(len(knots)), knots))


def triangulate(origins: Array, rays: Array, depth_m: Array) -> Array:
    """Find the point (L, 3) nearest to each landmark's rays: origins and unit rays (L, k, 3) in g.

    A point nearer than half of the DVL's range depth_m (L,), or farther than twice, is replaced by
    the point at that range along the first ray, as a front end would.
    """
    across = np.eye(3) - rays[..., :, None] * rays[..., None, :]
    normal, right = across.sum(1), np.einsum("lkij,lkj->li", across, origins)
    # A thousandth of a ray's weight keeps parallel rays from falling on a singular matrix; it moves
    # no good point visibly.
    first = origins[:, 0] + depth_m[:, None] * rays[:, 0]
    point = np.linalg.solve(normal + 1e-6 * np.eye(3), (right + 1e-6 * first)[..., None])[..., 0]
    depth = np.einsum("lkj,lkj->lk", point[:, None] - origins, rays)
    good = ((depth > 0.5 * depth_m[:, None]) & (depth < 2 * depth_m[:, None])).all(1)
    return np.where(good[:, None], point, first)


def mount_error(rng: np.random.Generator, shift_m: float, turn_rad: float) -> Poses:
    """Draw a small motion with white translation and rotation."""
    return poses.exp(np.r_[shift_m * rng.standard_normal(3), turn_rad * rng.standard_normal(3)])
