# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read what each step left in its folder. Only this module knows the files' names.

A property raises InputError if a file is missing that its step always leaves. What a dive may lack
is None.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Literal, TypeVar

import msgspec
import numpy as np

from hullrecon.artifacts.stage import StageSettings, load_arrays, map_arrays
from hullrecon.dive.config.mounts import (
    ChosenMount,
    choose_mounts,
    refuse_mounts,
    with_value,
)
from hullrecon.dive.config.schema import DEFAULT_MOUNTS
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
    VehicleTrack,
)
from hullrecon.rig import Rig, rig_with_priors
from hullrecon.typing import Arrays

Record = TypeVar("Record")
Artifact = TypeVar("Artifact", bound="StepArtifact")
Document = Mapping[str, object]
MOUNTS = "mounts.json"
SONAR_IMAGES = "sonar_image.npy"
COMMON_FEATURES = "features.npy"
CHANGE_CHAPTER, CHANGE_MAP = "chapter.json", "change.png"


@dataclass(frozen=True)
class StepArtifact:
    """The folder of one step's artifact. Subclasses list its files."""

    folder: Path

    def missing(self, name: str) -> InputError:
        return InputError(f"{name} is missing", where=str(self.folder), remedy="run the step again")

    def read(self, name: str, kind: type[Record]) -> Record | None:
        """Read a record. None if the dive lacks it."""
        path = self.folder / name
        return from_arrays(kind, load_arrays(path)) if path.exists() else None


class OptionalFile(Generic[Record]):
    """A record in a file of an artifact, read on access. None if the dive lacks it."""

    def __init__(self, name: str, kind: type[Record]) -> None:
        self.name, self.kind = name, kind

    def __get__(self, artifact: StepArtifact, owner: type) -> Record | None:
        return artifact.read(self.name, self.kind)


class RequiredFile(Generic[Record]):
    """A record that its step always leaves, read on access.

    Raises InputError if its file is missing.
    """

    def __init__(self, name: str, kind: type[Record]) -> None:
        self.name, self.kind = name, kind

    def __get__(self, artifact: StepArtifact, owner: type) -> Record:
        """Read the record at the first access, and keep it as long as the artifact's object."""
        kept: dict[str, Record] = artifact.__dict__
        if self.name not in kept:
            found = artifact.read(self.name, self.kind)
            if found is None:
                raise artifact.missing(self.name)
            kept[self.name] = found
        return kept[self.name]


class JsonFile:
    """A JSON document, read on access. Empty if there is no file."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __get__(self, artifact: StepArtifact, owner: type) -> Document:
        path = artifact.folder / self.name
        document: Document = json.loads(path.read_text("utf-8")) if path.exists() else {}
        return document


class IngestArtifact(StepArtifact):
    """What the package holds, decoded."""

    dvl = OptionalFile("dvl.npz", DvlPings)
    imu = OptionalFile("imu.npz", ImuSamples)
    pressure = OptionalFile("pressure.npz", PressureSamples)
    tray = OptionalFile("tray.npz", JointSamples)
    sonar_joint = OptionalFile("sonar_tray.npz", JointSamples)
    position = OptionalFile("position.npz", PositionFixes)
    findings = JsonFile("findings.json")
    mounts = JsonFile(MOUNTS)

    @property
    def sonar(self) -> SonarPings | None:
        """The sonar's pings, their images mapped from the file. None if no sonar was carried."""
        path = self.folder / "sonar.npz"
        if not path.exists():
            return None
        image = np.load(self.folder / SONAR_IMAGES, mmap_mode="r", allow_pickle=False)
        return from_arrays(SonarPings, {**load_arrays(path), "image": image})

    @property
    def hull(self) -> Mesh | None:
        """The checked CAD model in its own frame. None if the dive has no CAD model."""
        path = self.folder / "hull.npz"
        if not path.exists():
            return None
        arrays = load_arrays(path)
        return Mesh(arrays["vertices"], arrays["faces"])

    @property
    def camera_models(self) -> dict[Camera, CameraModel]:
        """The calibrations as read. Empty if no camera was carried."""
        return read_camera_models(self.folder / "cameras.json")

    @property
    def sensors(self) -> dict[str, FixedSensor]:
        """The sensors that the log's tf_static gives a pose for. Empty without tf_static."""
        return msgspec.convert(self.mounts, dict[str, FixedSensor])

    def image_index(self, camera: Camera) -> ImageIndex | None:
        return self.read(f"images_{camera.key}.npz", ImageIndex)

    def images(self, camera: Camera, package: Path | None) -> ImageStore:
        """Open the images of a camera. `package` is the folder of images that are plain files."""
        return ImageStore(self.folder, package, camera.key)


