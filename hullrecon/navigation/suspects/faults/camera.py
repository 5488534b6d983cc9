# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Faults of the upper camera: of its calibration, its pictures, its clock."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from hullrecon.findings.adjustment import WATER
from hullrecon.geometry.cameras import CameraModel
from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.faults.axes import signed_axes
from hullrecon.navigation.suspects.faults.clock import clock_faults
from hullrecon.navigation.suspects.faults.hypothesis import FACTORS, Hypothesis
from hullrecon.records.sensors import SensorRecords
from hullrecon.typing import Array

SIZES = (0.25, 0.5, 2.0, 4.0)  # of a calibration's pictures over those logged, which were resized
# changes of k1, in steps so small that a comparison agrees at the nearest
RADIAL = [s * k for k in np.arange(0.05, 0.65, 0.05) for s in (1, -1)]
FAR_S = 5.0  # largest offset of a camera's clock that is tried


def camera_faults(
    records: SensorRecords, flows: Sequence[Flow], camera: CameraModel
) -> Iterator[Hypothesis]:
    """Yield faults of the camera: focal length, medium, turned or resized pictures, lens, clock.

    The features' ideal coordinates are recomputed as by the right calibration.

    records, flows, camera: the dive, features of neighbouring images, and the calibration given.
    """
    lenses: dict[tuple[str, str], Callable[[Array], Array]] = {
        ("focal", f"{factor:.2f}"): partial(_refocused, camera=camera, factor=factor)
        for factor in FACTORS
    }
    lenses["medium", f"{WATER:.2f}"] = partial(_refocused, camera=camera, factor=WATER)
    lenses["port", f"{WATER:.2f}"] = _refracted
    for name, turn in signed_axes():
        if turn[2, 2] == 1 and not turn[:2, 2].any() and not turn[2, :2].any():
            # named by its first two axes
            lenses["picture", name[:5]] = partial(_turned, turn=turn[:2, :2])
    lenses |= {("distortion", f"{k1:+.2f}"): partial(_straightened, k1=k1) for k1 in RADIAL}
    lenses |= {("size", f"{size:g}"): partial(_resized, camera=camera, size=size) for size in SIZES}
    for (fault, value), lens in lenses.items():
        moved = [replace(flow, first=lens(flow.first), second=lens(flow.second)) for flow in flows]
        yield Hypothesis(
            sensor=Sensor.CAMERA, fault=fault, value=value, mended=records, flows=moved
        )
    first_ns = np.array([flow.t_ns[0] for flow in flows], np.int64)
    for clock in clock_faults(first_ns, FAR_S):
        late_ns = (first_ns - clock.t_ns).tolist()
        moved = [
            replace(flow, t_ns=(flow.t_ns[0] - late, flow.t_ns[1] - late))
            for flow, late in zip(flows, late_ns, strict=True)
        ]
        yield replace(clock.hypothesis(Sensor.CAMERA, records), flows=moved)


def _turned(ideal: Array, turn: Array) -> Array:
    """Multiply ideal coordinates (n, 2) by a matrix (2, 2)."""
    return np.asarray(ideal @ turn.T)


def _refocused(ideal: Array, camera: CameraModel, factor: float) -> Array:
    """Recompute ideal coordinates (n, 2) for focal lengths `factor` times as long.

    Distortion is a function of ideal coordinates, so that it is removed anew from the pixels.
    """
    longer = replace(camera, fx=camera.fx * factor, fy=camera.fy * factor)
    return longer.undistort(camera.distort(ideal))


def _refracted(ideal: Array) -> Array:
    """Refract rays (n, 2) by a calibration made in air into the water before a flat port.

    Snell's law of a port that stands across the line of sight, at the camera's centre.
    """
    r2 = (ideal**2).sum(axis=1, keepdims=True)
    return np.asarray(ideal / np.sqrt(WATER**2 * (1 + r2) - r2))


def _resized(ideal: Array, camera: CameraModel, size: float) -> Array:
    """Recompute ideal coordinates (n, 2) for a calibration of pictures `size` times as large."""
    fx, fy = camera.fx / size, camera.fy / size
    cx, cy = (camera.cx + 0.5) / size - 0.5, (camera.cy + 0.5) / size - 0.5
    return replace(camera, fx=fx, fy=fy, cx=cx, cy=cy).undistort(camera.distort(ideal))


def _straightened(ideal: Array, k1: float) -> Array:
    """Remove radial distortion that a calibration misses from ideal coordinates (n, 2)."""
    return np.asarray(ideal * (1 - k1 * (ideal**2).sum(axis=1, keepdims=True)))
