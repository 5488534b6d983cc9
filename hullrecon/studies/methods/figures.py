# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of [Ozog2016] that a comparison of the methods gives."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hullrecon.evaluation.deliverables import TimedPoses
from hullrecon.evaluation.objects import find_reported
from hullrecon.evaluation.trajectory import score_trajectory
from hullrecon.evaluation.truth import TrueStructure, Truth
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.iterations import reached_cost
from hullrecon.records.solution import DeviationField
from hullrecon.records.trajectory import Returns
from hullrecon.studies.figure_style import PublishedFigure
from hullrecon.studies.methods.comparison import DeadReckoning, SolvedVariant
from hullrecon.studies.methods.histories import SolveHistory, cost_history, label_frequency
from hullrecon.studies.methods.method_figures import (
    METHODS,
    WEIGHTINGS,
    height_over_steel,
    hull_frame,
    landmarks_in_hull,
    stamps,
)
from hullrecon.studies.methods.plots import (
    CrossSection,
    DeliveredHeight,
    WholeSection,
    cross_sections,
    range_histogram,
    structure_heights,
)
from hullrecon.studies.methods.sections import (
    adjusted_beams,
    cut_section,
    cut_whole_hull,
    dead_reckoned_beams,
    range_residuals,
)
from hullrecon.typing import Array, Ints


def draw_method_figures(
    variants: Sequence[SolvedVariant],
    start: DeadReckoning,
    truth: Truth,
    reported: Sequence[ReportedObject],
) -> list[PublishedFigure]:
    """Draw [Ozog2016 Figs 4.10 (4.11), 4.12, 4.13, 4.14, 4.16] from solves.

    A figure without its data is left out.
    """
    figures = [cost_history([_history(v) for v in variants])]
    maxmix = [_history(v) for v in variants if v.method == "maxmix" and len(v.solution.landmarks)]
    figures += [label_frequency(maxmix)] if maxmix else []
    structure = tallest(truth)
    if structure is not None and all(len(v.solution.landmarks) for v in variants):
        rows = [
            [v for m in METHODS for v in variants if (v.method, v.weighting) == (m, w)]
            for w in WEIGHTINGS
        ]
        sections = [[_section(v, start, truth, structure) for v in row] for row in rows]
        overviews = [_overview(v, start, truth, structure) for v in rows[0]]
        figures.append(cross_sections(sections, overviews, structure.kind))
        figures.append(_heights(variants, truth, structure, reported))
    if start.returns is not None and truth.cad_model is not None:
        figures.append(_ranges(variants, start, start.returns, truth, truth.cad_model))
    return figures


def tallest(truth: Truth) -> TrueStructure | None:
    """Choose the cylinder, as in [Ozog2016 Fig. 4.16], else the highest well seen structure."""
    seen = [o for o in truth.structures() if o.views >= 3 and o.height > 0]
    return max(seen, key=lambda o: (o.kind == "cylinder", o.height), default=None)


def _history(v: SolvedVariant) -> SolveHistory:
    """Read the history of a variant's solve: cost, labels and seconds by iteration."""

    def counts(name: str) -> Ints:
        """Read one column of counts (k,) of the record of iterations."""
        return np.asarray(v.iterations[name], np.int64)

    cost = np.asarray(v.iterations["cost"], float)
    done_s = v.iterations_s if len(v.iterations_s) == len(cost) else np.zeros(len(cost))
    return SolveHistory(
        method=v.name,
        as_published=v.as_published,
        round=counts("round"),
        cost=reached_cost(cost, np.asarray(v.iterations["accepted"], bool)),
        landmarks=counts("landmarks"),
        on_surface=counts("on_surface"),
        label_changes=counts("label_changes"),
        seconds=done_s - done_s[0],
    )


