# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The logs of a vehicle that swims along a wall and looks at it, held by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from navigation.conftest import JANUS, START_NS, SimulatedPath

from hullrecon.geometry import poses
from hullrecon.navigation.clocks.comparisons.comparison import ClockedSensor
from hullrecon.navigation.dead_reckoning.dead_reckon import NavigationLogs

WALL_M = 1.4
STREAMS = {
    ClockedSensor.DVL: "dvl",
    ClockedSensor.IMU: "imu",
    ClockedSensor.PRESSURE: "pressure",
    ClockedSensor.IMAGES: "top",
}


def unsteady(t: np.ndarray, seed: int = 11) -> np.ndarray:
    """Six signals that never repeat, of size one, as of a vehicle in a swell."""
    rng = np.random.default_rng(seed)
    rate, phase = 2 * np.pi * rng.uniform(0.03, 0.22, (7, 6)), rng.uniform(0, 2 * np.pi, (7, 6))
    return np.sum(np.sin(t[:, None, None] * rate + phase), axis=1) * np.sqrt(2 / 7)


@dataclass(frozen=True)
class AlongWall(SimulatedPath):
    """Sideways before the wall x = WALL_M, with turns and heaving of a vehicle that is held by
    hand.
    """

    duration_s: float = 240.0

    def attitude(self, t):
        return poses.from_rpy(np.zeros((len(t), 3)), 0.017 * unsteady(t)[:, 3:]).rotation

    def place(self, t):
        sunk = 2 + 0.3 * unsteady(0.4 * t + 100)[:, 0]
        return 0.012 * unsteady(t)[:, :3] + np.stack([0 * t, 6 * np.sin(0.05 * t), sunk], axis=1)

    def tray(self, t):
        return 0.1 + 0.02 * np.sin(0.4 * t)

    def cameras(self, t):
        mounted = self.poses(t) @ poses.tray_poses(self.rig.tray_origin, self.tray(t))
        return mounted @ self.rig.tray_from_top


def logs_along_wall(swum: AlongWall) -> NavigationLogs:
    """With the noise of usual instruments."""
    logs = swum.logs(noise=1.0, seed=3, dvl_hz=5.0, imu_hz=25.0)
    at = swum.instrument((logs.dvl.t_ns - START_NS) * 1e-9)
    ranges = np.stack(
        [(WALL_M - at.translation[:, 0]) / at.rotation.apply(beam)[:, 0] for beam in JANUS], axis=1
    )
    noise = 0.01 * np.random.default_rng(4).standard_normal(ranges.shape)
    return replace(logs, dvl=replace(logs.dvl, ranges=ranges + noise))


def late(
    logs: NavigationLogs, sensor: ClockedSensor, seconds: float, from_s: float = -10.0
) -> NavigationLogs:
    stream = getattr(logs, STREAMS[sensor])
    t_ns = stream.t_ns + np.where(stream.t_ns >= START_NS + from_s * 1e9, round(seconds * 1e9), 0)
    return replace(logs, **{STREAMS[sensor]: replace(stream, t_ns=t_ns)})
