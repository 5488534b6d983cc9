# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Matches between nodes, verified pair by pair, and the tracks that they join to."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from hullrecon.artifacts.graph.stage import Context, Stage, load_arrays
from hullrecon.errors import StageError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import from_mount
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import Returns, Trajectory, TrajectoryErrorModel
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.camera_track import Survey, depth_priors, survey_of
from hullrecon.vision.pairs.match_worker import Bench, MatchNode, MatchPairs, Node, Pair
from hullrecon.vision.pairs.matching import WORDS, PairMatch, Reason
from hullrecon.vision.pairs.selection import Proposal, propose
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import DepthPrior
from hullrecon.vision.stereo.rectification import Rig
from hullrecon.vision.tracks.landmarks import Matches, build
from hullrecon.vision.tracks.track_verification import Link, doubtful

BLOCK = 48  # pairs that one call of a worker compares: neighbours share views


def applies(settings: Mapping[str, Any]) -> str | None:
    return None if settings["camera.top.mount"] is not None else "no camera was carried"


def run(context: Context) -> None:
    options: MatchOptions = context.parameters
    trajectory = from_arrays(Trajectory, load_arrays(context.inputs["navigate"] / "trajectory.npz"))
    bench = _bench(context)
    survey, depths = _survey(context, trajectory, bench.rig)
    nodes = [Node((int(i[0]), int(i[1])), depth, no_matches()) for i, depth in zip(trajectory.image, depths, strict=True)]
    usable = np.asarray((trajectory.image >= 0).any(axis=1))
    counted = context.map(MatchNode(bench), [nodes[k] for k in np.flatnonzero(usable)], "stereo")
    count = np.zeros(len(nodes), np.int64)
    for k, (features, stereo) in zip(np.flatnonzero(usable), counted, strict=True):
        count[k], nodes[k] = features, replace(nodes[k], stereo=stereo)
    depth_m = np.array([_depth(node) for node in nodes])
    salient = np.array([bench.saliency(node) >= options.min_saliency for node in nodes])
    keyframes, proposal = propose(survey, usable, depth_m, bench.rig.top, options, salient)
    found = _match_pairs(context, bench, survey, nodes, proposal)
    matches = _gather(proposal, found)
    links = [
        Link(int(a), int(b), pair.motion, pair.scaled)
        for a, b, pair in zip(proposal.first, proposal.second, found, strict=True)
        if pair.motion is not None
    ]
    doubt = partial(_doubtful, bench.rig, links, options)
    tracks = build(count, [n.stereo for n in nodes], matches, lambda k: bench.read(nodes[k].image), options.single_node, doubt)
    if not any(len(pair.first) for pair in found):
        raise StageError("no two images could be matched", where="matches", remedy=_most_frequent(found))
    context.out.arrays("tracks.npz", to_arrays(tracks))
    _write_pairs(context, proposal, found, {"keyframes": len(keyframes), "nodes": len(nodes)}, tracks)


def _doubtful(
    rig: Rig, links: Sequence[Link], options: MatchOptions, node: Ints, label: Ints, top: Array, bottom: Array
) -> Mask:
    return doubtful(rig, node, label, top, bottom, links, options)


def _bench(context: Context) -> Bench:
    cameras = json.loads((context.inputs["ingest"] / "cameras.json").read_text(encoding="utf-8"))
    top, pose_in_top = CameraModel(**cameras["top"]), context.settings["camera.bottom.pose_in_top"]
    if pose_in_top is None or "bottom" not in cameras:
        return Bench(context.inputs["features"], Rig(top), False, context.parameters)
    rig = Rig(top, CameraModel(**cameras["bottom"]), from_mount(pose_in_top))
    return Bench(context.inputs["features"], rig, True, context.parameters)


def _survey(context: Context, trajectory: Trajectory, rig: Rig) -> tuple[Survey, list[DepthPrior | None]]:
    """The cameras' places, and the depth of the scene at each by the DVL."""
    origin, play = context.settings["tray.origin"], np.radians(context.settings["tray.sigma_deg"])
    mount = from_mount(context.settings["camera.top.mount"])
    errors = from_arrays(TrajectoryErrorModel, load_arrays(context.inputs["navigate"] / "error_model.npz"))
    survey = survey_of(trajectory, errors, origin, mount, rig.top_from_bottom, play)
    path = context.inputs["navigate"] / "returns.npz"
    if not path.exists():
        return survey, [None] * len(survey)
    returns = from_arrays(Returns, load_arrays(path))
    dvl = from_mount(context.settings["dvl.mount"])
    return survey, depth_priors(survey, trajectory, returns, origin, dvl, context.parameters.range_margin)


