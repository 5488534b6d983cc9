# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How the odometry of a solved path changes if the DVL's readings were stamped late.

Its velocities then belong to earlier times. A step measured t too late is off by as much as the
velocity changes over it, times t: nothing on a straight leg, and most where legs turn back. Images
that link the nodes show it (docs/methods.md 6).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.records.clock import seconds
from hullrecon.typing import Array, Ints

LONGEST_S = 5.0  # between neighbouring nodes; longer pauses give no velocity


@dataclass(frozen=True, kw_only=True)
class VelocityChange:
    """Change of the velocity over each step of a problem's odometry."""

    change: Array  # (m, 3) m/s, in the axes of the step's first node

    def punctual(self, problem: native.Problem, late_s: float) -> native.Problem:
        """Change the odometry to what it would be with right stamps.

        problem: the steps of its odometry are those of the change. late_s: by how much the stamps
        of the DVL are late, s. Negative: early.
        """
        measured = problem.odometry.measured.copy()
        measured[:, :3] += late_s * self.change
        return replace(problem, odometry=replace(problem.odometry, measured=measured))


def velocity_change(problem: native.Problem, t_ns: Ints) -> VelocityChange:
    """Compute how the velocity of a solved path changes over each step of its odometry.

    Zero next to a pause, where neighbouring nodes give no velocity. t_ns (n,): stamps of the nodes.
    """
    pose, odometry = problem.unknowns.pose, problem.odometry
    if len(t_ns) < 3 or pose is None:
        return VelocityChange(change=np.zeros((len(odometry.first), 3)))
    t_s = seconds(t_ns, int(t_ns[0]))
    velocity = np.gradient(pose[:, :3], t_s, axis=0)
    pause = np.diff(t_s) > LONGEST_S
    velocity[np.r_[pause, False] | np.r_[False, pause]] = np.nan
    change = velocity[odometry.second] - velocity[odometry.first]
    own = Rotation.from_quat(pose[odometry.first, 3:7]).inv().apply(change)
    return VelocityChange(change=np.nan_to_num(own))
