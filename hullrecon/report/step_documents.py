# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Members of the steps' JSON documents that a report shows. Other members are ignored."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct

from hullrecon.records.deliverables import RejectedRegion

Interval = tuple[float, float]  # seconds since start_ns


class StepDocument(Struct, frozen=True, kw_only=True):
    """A JSON document of a step."""


class LogFindings(StepDocument, frozen=True):
    """findings.json of ingest, in sentences."""

    lost: tuple[str, ...] = ()  # data that was lost
    hull: tuple[str, ...] = ()  # of the CAD model, as checked
    notes: tuple[str, ...] = ()


class NavigationFacts(StepDocument, frozen=True):
    """navigation.json of navigate."""

    start_ns: int = 0  # of the first velocity
    outages_s: tuple[Interval, ...] = ()  # of the DVL
    attitude_gaps_s: tuple[Interval, ...] = ()
    remarks: tuple[str, ...] = ()


class PairFacts(StepDocument, frozen=True):
    """pairs.json of matches."""

    failed: Mapping[str, int] = {}  # number of pairs without a geometry, by reason


class FactorResiduals(StepDocument, frozen=True):
    """Residuals of one kind of measurement, in their own sigma."""

    rms: float
    count: float = 0
    robust_sigma: float | None = None  # from their median
    share_beyond_3: float | None = None  # beyond three sigmas


class AdjustSigmas(StepDocument, frozen=True):
    """Sigmas with which the adjustment weighted, None of what was not measured."""

    pixel_px: float | None = None
    range_m: float | None = None  # of a DVL range


class SensorErrors(StepDocument, frozen=True):
    """Errors of navigation as estimated, or one sigma of each (zero: unknown)."""

    dvl_scale: float = 0.0  # correction: the true speed is (1 + dvl_scale) times the measured
    heading_drift_rad_s: float = 0.0  # correction, added to the measured rate of turn
    roll_bias_rad: float = 0.0
    pitch_bias_rad: float = 0.0
    depth_bias_m: float = 0.0


class RefinedParameter(StepDocument, frozen=True):
    """A parameter of a camera."""

    calibrated: float
    found: float
    sigma: float


class PositionFacts(StepDocument, frozen=True):
    """Positions from outside (USBL, GPS) against the adjusted path."""

    count: int
    span_s: float  # from the first to the last
    sigma_m: float  # median
    rms_sigmas: float  # of the residuals in their sigmas, by the median
    outliers: int


class StereoContradictionFacts(StepDocument, frozen=True):
    """What the dive says of the stereo rig's calibration."""

    sentence: str | None = None  # what it contradicts, None if that has no effect on the result


class SuspectFacts(StepDocument, frozen=True):
    """A sensor that was suspected, as in adjust.json."""

    words: str  # with or without what the rest agrees
    gain: float  # squares of residuals that are gone then


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

    comparison: str | None = None  # how far comparing it with the CAD model is circular


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
