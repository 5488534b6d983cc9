# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare the pressure sensor's depth with the DVL's path, and with the water's surface.

The change of depth is held against the integral of the DVL's vertical velocity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import robust_sigma
from hullrecon.navigation.sensors.smoothing import local_line
from hullrecon.navigation.suspects.comparisons.comparison import (
    LATE_S,
    LEAST_WINDOWS,
    SMOOTH_S,
    Comparison,
    Sensor,
    change_over,
    cut_windows,
)
from hullrecon.navigation.suspects.comparisons.dvl_track import Track
from hullrecon.records.clock import period, seconds
from hullrecon.records.sensors import PressureSamples
from hullrecon.typing import Array, Ints

SUNK_S = 3.0  # length of the windows in which the change of depth is compared
LEVELS = np.linspace(0.25, 0.75, 5)  # quantiles of the depth that are compared with the surface
HIGHEST_M, SURFACE_SIGMA_M = 1.0, 0.3  # a sensor above the surface, and the day's air pressure
SCALE = 0.015  # sigma of the scale of a DVL and of the water's density together
DEPTH_SIGMA_M = 0.005  # of a change of depth by two smoothed readings, at least
ROUGH_SHARE = 0.4  # of LATE_S, by which the lags of two smoothed sensors differ from time to time


def compare_level(pressure: PressureSamples) -> Comparison:
    """Compare quantiles of the depth with the water's surface: no vehicle dives above it."""
    read = pressure.depth[np.isfinite(pressure.depth)]
    depth = np.quantile(read, LEVELS) if len(read) else np.zeros(len(LEVELS))
    above = np.minimum(depth + HIGHEST_M, 0.0)  # m, negative beyond HIGHEST_M over the surface
    return Comparison(
        kind="level",
        sensors=frozenset({Sensor.PRESSURE}),
        residual=above,
        sigma=np.full(len(LEVELS), SURFACE_SIGMA_M),
        by_nuisance=np.zeros((len(LEVELS), 0)),
        first=above,
        second=np.zeros(len(LEVELS)),
    )


@dataclass(frozen=True, kw_only=True)
class SmoothedDepth:
    """The depth by the pressure sensor at the pings of a track, smoothed."""

    windows: Ints  # (m, 2) first and last row of each window in which changes are compared
    depth: Array  # (n,) m
    sigma: float  # m, noise of a smoothed depth


def smooth_depth(pressure: PressureSamples, ping_ns: Ints) -> SmoothedDepth | None:
    """Smooth the pressure sensor's depth at the pings of a track.

    None where too few windows have both. ping_ns (n,): stamps of the track.
    """
    read = np.isfinite(pressure.depth)
    read_ns, depth = pressure.t_ns[read], pressure.depth[read]
    if len(read_ns) < LEAST_WINDOWS:
        return None
    windows = cut_windows(ping_ns, SUNK_S, (ping_ns >= read_ns[0]) & (ping_ns <= read_ns[-1]))
    if len(windows) < LEAST_WINDOWS:
        return None
    start = int(ping_ns[0])
    read_s, t_s = seconds(read_ns, start), seconds(ping_ns, start)
    # White noise of a reading, from second differences. Smoothing reduces it to `sigma`.
    white = robust_sigma(np.diff(depth, n=2), about=0.0) / np.sqrt(6)
    return SmoothedDepth(
        windows=windows,
        depth=local_line(read_s, depth, t_s, SMOOTH_S)[0][:, 0],
        sigma=float(white * np.sqrt(period(read_s) / (2 * np.sqrt(np.pi) * SMOOTH_S))),
    )


def compare_depth(smoothed: SmoothedDepth, track: Track) -> Comparison:
    """Compare the change of the pressure sensor's depth with that of the DVL's path.

    Nuisances are a tilt of the DVL, a scale and a time offset.
    """
    windows = smoothed.windows
    sunk, way = change_over(smoothed.depth, windows), change_over(track.way.total, windows)
    late = LATE_S * change_over(track.way.signal[:, 2], windows)
    return Comparison(
        kind="depth",
        sensors=frozenset({Sensor.PRESSURE, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY}),
        residual=sunk - way[:, 2] + change_over(track.lever[:, 2], windows),
        sigma=np.sqrt(2 * smoothed.sigma**2 + DEPTH_SIGMA_M**2 + (ROUGH_SHARE * late) ** 2),
        by_nuisance=np.column_stack(
            [change_over(track.sunk_by_tilt, windows), SCALE * way[:, 2], late]
        ),
        first=sunk,
        second=way[:, 2],
    )
