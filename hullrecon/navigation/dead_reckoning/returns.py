# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The DVL's returns by their nearest node, and those that disagree with their neighbours."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.navigation.dead_reckoning.reckoning import Instant, Reckoning
from hullrecon.navigation.sensors.smoothing import running_median
from hullrecon.records.clock import nearest
from hullrecon.records.sensors import DvlPings
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Array, Mask


def returns(dvl: DvlPings, path: Reckoning, nodes: Instant, flagged: Mask) -> Returns:
    """Return one row a beam that came back, by ping and then by beam. flagged (pings, beams). Pings
    beyond the nodes' span by more than a second are left out: nothing places them.
    """
    inside = (dvl.t_ns >= nodes.t_ns[0] - 10**9) & (dvl.t_ns <= nodes.t_ns[-1] + 10**9)
    back = mark_lost(dvl.ranges)
    ping, beam = np.nonzero(np.isfinite(back) & inside[:, None])
    at = path.at(dvl.t_ns)
    node = nearest(nodes.t_ns, dvl.t_ns)
    offset = nodes.poses()[node].inverse() @ at.poses()
    return Returns(
        t_ns=dvl.t_ns[ping],
        node=node[ping],
        quaternion=offset.quaternion[ping],
        translation=offset.translation[ping],
        tray_offset=(at.tray - nodes.tray[node])[ping],
        beam=dvl.beams[beam],
        range_m=back[ping, beam],
        flagged=flagged[ping, beam],
    )


def mark_lost(ranges: Array) -> Array:
    """Return ranges with what is no return (zero, negative, infinite) as NaN."""
    return np.where(np.isfinite(ranges) & (ranges > 0), ranges, np.nan)


def flag_ranges(
    dvl: DvlPings, window_s: float, jump_m: float, sigmas: float, sigma_range_m: float
) -> Mask:
    """Return which ranges (n, b) leave the median of their beam's neighbours by jump_m or so many
    robust sigma of the window.

    The robust sigma is that of the neighbours' own departures, at least the instrument's.
    """
    ranges = mark_lost(dvl.ranges)
    if len(ranges) < 3:
        return np.zeros(ranges.shape, bool)
    period_s = float(np.median(np.diff(dvl.t_ns))) * 1e-9
    count = 2 * max(1, round(0.5 * window_s / max(period_s, 1e-3))) + 1
    away = np.abs(ranges - running_median(ranges, count))
    sigma = np.maximum(NORMAL_MAD * running_median(away, count), sigma_range_m)
    with np.errstate(invalid="ignore"):
        return np.asarray((away > jump_m) | (away > sigmas * sigma))
