# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the vehicle is at any time: smooth in position and attitude, with a tray whose servo has
backlash.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Hold the path. t_s (n,) seconds since the log's start; position (n, 3) and roll_pitch_yaw (n,
    3) of the vehicle in g; encoder (n,) what the tray's servo reports, tray (n,) what it truly
    does, sonar_tray (n,), rad; T_g_M.
    """

    t_s: Array
    position: Array
    roll_pitch_yaw: Array
    encoder: Array
    tray: Array
    sonar_tray: Array
    global_from_hull: Poses

    def vehicle(self, t_s: Array) -> Poses:
        """Return T_g_v at times (n,)."""
        return poses.from_rpy(
            self._spline(self.position)(t_s), self._spline(self.roll_pitch_yaw)(t_s)
        )

    def angle(self, series: Array, t_s: Array) -> Array:
        """Return a servo's angle (n,) at times, from its series over the motion."""
        return np.interp(t_s, self.t_s, series)

    def on_tray(
        self,
        t_s: Array,
        mount: Poses,
        origin_m: tuple[float, float, float],
        series: Array | None = None,
    ) -> Poses:
        """Return T_g_x of something mounted so on a servo (the camera tray, unless another series
        of angles is given).
        """
        angle = self.angle(self.tray if series is None else series, t_s)
        return self.vehicle(t_s) @ poses.tray_poses(origin_m, angle) @ mount

    def rates(self, t_s: Array, half_s: float = 0.01) -> Array:
        """Return the angular velocity (n, 3) in the vehicle, rad/s."""
        before, after = self.vehicle(t_s - half_s).rotation, self.vehicle(t_s + half_s).rotation
        return np.asarray((before.inv() * after).as_rotvec() / (2 * half_s))

    def acceleration(self, t_s: Array) -> Array:
        """Return the second derivative (n, 3) of the position in g, m/s2."""
        return np.asarray(self._spline(self.position)(t_s, 2))

    def in_hull(self, frames: Poses) -> Poses:
        """Return T_M_x of frames given in g."""
        return self.global_from_hull.inverse() @ frames

    def _spline(self, values: Array) -> Callable[..., Array]:
        from scipy.interpolate import CubicSpline

        spline: Callable[..., Array] = CubicSpline(self.t_s, values)
        return spline


def with_backlash(command: Array, backlash: float) -> Array:
    """Return the angle (n,) of the load behind a gear with that backlash (half the dead band): it
    stands still while the gear crosses the band.
    """
    out = np.empty_like(command)
    at = float(command[0])
    for k, c in enumerate(command.tolist()):
        at = min(max(at, c - backlash), c + backlash)
        out[k] = at
    return out


def ticks(
    motion: Motion, rate_hz: float, random: np.random.Generator, first_s: float = 0.25
) -> Array:
    """Return the times (n,) of a sensor, s: nearly even, inside the motion."""
    t = np.arange(first_s, motion.t_s[-1] - 0.2, 1 / rate_hz)
    return np.asarray(t + random.uniform(-0.01, 0.01, len(t)) / max(1.0, rate_hz / 5))
