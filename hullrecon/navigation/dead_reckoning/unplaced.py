# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Describe DVL and IMU measurements that go unused because the vehicle's pose is not known then."""

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
    """Describe how much was measured while the vehicle's pose is not known.

    These are velocities without an attitude, ranges before or after the path, and readings of an
    IMU that ran on without a velocity. Small shares are not mentioned, so the list may be empty.

    Parameters
    ----------
    dvl, imu
        All that was logged.
    pressure
        Tells when the vehicle was under water. None without one.
    velocities, returns
        Velocities that the path uses, and ranges that were attached to nodes.
    nodes_ns
        Stamps of the nodes, from the first of which to the last the pose is known.
    """
    given_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    used_ns = np.concatenate([velocities.t_ns, velocities.outliers])
    without_attitude = int(
        np.count_nonzero((given_ns < used_ns.min()) | (given_ns > used_ns.max()))
    )
    ranges = int(np.count_nonzero(np.isfinite(dvl.ranges)))
    unheard_s = seconds_beyond(imu.t_ns, pressure, (int(nodes_ns[0]), int(nodes_ns[-1])))
    return [
        *_describe_unused(
            without_attitude, len(given_ns), "velocities", "where no attitude was read"
        ),
        *_describe_unused(ranges - len(returns.t_ns), ranges, "ranges", "before or after the path"),
        *([_silent(unheard_s)] if unheard_s >= UNPLACED_S else []),
    ]


def _describe_unused(count: int, total: int, noun: str, where: str) -> list[str]:
    """Describe measurements that cannot be used, if they are UNPLACED_SHARE of all or more.

    Empty for fewer. count of total: how many. noun, where: what they are, and why they are unused.
    """
    if count < UNPLACED_SHARE * max(total, 1):
        return []
    return [
        f"DVL: {100 * count / total:.0f} % of its {noun} ({count} of {total}) lie "
        f"{where} and are not used"
    ]


def _silent(seconds: float) -> str:
    """Describe readings under water that no path reaches, as the DVL was silent.

    seconds: that they last.
    """
    return (
        f"IMU: {seconds:.1f} s of its readings under water lie before or after the path: "
        "the DVL gave no velocity then, and "
        "nothing says where the vehicle was"
    )
