# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which deliverables a dive cannot give, and why."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from hullrecon.records.solution import Solution

_BY_STEP = {
    "adjust": ("colmap/", "landmarks.ply"),
    "surface": ("surface.ply",),
    "detect": ("as_found.ply", "objects.json", "objects.csv", "coverage.json"),
    "mosaic-optical": ("ortho_optical.tif", "ortho_optical.png", "mosaic_optical.glb"),
    "mosaic-sonar": ("ortho_sonar.tif", "ortho_sonar.png", "mosaic_sonar.glb"),
}


def absences(sections: Mapping[str, Any], steps: Collection[str], solution: Solution | None) -> dict[str, str]:
    """Name to reason, in the order of docs/deliverables.md. sections: decoded, None when absent; steps: those that left an
    artifact."""
    reasons: dict[str, str] = {}
    camera, sonar, hull = (sections.get(s) is not None for s in ("camera.top", "sonar", "hull"))
    if solution is None or solution.hull_pose is None:
        reasons["alignment.json"] = (
            "the adjustment did not run" if hull else "no CAD model was given, so there is nothing to align to"
        )
    for step, names in _BY_STEP.items():
        why = _reason(step, camera, sonar, step in steps)
        if why:
            reasons.update(dict.fromkeys(names, why))
    if camera and solution is not None and not len(solution.landmarks):
        reasons["landmarks.ply"] = "no landmark was adjusted"
    if not camera:
        reasons.update(dict.fromkeys(_BY_STEP["adjust"], "no camera was carried"))
    return reasons


def _reason(step: str, camera: bool, sonar: bool, ran: bool) -> str:
    if ran:
        return ""
    if not camera and step == "mosaic-optical":
        return "no camera was carried"
    if not sonar and step == "mosaic-sonar":
        return "no imaging sonar was carried"
    return f"the step {step} left no result"
