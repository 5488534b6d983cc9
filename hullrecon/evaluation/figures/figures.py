# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which figures of [Ozog2016] a comparison gives, and what is drawn in each."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hullrecon.evaluation.comparison.beams import adjusted_beams, field_at, range_residuals, reckoned_beams
from hullrecon.evaluation.comparison.comparison import Reckoned, Solved
from hullrecon.evaluation.comparison.method_comparison import (
    METHODS,
    WEIGHTINGS,
    frame_of,
    height_over_steel,
    landmarks_in_hull,
    stamps,
)
from hullrecon.evaluation.figures.figure_style import Figure
from hullrecon.evaluation.figures.histories import Progress, cost_history, label_frequency
from hullrecon.evaluation.figures.plots import Delivered, Overview, Section, cross_sections, range_histogram, structure_heights
from hullrecon.evaluation.figures.sections import cut, whole
from hullrecon.evaluation.scoring.alignment import Motion
from hullrecon.evaluation.scoring.deliverables import Track
from hullrecon.evaluation.scoring.objects import delivered_of
from hullrecon.evaluation.scoring.trajectory import judge_trajectory
from hullrecon.evaluation.scoring.truth import Truth
from hullrecon.geometry.poses import pose_from_vector
from hullrecon.records.iterations import reached
from hullrecon.typing import Array


def draw(solved: Sequence[Solved], start: Reckoned, truth: Truth, detect: Path) -> list[Figure]:
    """[Ozog2016 Figs 4.10 (4.11), 4.12, 4.13, 4.14, 4.16] from those solves; one without its data is left out. detect: the
    artifact of the step of that name, whether it is there or not."""
    figures = [cost_history([_progress(s) for s in solved])]
    mixed = [_progress(s) for s in solved if s.method == "maxmix" and len(s.solution.landmarks)]
    figures += [label_frequency(mixed)] if mixed else []
    structure = tallest(truth)
    if structure is not None and all(len(s.solution.landmarks) for s in solved):
        rows = [[s for m in METHODS for s in solved if (s.method, s.weighting) == (m, w)] for w in WEIGHTINGS]
        sections = [[_section(s, start, truth, structure) for s in row] for row in rows]
        overviews = [_overview(s, start, truth, structure) for s in rows[0]]
        figures.append(cross_sections(sections, overviews, str(structure["kind"])))
        figures.append(_heights(solved, truth, structure, detect))
    if start.returns is not None and truth.cad_model is not None:
        figures.append(_ranges(solved, start, truth))
    return figures


def tallest(truth: Truth) -> dict[str, Any] | None:
    """The cylinder, as in O, else the highest structure that enough frames saw."""
    seen = [o for o in truth.structures() if o["views"] >= 3 and o["height"] > 0]
    return max(seen, key=lambda o: (o["kind"] == "cylinder", o["height"]), default=None)


def _progress(s: Solved) -> Progress:
    record = s.iterations
    began = s.iterations_s if len(s.iterations_s) == len(record["cost"]) else np.zeros(len(record["cost"]))
    return Progress(
        method=s.name,
        printed=s.printed,
        round=record["round"],
        cost=reached(record["cost"], record["accepted"]),
        landmarks=record["landmarks"],
        on_surface=record["on_surface"],
        label_changes=record["label_changes"],
        seconds=began - began[0],
    )


def _placed(s: Solved, start: Reckoned, truth: Truth) -> tuple[Array, Array]:
    """Landmarks and DVL returns in M, moved by the alignment of the path with the true one."""
    frame, motion = frame_of(s.solution, truth), _motion(s, truth)
    dvl = np.zeros((0, 3))
    if start.returns is not None:
        dvl = adjusted_beams(s.solution, frame, start.returns, start.tray_origin_m).points()
    return motion.apply(landmarks_in_hull(s.solution, frame)), motion.apply(dvl)


def _section(s: Solved, start: Reckoned, truth: Truth, structure: dict[str, Any]) -> Section:
    landmarks, dvl = _placed(s, start, truth)
    return cut((s.method, s.weighting), structure, landmarks, s.solution.landmarks.label == 1, dvl, truth)


def _overview(s: Solved, start: Reckoned, truth: Truth, structure: dict[str, Any]) -> Overview:
    landmarks, dvl = _placed(s, start, truth)
    return whole(structure, landmarks, s.solution.landmarks.label == 1, dvl, truth)


def _heights(solved: Sequence[Solved], truth: Truth, structure: dict[str, Any], detect: Path) -> Figure:
    found: dict[str, Array] = {}
    for s in solved:
        landmarks = landmarks_in_hull(s.solution, frame_of(s.solution, truth))
        found[s.name], _ = height_over_steel(landmarks, structure, truth, _motion(s, truth))
    delivered = None
    if (detect / "objects.json").exists():
        objects = json.loads((detect / "objects.json").read_text())["objects"]
        one = delivered_of(structure, objects, truth, _motion(solved[-1], truth))
        delivered = None if one is None else Delivered(one["height"], one["height_sigma"], one["views"])
    return structure_heights(found, float(structure["height"]), str(structure["kind"]), delivered)


def _ranges(solved: Sequence[Solved], start: Reckoned, truth: Truth) -> Figure:
    """Before: dead reckoning where the registration put it. After: maxmix by weighting, ours also against the CAD model moved by
    its field."""
    assert start.returns is not None
    assert truth.cad_model is not None
    best = next(s for s in solved if s.method == "maxmix" and not s.printed)
    registered = frame_of(best.solution, truth) if best.registered is None else pose_from_vector(best.registered)
    reckoned = reckoned_beams(start.trajectory, registered, start.T_s_d, start.returns, start.tray_origin_m)
    before = {"registered, before the adjustment": range_residuals(reckoned, truth.cad_model)}
    after = {}
    for s in (s for s in solved if s.method == "maxmix"):
        beams = adjusted_beams(s.solution, frame_of(s.solution, truth), start.returns, start.tray_origin_m)
        after[s.name] = range_residuals(beams, truth.cad_model)
        if not s.printed and s.chart is not None and s.solution.deviation_field is not None:
            after[f"{s.name}, its field applied"] = range_residuals(
                beams, truth.cad_model, field_at(s.solution.deviation_field, s.chart)
            )
    everything = np.abs(np.concatenate([*before.values(), *after.values()]))
    return range_histogram(before, after, float(np.clip(np.percentile(everything, 97), 0.03, 0.5)))


def _motion(s: Solved, truth: Truth) -> Motion:
    poses = frame_of(s.solution, truth).inverse() @ s.solution.global_from_vehicle
    _, motion = judge_trajectory(Track(stamps(s.solution), poses, None), truth)
    return motion
