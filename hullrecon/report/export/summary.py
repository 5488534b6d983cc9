# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""summary.json: the run in numbers, for programs. All that differs between equal runs stands in its `run` block."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hullrecon import __version__
from hullrecon.records.iterations import count
from hullrecon.report.content.headline import path_length_m, summary_lines
from hullrecon.report.content.survey import Survey

SCHEMA = 1
_FRAMES = {"M": "the hull frame: that of the CAD model's file", "g": "local level: z down, z = 0 at the water surface"}


def summary_json(survey: Survey, deliverables: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """deliverables: bytes and sha256 by name."""
    dive = survey.dive
    return {
        "schema": SCHEMA,
        "software": {"name": "hullrecon", "version": __version__},
        "dive": {"name": dive.name, "vessel": dive.vessel, "date": dive.date.isoformat() if dive.date else None},
        "frame": survey.track.frame,
        "frame_in_words": _FRAMES[survey.track.frame],
        "units": "metres, seconds, radians; sigma is one standard deviation",
        "method": survey.method,
        "summary": summary_lines(survey),
        "counts": counts(survey),
        "warnings": survey.warnings(),
        "lost": [str(x) for x in survey.findings.get("lost") or []],
        "deliverables": {name: dict(entry) for name, entry in deliverables.items()},
        "absent": dict(survey.absent),
        "run": {"steps": {step.name: {k: v for k, v in step.run.items() if k != "times"} for step in survey.steps}},
    }


def _iterations(survey: Survey) -> int | None:
    """Of all rounds, their starts not counted."""
    record = survey.iterations
    if record is None or "cost" not in record:
        return None
    return count(np.asarray(record["round"], np.int64)) if "round" in record else len(record["cost"]) - 1


def counts(survey: Survey) -> dict[str, Any]:
    """What there is how often."""
    numbers: dict[str, Any] = {
        "poses": len(survey.track.t_ns),
        "path_m": round(path_length_m(survey), 3),
        "duration_s": round(float(survey.track.t_ns[-1] - survey.track.t_ns[0]) * 1e-9, 3),
        "images": {eye.name: int(eye.index.usable.sum()) for eye in survey.eyes},
        "images_unusable": {eye.name: int((~eye.index.usable).sum()) for eye in survey.eyes},
    }
    if survey.solution is not None:
        numbers["landmarks"] = len(survey.solution.landmarks)
        numbers["landmarks_on_surface"] = int((survey.solution.landmarks.label == 1).sum())
        numbers["iterations"] = _iterations(survey)
    if survey.objects is not None:
        numbers["objects"] = len(survey.objects)
    if survey.dvl is not None:
        numbers["dvl_pings"] = len(survey.dvl.t_ns)
    return numbers
