# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from navigation.instruments import RIG
from scipy.spatial.transform import Rotation

from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.dead_reckoning.dead_reckon import NavigationLogs
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PressureSamples,
)
from hullrecon.rig import Rig

START_NS = 1_777_887_000_000_000_000
JANUS = np.array(
    [[-0.5, 0, 0.75**0.5], [0.5, 0, 0.75**0.5], [0, 0.5, 0.75**0.5], [0, -0.5, 0.75**0.5]]
)


def nanoseconds(t_s: np.ndarray) -> np.ndarray:
    return START_NS + np.round(t_s * 1e9).astype(np.int64)


@dataclass(frozen=True)
class SimulatedPath:
    """A swum path whose every quantity is known in closed form: seconds to poses, tray and sensor
    readings.
    """

    rig: Rig
    duration_s: float = 40.0

    def attitude(self, t: np.ndarray) -> Rotation:
        rpy = [0.04 * np.sin(0.5 * t), 0.06 * np.cos(0.37 * t), 0.3 * np.sin(0.11 * t)]
        return Rotation.from_euler("xyz", np.stack(rpy, axis=1))

    def place(self, t: np.ndarray) -> np.ndarray:
        return np.stack([0.3 * t, 1.5 * np.sin(0.2 * t), 2.0 + 0.5 * np.sin(0.15 * t)], axis=1)

    def tray(self, t: np.ndarray) -> np.ndarray:
        return 0.3 + 0.25 * np.sin(0.3 * t)

    def poses(self, t: np.ndarray) -> Poses:
        return Poses(self.attitude(t).as_quat(), self.place(t))

    def instrument(self, t: np.ndarray) -> Poses:
        return (
            self.poses(t)
            @ poses.tray_poses(self.rig.tray_origin, self.tray(t))
            @ self.rig.tray_from_dvl
        )

    def velocity(self, t: np.ndarray) -> np.ndarray:
        """Of the instrument in dvl: central differences of its path, good to 1e-8 m/s."""
        h = 1e-4
        v_g = (self.instrument(t + h).translation - self.instrument(t - h).translation) / (2 * h)
        return self.instrument(t).rotation.inv().apply(v_g)

    def rates(self, t: np.ndarray) -> np.ndarray:
        h = 1e-4
        return (self.attitude(t - h).inv() * self.attitude(t + h)).as_rotvec() / (2 * h)

    def logs(
        self, noise: float = 0.0, seed: int = 0, dvl_hz: float = 20.0, imu_hz: float = 50.0
    ) -> NavigationLogs:
        """noise 1: usual instruments; 0: perfect ones, sampled fast enough that sampling does not
        show.
        """
        rng = np.random.default_rng(seed)
        end = self.duration_s
        t = np.arange(0, end, 1 / dvl_hz)
        ti = np.arange(-0.5, end + 0.5, 1 / imu_hz)
        tp = np.arange(-0.3, end, 0.1)
        drift = Rotation.from_rotvec(noise * np.radians(0.1) * rng.standard_normal((len(ti), 3)))
        velocity = self.velocity(t) + noise * 0.003 * rng.standard_normal((len(t), 3))
        rates = self.rates(ti) + noise * 0.002 * rng.standard_normal((len(ti), 3))
        depth = self.poses(tp).apply(self.rig.pressure_origin)[
            :, 2
        ] + noise * 0.02 * rng.standard_normal(len(tp))
        frames = np.arange(0.25, end - 0.3, 0.5)
        return NavigationLogs(
            dvl=DvlPings(
                t_ns=nanoseconds(t),
                velocity=velocity,
                velocity_sigma=np.full(len(t), 0.003),
                ranges=np.full((len(t), 4), 1.5),
                beams=JANUS,
            ),
            imu=ImuSamples(
                t_ns=nanoseconds(ti),
                quaternion=(self.attitude(ti) * drift).as_quat(),
                angular_velocity=rates,
                acceleration=np.full((len(ti), 3), np.nan),
            ),
            pressure=PressureSamples(t_ns=nanoseconds(tp), depth=depth),
            tray=JointSamples(t_ns=nanoseconds(ti), angle=self.tray(ti)),
            top=frames_at(frames),
        )


def frames_at(t_s: np.ndarray) -> ImageIndex:
    n = len(t_s)
    empty = np.zeros(n, np.int64)
    return ImageIndex(
        t_ns=nanoseconds(t_s),
        file=np.full(n, ""),
        offset=empty,
        size=empty,
        usable=np.ones(n, bool),
    )


@pytest.fixture(scope="session")
def rig() -> Rig:
    return RIG


@pytest.fixture(scope="session")
def simulated(rig: Rig) -> SimulatedPath:
    return SimulatedPath(rig)


@pytest.fixture(scope="session")
def perfect(simulated: SimulatedPath) -> NavigationLogs:
    return simulated.logs()


@pytest.fixture(scope="session")
def noisy(simulated: SimulatedPath) -> NavigationLogs:
    return simulated.logs(noise=1.0)


def without(logs: NavigationLogs, start_s: float, stop_s: float) -> NavigationLogs:
    """The DVL silent in an interval."""
    t = logs.dvl.t_ns
    gone = (t >= START_NS + start_s * 1e9) & (t <= START_NS + stop_s * 1e9)
    velocity = logs.dvl.velocity.copy()
    velocity[gone] = np.nan
    return replace(logs, dvl=replace(logs.dvl, velocity=velocity))


@pytest.fixture(scope="session")
def silenced():
    return without


@pytest.fixture(scope="session")
def frames():
    return frames_at
