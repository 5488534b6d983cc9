# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the steps' JSON documents hold that a report shows; other members are ignored."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct

from hullrecon.records.deliverables import RejectedRegion

Interval = tuple[float, float]  # seconds of the log


class StepDocument(Struct, frozen=True, kw_only=True):
    """A JSON document of a step."""


class LogFindings(StepDocument, frozen=True):
    """findings.json of ingest: what was lost, the CAD model as checked, and remarks, each a sentence."""

    lost: tuple[str, ...] = ()
    hull: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


class NavigationFacts(StepDocument, frozen=True):
    """navigation.json of navigate."""

    outages_s: tuple[Interval, ...] = ()
    attitude_gaps_s: tuple[Interval, ...] = ()
    remarks: tuple[str, ...] = ()


class PairFacts(StepDocument, frozen=True):
    """pairs.json of matches: how many pairs gave no geometry, by reason."""

    failed: Mapping[str, int] = {}


class FactorResiduals(StepDocument, frozen=True):
    """Residuals of one kind of measurement, in their own sigma."""

    rms: float
    count: float = 0


class WeakDirection(StepDocument, frozen=True):
    """A direction in which the survey as a whole is uncertain: unit vector, sigma, and a sentence."""

    direction: tuple[float, ...] = ()
    sigma: float = 0.0
    sentence: str = ""


class AdjustSummary(StepDocument, frozen=True):
    """adjust.json of adjust. cad_model_refused: why the CAD model was left out; None where it was not."""

    method: str = "maxmix"
    observations: int = 0
    observations_left_out: int = 0
    residuals_before: Mapping[str, FactorResiduals] = {}
    residuals_after: Mapping[str, FactorResiduals] = {}
    cad_model_refused: str | None = None


class SurfaceFacts(StepDocument, frozen=True):
    """surface.json of surface. comparison: how far one with the CAD model is circular; None without a CAD model."""

    comparison: str | None = None


class DetectFacts(StepDocument, frozen=True):
    """detect.json of detect. objects: why objects were not looked for; None where they were."""

    objects: str | None = None
    not_reported: tuple[RejectedRegion, ...] = ()


class MosaicFacts(StepDocument, frozen=True):
    """mosaic.json of a mosaic step. gap_area_m2: of its gaps inside its outline."""

    caption: str = ""
    resolution_m: float | None = None
    gap_area_m2: float = 0.0
