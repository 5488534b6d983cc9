# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The images of a dive matched: which nodes are compared, what they have in common, and the tracks that this joins to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol, TypeVar

import numpy as np

from hullrecon.errors import StageError
from hullrecon.geometry.frames import Camera
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import Returns, Trajectory, TrajectoryErrorModel
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.camera_track import CameraTrack, depth_priors, track_cameras
from hullrecon.vision.pairs.match_worker import MatchNode, MatchPairs, MatchStereo, MatchWorker, NodePair
from hullrecon.vision.pairs.matching import REASON_TEXTS, PairMatch, Reason
from hullrecon.vision.pairs.selection import Proposal, propose
from hullrecon.vision.stereo.camera_rig import CameraRig
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.tracks.landmarks import NodeMatches, build_tracks
from hullrecon.vision.tracks.track_verification import Link, contradicted_observations

BLOCK = 48  # pairs that one call of a worker compares: neighbours share views
MIN_STEREO_POINTS = 8  # from which their median is the depth of the scene

Item = TypeVar("Item")
Result = TypeVar("Result")


class Map(Protocol):
    """Applies a function that can be pickled to all items, in order, perhaps in other processes."""

    def __call__(self, function: Callable[[Item], Result], items: Sequence[Item], label: str) -> list[Result]: ...


@dataclass(frozen=True, kw_only=True)
class NavigatedDive:
    """What navigation says; returns: None without a DVL; tray_sigma_rad: of the servo's backlash."""

    trajectory: Trajectory
    errors: TrajectoryErrorModel
    returns: Returns | None
    tray_sigma_rad: float


