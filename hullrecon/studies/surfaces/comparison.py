# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces and hulls as found by the sources' variants, beside the product's, against the truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.runner import RunContext, run_chain
from hullrecon.artifacts.stage import Stage
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import InputError, StageError
from hullrecon.evaluation.deliverables import PointCloud
from hullrecon.evaluation.surfaces import score_surface
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.poses import identity
from hullrecon.records.surface import Surface
from hullrecon.steps import detect, surface
from hullrecon.steps.artifacts import AdjustArtifact, DetectArtifact, SurfaceArtifact
from hullrecon.steps.chain import stage
from hullrecon.studies.dive_steps import build_beside, with_stages
from hullrecon.studies.surfaces.regression import (
    RadialKernel,
    WendlandKernel,
    by_triangles,
    heights_over_plane,
    move_along_rays,
    offsets_from_plane,
)
from hullrecon.surface.build import gaussian_process

SURFACE, _RUN = stage("surface"), surface.run
SURFACES = {  # stages that take the place of the step surface
    "linear": replace(SURFACE, run=partial(_RUN, regression=by_triangles)),
    "radial kernel": replace(
        SURFACE, run=partial(_RUN, regression=partial(gaussian_process, form=RadialKernel))
    ),
    "wendland kernel": replace(
        SURFACE,
        run=partial(_RUN, regression=partial(gaussian_process, form=WendlandKernel)),
    ),
    "offsets from a plane": replace(SURFACE, run=partial(_RUN, reference=offsets_from_plane)),
    "heights over a plane": replace(SURFACE, run=partial(_RUN, reference=heights_over_plane)),
}
# and the place of the step detect
AS_FOUND = {"rays": replace(stage("detect"), run=partial(detect.run, fusion=move_along_rays))}
VariantFigures = dict[str, object]  # by name, or why there are none
TABLE = {"rmse_m": "rms, mm", "p95_m": "95 %, mm", "share_within_1.96_sigma": "in 1.96 sigma"}
MIN_SUPPORT = 1  # returns or views behind a vertex that is scored


def compare_surfaces(
    dive: DiveRun, truth: Truth, run_context: RunContext
) -> dict[str, VariantFigures]:
    """Score the surfaces that the product and every variant make of one dive.

    A variant that reaches no result has its reason in place of figures. Raises InputError for a
    dive whose CAD model was refused, or that has none: its surfaces are not in the hull's frame.
    """
    run_chain(dive.chain.up_to("detect"), dive.workspace, run_context)
    if AdjustArtifact(dive.workspace.artifact("adjust")).solution.hull_pose is None:
        raise InputError(
            "surfaces are compared in the hull's frame, and no CAD model fits this dive",
            where=str(dive.workspace.root),
            remedy="take a dive with a CAD model",
        )
    figures = {"surface, product": _score(_surface_in(dive.workspace), truth)}
    for name, step in SURFACES.items():
        figures[f"surface, {name}"] = _figures_of(dive, name, step, truth, run_context)
    figures["as found, product"] = _score(_as_found_in(dive.workspace), truth)
    for name, step in AS_FOUND.items():
        figures[f"as found, {name}"] = _figures_of(dive, name, step, truth, run_context)
    return figures


def surface_table(figures: Mapping[str, VariantFigures]) -> tuple[list[str], list[list[str]]]:
    """Arrange the figures in heads and rows, lengths in millimetres."""
    rows = [
        [name, *(_cell(key, found) for key in TABLE), str(found.get("error", ""))]
        for name, found in figures.items()
    ]
    return ["variant", *TABLE.values(), ""], rows


def _figures_of(
    dive: DiveRun, name: str, stage: Stage, truth: Truth, run_context: RunContext
) -> VariantFigures:
    """Make a variant's artifact in RUNS/<dive>/compare where it is out of date, and score it."""
    chain = with_stages(dive.chain, stage)
    try:
        workspace = build_beside(dive, name, stage.name, chain, run_context)
    except StageError as error:
        return {"error": error.what}
    read = _surface_in if stage.name == "surface" else _as_found_in
    return _score(read(workspace), truth)


def _surface_in(workspace: Workspace) -> Surface:
    return SurfaceArtifact(workspace.artifact("surface")).surface


def _as_found_in(workspace: Workspace) -> Surface | None:
    return DetectArtifact(workspace.artifact("detect")).as_found


def _score(surface: Surface | None, truth: Truth) -> VariantFigures:
    """Measure the distances of a surface's supported vertices from the true hull."""
    if surface is None:
        return {"error": "nothing was found"}
    cloud = PointCloud(
        points=surface.vertices, fields={"support": surface.support, "sigma": surface.sigma}
    )
    return {**score_surface(cloud, truth, identity(), MIN_SUPPORT)}


def _cell(key: str, figures: VariantFigures) -> str:
    """Format one figure of a variant, lengths in millimetres. A dash where it has none."""
    value = figures.get(key)
    if not isinstance(value, int | float):
        return "-"
    return f"{1e3 * value:.2f}" if key.endswith("_m") else f"{value:.3f}"
