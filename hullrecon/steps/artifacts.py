# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What each step left, read from its folder: nobody else knows a file's name.

A property raises InputError where a file that its step always leaves is missing; what a dive may
lack is None.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

from hullrecon.artifacts.stage import StageSettings, load_arrays
from hullrecon.dive.config.mounts import (
    DEFAULTS,
    ChosenMount,
    choose_mounts,
    refuse_parted_tray,
    with_value,
)
from hullrecon.dive.images.store import ImageStore
from hullrecon.dive.logs.fixed_frames import FixedSensor
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.charts.chart import Chart, chart_from_arrays
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.links import CameraLinks, LinkedPath, NodePairs, NodeStereo, PairFeatures
from hullrecon.records.planes import TiedPlanes
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PositionFixes,
    PressureSamples,
    SonarPings,
)
from hullrecon.records.serialisation import from_arrays
from hullrecon.records.solution import Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import (
    Attitude,
    Odometry,
    PositionTies,
    Returns,
    Trajectory,
    TrajectoryErrorModel,
)
from hullrecon.typing import Arrays

Record = TypeVar("Record")
Document = Mapping[str, object]
MOUNTS = "mounts.json"
SONAR_IMAGES = "sonar_image.npy"
# What two dives of one hull are compared by, a step's files each, in the order of the chain
HULL_SURVEY_FILES = {
    "ingest": ("hull.npz",), "adjust": ("solution.npz",), "surface": ("chart.npz",),
    "detect": ("as_found.npz", "deviation.npz", "objects.json"),
}  # fmt: skip
CHANGE_CHAPTER, CHANGE_MAP = "chapter.json", "change.png"


@dataclass(frozen=True)
class StepArtifact:
    """The folder of one step's artifact."""

    folder: Path

    def _optional(self, name: str, kind: type[Record]) -> Record | None:
        path = self.folder / name
        return from_arrays(kind, load_arrays(path)) if path.exists() else None

    def _read_required(self, name: str, kind: type[Record]) -> Record:
        found = self._optional(name, kind)
        if found is None:
            raise InputError(
                f"{name} is missing", where=str(self.folder), remedy="run the step again"
            )
        return found

    def _document(self, name: str) -> Document:
        path = self.folder / name
        if not path.exists():
            return {}
        document: Document = json.loads(path.read_text(encoding="utf-8"))
        return document


class IngestArtifact(StepArtifact):
    """What the package holds, decoded."""

    @property
    def dvl(self) -> DvlPings | None:
        return self._optional("dvl.npz", DvlPings)

    @property
    def imu(self) -> ImuSamples | None:
        return self._optional("imu.npz", ImuSamples)

    @property
    def pressure(self) -> PressureSamples | None:
        return self._optional("pressure.npz", PressureSamples)

    @property
    def tray(self) -> JointSamples | None:
        return self._optional("tray.npz", JointSamples)

    @property
    def sonar(self) -> SonarPings | None:
        """Return the pings, their images mapped from the file; None where no sonar was carried."""
        path = self.folder / "sonar.npz"
        if not path.exists():
            return None
        image = np.load(self.folder / SONAR_IMAGES, mmap_mode="r", allow_pickle=False)
        return from_arrays(SonarPings, {**load_arrays(path), "image": image})

    @property
    def sonar_joint(self) -> JointSamples | None:
        return self._optional("sonar_tray.npz", JointSamples)

    @property
    def position(self) -> PositionFixes | None:
        return self._optional("position.npz", PositionFixes)

    @property
    def hull(self) -> Mesh | None:
        """Return the checked CAD model in M; None where the dive has none."""
        path = self.folder / "hull.npz"
        if not path.exists():
            return None
        arrays = load_arrays(path)
        return Mesh(arrays["vertices"], arrays["faces"])

    @property
    def findings(self) -> Document:
        return self._document("findings.json")

    @property
    def camera_models(self) -> dict[Camera, CameraModel]:
        """Return the calibrations as read; empty where no camera was carried."""
        return read_camera_models(self.folder / "cameras.json")

    @property
    def sensors(self) -> dict[str, FixedSensor]:
        """Return the sensors that the log's tf_static leads to; empty where it has none."""
        return msgspec.convert(self._document(MOUNTS), dict[str, FixedSensor])

    def image_index(self, camera: Camera) -> ImageIndex | None:
        return self._optional(f"images_{camera.key}.npz", ImageIndex)

    def images(self, camera: Camera, package: Path | None) -> ImageStore:
        """Return the images of a camera; package: its folder, where images are plain files."""
        return ImageStore(self.folder, package, camera.key)