class NavigateArtifact(StepArtifact):
    """The dead-reckoned dive."""

    trajectory = RequiredFile("trajectory.npz", Trajectory)
    odometry = RequiredFile("odometry.npz", Odometry)
    attitude = RequiredFile("attitude.npz", Attitude)
    error_model = RequiredFile("error_model.npz", TrajectoryErrorModel)
    returns = OptionalFile("returns.npz", Returns)  # of the DVL, None if no DVL was carried
    positions = OptionalFile("positions.npz", PositionTies)  # fixes (USBL, GNSS) tied to nodes
    facts = JsonFile("navigation.json")

    @property
    def depth_offset_m(self) -> float:
        """Largest difference between two levels of the depths, m. 0 if the level never stepped."""
        return float(str(self.facts.get("depth_offset_m", 0.0)))

    @property
    def heading_drift_sigma_rad_s(self) -> float:
        """Sigma of the drift of a heading that was taken from the rates. 0 if it was not."""
        return float(str(self.facts.get("heading_drift_sigma_rad_s", 0.0)))


class LinksArtifact(StepArtifact):
    """Pairs of nodes, the common features of their images, and the path solved with the links."""

    pairs = RequiredFile("pairs.npz", NodePairs)
    compared = OptionalFile("pairs.npz", NodePairs)  # as `pairs`, None if no camera was carried
    links = RequiredFile("links.npz", CameraLinks)
    stereo = RequiredFile("stereo.npz", NodeStereo)
    planes = OptionalFile("planes.npz", TiedPlanes)  # patches of hull that tie passes together
    path = RequiredFile("path.npz", LinkedPath)
    facts = JsonFile("links.json")

    @property
    def features(self) -> PairFeatures:
        """The common features of the pairs that matched and were kept (`NodePairs.joined`).

        They are mapped from the file, pair by pair, as those of a long dive do not fit into memory.
        """
        index, rows = self.folder / "features.npz", self.folder / COMMON_FEATURES
        for path in (index, rows):
            if not path.exists():
                raise self.missing(path.name)
        start = load_arrays(index)["start"]
        # numpy cannot map an array without rows
        mode: Literal["r"] | None = "r" if start[-1] else None
        return PairFeatures(start=start, rows=np.load(rows, mmap_mode=mode, allow_pickle=False))


class MatchesArtifact(StepArtifact):
    """Pairs and tracks."""

    tracks = RequiredFile("tracks.npz", Tracks)
    pairs = JsonFile("pairs.json")

    def mapped_tracks(self) -> Tracks:
        """Map the tracks from their file: those of a long dive do not fit into memory."""
        path = self.folder / "tracks.npz"
        if not path.exists():
            raise self.missing(path.name)
        return from_arrays(Tracks, map_arrays(path))


class AdjustArtifact(StepArtifact):
    """The adjusted dive."""

    solution = RequiredFile("solution.npz", Solution)
    summary = JsonFile("adjust.json")

    @property
    def depth_sigma_m(self) -> float | None:
        """Sigma of the water surface's height in g, m. None if it is unknown.

        It combines the pressure sensor's bias, which all depths share, and its noise. It is unknown
        where adjust.json does not hold both, or the bias is zero.
        """
        bias = _number(self.summary, "navigation_sigma", "depth_bias_m")
        noise = _number(self.summary, "sigmas", "depth_m")
        return math.hypot(bias, noise) if bias and noise is not None else None

    @property
    def iterations(self) -> Arrays:
        return load_arrays(self.folder / "iterations.npz")

    @property
    def chart(self) -> Chart | None:
        """The hull chart. None without a CAD model."""
        return read_chart(self.folder / "chart.npz")

    @property
    def camera_models(self) -> dict[Camera, CameraModel]:
        """The refined calibrations. Empty if calibrations were held fixed."""
        return read_camera_models(self.folder / "cameras.json")


class SurfaceArtifact(StepArtifact):
    """The surface from the DVL's returns (of landmarks where there is no DVL)."""

    surface = RequiredFile("surface.npz", Surface)
    facts = JsonFile("surface.json")

    @property
    def chart(self) -> Chart:
        """The chart that all later steps use. Raises InputError if it is missing."""
        chart = read_chart(self.folder / "chart.npz")
        if chart is None:
            raise self.missing("chart.npz")
        return chart


class DetectArtifact(StepArtifact):
    """The hull as found and what is on it."""

    as_found = OptionalFile("as_found.npz", Surface)
    deviation = OptionalFile("deviation.npz", DeviationSplit)  # None without a CAD model
    objects = JsonFile("objects.json")
    coverage = JsonFile("coverage.json")
    facts = JsonFile("detect.json")

    @property
    def is_found_by_images(self) -> bool:
        """Whether the hull as found comes from landmarks, not from the DVL's returns."""
        return self.facts.get("as_found") is None


