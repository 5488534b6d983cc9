# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Describe what was read of each sensor, and what was lost."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from hullrecon.dive.check.time_overlap import Stream, clock_gaps
from hullrecon.dive.logs.readers.protocol import Loss
from hullrecon.dive.logs.timeline import describe_ends, describe_gaps
from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import Camera
from hullrecon.records.clock import NS, format_time, rate_hz
from hullrecon.records.sensors import DvlPings, ImageIndex, SensorRecords

NOUNS = {
    "dvl": "ping",
    "imu": "reading",
    "pressure": "reading",
    "tray": "angle",
    "sonar_tray": "angle",
    "sonar": "ping",
    "position": "position",
    Camera.TOP.key: "image",
    Camera.BOTTOM.key: "image",
}


def describe_streams(records: SensorRecords, images: Mapping[str, ImageIndex]) -> list[Finding]:
    """Describe each sensor's readings, rate and gaps, and the spans of their values.

    Sensors without readings are left out.
    """
    streams: Iterable[tuple[str, Stream]] = [*records.by_name().items(), *images.items()]
    logged = [(name, record.t_ns) for name, record in streams if len(record.t_ns)]
    # a sensor on another clock says nothing about when the others began or ended
    apart = {finding.where for finding in clock_gaps(dict(streams))}
    start_ns = min((int(t[0]) for name, t in logged if name not in apart), default=0)
    stop_ns = max((int(t[-1]) for name, t in logged if name not in apart), default=0)
    out = []
    for name, t_ns in logged:
        values = {
            "count": len(t_ns),
            "noun": NOUNS[name],
            "seconds": float(t_ns[-1] - t_ns[0]) / NS,
            "start": format_time(int(t_ns[0])),
            "rate_hz": rate_hz(t_ns) if len(t_ns) > 1 else None,
        }
        out.append(Finding("stream-read", values, name))
        out += describe_gaps(name, t_ns)
        out += [] if name in apart else describe_ends(name, t_ns, start_ns, stop_ns)
        if name == "dvl" and records.dvl is not None:
            out += _describe_lost_lock(records.dvl)
    return out + _describe_values(records)


def _describe_lost_lock(dvl: DvlPings) -> list[Finding]:
    """Describe spans in which the DVL sent pings without a velocity over ground.

    Spans without any ping are left out, as they are described already.
    """
    heard_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    silent = [finding.values for finding in describe_gaps("dvl", dvl.t_ns)]
    name, ends = "velocity of the DVL", (int(dvl.t_ns[0]), int(dvl.t_ns[-1]))
    gaps = [gap for gap in describe_gaps(name, heard_ns) if gap.values not in silent]
    return gaps + (describe_ends(name, heard_ns, *ends) if len(heard_ns) else [])


def _describe_values(records: SensorRecords) -> list[Finding]:
    """Describe the spans of depths, ranges, speeds, positions and joint angles."""
    out = []
    pressure, dvl, fixes = records.pressure, records.dvl, records.position
    if pressure is not None and len(pressure.depth):
        low, high = float(pressure.depth.min()), float(pressure.depth.max())
        out.append(Finding("depth-span", {"low_m": low, "high_m": high}))
    if dvl is not None and np.isfinite(dvl.ranges).any():
        low, high = float(np.nanmin(dvl.ranges)), float(np.nanmax(dvl.ranges))
        out.append(Finding("range-span", {"low_m": low, "high_m": high}))
    if dvl is not None and np.isfinite(dvl.velocity).any():
        speed = float(np.nanmax(np.linalg.norm(dvl.velocity, axis=1)))
        out.append(Finding("speed-span", {"high_m_s": speed}))
    if fixes is not None and len(fixes.t_ns):
        north_m, east_m = np.ptp(fixes.north_east, axis=0).tolist()
        values = {
            "north_m": north_m,
            "east_m": east_m,
            "sigma_m": [float(fixes.sigma.min()), float(fixes.sigma.max())],
            "single": len(fixes.t_ns) == 1,
        }
        out.append(Finding("position-span", values))
    for name, joint in (("tray", records.tray), ("sonar_tray", records.sonar_tray)):
        if joint is not None and len(joint.angle):
            low, high = np.degrees([joint.angle.min(), joint.angle.max()]).tolist()
            angles = {"joint": name, "low_deg": low, "high_deg": high}
            out.append(Finding("angle-span", angles))
    return out


def describe_start_offset(
    records: SensorRecords, images: Mapping[str, ImageIndex]
) -> list[Finding]:
    """Say how long before or after the first DVL ping the first image was taken.

    Empty without a DVL or an upper camera.
    """
    top = images.get(Camera.TOP.key)
    if records.dvl is None or top is None:
        return []
    seconds = (int(top.t_ns[0]) - int(records.dvl.t_ns[0])) / NS
    side = "after" if seconds >= 0 else "before"
    return [Finding("first-image", {"seconds": abs(seconds), "side": side})]


def describe_losses(found: Sequence[tuple[str, Loss]]) -> list[Finding]:
    """Describe each loss of a file: its topic, when it begins and ends, and why.

    found: losses with the name of their file.
    """
    return [
        Finding(
            "data-lost",
            {
                "topic": loss.topic,
                "start": format_time(loss.start_ns) if loss.start_ns else None,
                "end": format_time(loss.end_ns) if loss.end_ns else None,
                "messages": loss.messages,
                "why": loss.why,
            },
            file,
        )
        for file, loss in found
    ]
