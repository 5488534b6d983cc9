# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""summary.json: the run in numbers, for programs. What differs between equal runs is in `run`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType

import numpy as np

from hullrecon.records.iterations import count
from hullrecon.report.content.deviation import deviation_document, deviation_figures
from hullrecon.report.content.headline import headline, path_length_m
from hullrecon.report.survey import AdjustedDive, Survey
from hullrecon.version import commit, version

SCHEMA = 1


@dataclass(frozen=True, kw_only=True)
class FileEntry:
    """Size and hash of one delivered file."""

    bytes: int
    sha256: str


def summary_document(
    survey: Survey,
    deliverables: Mapping[str, FileEntry],
    failed: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, object]:
    """Build summary.json (docs/deliverables.md).

    Parameters
    ----------
    survey
        All that the steps found.
    deliverables
        The files written, by name.
    failed
        Reason by name of each deliverable that could not be written.
    """
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
        "frame_in_words": survey.frame_in_words,
        "units": "metres, seconds, radians; sigma is one standard deviation",
        "method": survey.method,
        "summary": headline(survey),
        "counts": counts(survey),
        "deviation": deviation_document(deviation_figures(survey)),
        "warnings": provenance.warnings(),
        "lost": list(survey.facts.log.lost),
        "deliverables": {name: asdict(entry) for name, entry in deliverables.items()},
        "absent": dict(provenance.missing),
        "failed": dict(failed),
        "run": {"steps": {step.name: _public_run(step.run) for step in provenance.steps}},
    }


def _public_run(run: Mapping[str, object]) -> dict[str, object]:
    """Drop the times of single iterations and the host's name from a step's run block."""
    public = {name: value for name, value in run.items() if name != "times"}
    host = public.get("host")
    if isinstance(host, Mapping):
        public["host"] = {name: value for name, value in host.items() if name != "name"}
    return public


def _iterations(adjusted: AdjustedDive) -> int | None:
    """Count the iterations of all rounds. None if they were not recorded.

    The record also has the start of each round, which is not counted.
    """
    record = adjusted.iterations
    if "cost" not in record:
        return None
    if "round" in record:
        return count(np.asarray(record["round"], np.int64))
    return len(record["cost"]) - 1


def counts(survey: Survey) -> dict[str, object]:
    """Count poses, images, landmarks, objects and DVL pings."""
    track, facts = survey.track, survey.facts
    usable = {camera.key: source.index.usable for camera, source in facts.images.items()}
    numbers: dict[str, object] = {
        "poses": len(track.t_ns),
        "path_m": path_length_m(survey),
        "duration_s": round(float(track.t_ns[-1] - track.t_ns[0]) * 1e-9, 3),
        "images": {camera: int(rows.sum()) for camera, rows in usable.items()},
        "images_unusable": {camera: int((~rows).sum()) for camera, rows in usable.items()},
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