class ChangeArtifact(StepArtifact):
    """What changed since an earlier dive."""

    chapter = JsonFile(CHANGE_CHAPTER)

    @property
    def map(self) -> bytes:
        """The map of changes, a PNG."""
        return (self.folder / CHANGE_MAP).read_bytes()

    @property
    def delivered(self) -> tuple[Path, ...]:
        """The files that are delivered unchanged."""
        return tuple(sorted(self.folder.glob("change.*")))


class NeededInput(Generic[Artifact]):
    """An artifact that the step is given."""

    def __init__(self, name: str, kind: type[Artifact]) -> None:
        self.name, self.kind = name, kind

    def __get__(self, given: InputArtifacts, owner: type) -> Artifact:
        return self.kind(given.inputs[self.name])


class OptionalInput(NeededInput[Artifact]):
    """An artifact that this dive may lack, None then."""

    def __get__(self, given: InputArtifacts, owner: type) -> Artifact | None:  # type: ignore[override]
        return super().__get__(given, owner) if self.name in given.inputs else None


@dataclass(frozen=True)
class InputArtifacts:
    """The artifacts that a step is given. None for an optional artifact that this dive lacks."""

    inputs: Mapping[str, Path]

    ingest = NeededInput("ingest", IngestArtifact)
    navigate = NeededInput("navigate", NavigateArtifact)
    surface = NeededInput("surface", SurfaceArtifact)
    links = OptionalInput("links", LinksArtifact)
    matches = OptionalInput("matches", MatchesArtifact)
    adjust = OptionalInput("adjust", AdjustArtifact)
    detect = OptionalInput("detect", DetectArtifact)
    change = OptionalInput("change", ChangeArtifact)

    def mounts(self, settings: Mapping[str, object]) -> dict[str, ChosenMount]:
        """Choose each lever arm and mount: by dive.toml, else by the log, else its default.

        settings: of a step, which may declare only some of the mounts. Raises InputError where
        dive.toml leaves a mount to the log, and the log's tf_static cannot give it.
        """
        # A dict, in which a missing key can be asked for: StageSettings raises for keys that the
        # step did not declare.
        declared = dict(settings)
        values = {key: _value(declared, key) for key in DEFAULT_MOUNTS}
        tray = self.ingest.tray
        refuse_mounts(values, self.ingest.sensors, tray is not None and len(tray.t_ns) > 0)
        return choose_mounts(values, self.ingest.sensors)

    def mounted(self, settings: StageSettings) -> StageSettings:
        """Fill in the lever arms and mounts that these settings leave to the log.

        A mount is filled in under its own key, and in its section where the step declares that.
        Raises InputError where the log's tf_static cannot give one.
        """
        values: dict[str, object] = dict(settings)
        for key, mount in self.mounts(settings).items():
            section, _, name = key.rpartition(".")
            if section in values:
                values[section] = with_value(values[section], name, mount.value)
            values[key] = mount.value
        return settings.replaced(values)

    def rig(self, settings: StageSettings) -> Rig:
        """Build the rig with its priors, by settings that hold the log's mounts (`mounted`).

        The prior of the depths' bias is wider where the level of the depths stepped, and that of
        the heading's drift where the heading was taken from the rates.
        """
        rig = rig_with_priors(settings, self.ingest.camera_models)
        navigate = self.navigate
        return rig.with_wider_navigation(
            depth_bias_m=navigate.depth_offset_m,
            heading_drift_rad_s=navigate.heading_drift_sigma_rad_s,
        )

    @property
    def track(self) -> VehicleTrack:
        """The best path: adjusted in M, adjusted in g, or dead reckoned in g."""
        adjusted = self.adjust
        path = self.navigate.trajectory if adjusted is None else adjusted.solution
        return path.track()

    @property
    def camera_models(self) -> dict[Camera, CameraModel]:
        """The calibrations as refined by adjust, else as read."""
        refined = self.adjust.camera_models if self.adjust is not None else {}
        return refined or self.ingest.camera_models


def _number(document: Document, section: str, name: str) -> float | None:
    """Look up a number in a section of a document. None if either is missing."""
    members = document.get(section)
    value = members.get(name) if isinstance(members, dict) else None
    return float(value) if isinstance(value, int | float) else None


def _value(settings: Mapping[str, object], key: str) -> object:
    """Look up a key that a step declares alone or with its section. None if it declares neither."""
    section, _, name = key.rpartition(".")
    return settings[key] if key in settings else getattr(settings.get(section), name, None)


def read_camera_models(path: Path) -> dict[Camera, CameraModel]:
    """Read the cameras of a cameras.json. Empty if there is no such file."""
    if not path.exists():
        return {}
    return {
        Camera(name): CameraModel(**fields)
        for name, fields in json.loads(path.read_text(encoding="utf-8")).items()
    }


def read_chart(path: Path) -> Chart | None:
    """Read the chart of a chart.npz. None if there is no such file."""
    return chart_from_arrays(load_arrays(path)) if path.exists() else None
