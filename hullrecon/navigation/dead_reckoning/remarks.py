# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Remarks of navigation: outages, flagged beams, steps in depth, holes in the attitude."""

from __future__ import annotations

import numpy as np

from hullrecon.navigation.dead_reckoning.nodes import Nodes
from hullrecon.navigation.dead_reckoning.reckoning import Reckoning
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.depth import Depth
from hullrecon.navigation.sensors.velocity import Velocities
from hullrecon.records.clock import SILENT_S, format_time, longest_pause_s
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Array, Ints

FEW_PERIODS = 2.5  # of the DVL, to the next velocity: one ping may be lost


def remarks_of(
    pings_ns: Ints, path: Reckoning, nodes: Nodes, depth: Depth | None, returns: Returns
) -> tuple[list[str], dict[str, object]]:
    """Describe what was wrong with the sensors, with the numbers for navigation.json.

    Times in the numbers are seconds since start_ns.
    """

    def since(t_ns: Ints) -> list[float]:
        """Convert stamps to seconds since the start of the path."""
        return [round(float(t), 3) for t in (np.asarray(t_ns) - path.start_ns).ravel() * 1e-9]

    v, holes, turned = path.velocities, path.attitude.holes, path.attitude.steps
    way_m = np.concatenate(
        [[0.0], np.cumsum(np.linalg.norm(np.diff(path.at(nodes.t_ns).instrument, axis=0), axis=1))]
    )
    blank = images_missing(nodes, way_m)
    steps = np.zeros(0, np.int64) if depth is None else depth.steps
    no_depth = "" if depth is None else depth.silence
    no_angle = path.servo.silence(nodes.t_ns)
    bridged, no_velocity, no_attitude = (
        _bridged(v),
        _silent_dvl(v, nodes.t_ns),
        _silent_imu(path.attitude, nodes.t_ns),
    )
    sentences = [
        (bridged, bridged),
        (no_velocity, no_velocity),
        (no_attitude, no_attitude),
        (len(v.outliers), f"DVL: {_times(len(v.outliers), 'velocity')} rejected as outliers"),
        (
            returns.flagged.any(),
            f"{returns.flagged.sum()} of {len(returns.flagged)} DVL ranges rejected as outliers",
        ),
        (len(holes), f"IMU: {_times(len(holes), 'gap')} in the attitude, {_longest(holes)}"),
        (len(turned.row), _heading_steps(np.degrees(turned.size), path.attitude.t_ns[turned.row])),
        (
            len(turned.disagreement),
            _disagreements(
                np.degrees(turned.disagreement_rad), path.attitude.t_ns[turned.disagreement]
            ),
        ),
        (not path.attitude.fused, "IMU: no rates; the attitude between readings is interpolated"),
        (len(blank), _without_images(nodes.t_ns, blank, v)),
        (depth is None, "no pressure: the depth is counted from the start and drifts"),
        (
            len(steps),
            (
                f"pressure: {_times(len(steps), 'step')} that the DVL did not see, the "
                f"first at {_first(steps)}"
            ),
        ),
        (no_depth, f"pressure: {no_depth}; there the depth is counted on by the DVL"),
        (not path.servo.is_read, "no tray angles: the tray is taken to stand at zero"),
        (
            no_angle,
            (
                f"tray: {no_angle}; there it is taken to stand as last read, or to turn "
                "evenly between two readings"
            ),
        ),
        (nodes.outside, _without_pose(nodes.outside)),
        (
            nodes.lone,
            f"{_times(nodes.lone, 'image')} of the upper camera without a partner in the lower one",
        ),
        (
            nodes.unpaired,
            (
                f"{_times(nodes.unpaired, 'image')} of the lower camera without a "
                "partner in the upper one"
            ),
        ),
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
        "heading_steps_s": since(path.attitude.t_ns[turned.row]),
        "heading_steps_deg": np.degrees(turned.size).round(3).tolist(),
        "attitude_sigma_deg": round(float(np.degrees(path.attitude.sigma_rad)), 5),
        "depth_steps_s": since(steps),
        "depth_white_sigma_m": None if depth is None else round(depth.white, 5),
        "without_images_s": [since(nodes.t_ns[[first, last]]) for first, last, _ in blank],
        "path_length_m": round(float(way_m[-1]), 3),
    }
    return [sentence for holds, sentence in sentences if holds], facts


def _bridged(velocities: Velocities) -> str:
    """Count the outages that last longer than a few periods of the DVL.

    Between two pings of a slow DVL nothing was lost.
    """
    few_ns = (
        FEW_PERIODS * float(np.median(np.diff(velocities.t_ns)))
        if len(velocities.t_ns) > 1
        else 0.0
    )
    outages = velocities.outages[np.diff(velocities.outages, axis=1)[:, 0] > few_ns]
    if not len(outages):
        return ""
    return (
        f"DVL: {_times(len(outages), 'outage')} bridged at constant velocity, "
        f"{_longest(outages)}{_unsure(velocities)}"
    )


