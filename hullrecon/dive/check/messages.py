# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Describe in sentences what was read and what was lost."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

import numpy as np

from hullrecon.dive.logs.readers.protocol import Loss
from hullrecon.dive.logs.timeline import describe_ends, describe_gaps
from hullrecon.geometry.frames import Camera
from hullrecon.records.clock import NS, format_time, rate_hz
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    JointSamples,
    PositionFixes,
    PressureSamples,
    SensorRecords,
)
from hullrecon.typing import Ints

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


class Stream(Protocol):
    """Any record with stamps."""

    @property
    def t_ns(self) -> Ints:
        """Return the stamps (n,), ns since 1970."""


def count_noun(count: int, noun: str) -> str:
    """Return count and noun, the noun in the plural unless the count is 1."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def describe_streams(records: SensorRecords, images: Mapping[str, ImageIndex]) -> list[str]:
    """Return a sentence for each sensor (how many readings, how long, at which rate), its gaps, and
    ranges of values.
    """
    out: list[str] = []
    streams: Iterable[tuple[str, Stream]] = [*records.by_name().items(), *images.items()]
    logged = [(name, record.t_ns) for name, record in streams if len(record.t_ns)]
    whole = [
        min((int(t[0]) for _, t in logged), default=0),
        max((int(t[-1]) for _, t in logged), default=0),
    ]
    for name, t in logged:
        count, seconds, start = (
            count_noun(len(t), NOUNS[name]),
            (t[-1] - t[0]) / NS,
            format_time(int(t[0])),
        )
        out.append(
            f"{name}: {count} in {seconds:.1f} s from {start}"
            + (f", {rate_hz(t):.1f} Hz" if len(t) > 1 else "")
        )
        out += describe_gaps(name, t) + describe_ends(name, t, *whole)
    joints = {"tray": records.tray, "sonar_tray": records.sonar_tray}
    return [
        *out, *_describe_depth(records.pressure), *_describe_dvl(records.dvl),
        *_describe_positions(records.position),
        *(line for name, joint in joints.items() for line in _describe_joint(name, joint)),
    ]  # fmt: skip


def _describe_depth(pressure: PressureSamples | None) -> list[str]:
    if pressure is None or not len(pressure.depth):
        return []
    return [f"depth runs from {pressure.depth.min():.1f} to {pressure.depth.max():.1f} m"]


def _describe_dvl(dvl: DvlPings | None) -> list[str]:
    if dvl is None:
        return []
    out = []
    if np.isfinite(dvl.ranges).any():
        out.append(
            f"DVL ranges run from {np.nanmin(dvl.ranges):.2f} to {np.nanmax(dvl.ranges):.2f} m"
        )
    if np.isfinite(dvl.velocity).any():
        out.append(f"DVL speeds reach {np.nanmax(np.linalg.norm(dvl.velocity, axis=1)):.2f} m/s")
    return out


def _describe_positions(fixes: PositionFixes | None) -> list[str]:
    if fixes is None or not len(fixes.t_ns):
        return []
    north, east = np.ptp(fixes.north_east, axis=0)
    low, high = fixes.sigma.min(), fixes.sigma.max()
    sigma = (
        f"sigma {low:.2g} m" if np.isclose(low, high) else f"sigmas from {low:.2g} to {high:.2g} m"
    )
    alone = "; one alone tells nothing of the path" if len(fixes.t_ns) == 1 else ""
    return [
        f"positions from outside span {north:.1f} m north and {east:.1f} m east, {sigma}{alone}"
    ]


def _describe_joint(name: str, joint: JointSamples | None) -> list[str]:
    if joint is None or not len(joint.angle):
        return []
    low, high = np.degrees([joint.angle.min(), joint.angle.max()])
    return [f"{name} angles run from {low:.1f} to {high:.1f} degrees"]


def describe_losses(found: Sequence[tuple[str, Loss]]) -> list[str]:
    """Return a sentence for each loss (file and loss), with its span and topic."""
    return [
        f"{file}: {loss.topic or 'every topic'}: {_span(loss)} lost{_many(loss)}: {loss.why}"
        for file, loss in found
    ]


def _span(loss: Loss) -> str:
    if not loss.start_ns and not loss.end_ns:
        return "an unknown part is"
    start = f"from {format_time(loss.start_ns)}" if loss.start_ns else "from the start"
    return f"{start} {f'to {format_time(loss.end_ns)}' if loss.end_ns else 'to the end'} is"


def _many(loss: Loss) -> str:
    return f" ({count_noun(loss.messages, 'message')})" if loss.messages is not None else ""
