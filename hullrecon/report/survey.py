# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""All that a report draws on, by parts; what a dive cannot have is None."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from hullrecon.dive.config.schema import Dive, Hull
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.frames import Camera, Frame
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.deliverables import Coverage, RejectedRegion, ReportedObject
from hullrecon.records.links import NodePairs
from hullrecon.records.sensors import DvlPings, ImageIndex
from hullrecon.records.solution import Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.records.trajectory import Returns, Trajectory, VehicleTrack
from hullrecon.report.about import AboutInspection
from hullrecon.report.change.chapter import ChangeChapter
from hullrecon.report.step_documents import (
    AdjustSummary,
    LogFindings,
    MosaicFacts,
    NavigationFacts,
    PairFacts,
)
from hullrecon.rig import Rig
from hullrecon.typing import Arrays, Pixels

Document = Mapping[str, object]


class ImageSource(Protocol):
    """The images of one camera."""

    @property
    def index(self) -> ImageIndex:
        """Return the index of the images, in time order."""

    def read(self, row: int, /) -> Pixels | None:
        """Return an image (h, w, 3) RGB by row; None when it does not decode."""


@dataclass(frozen=True, kw_only=True)
class DiveFacts:
    """What was dived, what was carried, and what the log, its navigation and its image pairs say in
    sentences. has_depth: a pressure sensor was logged; has_attitude: an IMU was; node_pairs: all
    pairs of nodes whose images were compared; about: what [report] of dive.toml says of the
    inspection.
    """

    dive: Dive
    hull: Hull | None = None
    dvl: DvlPings | None = None
    returns: Returns | None = None  # of the DVL, attached to nodes
    has_depth: bool = True
    has_attitude: bool = True
    rig: Rig
    images: Mapping[Camera, ImageSource] = field(default_factory=dict)
    log: LogFindings = field(default_factory=LogFindings)
    navigation: NavigationFacts = field(default_factory=NavigationFacts)
    pairs: PairFacts = field(default_factory=PairFacts)
    node_pairs: NodePairs | None = None
    about: AboutInspection = field(default_factory=AboutInspection)


@dataclass(frozen=True, kw_only=True)
class AdjustedDive:
    """What the adjustment left. weak_directions: as adjust.json has them; iterations: the record of
    the solve; depth_sigma_m: of any depth below the water surface, None where it is not known.
    """

    solution: Solution
    summary: AdjustSummary = field(default_factory=AdjustSummary)
    weak_directions: tuple[Document, ...] = ()
    iterations: Arrays = field(default_factory=dict)
    depth_sigma_m: float | None = None

    @property
    def has_cad_model(self) -> bool:
        """Return whether the dive was aligned with a CAD model."""
        return self.solution.hull_pose is not None

    @property
    def cad_model_was_refused(self) -> bool:
        """Return whether there was a CAD model that the adjustment left out."""
        return not self.has_cad_model and self.summary.cad_model_refused is not None


@dataclass(frozen=True, kw_only=True)
class Surfaces:
    """The hull chart, the surveyed surface (the DVL's, of landmarks where there is none) and the
    hull as found with the parts of its deviation. outside: the map in which rasters and vector
    layers lie. comparison: how far a comparison of the DVL's surface with the CAD model is
    circular, in a sentence. cad_model: as given, in M. found_by_images: whether images are what
    supports the hull as found, not returns of the DVL.
    """

    chart: Chart | None = None
    outside: OutsideMap | None = None
    surveyed: Surface | None = None
    as_found: Surface | None = None
    deviation: DeviationSplit | None = None
    comparison: str = ""
    cad_model: Mesh | None = None
    found_by_images: bool = True


@dataclass(frozen=True, kw_only=True)
class Findings:
    """What is on the hull, and how much of it was seen. documents: objects.json and coverage.json
    as they are delivered.
    """

    objects: tuple[ReportedObject, ...] | None = None
    not_reported: tuple[RejectedRegion, ...] = ()
    coverage: Coverage | None = None
    documents: Mapping[str, Document] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Mosaic:
    """What a mosaic step left: mosaic.json, the preview (PNG bytes), and whether there is a
    textured mesh.
    """

    facts: MosaicFacts
    preview: bytes
    has_mesh: bool


@dataclass(frozen=True, kw_only=True)
class Mosaics:
    """The mosaics by sensor."""

    optical: Mosaic | None = None
    sonar: Mosaic | None = None

    def named(self) -> dict[str, Mosaic]:
        """Return those that there are by name: optical, sonar."""
        both = {"optical": self.optical, "sonar": self.sonar}
        return {name: mosaic for name, mosaic in both.items() if mosaic is not None}


@dataclass(frozen=True, kw_only=True)
class EarlierComparison:
    """What changed since an earlier dive of the hull: the texts, and the map (PNG bytes)."""

    chapter: ChangeChapter
    map: bytes


@dataclass(frozen=True, kw_only=True)
class StepRun:
    """One step as its manifest has it: name, version, resolved settings by section, hashes of its
    inputs, warnings, and the run block, which differs between equal runs.
    """

    name: str
    version: int
    settings: Document
    inputs: Document
    warnings: tuple[str, ...]
    run: Document


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """How the results came about. missing: deliverables that cannot be given, with the reason of
    each; copies: files of the steps that are delivered as they are, by their name in deliver/.
    """

    steps: tuple[StepRun, ...] = ()
    missing: Mapping[str, str] = field(default_factory=dict)
    copies: Mapping[str, Path] = field(default_factory=dict)

    def settings_of(self, step: str) -> Mapping[str, object]:
        """Return the options of a step as it ran; nothing where it did not, or its manifest is not
        there.
        """
        found = next((run.settings.get(step) for run in self.steps if run.name == step), None)
        return found if isinstance(found, Mapping) else {}

    def warnings(self) -> list[str]:
        """Return what the steps warned of, with the step's name, in the order of the chain."""
        return [f"{step.name}: {text}" for step in self.steps for text in step.warnings]


@dataclass(frozen=True, kw_only=True)
class Survey:
    """The dive, adjusted or not. track: its best path; trajectory: dead reckoned."""

    facts: DiveFacts
    track: VehicleTrack
    trajectory: Trajectory
    adjusted: AdjustedDive | None = None
    surfaces: Surfaces = field(default_factory=Surfaces)
    findings: Findings = field(default_factory=Findings)
    mosaics: Mosaics = field(default_factory=Mosaics)
    change: EarlierComparison | None = None
    provenance: Provenance = field(default_factory=Provenance)

    @property
    def method(self) -> str:
        """Return naive, geva or maxmix; "dead reckoning" when nothing was adjusted."""
        return self.adjusted.summary.method if self.adjusted is not None else "dead reckoning"

    @property
    def is_in_hull_frame(self) -> bool:
        """Return whether results are in M, that is aligned with a CAD model."""
        return self.track.frame == Frame.HULL