class NavigateArtifact(StepArtifact):
    """The dead-reckoned dive."""

    @cached_property
    def trajectory(self) -> Trajectory:
        return self._read_required("trajectory.npz", Trajectory)

    @property
    def odometry(self) -> Odometry:
        return self._read_required("odometry.npz", Odometry)

    @property
    def attitude(self) -> Attitude:
        return self._read_required("attitude.npz", Attitude)

    @property
    def error_model(self) -> TrajectoryErrorModel:
        return self._read_required("error_model.npz", TrajectoryErrorModel)

    @property
    def returns(self) -> Returns | None:
        """Return the DVL's returns; None where no DVL was carried."""
        return self._optional("returns.npz", Returns)

    @property
    def positions(self) -> PositionTies | None:
        """Return the positions from outside that bound the path; None where there are none, or they
        tell nothing.
        """
        return self._optional("positions.npz", PositionTies)

    @property
    def facts(self) -> Document:
        return self._document("navigation.json")


class LinksArtifact(StepArtifact):
    """Pairs of nodes, what their images have in common, and the path that this ties together."""

    @property
    def pairs(self) -> NodePairs:
        return self._read_required("pairs.npz", NodePairs)

    @property
    def compared(self) -> NodePairs | None:
        """Return the pairs; None where no camera was carried."""
        return self._optional("pairs.npz", NodePairs)

    @property
    def features(self) -> PairFeatures:
        return self._read_required("features.npz", PairFeatures)

    @property
    def links(self) -> CameraLinks:
        return self._read_required("links.npz", CameraLinks)

    @property
    def stereo(self) -> NodeStereo:
        return self._read_required("stereo.npz", NodeStereo)

    @property
    def planes(self) -> TiedPlanes | None:
        """Return the planes that tie passes; None where none do."""
        return self._optional("planes.npz", TiedPlanes)

    @cached_property
    def path(self) -> LinkedPath:
        return self._read_required("path.npz", LinkedPath)

    @property
    def facts(self) -> Document:
        return self._document("links.json")


class MatchesArtifact(StepArtifact):
    """Pairs and tracks."""

    @property
    def tracks(self) -> Tracks:
        return self._read_required("tracks.npz", Tracks)

    @property
    def pairs(self) -> Document:
        return self._document("pairs.json")


class AdjustArtifact(StepArtifact):
    """The adjusted dive."""

    @cached_property
    def solution(self) -> Solution:
        return self._read_required("solution.npz", Solution)

    @property
    def summary(self) -> Document:
        return self._document("adjust.json")

    @property
    def depth_sigma_m(self) -> float | None:
        """Return how well the water surface is known in g, one sigma: the pressure sensor's bias,
        which all depths share, and its noise; None where no depth was measured or the bias has no
        sigma.
        """
        bias = _number(self.summary, "navigation_sigma", "depth_bias_m")
        noise = _number(self.summary, "sigmas", "depth_m")
        return math.hypot(bias, noise) if bias and noise is not None else None

    @property
    def iterations(self) -> Arrays:
        return load_arrays(self.folder / "iterations.npz")

    @property
    def chart(self) -> Chart | None:
        """Return the hull chart; None without a CAD model."""
        return read_chart(self.folder / "chart.npz")

    @property
    def camera_models(self) -> dict[Camera, CameraModel]:
        """Return the refined calibrations; empty where they were held."""
        return read_camera_models(self.folder / "cameras.json")


class SurfaceArtifact(StepArtifact):
    """The surface from the DVL's returns (of landmarks where there is no DVL)."""

    @property
    def surface(self) -> Surface:
        return self._read_required("surface.npz", Surface)

    @property
    def chart(self) -> Chart:
        """Return the chart that all later steps use. Raises InputError where it is missing."""
        chart = read_chart(self.folder / "chart.npz")
        if chart is None:
            raise InputError(
                "chart.npz is missing", where=str(self.folder), remedy="run the step again"
            )
        return chart

    @property
    def facts(self) -> Document:
        return self._document("surface.json")


