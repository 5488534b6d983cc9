# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Attach DVL returns to their nearest node, and flag those that disagree with their neighbours."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.navigation.dead_reckoning.reckoning import Instant, Reckoning
from hullrecon.navigation.sensors.smoothing import running_median
from hullrecon.records.clock import nearest
from hullrecon.records.sensors import DvlPings
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Mask

WINDOW_S = 3.0  # around a range, of the beam's neighbouring ranges that it is compared with
# a range is flagged where it differs from their median by more than this distance, m, or more than
# this many sigmas
JUMP_M, OUTLIER_SIGMAS = 0.5, 5.0


def returns(dvl: DvlPings, path: Reckoning, nodes: Instant, flagged: Mask) -> Returns:
    """Attach each range that came back to the node nearest in time, sorted by ping and then beam.

    Ranges then move with the nodes when these are adjusted. Flagged ones are kept with their flag.
    Pings more than a second beyond the nodes are left out, as their pose is not known.

    Parameters
    ----------
    dvl
        All pings with their ranges.
    path
        Gives the vehicle's pose at each ping, which is recorded relative to its node.
    nodes
        The same path at the nodes.
    flagged
        Ranges (pings, beams) that disagree with their neighbours (`flag_ranges`).
    """
    inside = (dvl.t_ns >= nodes.t_ns[0] - 10**9) & (dvl.t_ns <= nodes.t_ns[-1] + 10**9)
    ping, beam = np.nonzero(np.isfinite(dvl.ranges) & inside[:, None])
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
        range_m=dvl.ranges[ping, beam],
        flagged=flagged[ping, beam],
        scale_sigma=dvl.range_scale_sigma,
    )


def flag_ranges(dvl: DvlPings, sigma_range_m: float, sigmas: float = OUTLIER_SIGMAS) -> Mask:
    """Flag DVL ranges (n, b) that disagree with the running median of their beam.

    They may have met a fish, a bubble or another part of the hull, and are not used for its
    surface. None is flagged with fewer than three pings. The sigma is the robust scatter of the
    neighbouring ranges about that median, or that of the instrument where this is larger.

    Parameters
    ----------
    dvl
        Pings in time order, whose ranges are compared beam by beam.
    sigma_range_m
        Sigma of a range by the instrument.
    sigmas
        How many sigmas from the median a range may lie.
    """
    ranges = dvl.ranges
    if len(ranges) < 3:
        return np.zeros(ranges.shape, bool)
    period_s = float(np.median(np.diff(dvl.t_ns))) * 1e-9
    count = 2 * max(1, round(0.5 * WINDOW_S / max(period_s, 1e-3))) + 1
    deviation = np.abs(ranges - running_median(ranges, count))
    sigma = np.maximum(NORMAL_MAD * running_median(deviation, count), sigma_range_m)
    with np.errstate(invalid="ignore"):
        return np.asarray((deviation > JUMP_M) | (deviation > sigmas * sigma))