@dataclass(frozen=True, kw_only=True)
class MatchedImages:
    """The tracks, the pairs that were compared, what each gave, and the number of keyframes and nodes."""

    tracks: Tracks
    proposal: Proposal
    pairs: list[PairMatch]
    keyframes: int
    nodes: int

    @property
    def reason(self) -> Ints:
        """Return why each pair (m,) gave nothing, 0 where it matched."""
        return np.array([pair.reason for pair in self.pairs], np.int64)

    @property
    def inliers(self) -> Ints:
        """Return the number of matches of each pair (m,)."""
        return np.array([len(pair.first) for pair in self.pairs], np.int64)

    def counts(self) -> dict[str, int]:
        """Return how many pairs, landmarks and observations there are."""
        matched, tracks = self.reason == Reason.MATCHED, self.tracks
        both = np.isfinite(tracks.top[:, 0]) & np.isfinite(tracks.bottom[:, 0])
        return {
            "keyframes": self.keyframes,
            "nodes": self.nodes,
            "pairs": len(self.pairs),
            "matched": int(matched.sum()),
            "matched_across_legs": int((matched & self.proposal.across).sum()),
            "landmarks": len(tracks.color),
            "observations": len(tracks.landmark),
            "stereo_observations": int(both.sum()),
            "landmarks_of_several_nodes": int((np.bincount(tracks.landmark) > 1).sum()),
        }

    def failures(self) -> dict[str, int]:
        """Return the number of pairs by the reason why they failed."""
        codes, counts = np.unique(self.reason[self.reason > 0], return_counts=True)
        return {REASON_TEXTS[Reason(code)]: int(count) for code, count in zip(codes, counts, strict=True)}

    def chains(self) -> list[int]:
        """Return the sizes of the groups of nodes that matches connect, the largest first; without nodes in no pair."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        proposal, matched = self.proposal, self.reason == Reason.MATCHED
        nodes, index = np.unique(np.concatenate([proposal.first, proposal.second]), return_inverse=True)
        if not len(nodes):
            return []
        a, b = index[: len(proposal)][matched], index[len(proposal) :][matched]
        graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(nodes), len(nodes)))
        return sorted(np.bincount(connected_components(graph, directed=False)[1]).tolist(), reverse=True)


def match_images(worker: MatchWorker, dive: NavigatedDive, map_items: Map) -> MatchedImages:
    """Return the matches of a dive and its tracks. Raises StageError where no two images match."""
    track = track_cameras(dive.trajectory, dive.errors, worker.rig, dive.tray_sigma_rad)
    usable = np.asarray((dive.trajectory.image >= 0).any(axis=1))
    # The two cameras of each node.
    nodes = _nodes(worker, dive, track)
    count = np.zeros(len(nodes), np.int64)
    stereo = map_items(MatchStereo(worker), [nodes[k] for k in np.flatnonzero(usable)], "stereo")
    for k, (features, matches) in zip(np.flatnonzero(usable), stereo, strict=True):
        count[k], nodes[k] = features, replace(nodes[k], stereo=matches)
    # The pairs of nodes worth comparing, and what they have in common.
    depth_m = np.array([_scene_depth(node) for node in nodes])
    salient = np.array([worker.saliency(node) >= worker.options.min_saliency for node in nodes])
    keyframes, proposal = propose(track, usable, depth_m, worker.rig.model(Camera.TOP), worker.options, salient)
    pairs = _match_pairs(worker, track, nodes, proposal, map_items)
    # Matches joined to tracks; observations that verified pairs contradict are dropped.
    tracks = build_tracks(
        count,
        [node.stereo for node in nodes],
        _join_pairs(proposal, pairs),
        lambda k: worker.read(nodes[k].image),
        worker.options.single_node,
        partial(_contradicted, worker.rig, _links(proposal, pairs), worker.options),
    )
    if not any(len(pair.first) for pair in pairs):
        raise StageError("no two images could be matched", where="matches", remedy=_most_frequent_reason(pairs))
    return MatchedImages(tracks=tracks, proposal=proposal, pairs=pairs, keyframes=len(keyframes), nodes=len(nodes))


def _nodes(worker: MatchWorker, dive: NavigatedDive, track: CameraTrack) -> list[MatchNode]:
    """Return the nodes with the depth of the scene by the DVL, without stereo matches yet."""
    depths = [None] * len(track) if dive.returns is None else depth_priors(
        track, dive.trajectory, dive.returns, worker.rig.rig, worker.options.range_margin
    )  # fmt: skip
    images = [(int(top), int(bottom)) for top, bottom in dive.trajectory.image]
    return [MatchNode(image=image, depth=depth, stereo=no_matches()) for image, depth in zip(images, depths, strict=True)]


def _scene_depth(node: MatchNode) -> float:
    """Return the depth of the scene, m: the stereo's median where there is one, else the DVL's, else NaN."""
    if len(node.stereo) >= MIN_STEREO_POINTS:
        return float(np.median(node.stereo.point[:, 2]))
    return node.depth.mean if node.depth else float("nan")


def _match_pairs(
    worker: MatchWorker, track: CameraTrack, nodes: Sequence[MatchNode], proposal: Proposal, map_items: Map
) -> list[PairMatch]:
    pairs = [
        NodePair(first=int(a), second=int(b), expected=track.motion(int(a), int(b)), full_search=not across)
        for a, b, across in zip(proposal.first, proposal.second, proposal.across, strict=True)
    ]
    blocks = []
    for start in range(0, len(pairs), BLOCK):
        part = pairs[start : start + BLOCK]
        touched = sorted({p.first for p in part} | {p.second for p in part})
        blocks.append(({k: nodes[k] for k in touched}, part))
    return [match for block in map_items(MatchPairs(worker), blocks, "pairs") for match in block]


def _links(proposal: Proposal, pairs: Sequence[PairMatch]) -> list[Link]:
    return [
        Link(first=int(a), second=int(b), motion=pair.motion, scaled=pair.scaled)
        for a, b, pair in zip(proposal.first, proposal.second, pairs, strict=True)
        if pair.motion is not None
    ]


def _contradicted(
    rig: CameraRig, links: Sequence[Link], options: MatchOptions, node: Ints, label: Ints, top: Array, bottom: Array
) -> Mask:
    return contradicted_observations(rig, node, label, top, bottom, links, options)


def _join_pairs(proposal: Proposal, pairs: Sequence[PairMatch]) -> NodeMatches:
    size = np.array([len(pair.first) for pair in pairs], np.int64)
    none = np.zeros(0, np.int64)
    return NodeMatches(
        first_node=np.repeat(proposal.first, size),
        first_row=np.concatenate([none, *(pair.first for pair in pairs)]),
        second_node=np.repeat(proposal.second, size),
        second_row=np.concatenate([none, *(pair.second for pair in pairs)]),
        distance=np.concatenate([np.zeros(0, np.float32), *(pair.distance for pair in pairs)]),
    )


def _most_frequent_reason(pairs: Sequence[PairMatch]) -> str:
    if not pairs:
        return "no two images were near enough to be compared"
    code = int(np.bincount([pair.reason for pair in pairs]).argmax())
    return f"of {len(pairs)} pairs most failed by: {REASON_TEXTS[Reason(code)]}"
