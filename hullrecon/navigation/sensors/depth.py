# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Depth: the DVL's vertical path, held to the pressure sensor slowly.

Over a second the DVL knows the vertical step to a millimetre where one pressure reading scatters by centimetres; over minutes
the pressure is right. So what is smoothed is the difference of the two, over WIDTH_S: ten readings a second of 0.02 m leave
some 1.5 mm, and a drift that is steady over half a minute (scale, mount) is followed without lag.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import robust_sigma
from hullrecon.navigation.dead_reckoning.reckoning import Reckoning
from hullrecon.navigation.sensors.silence import describe_silence, unread_s
from hullrecon.navigation.sensors.smoothing import local_line, running_median
from hullrecon.records.sensors import PressureSamples
from hullrecon.typing import Array, Ints

WIDTH_S = 5.0
STEP_M = 0.3  # between two readings, beyond what the DVL saw


@dataclass(frozen=True, kw_only=True)
class Depth:
    """z to add to the DVL's vertical path at the nodes: shift (n,), its sigma (m). measured (n,): depth of the sensor there.
    steps (k,): stamps where the pressure jumped against the DVL; white: scatter of one reading, m. unread_s (n,): how far in
    time the next reading is, 0 where the depth was measured; silence: the same in words, "" without any."""

    shift: Array
    sigma: float
    measured: Array
    steps: Ints
    white: float
    unread_s: Array
    silence: str


def hold_to_pressure(pressure: PressureSamples, path: Reckoning, nodes_ns: Ints, window_s: float) -> Depth:
    """Return what the pressure adds to the path's depth, from a record in time order; window_s: half a node's share of the
    time, over which readings are averaged."""
    known = np.isfinite(pressure.depth)
    t_ns, depth = pressure.t_ns[known], pressure.depth[known]
    t, at = path_seconds(path, t_ns), path_seconds(path, nodes_ns)
    gap = depth - _sensor(path, t_ns)
    steady = running_median(gap[:, None], 5)[:, 0]
    slow, _ = local_line(t, steady, np.concatenate([at, t]), WIDTH_S)
    fitted, unread = slow[len(at) :, 0], unread_s(t_ns, nodes_ns)
    shift = np.where(unread > 0, np.interp(at, t, fitted), slow[: len(at), 0])  # a line fitted to noise leads far astray there
    white = robust_sigma(gap - fitted, about=0.0)
    step = float(np.median(np.diff(t)))
    sigma = max(white * np.sqrt(step / (2 * np.sqrt(np.pi) * WIDTH_S)), 1e-3)
    near, _ = local_line(t, steady, at, window_s)
    jumps = np.abs(np.diff(steady)) > max(STEP_M, 6 * white)
    measured = near[:, 0] + _sensor(path, nodes_ns)
    silence = describe_silence(t_ns, nodes_ns)
    return Depth(
        shift=shift, sigma=float(sigma), measured=measured, steps=t_ns[1:][jumps], white=white, unread_s=unread, silence=silence
    )


def path_seconds(path: Reckoning, t_ns: Ints) -> Array:
    """Return seconds (n,) since the start of the path."""
    return np.asarray((t_ns - path.start_ns) * 1e-9)


def _sensor(path: Reckoning, t_ns: Ints) -> Array:
    """Return z (n,) of the pressure sensor by the DVL's path."""
    return np.asarray(path.at(t_ns).poses().apply(path.rig.pressure_origin)[:, 2])
