# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the threshold on a feature's height costs and gains [Ozog2016 Figs 4.17, 4.18]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np
from matplotlib.axes import Axes

from hullrecon.detection.as_found.hull_as_found import refine_near
from hullrecon.detection.options import DetectOptions
from hullrecon.evaluation.objects import find_reported
from hullrecon.evaluation.truth import TrueStructure, Truth
from hullrecon.geometry.meshes.mesh import Mesh, face_areas, vertex_normals
from hullrecon.geometry.poses import Poses
from hullrecon.records.deliverables import ReportedObject
from hullrecon.steps.artifacts import DetectArtifact
from hullrecon.studies.dive_steps import build_beside
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.methods.variants import run_to_detect
from hullrecon.studies.structures.inspected import InspectedHull, inspect
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.studies.surfaces.regression import fuse_shapes
from hullrecon.typing import Array, Mask

THRESHOLDS_M = np.linspace(0.0, 0.1, 11)
SHOWN_M = (0.0, 0.06)  # [Ozog2016 Fig. 4.17 b, c]
EDGE_M, REACH_M = 0.04, 0.1  # of the mesh that shapes are fused into, and around features
FOUND_SHARE = 0.5  # of a structure's top that must be raised to half its height
MARGIN_M = 0.1  # around a structure, where a raised vertex is no false one
AXIS_REACH_M = 0.35  # along a structure's axis: higher than any, and less than to another side
LEAST_AREA_M2 = 0.0025  # of a false object: detect.min_area_m2
LOWEST_M = 0.001  # min_height_m of the run whose objects are then counted by threshold


@dataclass(frozen=True, kw_only=True)
class Remeshed:
    """The CAD model with the shapes of one threshold fused into it."""

    threshold_m: float
    mesh: Mesh  # refined, its vertices (n) where they were
    raised_m: Array  # (n,) m along the normal, 0 where no ray met a shape
    moved: Mask  # (n,)


@dataclass(frozen=True, kw_only=True)
class ThresholdCount:
    """What one threshold finds."""

    found: int  # of the true structures
    missed: int
    false: int  # objects where the hull is bare
    false_area_m2: float
    kept: float | None = None  # share of the structures' footprints that is raised


def study(given: StudyDive) -> StudyResult:
    """Count what each threshold finds, by Algorithm 5 and by the product."""
    truth = given.truth
    run_to_detect(given.dive, given.run_context)
    hull = inspect(given.dive, truth)
    mesh = refine_near(hull.cad_model, hull.features, EDGE_M, REACH_M)
    remeshed = [remesh(hull, mesh, float(threshold)) for threshold in THRESHOLDS_M]
    by_rays = [count_raised(r, truth, hull.truth_from_result) for r in remeshed]
    reported = _objects_of_any_height(given)
    by_us = [
        count_reported(reported, float(t), truth, hull.truth_from_result) for t in THRESHOLDS_M
    ]
    shown = [r for r in remeshed if r.threshold_m in SHOWN_M]
    rows = tuple(
        (
            name,
            f"{t:.2f}",
            str(c.found),
            str(c.missed),
            str(c.false),
            f"{c.false_area_m2:.3f}",
            "-" if c.kept is None else f"{c.kept:.2f}",
        )
        for name, counts in (("Algorithm 5", by_rays), ("product", by_us))
        for t, c in zip(THRESHOLDS_M, counts, strict=True)
    )
    return StudyResult(
        figures=(draw(by_rays, by_us, shown, hull),),
        heads=("by", "threshold, m", "found", "missed", "false", "false area, m2", "kept"),
        rows=rows,
    )


def remesh(hull: InspectedHull, mesh: Mesh, threshold_m: float) -> Remeshed:
    """Fuse the shapes of one threshold into the CAD model [Ozog2016 Algorithm 5]."""
    fused = fuse_shapes(
        hull.views, hull.features, hull.height, mesh.vertices, DetectOptions(), threshold_m
    )
    away = np.einsum("ni,ni->n", fused.vertex - mesh.vertices, vertex_normals(mesh))
    return Remeshed(threshold_m=threshold_m, mesh=mesh, raised_m=away, moved=fused.count > 0)