def _depth(node: Node) -> float:
    """Depth of the scene: the stereo's median where there is one, else the DVL's."""
    if len(node.stereo) >= 8:
        return float(np.median(node.stereo.point[:, 2]))
    return node.depth.mean if node.depth else float("nan")


def _match_pairs(context: Context, bench: Bench, survey: Survey, nodes: Sequence[Node], proposal: Proposal) -> list[PairMatch]:
    pairs = [
        Pair(int(a), int(b), survey.motion(int(a), int(b)), not across)
        for a, b, across in zip(proposal.first, proposal.second, proposal.across, strict=True)
    ]
    blocks = []
    for start in range(0, len(pairs), BLOCK):
        part = pairs[start : start + BLOCK]
        touched = sorted({p.first for p in part} | {p.second for p in part})
        blocks.append(({k: nodes[k] for k in touched}, part))
    return [match for block in context.map(MatchPairs(bench), blocks, "pairs") for match in block]


def _gather(proposal: Proposal, found: Sequence[PairMatch]) -> Matches:
    size = np.array([len(pair.first) for pair in found], np.int64)
    none = np.zeros(0, np.int64)
    return Matches(
        np.repeat(proposal.first, size),
        np.concatenate([none, *(pair.first for pair in found)]),
        np.repeat(proposal.second, size),
        np.concatenate([none, *(pair.second for pair in found)]),
        np.concatenate([np.zeros(0, np.float32), *(pair.distance for pair in found)]),
    )


def _write_pairs(
    context: Context, proposal: Proposal, found: Sequence[PairMatch], counts: dict[str, int], tracks: Tracks
) -> None:
    reason = np.array([pair.reason for pair in found], np.int64)
    inliers = np.array([len(pair.first) for pair in found], np.int64)
    context.out.arrays("pairs.npz", {
        "first": proposal.first, "second": proposal.second, "across": proposal.across, "overlap": proposal.overlap,
        "putative": np.array([pair.putative for pair in found], np.int64), "inliers": inliers, "reason": reason,
    })  # fmt: skip
    both = np.isfinite(tracks.top[:, 0]) & np.isfinite(tracks.bottom[:, 0])
    counts |= {
        "pairs": len(found), "matched": int((reason == 0).sum()),
        "matched_across_legs": int(((reason == 0) & proposal.across).sum()),
        "landmarks": len(tracks.color), "observations": len(tracks.landmark), "stereo_observations": int(both.sum()),
        "landmarks_of_several_nodes": int((np.bincount(tracks.landmark) > 1).sum()),
    }  # fmt: skip
    chains = _chains(proposal, reason == 0)
    if len(chains) > 1:
        context.warn(
            f"the images fall into {len(chains)} chains without a match between them; the longest has {chains[0]} nodes"
        )
    failed = {WORDS[Reason(code)]: int((reason == code).sum()) for code in np.unique(reason[reason > 0])}
    words = {str(int(code)): text for code, text in WORDS.items()}
    context.out.json("pairs.json", {"reasons": words, "failed": failed, "chains": chains, "counts": counts})


def _chains(proposal: Proposal, matched: Mask) -> list[int]:
    """Sizes of the groups of nodes that matches connect, the largest first; nodes in no proposed pair are left out."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    nodes, index = np.unique(np.concatenate([proposal.first, proposal.second]), return_inverse=True)
    a, b = index[: len(proposal)][matched], index[len(proposal) :][matched]
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(nodes), len(nodes)))
    return sorted(np.bincount(connected_components(graph, directed=False)[1]).tolist(), reverse=True) if len(nodes) else []


def _most_frequent(found: Sequence[PairMatch]) -> str:
    if not found:
        return "no two images were near enough to be compared"
    code = int(np.bincount([pair.reason for pair in found]).argmax())
    return f"of {len(found)} pairs most failed by: {WORDS[Reason(code)]}"


STAGE = Stage(
    name="matches",
    summary="match images and build feature tracks",
    inputs=("ingest", "navigate", "features"),
    parameters=MatchOptions,
    version=3,
    run=run,
    uses=("tray.origin", "tray.sigma_deg", "dvl.mount", "camera.top.mount", "camera.bottom.pose_in_top"),
    applies=applies,
)
