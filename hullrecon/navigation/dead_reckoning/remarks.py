# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Remarks of navigation: outages, flagged beams, steps in depth, holes in the attitude."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hullrecon.navigation.dead_reckoning.nodes import Nodes
from hullrecon.navigation.dead_reckoning.reckoning import Reckoning
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.depth import Depth
from hullrecon.navigation.sensors.servo import Servo
from hullrecon.navigation.sensors.velocity import Velocities
from hullrecon.records.clock import SILENT_S, format_time, longest_pause_s
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Array, Ints

FEW_PERIODS = 2.5  # of the DVL between two velocities: one lost ping is no outage


def remarks_of(
    pings_ns: Ints, path: Reckoning, nodes: Nodes, depth: Depth | None, returns: Returns
) -> tuple[list[str], dict[str, object]]:
    """Describe in words what was wrong with the sensors, and collect numbers for navigation.json.

    There are no words where nothing was wrong. Times in the numbers are seconds since the start of
    the path.

    Parameters
    ----------
    pings_ns
        Stamps of all pings, which are counted.
    path
        Tells of outages, outliers, gaps in the attitude, heading steps, and angles not read.
    nodes
        Tell of images without a pose or a partner, and of spans without images.
    depth
        Tells of steps and silences of the pressure sensor, None without one.
    returns
        DVL ranges, of which the flagged ones are counted.
    """
    way_m = np.concatenate(
        [[0.0], np.cumsum(np.linalg.norm(np.diff(path.at(nodes.t_ns).instrument, axis=0), axis=1))]
    )
    blank = images_missing(nodes, way_m)
    remarks = [
        *_motion_remarks(path, nodes.t_ns, returns),
        _describe_missing_images(nodes.t_ns, blank, path.velocities),
        *_depth_remarks(depth),
        *_tray_remarks(path.servo, nodes.t_ns),
        *_image_remarks(nodes),
    ]
    facts = {
        "start_ns": path.start_ns,
        "pings": len(pings_ns),
        **_sensor_facts(path, depth, returns),
        "without_images_s": [
            _seconds_since(path.start_ns, nodes.t_ns[[first, last]]) for first, last, _ in blank
        ],
        "path_length_m": round(float(way_m[-1]), 3),
    }
    return [remark for remark in remarks if remark], facts


def _motion_remarks(path: Reckoning, nodes_ns: Ints, returns: Returns) -> Iterator[str]:
    """Describe what was wrong with DVL and IMU: outages, outliers, steps of the heading.

    Sentences are empty where nothing was wrong. nodes_ns: stamps of the nodes.
    """
    v, attitude = path.velocities, path.attitude
    holes, turned = attitude.holes, attitude.steps
    yield _describe_outages(v)
    yield _describe_ends_without_dvl(v, nodes_ns)
    yield _describe_ends_without_imu(attitude, nodes_ns)
    if len(v.outliers):
        yield f"DVL: {_times(len(v.outliers), 'velocity')} rejected as outliers"
    if returns.flagged.any():
        yield f"{returns.flagged.sum()} of {len(returns.flagged)} DVL ranges rejected as outliers"
    if len(holes):
        yield f"IMU: {_times(len(holes), 'gap')} in the attitude, {_longest(holes)}"
    yield _describe_heading_steps(np.degrees(turned.size), attitude.t_ns[turned.row])
    yield _describe_disagreements(
        np.degrees(turned.disagreement_rad), attitude.t_ns[turned.disagreement]
    )
    if not attitude.fused:
        yield "IMU: no rates; the attitude between readings is interpolated"


def _depth_remarks(depth: Depth | None) -> Iterator[str]:
    """Describe what was wrong with the pressure sensor."""
    if depth is None:
        yield "no pressure: the depth is counted from the start and drifts"
        return
    if len(depth.steps):
        yield (
            f"pressure: {_times(len(depth.steps), 'step')} that the DVL did not see, the "
            f"first at {_first(depth.steps)}"
        )
    if depth.silence:
        yield f"pressure: {depth.silence}; there the depth is counted on by the DVL"


def _tray_remarks(servo: Servo, nodes_ns: Ints) -> Iterator[str]:
    """Describe where the tray's angle was not read."""
    no_angle = servo.silence(nodes_ns)
    if not servo.is_read:
        yield "no tray angles: the tray is taken to stand at zero"
    if no_angle:
        yield (
            f"tray: {no_angle}; there it is taken to stand as last read, or to turn "
            "evenly between two readings"
        )


def _image_remarks(nodes: Nodes) -> Iterator[str]:
    """Describe images without a pose or a partner."""
    if nodes.outside:
        yield _without_pose(nodes.outside)
    if nodes.lone:
        yield (
            f"{_times(nodes.lone, 'image')} of the upper camera without a partner in the lower one"
        )
    if nodes.unpaired:
        yield (
            f"{_times(nodes.unpaired, 'image')} of the lower camera without a "
            "partner in the upper one"
        )