def _aligned(v: SolvedVariant, start: DeadReckoning, truth: Truth) -> tuple[Array, Array]:
    """Align a solve's landmarks (L, 3) and ends of beams (k, 3), m in M, with the true hull.

    The rigid motion is that which lays the path onto the true one.
    """
    frame, motion = hull_frame(v.solution, truth), _alignment(v, truth)
    dvl = np.zeros((0, 3))
    if start.returns is not None:
        dvl = adjusted_beams(v.solution, frame, start.returns, start.rig).points
    return motion.apply(landmarks_in_hull(v.solution, frame)), motion.apply(dvl)


def _section(
    v: SolvedVariant, start: DeadReckoning, truth: Truth, structure: TrueStructure
) -> CrossSection:
    """Slice the hull through a structure, as a variant solved it."""
    landmarks, dvl = _aligned(v, start, truth)
    return cut_section(
        (v.method, v.weighting), structure, landmarks, v.solution.landmarks.label == 1, dvl, truth
    )


def _overview(
    v: SolvedVariant, start: DeadReckoning, truth: Truth, structure: TrueStructure
) -> WholeSection:
    """Slice across the whole hull at a structure, as a variant solved it."""
    landmarks, dvl = _aligned(v, start, truth)
    return cut_whole_hull(structure, landmarks, v.solution.landmarks.label == 1, dvl, truth)


def _heights(
    variants: Sequence[SolvedVariant],
    truth: Truth,
    structure: TrueStructure,
    reported: Sequence[ReportedObject],
) -> PublishedFigure:
    """Draw heights of landmarks on a structure by method, and its height as delivered."""
    heights: dict[str, Array] = {}
    for v in variants:
        landmarks = landmarks_in_hull(v.solution, hull_frame(v.solution, truth))
        heights[v.name], _ = height_over_steel(landmarks, structure, truth, _alignment(v, truth))
    found = find_reported(structure, reported, truth, _alignment(variants[-1], truth))
    delivered = None
    if found is not None and found.height_sigma is not None:
        delivered = DeliveredHeight(
            height_m=found.height, sigma_m=found.height_sigma, views=found.views
        )
    return structure_heights(heights, structure.height, structure.kind, delivered)


def _ranges(
    variants: Sequence[SolvedVariant],
    start: DeadReckoning,
    returns: Returns,
    truth: Truth,
    cad_model: Scene,
) -> PublishedFigure:
    """Draw the ranges' residuals before and after the adjustment.

    Before is dead reckoning as registered. After is maxmix by weighting, ours also against the CAD
    model moved by the deviation field.
    """
    maxmix = [v for v in variants if v.method == "maxmix"]
    ours = next(v for v in maxmix if not v.as_published)
    registered = hull_frame(ours.solution, truth) if ours.registered is None else ours.registered
    dead_reckoned = dead_reckoned_beams(start.trajectory, registered, returns, start.rig)
    before = {"registered, before the adjustment": range_residuals(dead_reckoned, cad_model)}
    after = {}
    for v in maxmix:
        beams = adjusted_beams(v.solution, hull_frame(v.solution, truth), returns, start.rig)
        after[v.name] = range_residuals(beams, cad_model)
        field = v.solution.deviation_field
        if not v.as_published and v.chart is not None and field is not None:
            residuals = range_residuals(beams, cad_model, _field_in_hull(field, v.chart))
            after[f"{v.name}, its deviation field applied"] = residuals
    everything = np.abs(np.concatenate([*before.values(), *after.values()]))
    return range_histogram(before, after, float(np.clip(np.percentile(everything, 97), 0.03, 0.5)))


def _field_in_hull(field: DeviationField, chart: Chart) -> Callable[[Array], Array]:
    return lambda points: np.nan_to_num(field.value_at(chart.to_chart(points)[:, :2]))


def _alignment(v: SolvedVariant, truth: Truth) -> Poses:
    """Fit the rigid motion that takes the solved path onto the true one."""
    poses = hull_frame(v.solution, truth).inverse() @ v.solution.global_from_vehicle
    _, motion = score_trajectory(TimedPoses(t_s=stamps(v.solution), poses=poses), truth)
    return motion
