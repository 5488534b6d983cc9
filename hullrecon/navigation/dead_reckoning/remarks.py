# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Remarks of navigation: outages, flagged beams, steps in depth, holes in the attitude."""

from __future__ import annotations

import numpy as np

from hullrecon.navigation.dead_reckoning.nodes import Nodes
from hullrecon.navigation.dead_reckoning.reckoning import Reckoning
from hullrecon.navigation.sensors.depth import Depth
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Ints


def remarks_of(
    pings_ns: Ints, no_tray: bool, path: Reckoning, nodes: Nodes, depth: Depth | None, returns: Returns
) -> tuple[list[str], dict[str, object]]:
    """Return sentences, and the numbers behind them for navigation.json; times are seconds since the first velocity."""

    def since(t_ns: Ints) -> list[float]:
        """Return seconds since the first velocity."""
        return [round(float(t), 3) for t in (np.asarray(t_ns) - path.start_ns).ravel() * 1e-9]

    v, holes = path.velocities, path.attitude.holes
    steps = np.zeros(0, np.int64) if depth is None else depth.steps
    sentences = [
        (len(v.outages), f"DVL: {_times(len(v.outages), 'outage')} bridged at constant velocity, {_longest(v.outages)}"),
        (len(v.outliers), f"DVL: {_times(len(v.outliers), 'velocity')} rejected as outliers"),
        (returns.flagged.any(), f"{returns.flagged.sum()} of {len(returns.flagged)} DVL ranges rejected as outliers"),
        (len(holes), f"IMU: {_times(len(holes), 'gap')} in the attitude, {_longest(holes)}"),
        (not path.attitude.fused, "IMU: no rates; the attitude between readings is interpolated"),
        (depth is None, "no pressure: the depth is counted from the start and drifts"),
        (len(steps), f"pressure: {_times(len(steps), 'step')} that the DVL did not see, the first at {_first(since(steps))} s"),
        (no_tray, "no tray angles: the tray is taken to stand at zero"),
        (nodes.outside, f"{_times(nodes.outside, 'image')} before or after the DVL's log have no pose"),
        (nodes.unpaired, f"{_times(nodes.unpaired, 'image')} of the lower camera have no partner in the upper one"),
    ]
    facts: dict[str, object] = {
        "start_ns": path.start_ns,
        "pings": len(pings_ns),
        "velocities": len(v.t_ns),
        "outages_s": np.reshape(since(v.outages), (-1, 2)).tolist(),
        "outlier_velocities_s": since(v.outliers),
        "returns": len(returns.t_ns),
        "flagged_returns_s": since(returns.t_ns[returns.flagged]),
        "attitude_gaps_s": np.reshape(since(holes), (-1, 2)).tolist(),
        "attitude_sigma_deg": round(float(np.degrees(path.attitude.sigma_rad)), 5),
        "depth_steps_s": since(steps),
        "depth_white_sigma_m": None if depth is None else round(depth.white, 5),
        "path_length_m": round(float(np.linalg.norm(np.diff(path.at(nodes.t_ns).instrument, axis=0), axis=1).sum()), 3),
    }
    return [sentence for holds, sentence in sentences if holds], facts


def _times(count: int, noun: str) -> str:
    plural = f"{noun[:-1]}ies" if noun.endswith("y") else f"{noun}s"
    return f"{count} {noun if count == 1 else plural}"


def _longest(spans_ns: Ints) -> str:
    return f"the longest {np.diff(spans_ns, axis=1).max() * 1e-9:.1f} s" if len(spans_ns) else ""


def _first(times: list[float]) -> str:
    return f"{times[0]:.1f}" if times else ""
