# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""All that a report draws on: what the chain left, read into memory; what a dive cannot have is None."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.config.schema import Dive, Hull
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.poses import Poses
from hullrecon.records.sensors import DvlPings, ImageIndex
from hullrecon.records.solution import Solution
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Trajectory, VehicleTrack

Document = Mapping[str, Any]


@dataclass(frozen=True)
class Eye:
    """One camera: intrinsics, index of images, and how a row is read: (h, w, 3) uint8 RGB, None when it does not decode."""

    name: str  # camera_top, camera_bottom
    camera: CameraModel
    index: ImageIndex
    tray_from_camera: Poses
    read: Callable[[int], NDArray[np.uint8] | None]


@dataclass(frozen=True)
class Mosaic:
    """What a mosaic step left: mosaic.json, the preview (PNG bytes), and whether there is a textured mesh."""

    document: Document
    preview: bytes
    meshed: bool


@dataclass(frozen=True)
class StepRun:
    """One step as its manifest has it: name, version, resolved settings by section, warnings, and the volatile run block."""

    name: str
    version: int
    settings: Document
    inputs: Document
    warnings: tuple[str, ...]
    run: Document


@dataclass(frozen=True)
class Survey:
    """The dive, adjusted or not. absent: deliverables that cannot be given, with the reason of each."""

    dive: Dive
    track: VehicleTrack
    trajectory: Trajectory
    navigation: Document
    findings: Document
    tray_origin_m: tuple[float, float, float]
    hull: Hull | None = None
    solution: Solution | None = None
    adjust: Document = field(default_factory=dict)
    iterations: Mapping[str, NDArray[np.generic]] | None = None
    chart: Chart | None = None
    surface: Surface | None = None
    as_found: Surface | None = None
    objects: tuple[Document, ...] | None = None
    not_reported: tuple[Document, ...] = ()
    coverage: Document | None = None
    optical: Mosaic | None = None
    sonar: Mosaic | None = None
    dvl: DvlPings | None = None
    eyes: tuple[Eye, ...] = ()
    pairs: Document = field(default_factory=dict)
    steps: tuple[StepRun, ...] = ()
    absent: Mapping[str, str] = field(default_factory=dict)

    @property
    def method(self) -> str:
        """naive, geva or maxmix; "dead reckoning" when nothing was adjusted."""
        return str(self.adjust.get("method", "maxmix")) if self.solution is not None else "dead reckoning"

    def warnings(self) -> list[str]:
        """What the steps warned of, with the step's name, in the order of the chain."""
        return [f"{step.name}: {text}" for step in self.steps for text in step.warnings]
