# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the steps' JSON documents hold that a report shows; other members are ignored."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct

from hullrecon.records.deliverables import RejectedRegion

Interval = tuple[float, float]  # seconds since start_ns


class StepDocument(Struct, frozen=True, kw_only=True):
    """A JSON document of a step."""


class LogFindings(StepDocument, frozen=True):
    """findings.json of ingest: what was lost, the CAD model as checked, and remarks, each a
    sentence.
    """

    lost: tuple[str, ...] = ()
    hull: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


class NavigationFacts(StepDocument, frozen=True):
    """navigation.json of navigate. start_ns: of the first velocity; intervals count from it."""

    start_ns: int = 0
    outages_s: tuple[Interval, ...] = ()
    attitude_gaps_s: tuple[Interval, ...] = ()
    remarks: tuple[str, ...] = ()


class PairFacts(StepDocument, frozen=True):
    """pairs.json of matches: how many pairs gave no geometry, by reason."""

    failed: Mapping[str, int] = {}


class FactorResiduals(StepDocument, frozen=True):
    """Residuals of one kind of measurement, in their own sigma. robust_sigma: from their median;
    share_beyond_3: of three sigmas.
    """

    rms: float
    count: float = 0
    robust_sigma: float | None = None
    share_beyond_3: float | None = None


class AdjustSigmas(StepDocument, frozen=True):
    """One sigma of a pixel and of a DVL range, as the adjustment weighted them; None where there
    was none.
    """

    pixel_px: float | None = None
    range_m: float | None = None


class SensorErrors(StepDocument, frozen=True):
    """Errors of the navigation's sensors that the adjustment estimated, or one sigma of each (zero:
    not known). dvl_scale and heading_drift_rad_s: what is added to the sensor's velocities, as a
    share of the true ones, and to its rate of turn.
    """

    dvl_scale: float = 0.0
    heading_drift_rad_s: float = 0.0
    roll_bias_rad: float = 0.0
    pitch_bias_rad: float = 0.0
    depth_bias_m: float = 0.0


class WeakDirection(StepDocument, frozen=True):
    """A direction in which the survey as a whole is uncertain: unit vector, sigma, and a sentence."""

    direction: tuple[float, ...] = ()
    sigma: float = 0.0
    sentence: str = ""


class RefinedParameter(StepDocument, frozen=True):
    """A parameter of a camera: as calibrated, as found, and its sigma."""

    calibrated: float
    found: float
    sigma: float


class PositionFacts(StepDocument, frozen=True):
    """Positions from outside against the adjusted path: their number, from the first to the last,
    their median sigma, rms of their residuals in sigmas by the median, and how many are outliers.
    """

    count: int
    span_s: float
    sigma_m: float
    rms_sigmas: float
    outliers: int


class StereoContradictionFacts(StepDocument, frozen=True):
    """sentence: what of the stereo rig's calibration the dive contradicts; None where it matters to
    nobody.
    """

    sentence: str | None = None


class AdjustSummary(StepDocument, frozen=True):
    """adjust.json of adjust. intrinsics: by camera and name, empty where the calibrations were
    held; cad_model_refused: why the CAD model was left out, None where it was not;
    stereo_contradiction: None where the rig's calibration holds; positions: None where there were
    none from outside.
    """

    method: str = "maxmix"
    observations: int = 0
    observations_left_out: int = 0
    residuals_before: Mapping[str, FactorResiduals] = {}
    residuals_after: Mapping[str, FactorResiduals] = {}
    sigmas: AdjustSigmas = AdjustSigmas()
    navigation: SensorErrors | None = None
    navigation_sigma: SensorErrors = SensorErrors()
    intrinsics: Mapping[str, Mapping[str, RefinedParameter]] = {}
    cad_model_refused: str | None = None
    stereo_contradiction: StereoContradictionFacts | None = None
    positions: PositionFacts | None = None


class SurfaceFacts(StepDocument, frozen=True):
    """surface.json of surface. comparison: how far one with the CAD model is circular; None without
    a CAD model.
    """

    comparison: str | None = None


class DetectSettings(StepDocument, frozen=True):
    """What of the options of detect says which objects are reported."""

    min_height_m: float
    min_area_m2: float
    min_views: int
    max_p_value: float


class DetectFacts(StepDocument, frozen=True):
    """detect.json of detect. objects: why objects were not looked for; None where they were.
    as_found: what the hull as found was made of where that is not landmarks.
    """

    objects: str | None = None
    as_found: str | None = None
    not_reported: tuple[RejectedRegion, ...] = ()


class MosaicFacts(StepDocument, frozen=True):
    """mosaic.json of a mosaic step. gap_area_m2: of its gaps inside its outline."""

    caption: str = ""
    resolution_m: float | None = None
    gap_area_m2: float = 0.0