def count_raised(remeshed: Remeshed, truth: Truth, motion: Poses) -> ThresholdCount:
    """Count structures, and the moved patches of hull that no structure explains."""
    at = motion.apply(remeshed.mesh.vertices)
    explained, footprints = np.zeros((2, len(at)), bool)
    found = 0
    for structure in truth.structures():
        from_axis = _distance_from_axis(at, structure)
        top = from_axis < 0.35 * min(structure.extent)
        high = remeshed.moved & (remeshed.raised_m > 0.5 * structure.height)
        found += bool(top.any()) and float(np.mean(high[top])) >= FOUND_SHARE
        footprints |= from_axis < 0.5 * min(structure.extent)
        explained |= from_axis < 0.5 * max(structure.extent) + MARGIN_M
    areas = patch_areas(remeshed.mesh, remeshed.moved & ~explained)
    false = areas[areas >= LEAST_AREA_M2]
    return ThresholdCount(
        found=found,
        missed=len(truth.structures()) - found,
        false=len(false),
        false_area_m2=float(false.sum()),
        kept=float(np.mean(remeshed.moved[footprints])) if footprints.any() else None,
    )


def patch_areas(mesh: Mesh, marked: Mask) -> Array:
    """Measure the connected patches (k,) m2 of faces whose corners are all marked."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    whole = marked[mesh.faces].all(axis=1)
    faces = mesh.faces[whole]
    if not len(faces):
        return np.zeros(0)
    a, b = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]]).T
    n = len(mesh.vertices)
    _, patch = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(n, n)))
    areas = np.bincount(patch[faces[:, 0]], face_areas(mesh)[whole])
    return np.asarray(areas[areas > 0])


def count_reported(
    reported: Sequence[ReportedObject], threshold_m: float, truth: Truth, motion: Poses
) -> ThresholdCount:
    """Count structures and false objects among those reported above a threshold."""
    high = [item for item in reported if abs(item.height) > threshold_m]
    matched = [find_reported(s, high, truth, motion) for s in truth.structures()]
    true = {item.id for item in matched if item is not None}
    false = [item for item in high if item.id not in true]
    found = sum(item is not None for item in matched)
    return ThresholdCount(
        found=found,
        missed=len(matched) - found,
        false=len(false),
        false_area_m2=float(sum(item.area for item in false)),
    )


def draw(
    by_rays: Sequence[ThresholdCount],
    by_us: Sequence[ThresholdCount],
    shown: Sequence[Remeshed],
    hull: InspectedHull,
) -> PublishedFigure:
    """Draw the counts by threshold, and the CAD model remeshed at two of them."""
    figure, axes = new_canvas(10.4, 7.4, 2, 2, height_ratios=(2, 3))
    kept, area = axes[0]
    kept.plot(100 * THRESHOLDS_M, [100 * (c.kept or 0.0) for c in by_rays], "o-", color=INK)
    kept.set(xlabel="threshold (cm)", ylabel="of the structures' area,\nmoved by Algorithm 5 (%)")
    for found, ink, name in ((by_rays, COLOURS["geva"], "Algorithm 5"), (by_us, GREEN, "product")):
        area.plot(100 * THRESHOLDS_M, [c.false_area_m2 for c in found], "o-", color=ink, label=name)
    area.set(xlabel="threshold (cm)", ylabel="false area on bare hull (m²)")
    area.legend(fontsize=8, frameon=False)
    for axis, remeshed in zip(axes[1], shown, strict=True):
        _draw_map(axis, remeshed, hull)
    table = ["by,threshold_m,found,missed,false,false_area_m2,kept"]
    for name, found in (("algorithm 5", by_rays), ("product", by_us)):
        table += [
            f"{name},{t:.2f},{c.found},{c.missed},{c.false},{c.false_area_m2:.4f},"
            + ("" if c.kept is None else f"{c.kept:.4f}")
            for t, c in zip(THRESHOLDS_M, found, strict=True)
        ]
    of = {round(float(t), 2): c for t, c in zip(THRESHOLDS_M, by_rays, strict=True)}
    caption = (
        f"Of {of[0.0].found + of[0.0].missed} structures Algorithm 5 finds {of[0.0].found} with a "
        f"threshold of zero, where it also moves {of[0.0].false_area_m2:.1f} m² of bare hull, and "
        f"{of[0.06].found} with 6 cm, with {of[0.06].false_area_m2:.2f} m² of bare hull and "
        f"{100 * (of[0.06].kept or 0.0):.0f} % of the structures' area instead of "
        f"{100 * (of[0.0].kept or 0.0):.0f} %."
    )
    return finish_figure("thresholds", figure, table, caption, _compare(of[0.0], of[0.06]))


def _compare(none: ThresholdCount, high: ThresholdCount) -> tuple[ComparedValue, ...]:
    """Compare what Algorithm 5 finds at two thresholds with what the source says of them."""
    words = {
        "threshold of 0": (
            none,
            'printed: "more details but potentially introduces false positives"',
        ),
        "threshold of 0.06 m": (high, "printed: the strip of growth alone is left"),
    }
    return tuple(
        ComparedValue(what=f"{what}, {name}", unit=unit, ours=ours, note=note)
        for name, (c, note) in words.items()
        for what, unit, ours in (
            ("structures found by Algorithm 5", "", float(c.found)),
            ("bare hull moved by Algorithm 5", "m²", c.false_area_m2),
            ("of the structures' area, moved by Algorithm 5", "%", 100 * (c.kept or 0.0)),
        )
    )


def _draw_map(axis: Axes, remeshed: Remeshed, hull: InspectedHull) -> None:
    """Draw the vertices that Algorithm 5 moved on the chart, coloured by height."""
    at = hull.chart.to_chart(remeshed.mesh.vertices)
    known = np.isfinite(at[:, 0])
    near = known & (np.abs(at[:, 2]) < 0.5)
    seen = at[near & remeshed.moved]
    window = hull.chart.to_chart(hull.features)
    drawn = axis.scatter(
        seen[:, 0],
        seen[:, 1],
        c=100 * remeshed.raised_m[near & remeshed.moved],
        s=3,
        cmap="turbo",
        vmin=0,
        vmax=16,
        linewidths=0,
        rasterized=True,
    )
    low, high = np.nanpercentile(window[:, :2], [0.5, 99.5], axis=0)
    axis.set(
        xlim=(low[0] - 0.2, high[0] + 0.2),
        ylim=(low[1] - 0.2, high[1] + 0.2),
        aspect="equal",
        adjustable="box",
    )
    axis.set_title(f"moved vertices, threshold {100 * remeshed.threshold_m:.0f} cm", fontsize=9)
    axis.set(xlabel="along the hull (m)", ylabel="girth (m)")
    axis.figure.colorbar(drawn, ax=axis, label="height (cm)", shrink=0.8)


def _objects_of_any_height(given: StudyDive) -> tuple[ReportedObject, ...]:
    """Run detect once with hardly a least height, so that a threshold may be put on its objects."""
    dive = given.dive
    sections = {
        **dive.chain.sections,
        "detect": msgspec.structs.replace(dive.chain.sections["detect"], min_height_m=LOWEST_M),  # type: ignore[type-var]
    }
    chain = replace(dive.chain, sections=sections)
    workspace = build_beside(dive, "any height", "detect", chain, given.run_context)
    rows = DetectArtifact(workspace.artifact("detect")).objects.get("objects", ())
    return msgspec.convert(rows, tuple[ReportedObject, ...])


def _distance_from_axis(points: Array, structure: TrueStructure) -> Array:
    """Measure how far points (n, 3) are from a structure's axis along the hull's normal, (n,) m.

    inf for points farther than AXIS_REACH_M from its centre along the axis: another side of the
    hull, or no point of the structure.
    """
    normal = np.array(structure.normal)
    from_center = points - np.array(structure.center)
    along_axis = from_center @ normal
    from_axis = np.linalg.norm(from_center - along_axis[:, None] * normal, axis=1)
    return np.where(np.abs(along_axis) < AXIS_REACH_M, from_axis, np.inf)
