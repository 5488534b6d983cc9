# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""links: compare images in rounds, find patches of hull seen again, solve the path with both."""

from __future__ import annotations

import numpy as np

from hullrecon.artifacts.stage import Context, StageSettings
from hullrecon.artifacts.writer import write_blocks
from hullrecon.dive.config.schema import Tray
from hullrecon.navigation.planes.planar_graph import PlanarSolution, planar_graph
from hullrecon.navigation.pose_graph.graph import GraphSolution, PoseGraph
from hullrecon.navigation.pose_graph.ties import describe_parts
from hullrecon.records.links import COMMON_FEATURE, no_links
from hullrecon.records.serialisation import to_arrays
from hullrecon.steps.artifacts import COMMON_FEATURES, InputArtifacts
from hullrecon.typing import Ints
from hullrecon.vision.compared_pairs import CommonFeatures
from hullrecon.vision.link_images import LinkedImages, NavigatedDive, PathSolver, link_images
from hullrecon.vision.options import LinkOptions, MatchOptions
from hullrecon.vision.pairs.match_worker import MatchWorker
from hullrecon.vision.pairs.matching import MatchStrategy
from hullrecon.vision.pairs.pair_match import FeatureSpool

# Guards the path against wrong links: dynamic covariance scaling [docs/methods.md (51)].
KERNEL = "scaling"


def run(
    context: Context[LinkOptions],
    kernel: str = KERNEL,
    strategy: MatchStrategy = MatchStrategy(),  # noqa: B008  frozen
) -> None:
    """Write pairs of images, patches of hull seen again, and the path solved with both.

    Without features there are no pairs, and the path is that of navigation and the patches. Without
    a DVL, or if the options say so, there are no patches.

    Parameters
    ----------
    context
        Settings, inputs and writer of the step.
    kernel
        Robust kernel against wrong links. hullrecon/studies compares others.
    strategy
        How images are matched. hullrecon/studies has published variants.
    """
    inputs = InputArtifacts(context.inputs)
    graph = pose_graph(inputs, inputs.mounted(context.settings), kernel)
    returns = inputs.navigate.returns if context.parameters.planes else None
    planar = None if returns is None else planar_graph(graph, returns, inputs.ingest.hull)
    solve: PathSolver[GraphSolution] = (planar or graph).solve
    facts: dict[str, object] = {}
    if "features" in context.inputs:
        facts, solved = _link_images(context, solve, strategy)
    else:
        solved = solve(no_links(), None)
        context.out.arrays("path.npz", to_arrays(solved.record()))
    if not solved.converged:
        context.warn(
            "The path that links and navigation give was still changing when its iterations ended."
        )
    facts |= (
        {"converged": solved.converged}
        | _write_planes(context, solved)
        | _compare_fixes(context, solved)
    )
    context.out.json("links.json", facts)


def pose_graph(inputs: InputArtifacts, settings: StageSettings, kernel: str = KERNEL) -> PoseGraph:
    """Build the pose graph of a dive, without links yet.

    settings: with the mounts that the log gives filled in. kernel: robust kernel for links.
    """
    navigate = inputs.navigate
    return PoseGraph(
        trajectory=navigate.trajectory,
        odometry=navigate.odometry,
        attitude=navigate.attitude,
        rig=inputs.rig(settings),
        kernel=kernel,
        positions=navigate.positions,
    )


def _link_images(
    context: Context[LinkOptions], solve: PathSolver[GraphSolution], strategy: MatchStrategy
) -> tuple[dict[str, object], GraphSolution]:
    """Link the images, write the links and the path, and warn of what they leave open.

    Returns the figures for links.json, and the solution of the path with
    the links.
    """
    inputs = InputArtifacts(context.inputs)
    settings = inputs.mounted(context.settings)
    rig = inputs.rig(settings)
    worker = MatchWorker(
        features=context.inputs["features"],
        rig=rig,
        options=settings.read("matches", MatchOptions),
        strategy=strategy,
    )
    navigate = inputs.navigate
    dive = NavigatedDive(
        trajectory=navigate.trajectory,
        errors=navigate.error_model,
        returns=navigate.returns,
        tray_sigma_rad=float(np.radians(settings.read("tray", Tray).sigma_deg)),
    )
    with context.out.scratch() as file:
        found, solved = link_images(
            worker,
            dive,
            solve,
            context.stream,
            FeatureSpool(file),
            context.parameters.max_rounds,
            context.parameters.appearance,
        )
        _write_features(context, found.features)
    context.out.arrays("pairs.npz", to_arrays(found.pairs))
    context.out.arrays("links.npz", to_arrays(found.links))
    context.out.arrays("stereo.npz", to_arrays(found.stereo))
    context.out.arrays("path.npz", to_arrays(found.path))
    _warn_of_links(context, found, navigate.trajectory.t_ns)
    facts: dict[str, object] = {
        "keyframes": len(found.keyframes),
        "rounds": found.rounds(),
        "look_alikes": found.look_alikes,
    }
    if found.appearance:
        facts["appearance"] = [asked.facts() for asked in found.appearance]
    return facts, solved


def _warn_of_links(context: Context[LinkOptions], found: LinkedImages, t_ns: Ints) -> None:
    """Warn of parts that navigation alone ties, and of images that look alike.

    t_ns (n,): stamps of the nodes.
    """
    sentence = describe_parts(found.path, t_ns)
    if sentence is not None:
        context.warn(sentence)
    if found.look_alikes:
        context.warn(
            "Images on both sides of an outage match, but other places of the hull look alike too: "
            "they are not taken for one place."
        )
    if found.appearance and found.appearance[-1].refusal is not None:
        context.warn(
            f"How images look does not say what lies where: {found.appearance[-1].refusal}."
        )


def _write_features(context: Context[LinkOptions], features: CommonFeatures) -> None:
    """Write the common features pair by pair, and the row at which those of each pair begin.

    They are written in blocks as a .npy, which later steps map, as they may not fit into memory.
    """
    start = features.start
    context.out.arrays("features.npz", {"start": start})
    with context.out.path(COMMON_FEATURES) as path:
        write_blocks(path, COMMON_FEATURE, (int(start[-1]),), features.blocks())


def _write_planes(context: Context[LinkOptions], solved: GraphSolution) -> dict[str, object]:
    """Write the planes that tie the path, if any. Returns their figures for links.json.

    It warns where planes were refused, and says why. Empty where planes were not looked for.
    """
    if not isinstance(solved, PlanarSolution):
        return {}
    if solved.planes is not None:
        context.out.arrays("planes.npz", to_arrays(solved.planes))
    if solved.refusal is not None:
        context.warn(f"The patches of hull that were passed again tie nothing: {solved.refusal}.")
    ties = 0 if solved.planes is None else len(solved.planes)
    return {
        "planes": {
            "patches": solved.patches,
            "offered": solved.offered,
            "ties": ties,
            "refusal": solved.refusal,
        }
    }


def _compare_fixes(context: Context[LinkOptions], solved: GraphSolution) -> dict[str, object]:
    """Compare position fixes (USBL, GNSS) with the path, and warn if they contradict navigation.

    Returns the figures for links.json. Empty without fixes.
    """
    fit = solved.fit_of_positions()
    if fit is None:
        return {}
    sentence = fit.disagreement()
    if sentence is not None:
        context.warn(sentence)
    return {"positions": fit.facts()}
