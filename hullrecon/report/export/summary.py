# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""summary.json: the run in numbers, for programs. All that differs between equal runs stands in its
`run` block.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from hullrecon.records.iterations import count
from hullrecon.report.content.deviation import deviation_document, deviation_figures
from hullrecon.report.content.frame_words import frame_in_words
from hullrecon.report.content.headline import headline, path_length_m
from hullrecon.report.survey import AdjustedDive, Survey
from hullrecon.version import commit, version

if TYPE_CHECKING:
    from hullrecon.report.deliver import FileEntry

SCHEMA = 1


def summary_document(survey: Survey, deliverables: Mapping[str, FileEntry]) -> dict[str, object]:
    """Return summary.json (docs/deliverables.md); deliverables: size and hash by name."""
    dive, provenance = survey.facts.dive, survey.provenance
    return {
        "schema": SCHEMA,
        "software": {"name": "hullrecon", "version": version(), "commit": commit()},
        "dive": {
            "name": dive.name,
            "vessel": dive.vessel,
            "date": dive.date.isoformat() if dive.date else None,
        },
        "frame": survey.track.frame,
        "frame_in_words": frame_in_words(survey),
        "units": "metres, seconds, radians; sigma is one standard deviation",
        "method": survey.method,
        "summary": headline(survey),
        "counts": counts(survey),
        "deviation": deviation_document(deviation_figures(survey)),
        "warnings": provenance.warnings(),
        "lost": list(survey.facts.log.lost),
        "deliverables": {name: asdict(entry) for name, entry in deliverables.items()},
        "absent": dict(provenance.missing),
        "run": {"steps": {step.name: _public_run(step.run) for step in provenance.steps}},
    }


def _public_run(run: Mapping[str, object]) -> dict[str, object]:
    """Return a step's run block as others may see it: without times of single iterations and the
    host's name.
    """
    public = {name: value for name, value in run.items() if name != "times"}
    host = public.get("host")
    if isinstance(host, Mapping):
        public["host"] = {name: value for name, value in host.items() if name != "name"}
    return public


def _iterations(adjusted: AdjustedDive) -> int | None:
    """Return the iterations of all rounds, their starts not counted; None where they were not
    recorded.
    """
    record = adjusted.iterations
    if "cost" not in record:
        return None
    return (
        count(np.asarray(record["round"], np.int64))
        if "round" in record
        else len(record["cost"]) - 1
    )


def counts(survey: Survey) -> dict[str, object]:
    """Return what there is how often."""
    track, facts = survey.track, survey.facts
    numbers: dict[str, object] = {
        "poses": len(track.t_ns),
        "path_m": path_length_m(survey),
        "duration_s": round(float(track.t_ns[-1] - track.t_ns[0]) * 1e-9, 3),
        "images": {
            camera.key: int(source.index.usable.sum()) for camera, source in facts.images.items()
        },
        "images_unusable": {
            camera.key: int((~source.index.usable).sum()) for camera, source in facts.images.items()
        },
    }
    if survey.adjusted is not None:
        landmarks = survey.adjusted.solution.landmarks
        numbers["landmarks"] = len(landmarks)
        if survey.adjusted.has_cad_model:
            numbers["landmarks_on_surface"] = int((landmarks.label == 1).sum())
        numbers["iterations"] = _iterations(survey.adjusted)
    if survey.findings.objects is not None:
        numbers["objects"] = len(survey.findings.objects)
    if facts.dvl is not None:
        numbers["dvl_pings"] = len(facts.dvl.t_ns)
    return numbers
