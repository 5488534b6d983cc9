# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""All that a report draws on, by parts. What a dive does not have is None.

The structs named Facts, Summary or Findings decode the JSON documents of the steps: their fields
are the documents' members.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from msgspec import Struct

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
from hullrecon.report.change.chapter import ChangeChapter
from hullrecon.report.options import ReportOptions
from hullrecon.rig import Rig
from hullrecon.typing import Arrays, Pixels

Interval = tuple[float, float]  # seconds since start_ns


class StepDocument(Struct, frozen=True, kw_only=True):
    """A JSON document of a step, or a part of one. Members without a field are ignored."""


class LogFindings(StepDocument, frozen=True):
    """findings.json of ingest, in sentences."""

    lost: tuple[str, ...] = ()  # data that was lost
    hull: tuple[str, ...] = ()  # of the CAD model, as checked
    notes: tuple[str, ...] = ()


class NavigationFacts(StepDocument, frozen=True):
    """navigation.json of navigate."""

    start_ns: int = 0  # time of the first velocity
    outages_s: tuple[Interval, ...] = ()  # of the DVL
    attitude_gaps_s: tuple[Interval, ...] = ()
    remarks: tuple[str, ...] = ()


class PairFacts(StepDocument, frozen=True):
    """pairs.json of matches."""

    failed: Mapping[str, int] = {}  # number of pairs without a geometry, by reason


class FactorResiduals(StepDocument, frozen=True):
    """Residuals of one kind of measurement, each divided by its sigma."""

    rms: float
    count: float = 0  # of residuals
    robust_sigma: float | None = None  # from their median
    share_beyond_3: float | None = None  # share of the residuals beyond three sigmas


class AdjustSigmas(StepDocument, frozen=True):
    """Sigmas by which the adjustment weighted measurements, None of what was not measured."""

    pixel_px: float | None = None  # of a feature
    range_m: float | None = None  # of a DVL range


class SensorErrors(StepDocument, frozen=True):
    """Errors of navigation as estimated, or one sigma of each (zero: unknown)."""

    dvl_scale: float = 0.0  # correction: the true speed is (1 + dvl_scale) times the measured
    heading_drift_rad_s: float = 0.0  # correction, added to the measured rate of turn
    roll_bias_rad: float = 0.0
    pitch_bias_rad: float = 0.0
    depth_bias_m: float = 0.0


class RefinedParameter(StepDocument, frozen=True):
    """An intrinsic parameter of a camera that the adjustment estimated."""

    calibrated: float  # px for focal lengths and the principal point
    found: float  # as estimated
    sigma: float  # of the value found


class PositionFacts(StepDocument, frozen=True):
    """Position fixes (USBL, GNSS) against the adjusted path."""

    count: int
    span_s: float  # from the first to the last
    sigma_m: float  # median sigma of a fix
    rms_sigmas: float  # of the residuals in their sigmas, by the median
    outliers: int


class StereoContradictionFacts(StepDocument, frozen=True):
    """A contradiction between the dive's images and the stereo calibration."""

    sentence: str | None = None  # what is contradicted, None if it has no effect on the result


class SuspectFacts(StepDocument, frozen=True):
    """A sensor that was suspected, as in adjust.json."""

    words: str  # the sensor whose omission, or correction, makes the rest agree
    gain: float  # by how much chi-square falls then


class AdjustSummary(StepDocument, frozen=True):
    """adjust.json of adjust."""

    method: str = "maxmix"
    observations: int = 0
    observations_left_out: int = 0
    residuals_before: Mapping[str, FactorResiduals] = {}  # by kind of measurement
    residuals_after: Mapping[str, FactorResiduals] = {}
    sigmas: AdjustSigmas = AdjustSigmas()
    navigation: SensorErrors | None = None
    navigation_sigma: SensorErrors = SensorErrors()
    # by camera and name, empty if the calibrations were held
    intrinsics: Mapping[str, Mapping[str, RefinedParameter]] = {}
    cad_model_refused: str | None = None  # why the CAD model was left out
    stereo_contradiction: StereoContradictionFacts | None = None  # None if the calibration holds
    positions: PositionFacts | None = None
    suspects: tuple[SuspectFacts, ...] = ()  # where something contradicted the package, best first


