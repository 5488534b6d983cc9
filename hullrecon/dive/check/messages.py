# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sentences about what was read and what was lost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hullrecon.dive.logs.readers.protocol import Loss
from hullrecon.dive.logs.timeline import NS, gaps, moment, rate_hz
from hullrecon.records.sensors import ImageIndex

NOUNS = {
    "dvl": "pings", "imu": "readings", "pressure": "readings", "tray": "angles", "sonar_tray": "angles", "sonar": "pings",
    "camera_top": "images", "camera_bottom": "images",
}  # fmt: skip


def spans(records: Mapping[str, Any], images: Mapping[str, ImageIndex]) -> list[str]:
    """One sentence a sensor: how many, how long, how fast; then its gaps."""
    out: list[str] = []
    for name, record in [*records.items(), *images.items()]:
        t = record.t_ns
        if not len(t):
            continue
        seconds = (t[-1] - t[0]) / NS
        out.append(f"{name}: {len(t)} {NOUNS[name]} in {seconds:.1f} s from {moment(int(t[0]))}, {rate_hz(t):.1f} a second")
        out += gaps(name, t)
    return out + _extremes(records)


def _extremes(records: Mapping[str, Any]) -> list[str]:
    out = []
    if "pressure" in records and len(records["pressure"].depth):
        depth = records["pressure"].depth
        out.append(f"depth runs from {depth.min():.1f} to {depth.max():.1f} m")
    if "dvl" in records:
        dvl = records["dvl"]
        if np.isfinite(dvl.ranges).any():
            out.append(f"DVL ranges run from {np.nanmin(dvl.ranges):.2f} to {np.nanmax(dvl.ranges):.2f} m")
        if np.isfinite(dvl.velocity).any():
            out.append(f"DVL speeds reach {np.nanmax(np.linalg.norm(dvl.velocity, axis=1)):.2f} m/s")
    for name in ("tray", "sonar_tray"):
        if name in records and len(records[name].angle):
            low, high = np.degrees([records[name].angle.min(), records[name].angle.max()])
            out.append(f"{name} angles run from {low:.1f} to {high:.1f} degrees")
    return out


def losses(found: Sequence[tuple[str, Loss]]) -> list[str]:
    """One sentence a loss, with the span and the topic."""
    return [f"{file}: {loss.topic or 'every topic'}: {_span(loss)} lost{_many(loss)}: {loss.why}" for file, loss in found]


def _span(loss: Loss) -> str:
    if not loss.start_ns and not loss.end_ns:
        return "an unknown part is"
    start = f"from {moment(loss.start_ns)}" if loss.start_ns else "from the start"
    return f"{start} {f'to {moment(loss.end_ns)}' if loss.end_ns else 'to the end'} is"


def _many(loss: Loss) -> str:
    return f" ({loss.messages} messages)" if loss.messages is not None else ""
