# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""DVL and IMU measurements that go unused because nothing places the vehicle there."""

from __future__ import annotations

import numpy as np

from hullrecon.dive.check.consistency_checks import UNPLACED_S, UNPLACED_SHARE, seconds_beyond
from hullrecon.navigation.sensors.velocity import Velocities
from hullrecon.records.sensors import DvlPings, ImuSamples, PressureSamples
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Ints


def describe_unplaced(
    dvl: DvlPings,
    imu: ImuSamples,
    pressure: PressureSamples | None,
    velocities: Velocities,
    nodes_ns: Ints,
    returns: Returns,
) -> list[str]:
    """Say how much was measured where nothing places the vehicle.

    These are velocities without an attitude, ranges beyond the path, and an IMU that ran on without
    a velocity. Small shares are not mentioned.
    """
    given_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    used_ns = np.concatenate([velocities.t_ns, velocities.outliers])
    unread = int(np.count_nonzero((given_ns < used_ns.min()) | (given_ns > used_ns.max())))
    back = int(np.count_nonzero(np.isfinite(dvl.ranges)))
    unheard_s = seconds_beyond(imu.t_ns, pressure, (int(nodes_ns[0]), int(nodes_ns[-1])))
    return [
        *_unused(unread, len(given_ns), "velocities", "where no attitude was read"),
        *_unused(back - len(returns.t_ns), back, "ranges", "before or after the path"),
        *([_silent(unheard_s)] if unheard_s >= UNPLACED_S else []),
    ]


def _unused(count: int, of: int, noun: str, where: str) -> list[str]:
    """Note measurements that cannot be used, where they are more than UNPLACED_SHARE of all."""
    if count < UNPLACED_SHARE * max(of, 1):
        return []
    return [
        f"DVL: {100 * count / of:.0f} % of its {noun} ({count} of {of}) lie "
        f"{where} and are not used"
    ]


def _silent(seconds: float) -> str:
    return (
        f"IMU: {seconds:.1f} s of its readings under water lie before or after the path: "
        "the DVL gave no velocity then, and "
        "nothing says where the vehicle was"
    )