class SurfaceFacts(StepDocument, frozen=True):
    """surface.json of surface."""

    # how far the comparison of this surface with the CAD model is circular, as it was made with it
    comparison: str | None = None


class DetectSettings(StepDocument, frozen=True):
    """The options of detect that decide which objects are reported."""

    min_height_m: float
    min_area_m2: float
    min_views: int
    max_p_value: float


class DetectFacts(StepDocument, frozen=True):
    """detect.json of detect."""

    objects: str | None = None  # why objects were not looked for
    as_found: str | None = None  # what the hull as found was made of, if not of landmarks
    not_reported: tuple[RejectedRegion, ...] = ()


class MosaicFacts(StepDocument, frozen=True):
    """mosaic.json of a mosaic step."""

    caption: str = ""
    resolution_m: float | None = None
    gap_area_m2: float = 0.0  # of gaps inside the outline


Document = Mapping[str, object]


class ImageSource(Protocol):
    """The images of one camera."""

    @property
    def index(self) -> ImageIndex:
        """Index of the images, in time order."""

    def read(self, row: int, /) -> Pixels | None:
        """Read an image (h, w, 3) RGB by row. None when it does not decode."""


@dataclass(frozen=True, kw_only=True)
class DiveFacts:
    """The dive, what it carried, and what its log says."""

    dive: Dive
    hull: Hull | None = None
    dvl: DvlPings | None = None
    returns: Returns | None = None  # of the DVL, attached to nodes
    has_depth: bool = True  # a pressure sensor was logged
    has_attitude: bool = True  # an IMU was logged
    rig: Rig
    images: Mapping[Camera, ImageSource] = field(default_factory=dict)
    log: LogFindings = field(default_factory=LogFindings)
    navigation: NavigationFacts = field(default_factory=NavigationFacts)
    pairs: PairFacts = field(default_factory=PairFacts)
    node_pairs: NodePairs | None = None  # all pairs whose images were compared
    about: ReportOptions = field(default_factory=ReportOptions)
    logo: bytes | None = None  # PNG


@dataclass(frozen=True, kw_only=True)
class AdjustedDive:
    """What the adjustment left."""

    solution: Solution
    summary: AdjustSummary = field(default_factory=AdjustSummary)
    weak_directions: tuple[Document, ...] = ()  # as in adjust.json
    iterations: Arrays = field(default_factory=dict)  # the record of the solve
    depth_sigma_m: float | None = None  # of any depth below the water surface

    @property
    def has_cad_model(self) -> bool:
        """Whether the dive was aligned with a CAD model."""
        return self.solution.hull_pose is not None

    @property
    def cad_model_was_refused(self) -> bool:
        """Whether there was a CAD model that the adjustment left out."""
        return not self.has_cad_model and self.summary.cad_model_refused is not None


@dataclass(frozen=True, kw_only=True)
class Surfaces:
    """The hull's chart and surfaces."""

    chart: Chart | None = None
    outside: OutsideMap | None = None  # the map in which rasters and vector layers lie
    surveyed: Surface | None = None  # from the DVL, from landmarks without a DVL
    as_found: Surface | None = None
    deviation: DeviationSplit | None = None  # of as_found
    comparison: str = ""  # as in SurfaceFacts
    cad_model: Mesh | None = None  # as given, in M
    found_by_images: bool = True  # the support of as_found counts images, else DVL returns


@dataclass(frozen=True, kw_only=True)
class Findings:
    """What is on the hull, and how much of it was seen."""

    objects: tuple[ReportedObject, ...] | None = None
    not_looked_for: str = ""  # why objects were not looked for, empty if they were
    not_reported: tuple[RejectedRegion, ...] = ()
    coverage: Coverage | None = None
    # objects.json and coverage.json, as they are delivered
    documents: Mapping[str, Document] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Mosaic:
    """What a mosaic step left."""

    facts: MosaicFacts
    preview: bytes  # PNG
    has_mesh: bool  # a textured mesh was written