class DetectArtifact(StepArtifact):
    """The hull as found and what is on it."""

    @property
    def as_found(self) -> Surface | None:
        return self._optional("as_found.npz", Surface)

    @property
    def is_found_by_images(self) -> bool:
        """Return whether the hull as found, where there is one, is that of landmarks, else of the
        DVL's returns.
        """
        return self.facts.get("as_found") is None

    @property
    def deviation(self) -> DeviationSplit | None:
        """Return offset, tilt and form of the deviation; None without a CAD model."""
        return self._optional("deviation.npz", DeviationSplit)

    @property
    def objects(self) -> Document:
        return self._document("objects.json")

    @property
    def coverage(self) -> Document:
        return self._document("coverage.json")

    @property
    def facts(self) -> Document:
        return self._document("detect.json")


class ChangeArtifact(StepArtifact):
    """What changed since an earlier dive."""

    @property
    def chapter(self) -> Document:
        return self._document(CHANGE_CHAPTER)

    @property
    def map(self) -> bytes:
        """Return the map of what changed, a PNG."""
        return (self.folder / CHANGE_MAP).read_bytes()

    @property
    def delivered(self) -> tuple[Path, ...]:
        """Return the files that are delivered as they are."""
        return tuple(path for path in sorted(self.folder.glob("change.*")))


@dataclass(frozen=True)
class InputArtifacts:
    """The artifacts that a step was handed; None for an optional one that this dive has not."""

    inputs: Mapping[str, Path]

    @property
    def ingest(self) -> IngestArtifact:
        return IngestArtifact(self.inputs["ingest"])

    @property
    def navigate(self) -> NavigateArtifact:
        return NavigateArtifact(self.inputs["navigate"])

    @property
    def links(self) -> LinksArtifact | None:
        return LinksArtifact(self.inputs["links"]) if "links" in self.inputs else None

    @property
    def matches(self) -> MatchesArtifact | None:
        return MatchesArtifact(self.inputs["matches"]) if "matches" in self.inputs else None

    @property
    def adjust(self) -> AdjustArtifact | None:
        return AdjustArtifact(self.inputs["adjust"]) if "adjust" in self.inputs else None

    @property
    def surface(self) -> SurfaceArtifact:
        return SurfaceArtifact(self.inputs["surface"])

    @property
    def detect(self) -> DetectArtifact | None:
        return DetectArtifact(self.inputs["detect"]) if "detect" in self.inputs else None

    @property
    def change(self) -> ChangeArtifact | None:
        return ChangeArtifact(self.inputs["change"]) if "change" in self.inputs else None

    def mounts(self, settings: Mapping[str, object]) -> dict[str, ChosenMount]:
        """Return the lever arms and mounts that these settings leave to the log. Raises InputError
        for a tray that carries but one of DVL and camera.
        """
        declared = dict(settings)  # without a fault where the step declares no such key
        values = {key: _value(declared, key) for key in DEFAULTS}
        tray = self.ingest.tray
        if tray is not None and len(tray.t_ns):
            refuse_parted_tray(values, self.ingest.sensors)
        return choose_mounts(values, self.ingest.sensors)

    def mounted(self, settings: StageSettings) -> StageSettings:
        """Return the settings with the lever arms and mounts in place that they leave to the log."""
        values: dict[str, object] = dict(settings)
        for key, mount in self.mounts(settings).items():
            section, _, name = key.rpartition(".")
            if section in values:
                values[section] = with_value(values[section], name, mount.value)
            values[key] = mount.value
        return settings.replaced(values)

    @property
    def camera_models(self) -> dict[Camera, CameraModel]:
        """Return the calibrations as refined by adjust, else as read."""
        refined = self.adjust.camera_models if self.adjust is not None else {}
        return refined or self.ingest.camera_models


def _number(document: Document, section: str, name: str) -> float | None:
    members = document.get(section)
    value = members.get(name) if isinstance(members, dict) else None
    return float(value) if isinstance(value, int | float) else None


def _value(settings: Mapping[str, object], key: str) -> object:
    """Return the value of a dotted key, which a step declares alone or with its section; None where
    it declares neither.
    """
    section, _, name = key.rpartition(".")
    return settings[key] if key in settings else getattr(settings.get(section), name, None)


def read_camera_models(path: Path) -> dict[Camera, CameraModel]:
    """Return the cameras of a cameras.json; empty where there is no such file."""
    if not path.exists():
        return {}
    return {
        Camera(name): CameraModel(**fields)
        for name, fields in json.loads(path.read_text(encoding="utf-8")).items()
    }


def read_chart(path: Path) -> Chart | None:
    """Return the chart of a chart.npz; None where there is no such file."""
    return chart_from_arrays(load_arrays(path)) if path.exists() else None
