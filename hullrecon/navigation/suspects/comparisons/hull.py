# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare the DVL's velocity and the attitude with the hull that the DVL's ranges show.

The hull does not move, so that a DVL that moves and turns sees it come nearer and turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import median_of_known
from hullrecon.navigation.dead_reckoning.integral import integral
from hullrecon.navigation.sensors.motion_signals import hull_normals
from hullrecon.navigation.sensors.smoothing import local_line
from hullrecon.navigation.suspects.comparisons.comparison import (
    LEAST_WINDOWS,
    SMOOTH_S,
    TILT_RAD,
    Comparison,
    Sensor,
    change_over,
    cut_windows,
)
from hullrecon.navigation.suspects.comparisons.dvl_track import Track
from hullrecon.records.clock import seconds
from hullrecon.records.sensors import DvlPings
from hullrecon.typing import Array, Ints

NEARED_S = 2.0  # length of the windows in which the distance is compared
ALONG_1_M = 0.05  # curvature of a hull along its length
RELIEF_M, RELIEF_RAD = 0.03, 0.03  # plates, weld seams and curvature within a window


@dataclass(frozen=True, kw_only=True)
class HullPlanes:
    """Planes through the returns of each ping that has enough."""

    ping: Ints  # (n,) rows of the pings
    normal: Array  # (n, 3) in the DVL's frame, away from it
    distance: Array  # (n,) m


def hull_planes(dvl: DvlPings) -> HullPlanes:
    """Fit a plane to the returns of each ping that has enough, with its distance from the DVL."""
    t_ns, normal = hull_normals(dvl)
    if not len(t_ns):
        return HullPlanes(ping=t_ns, normal=normal, distance=np.zeros(0))
    ping = np.searchsorted(dvl.t_ns, t_ns)
    ends = dvl.ranges[ping][:, :, None] * dvl.beams
    distance = median_of_known((ends * normal[:, None]).sum(axis=2))
    return HullPlanes(ping=ping, normal=normal, distance=distance)


def compare_ranges(ping_ns: Ints, hull: HullPlanes, track: Track) -> list[Comparison]:
    """Compare the hull that the DVL's ranges show with its velocity, and with the attitude.

    As the hull does not move, its distance changes by the velocity along its normal ("range"), and
    its normal keeps its direction in `global` ("hull"). Of the latter the part along the tray's
    axis is compared, which the tray's angle does not change. Both are coarse, as a hull is curved.

    Parameters
    ----------
    ping_ns
        Stamps of all pings.
    hull
        Planes of the pings that show one.
    track
        Path and attitude of the DVL.
    """
    common, rows, plane_rows = np.intersect1d(track.t_ns, ping_ns[hull.ping], return_indices=True)
    if len(common) < LEAST_WINDOWS:
        return []
    t_s = seconds(common, int(common[0]))
    planes = np.column_stack([hull.normal, hull.distance])[plane_rows]
    smooth, _ = local_line(t_s, planes, t_s, SMOOTH_S)
    normal = smooth[:, :3] / np.linalg.norm(smooth[:, :3], axis=1, keepdims=True)
    distance = smooth[:, 3]
    windows = cut_windows(common, NEARED_S)
    if len(windows) < LEAST_WINDOWS:
        return []
    first, last = windows.T
    own = track.global_from_dvl[rows]
    seen, axis = own.apply(normal), track.global_from_vehicle[rows].apply([0.0, 1.0, 0.0])
    # The distance falls by the way along the normal, so that the sum of both changes is zero.
    way = change_over(track.way.total[rows], windows)
    middle = 0.5 * (seen[first] + seen[last])
    nearer = change_over(distance, windows) + (middle * way).sum(axis=1)
    # the way, if the velocity along the DVL's z axis had the other sign
    reversed_velocity = track.global_from_dvl.inv().apply(track.way.signal) * [1.0, 1.0, -1.0]
    mirrored = integral(track.way.t_s, track.global_from_dvl.apply(reversed_velocity)).total[rows]
    # In `global` the normal does not change. Along the tray's axis it holds no error of the tray.
    turned = ((seen[last] - seen[first]) * axis[first]).sum(axis=1)
    along = (way * axis[first]).sum(axis=1)
    return [
        Comparison(
            kind="range",
            sensors=frozenset({Sensor.DVL}),
            residual=nearer,
            sigma=np.full(len(nearer), RELIEF_M),
            by_nuisance=TILT_RAD * way,  # the normal may be off by TILT_RAD along each axis
            first=(middle * way).sum(axis=1),
            second=-change_over(distance, windows),
            is_coarse=True,
            if_reversed=nearer + (middle * (change_over(mirrored, windows) - way)).sum(axis=1),
        ),
        Comparison(
            kind="hull",
            sensors=frozenset({Sensor.ATTITUDE, Sensor.DVL}),
            residual=turned,
            sigma=np.full(len(turned), RELIEF_RAD),
            by_nuisance=ALONG_1_M * along[:, None],  # a curved hull turns its normal on the way
            first=turned,
            second=change_over(normal, windows)[:, 1],  # along the DVL's y, as the DVL saw it turn
            is_coarse=True,
            if_reversed=turned - 2 * change_over(normal, windows)[:, 1],
        ),
    ]