@dataclass(frozen=True, kw_only=True)
class Mosaics:
    """The mosaics by sensor."""

    optical: Mosaic | None = None
    sonar: Mosaic | None = None

    def named(self) -> dict[str, Mosaic]:
        """Select the mosaics that the dive has, by name: optical, sonar."""
        both = {"optical": self.optical, "sonar": self.sonar}
        return {name: mosaic for name, mosaic in both.items() if mosaic is not None}


@dataclass(frozen=True, kw_only=True)
class EarlierComparison:
    """What changed since an earlier dive of the hull."""

    chapter: ChangeChapter
    map: bytes  # PNG


@dataclass(frozen=True, kw_only=True)
class StepRun:
    """A step's run, from its manifest."""

    name: str
    version: int
    settings: Document  # resolved, by section
    inputs: Document  # hash of each input artifact, by name
    warnings: tuple[str, ...]
    run: Document  # time, memory, machine: what differs between equal runs


@dataclass(frozen=True, kw_only=True)
class Carried:
    """What a dive was equipped with and given."""

    camera: bool = True
    sonar: bool = True  # an imaging sonar
    cad_model: bool = True
    earlier_dive: bool = False  # named, to be compared with


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """How the results came about."""

    steps: tuple[StepRun, ...] = ()
    carried: Carried = field(default_factory=Carried)
    failures: Mapping[str, str] = field(default_factory=dict)  # why a step has no result, by name
    # deliverables that the dive cannot give, with the reason of each (missing_deliverables)
    missing: Mapping[str, str] = field(default_factory=dict)
    # files of the steps that are delivered as they are, by their name in deliver/
    copies: Mapping[str, Path] = field(default_factory=dict)

    def settings_of(self, step: str) -> Mapping[str, object]:
        """Look up a step's options as it ran. Empty if it did not run or left no manifest."""
        found = next((run.settings.get(step) for run in self.steps if run.name == step), None)
        return found if isinstance(found, Mapping) else {}

    def warnings(self) -> list[str]:
        """List the warnings of the steps, with the step's name, in the order of the chain."""
        return [f"{step.name}: {text}" for step in self.steps for text in step.warnings]


@dataclass(frozen=True, kw_only=True)
class Survey:
    """The dive, adjusted or not."""

    facts: DiveFacts
    track: VehicleTrack  # the best path: adjusted, else dead reckoned
    trajectory: Trajectory  # dead reckoned
    adjusted: AdjustedDive | None = None
    surfaces: Surfaces = field(default_factory=Surfaces)
    findings: Findings = field(default_factory=Findings)
    mosaics: Mosaics = field(default_factory=Mosaics)
    change: EarlierComparison | None = None
    provenance: Provenance = field(default_factory=Provenance)

    @property
    def method(self) -> str:
        """Method of the adjustment: naive, geva or maxmix. "dead reckoning" if there was none."""
        return self.adjusted.summary.method if self.adjusted is not None else "dead reckoning"

    @property
    def is_in_hull_frame(self) -> bool:
        """Whether results are in M, that is aligned with a CAD model."""
        return self.track.frame == Frame.HULL

    @property
    def frame_in_words(self) -> str:
        """The frame of positions in words, with its axes' directions as far as sensors tell."""
        if self.is_in_hull_frame:
            return "the hull frame: that of the CAD model's file"
        level, zero = "local level", "at the water surface"
        if not self.facts.has_attitude:
            level = "local, level where the vehicle was at the first pose"
        if not self.facts.has_depth:
            zero = "at the depth of the first pose, which was not measured"
        return f"{level}: z down, z = 0 {zero}"

    @property
    def origin_in_words(self) -> str:
        """The origin of positions without a CAD model, in words."""
        facts = self.facts
        heading = "the heading is that of the first attitude"
        depth = "depths are below the water surface"
        refused = self.adjusted is not None and self.adjusted.cad_model_was_refused
        why = "The CAD model was left out" if refused else "There is no CAD model to align with"
        return (
            f"{why}: positions are relative to the start of the dive; "
            f"{heading if facts.has_attitude else 'no heading was measured'}, and "
            f"{depth if facts.has_depth else 'no depth was measured'}."
        )