def _sensor_facts(path: Reckoning, depth: Depth | None, returns: Returns) -> dict[str, object]:
    """Collect what was wrong with the sensors in numbers, times in s since the path's start."""
    start_ns, v, attitude = path.start_ns, path.velocities, path.attitude
    turned = attitude.steps
    steps = np.zeros(0, np.int64) if depth is None else depth.steps
    return {
        "velocities": len(v.t_ns),
        "outages_s": np.reshape(_seconds_since(start_ns, v.outages), (-1, 2)).tolist(),
        "outlier_velocities_s": _seconds_since(start_ns, v.outliers),
        "returns": len(returns.t_ns),
        "flagged_returns_s": _seconds_since(start_ns, returns.t_ns[returns.flagged]),
        "attitude_gaps_s": np.reshape(_seconds_since(start_ns, attitude.holes), (-1, 2)).tolist(),
        "heading_steps_s": _seconds_since(start_ns, attitude.t_ns[turned.row]),
        "heading_steps_deg": np.degrees(turned.size).round(3).tolist(),
        "attitude_sigma_deg": round(float(np.degrees(attitude.sigma_rad)), 5),
        "depth_steps_s": _seconds_since(start_ns, steps),
        "depth_white_sigma_m": None if depth is None else round(depth.white, 5),
    }


def _seconds_since(start_ns: int, t_ns: Ints) -> list[float]:
    """Convert stamps to seconds since the start of the path, in ms."""
    return [round(float(t), 3) for t in (np.asarray(t_ns) - start_ns).ravel() * 1e-9]


def _describe_outages(velocities: Velocities) -> str:
    """Describe the outages that last longer than FEW_PERIODS of the DVL.

    Between two pings of a slow DVL nothing is lost. "" where no outage is longer.
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
    """Find the spans without images that are far longer than the usual time between images.

    way_m (n,): distance travelled up to each node. Empty with fewer than three nodes with images.

    Returns
    -------
    list of tuple
        For each span the nodes with images before and after it, and the distance travelled, m.
    """
    seen = np.flatnonzero((nodes.image >= 0).any(axis=1))
    if len(seen) < 3:
        return []
    long = np.flatnonzero(np.diff(nodes.t_ns[seen]) > 1e9 * longest_pause_s(nodes.t_ns[seen]))
    return [
        (int(seen[k]), int(seen[k + 1]), float(way_m[seen[k + 1]] - way_m[seen[k]])) for k in long
    ]


def _describe_missing_images(
    nodes_ns: Ints, blank: list[tuple[int, int, float]], velocities: Velocities
) -> str:
    """Describe the longest span without images, in which images do not support the path.

    The distance travelled is left out where an outage of the DVL makes it uncertain by a tenth.

    blank: the spans, as returned by `images_missing`.
    """
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


def _describe_heading_steps(size_deg: Array, at_ns: Ints) -> str:
    """Describe the steps that were removed from the heading, and name the largest.

    "" where there are none. size_deg, at_ns: of each step.
    """
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


def _describe_disagreements(apart_deg: Array, at_ns: Ints) -> str:
    """Describe where heading and rates contradict each other, and name the largest divergence.

    "" where they never do. apart_deg, at_ns: of each place.
    """
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
    """Describe the sigma of the displacement over the outage where it is largest."""
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


def _describe_ends_without_dvl(velocities: Velocities, nodes_ns: Ints) -> str:
    """Describe where images alone carry the path, before the first and after the last velocity.

    "" where the path does not reach so far.
    """
    velocities_ns, ends_ns = velocities.t_ns[[0, -1]], nodes_ns[[0, -1]]
    # of the way from the path's start to the first velocity, and from the last one to its end
    sigma_m = np.sqrt(
        velocities.bridged_variance(
            ends_ns.clip(max=velocities_ns[1]), ends_ns.clip(min=velocities_ns[0])
        ).max()
    )
    ends = _describe_silent_ends(velocities_ns, ends_ns)
    return ends and (
        f"DVL: silent over {ends} of the path, which each image carries on from the one "
        "before; navigation alone knows the way"
        f" there to {sigma_m:.2f} m (one sigma, each axis)"
    )


def _describe_ends_without_imu(attitude: AttitudeHistory, nodes_ns: Ints) -> str:
    """Describe where the path goes on before the first or after the last attitude.

    "" where it does not.
    """
    ends_ns = nodes_ns[[0, -1]]
    ends = _describe_silent_ends(attitude.t_ns[[0, -1]], ends_ns)
    sigma_deg = np.degrees(attitude.unread_sigma(ends_ns).max())
    return ends and (
        f"IMU: silent over {ends} of the path, which each image carries on from the one "
        "before; navigation alone knows the"
        f" attitude there to {sigma_deg:.0f} degrees (one sigma, each axis)"
    )


def _describe_silent_ends(read_ns: Ints, ends_ns: Ints) -> str:
    """Describe how long nothing was read at the ends (2,) of the path.

    read_ns (2,): the first and the last reading.
    """
    lasts_s = np.array([read_ns[0] - ends_ns[0], ends_ns[1] - read_ns[1]]) * 1e-9
    return " and ".join(
        f"the {name} {s:.1f} s"
        for name, s in zip(("first", "last"), lasts_s, strict=True)
        if s > SILENT_S
    )


def _first(t_ns: Ints) -> str:
    return format_time(int(t_ns[0])) if len(t_ns) else ""
