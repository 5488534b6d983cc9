# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which deliverables a dive cannot give, and why."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from hullrecon.records.solution import Solution

OF_OBJECTS = ("objects.json", "objects.csv", "objects.geojson", "objects.gpkg", "objects/")
OF_DEVIATION = ("deviation.tif", "deviation_sigma.tif", "form.tif", "form_sigma.tif")
OF_SUPPORT = "support.tif"
_BY_STEP = {
    "adjust": ("colmap/", "landmarks.ply"),
    "surface": ("surface.ply", "chart.json", "chart.ply"),
    "detect": ("as_found.ply", "as_found.las", *OF_OBJECTS, "coverage.json"),
    "mosaic-optical": (
        "ortho_optical.tif",
        "ortho_optical.png",
        "mosaic_optical.glb",
        "variance_optical.tif",
        "views_optical.tif",
    ),
    "mosaic-sonar": (
        "ortho_sonar.tif",
        "ortho_sonar.png",
        "mosaic_sonar.glb",
        "variance_sonar.tif",
        "views_sonar.tif",
    ),
    "change": ("change/",),
}


@dataclass(frozen=True, kw_only=True)
class Carried:
    """What a dive has: a camera, an imaging sonar, a CAD model, the name of an earlier dive to be
    compared with.
    """

    camera: bool
    sonar: bool
    cad_model: bool
    earlier_dive: bool = False


def missing_deliverables(
    carried: Carried,
    steps: Collection[str],
    solution: Solution | None,
    failures: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, str]:
    """Return the reason of each missing file by name. steps: those that left an artifact; failures:
    why others did not.
    """
    reasons: dict[str, str] = {}
    if not carried.cad_model:
        reasons["alignment.json"] = "no CAD model was given, so there is nothing to align to"
        reasons.update(
            dict.fromkeys(
                OF_DEVIATION, "no CAD model was given, so there is nothing to deviate from"
            )
        )
    elif solution is None:
        reasons["alignment.json"] = "the adjustment did not run"
    elif solution.hull_pose is None:
        reasons.update(
            dict.fromkeys(
                ("alignment.json", *OF_DEVIATION),
                "the CAD model does not fit the survey and was left out",
            )
        )
    for step, names in _BY_STEP.items():
        asked = step != "change" or carried.earlier_dive
        reason = "" if step in steps or not asked else failures.get(step) or _reason(step, carried)
        if reason:
            reasons.update(dict.fromkeys(names, reason))
    if not {"mosaic-optical", "mosaic-sonar"} & set(steps):
        rasters = (*OF_DEVIATION, OF_SUPPORT)
        reasons = {
            **dict.fromkeys(rasters, "they lie on a mosaic's grid, and there is none"),
            **reasons,
        }
    if carried.camera and solution is not None and not len(solution.landmarks):
        reasons["landmarks.ply"] = "no landmark was adjusted"
    if not carried.camera:
        reasons.update(dict.fromkeys(_BY_STEP["adjust"], "no camera was carried"))
    return reasons


def _reason(step: str, carried: Carried) -> str:
    if not carried.camera and step == "mosaic-optical":
        return "no camera was carried"
    if not carried.sonar and step == "mosaic-sonar":
        return "no imaging sonar was carried"
    if not carried.cad_model and step == "change":
        return "no CAD model was given, and two dives are compared on their hull's CAD model"
    return f"the step {step} left no result"