def images_missing(nodes: Nodes, way_m: Array) -> list[tuple[int, int, float]]:
    """Find the spans between two nodes with images that are far longer than usual.

    way_m (n,): distance travelled up to each node. Returns (first node, last node, m travelled) for
    each span.
    """
    seen = np.flatnonzero((nodes.image >= 0).any(axis=1))
    if len(seen) < 3:
        return []
    long = np.flatnonzero(np.diff(nodes.t_ns[seen]) > 1e9 * longest_pause_s(nodes.t_ns[seen]))
    return [
        (int(seen[k]), int(seen[k + 1]), float(way_m[seen[k + 1]] - way_m[seen[k]])) for k in long
    ]


def _without_images(
    nodes_ns: Ints, blank: list[tuple[int, int, float]], velocities: Velocities
) -> str:
    """Describe what the longest span without images means for the path."""
    if not blank:
        return ""
    first, last, way_m = max(blank, key=lambda span: nodes_ns[span[1]] - nodes_ns[span[0]])
    lasts_s = (nodes_ns[last] - nodes_ns[first]) * 1e-9
    bridged_m2 = velocities.bridged_variance(nodes_ns[[first]], nodes_ns[[last]])[0]
    way = f" and {way_m:.1f} m of way" if bridged_m2 < (0.1 * way_m) ** 2 else ""
    return (
        f"camera: {_times(len(blank), 'span')} without images that have a pose, the longest "
        f"{lasts_s:.1f} s{way}; there"
        " navigation and the hull's form alone say where the vehicle went"
    )


def _times(count: int, noun: str) -> str:
    plural = f"{noun[:-1]}ies" if noun.endswith("y") else f"{noun}s"
    return f"{count} {noun if count == 1 else plural}"


def _heading_steps(size_deg: Array, at_ns: Ints) -> str:
    """Describe the steps that were removed from the heading."""
    if len(size_deg) == 0:
        return ""
    largest = int(np.argmax(np.abs(size_deg)))
    when = format_time(int(at_ns[largest]))
    what = (
        f"{_times(len(size_deg), 'step')} in the heading, by "
        f"{size_deg[largest]:+.1f} degrees at {when}"
    )
    return (
        f"IMU: {what}{' the largest' if len(size_deg) > 1 else ''}, that no turn of the "
        "vehicle made; taken off what follows"
    )


def _disagreements(apart_deg: Array, at_ns: Ints) -> str:
    """Describe where heading and rates contradict each other."""
    if len(apart_deg) == 0:
        return ""
    largest = int(np.argmax(apart_deg))
    what = (
        f"heading and rates part {_times(len(apart_deg), 'time')}, at most by "
        f"{apart_deg[largest]:.1f} degrees"
    )
    return (
        f"IMU: {what} at {format_time(int(at_ns[largest]))}; the turn there is "
        "known no better than that"
    )


def _longest(spans_ns: Ints) -> str:
    return f"the longest {np.diff(spans_ns, axis=1).max() * 1e-9:.1f} s" if len(spans_ns) else ""


def _unsure(velocities: Velocities) -> str:
    """Describe how well navigation knows the way across the outage that it knows least."""
    if not len(velocities.outages):
        return ""
    sigma_m = np.sqrt(velocities.bridged_variance(*velocities.outages.T).max())
    return f"; navigation alone knows the way across it to {sigma_m:.2f} m (one sigma, each axis)"


def _without_pose(count: int) -> str:
    """Describe how many images navigation does not reach, and why."""
    return (
        f"{_times(count, 'image')} {'has' if count == 1 else 'have'} no pose: DVL and IMU "
        "did not both run then, and they"
        " could not be followed from images that have one"
    )


def _silent_dvl(velocities: Velocities, nodes_ns: Ints) -> str:
    """Describe where images alone carry the path, before the first and after the last velocity."""
    heard_ns, ends_ns = velocities.t_ns[[0, -1]], nodes_ns[[0, -1]]
    sigma_m = np.sqrt(
        velocities.bridged_variance(
            ends_ns.clip(max=heard_ns[1]), ends_ns.clip(min=heard_ns[0])
        ).max()
    )
    ends = _silent_ends(heard_ns, ends_ns)
    return ends and (
        f"DVL: silent over {ends} of the path, which each image carries on from the one "
        "before; navigation alone knows the way"
        f" there to {sigma_m:.2f} m (one sigma, each axis)"
    )


def _silent_imu(attitude: AttitudeHistory, nodes_ns: Ints) -> str:
    """Describe where the path goes on before the first or after the last attitude.

    "" where it does not.
    """
    ends_ns = nodes_ns[[0, -1]]
    ends = _silent_ends(attitude.t_ns[[0, -1]], ends_ns)
    sigma_deg = np.degrees(attitude.unread_sigma(ends_ns).max())
    return ends and (
        f"IMU: silent over {ends} of the path, which each image carries on from the one "
        "before; navigation alone knows the"
        f" attitude there to {sigma_deg:.0f} degrees (one sigma, each axis)"
    )


def _silent_ends(heard_ns: Ints, ends_ns: Ints) -> str:
    """Describe how long nothing was read at the ends (2,) of the path.

    heard_ns (2,): the first and the last reading.
    """
    lasts_s = np.array([heard_ns[0] - ends_ns[0], ends_ns[1] - heard_ns[1]]) * 1e-9
    return " and ".join(
        f"the {name} {s:.1f} s"
        for name, s in zip(("first", "last"), lasts_s, strict=True)
        if s > SILENT_S
    )


def _first(t_ns: Ints) -> str:
    return format_time(int(t_ns[0])) if len(t_ns) else ""
