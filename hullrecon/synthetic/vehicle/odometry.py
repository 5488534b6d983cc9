# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Odometry along a true path, its errors drawn from the sigmas that its record states, and dead
reckoning from it.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, from_matrix
from hullrecon.records.trajectory import Odometry, Trajectory
from hullrecon.typing import Array


def measured_steps(
    rng: np.random.Generator,
    truth: Array,
    navigation: Array,
    mount: Array,
    step_s: float,
    step_sigma: Array,
) -> Odometry:
    """Return the steps of a path T_g_v (n, 4, 4), one every step_s, with a wrong scale and a
    drifting heading, the first two of navigation (rad/s), and a DVL mount turned by mount (3,) rad,
    besides white noise of step_sigma (6,) m, rad.
    """
    first, second = np.arange(len(truth) - 1), np.arange(1, len(truth))
    step = np.linalg.inv(truth[first]) @ truth[second]
    t, m = step[:, :3, 3], len(first)
    by_navigation, by_mount, by_tray = np.zeros((m, 6, 2)), np.zeros((m, 6, 3)), np.zeros((m, 6))
    by_navigation[:, :3, 0] = t
    by_navigation[:, :3, 1] = 0.5 * step_s * np.cross(truth[first, 2, :3], t)
    by_navigation[:, 3:, 1] = step_s * truth[second, 2, :3]
    # what a small turn of the mount does: turn x t
    by_mount[:, :3] = np.cross(t[:, None], np.eye(3))
    by_tray[:, :3] = np.cross([0.0, 1.0, 0.0], t)
    error = (
        by_navigation @ navigation[:2] + by_mount @ mount + step_sigma * rng.standard_normal((m, 6))
    )
    turn = Rotation.from_matrix(step[:, :3, :3]) * Rotation.from_rotvec(-error[:, 3:])
    return Odometry(
        first=first,
        second=second,
        quaternion=turn.as_quat(),
        translation=t - error[:, :3],
        covariance=np.tile(np.diag(step_sigma**2), (m, 1, 1)),
        by_navigation=by_navigation,
        by_mount=by_mount,
        by_tray=by_tray,
        from_images=np.zeros(m, bool),
    )


def reckoned(start: Array, odometry: Odometry, step_s: float) -> Trajectory:
    """Return the path, one node every step_s, that the steps give from a first pose T_g_v (4, 4)
    on. Its covariance is unity: a pose graph does not read it.
    """
    track = [start]
    for step in Poses(odometry.quaternion, odometry.translation).matrix():
        track.append(track[-1] @ step)
    found, n = from_matrix(np.array(track)), len(track)
    return Trajectory(
        t_ns=(step_s * 1e9 * np.arange(n)).astype(np.int64),
        quaternion=found.quaternion,
        translation=found.translation,
        covariance=np.tile(np.eye(6), (n, 1, 1)),
        tray=np.zeros(n),
        image=np.tile(np.arange(n)[:, None], (1, 2)),
    )
