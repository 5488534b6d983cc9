# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Links of a dive by the product and by the sources' variants, and the paths that they tie."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.runner import RunContext, run_chain
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import InputError
from hullrecon.evaluation.trajectory import Figures, rms_length
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.steps import features, links
from hullrecon.steps.artifacts import LinksArtifact, NavigateArtifact
from hullrecon.studies.dive_steps import build_beside, with_stages
from hullrecon.studies.matching.corners import MatchWithCorners, extract_with_corners
from hullrecon.typing import Array
from hullrecon.vision.pairs.matching import MatchStrategy
from hullrecon.vision.pairs.two_view import TwoView, fit_both


def fit_essential(first: Array, second: Array, tolerance: float) -> TwoView | None:
    """Fit an essential matrix to matches (n, 2) as `two_view.fit` fits the likelier model."""
    both = fit_both(first, second, tolerance)
    return None if both is None else both.essential.within(tolerance)


def fit_homography(first: Array, second: Array, tolerance: float) -> TwoView | None:
    """Fit a homography to matches (n, 2) as `two_view.fit` fits the likelier model."""
    both = fit_both(first, second, tolerance)
    return None if both is None else both.homography.within(tolerance)


TWO_VIEW_MODELS = {
    "automatic": MatchStrategy(),
    "essential": MatchStrategy(fit_two_views=fit_essential),
    "homography": MatchStrategy(fit_two_views=fit_homography),
}


CORNERS = 0.5  # of the matches that may be corners: as many as SIFT's
HEADS = ("links", "pairs joined", "across legs", "path, mm")


@dataclass(frozen=True, kw_only=True)
class LinkVariant:
    """A variant of the steps that find and guard links."""

    links: Any  # runs the step `links`
    features: Any = None  # runs the step `features`; None for the product's


VARIANTS = {
    "with corners": LinkVariant(
        features=partial(features.run, find=extract_with_corners),
        links=partial(
            links.run, strategy=MatchStrategy(match_descriptors=MatchWithCorners(CORNERS))
        ),
    ),
    "guarded by switches": LinkVariant(links=partial(links.run, kernel="switch")),
    "without a guard": LinkVariant(links=partial(links.run, kernel="none")),
}


def compare_links(dive: DiveRun, truth: Truth, run_context: RunContext) -> dict[str, Figures]:
    """Link a dive by the product and by every variant, and score the paths.

    Raises InputError for a dive without a camera.
    """
    run_chain(dive.chain.up_to("links"), dive.workspace, run_context)
    if LinksArtifact(dive.workspace.artifact("links")).compared is None:
        raise InputError(
            "this dive has no images to compare",
            where=str(dive.workspace.root),
            remedy="take a dive with a camera",
        )
    t_ns = NavigateArtifact(dive.workspace.artifact("navigate")).trajectory.t_ns
    true = truth.vehicle_at(t_ns / 1e9).translation
    figures = {"product": _score(dive.workspace, true)}
    for name, variant in VARIANTS.items():
        figures[name] = _score(_build(dive, name, variant, run_context), true)
    return figures


def link_table(figures: Mapping[str, Figures]) -> tuple[list[str], list[list[str]]]:
    """Arrange the figures in heads and rows, lengths in millimetres."""
    rows = [
        [name, str(found["joined"]), str(found["across"]), f"{1e3 * float(found['rms_m']):.2f}"]  # type: ignore[arg-type]
        for name, found in figures.items()
    ]
    return list(HEADS), rows


def _build(dive: DiveRun, name: str, variant: LinkVariant, run_context: RunContext) -> Workspace:
    """Bring a variant's steps up to date in RUNS/<dive>/compare."""
    runs = {"links": variant.links, "features": variant.features}
    stages = (replace(dive.chain.stage(step), run=run) for step, run in runs.items() if run)
    chain = with_stages(dive.chain, *stages)
    own: dict[str, Path] = {}
    if variant.features is not None:
        found = build_beside(dive, name, "features", chain, run_context)
        own = {"features": found.artifact("features")}
    return build_beside(dive, name, "links", chain, run_context, own)


def _score(workspace: Workspace, true: Array) -> Figures:
    """Count joined pairs, and measure the path's error after rigid alignment. true: (n, 3) m."""
    artifact = LinksArtifact(workspace.artifact("links"))
    pairs, at = artifact.pairs, artifact.path.path().poses.translation
    return {
        "joined": int(pairs.joined.sum()),
        "across": int((pairs.joined & pairs.across).sum()),
        "rms_m": rms_length(fit_rigid(at, true).apply(at) - true),
    }
