# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Join the matches of linked images to tracks, with statistics of the pairs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hullrecon.errors import StageError
from hullrecon.findings.package import DVL_ALONE
from hullrecon.geometry.poses import Poses
from hullrecon.records.links import CameraLinks, NodePairs, NodeStereo, PairFeatures
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import Trajectory
from hullrecon.rows import read_rows
from hullrecon.typing import Array, Ints, Ints32, Mask
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.match_worker import MatchNode, MatchWorker
from hullrecon.vision.pairs.pair_match import REASON_TEXTS, Reason
from hullrecon.vision.stereo.matching import StereoMatches
from hullrecon.vision.stereo.node_view import NodeFeatures
from hullrecon.vision.tracks.landmarks import FeatureMatches, build_tracks, first_numbers
from hullrecon.vision.tracks.track_verification import Link, contradicted_observations

BLOCK_ROWS = 1 << 18  # matches that are read and joined at a time


@dataclass(frozen=True, kw_only=True)
class MatchedImages:
    """The tracks of a dive, and the pairs that they come from."""

    tracks: Tracks
    pairs: NodePairs  # the m pairs compared
    inliers: Ints  # (m,) features that each pair has in common
    keyframes: int  # number of nodes that were compared with others
    nodes: int  # number of all nodes

    def counts(self) -> dict[str, int]:
        """Count pairs, landmarks and observations."""
        matched, tracks = self.pairs.joined, self.tracks
        both = np.isfinite(tracks.top[:, 0]) & np.isfinite(tracks.bottom[:, 0])
        return {
            "keyframes": self.keyframes,
            "nodes": self.nodes,
            "pairs": len(self.pairs),
            "matched": int(matched.sum()),
            "matched_across_legs": int((matched & self.pairs.across).sum()),
            "rejected": int(self.pairs.rejected.sum()),
            "landmarks": len(tracks.color),
            "observations": len(tracks.landmark),
            "stereo_observations": int(both.sum()),
            "landmarks_of_several_nodes": int((np.bincount(tracks.landmark) > 1).sum()),
        }

    def failures(self) -> dict[str, int]:
        """Count the pairs that failed, by reason."""
        codes, counts = np.unique(self.pairs.reason[self.pairs.reason > 0], return_counts=True)
        return {
            REASON_TEXTS[Reason(code)]: int(count)
            for code, count in zip(codes, counts, strict=True)
        }

    def chains(self) -> list[int]:
        """Count the nodes of each group that joined pairs connect, the largest first.

        More than one group means that images do not tie the whole path together. A compared node
        without a joined pair is a group of its own.
        """
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        pairs, joined = self.pairs, self.pairs.joined
        nodes, index = np.unique(np.concatenate([pairs.first, pairs.second]), return_inverse=True)
        if not len(nodes):
            return []
        a, b = index[: len(pairs)][joined], index[len(pairs) :][joined]
        graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(nodes), len(nodes)))
        group = connected_components(graph, directed=False)[1]
        return sorted(np.bincount(group).tolist(), reverse=True)


def join_images(
    worker: MatchWorker,
    trajectory: Trajectory,
    pairs: NodePairs,
    links: CameraLinks,
    features: PairFeatures,
    stereo: NodeStereo,
    keyframes: int,
) -> MatchedImages:
    """Join the matches of linked images to tracks, without observations that links contradict.

    The tracks are the landmarks that the adjustment estimates.

    Parameters
    ----------
    worker
        Reads features.
    trajectory
        Images and their exposures by node.
    pairs
        All pairs that were compared.
    links, features
        Relative poses and common features of the joined pairs (those that matched and were kept),
        in the order of `pairs`.
    stereo
        Matches between the cameras of each node.
    keyframes
        Number of nodes that were compared with others.

    Raises
    ------
    StageError
        Where no two images match.
    """
    if not pairs.joined.any():
        raise StageError(
            "no two images could be matched",
            where=f"links: {_most_frequent_reason(pairs)}",
            remedy=DVL_ALONE,
        )
    by_node, verified = stereo_by_node(stereo), _verified_links(links)

    def read(k: int) -> NodeFeatures:
        """Read the features of node k, with its stereo matches."""
        top, bottom = trajectory.image[k].tolist()
        exposures = trajectory.exposures
        exposure = None if exposures is None else exposures.take(np.array([k]))
        return worker.read(
            MatchNode(image=(top, bottom), depth=None, stereo=by_node[k], exposure=exposure)
        )

    def contradicted(node: Ints32, label: Ints, top: Array, bottom: Array) -> Mask:
        """Mark observations of a track that do not fit the verified relative poses."""
        return contradicted_observations(
            worker.rig, node, label, top, bottom, verified, worker.options.sigma_px
        )

    tracks = build_tracks(
        stereo.features,
        by_node,
        _MatchesOnDisk(links, features, first_numbers(stereo.features)),
        read,
        worker.options.single_node,
        contradicted,
    )
    inliers = np.zeros(len(pairs), np.int64)
    inliers[pairs.joined] = np.diff(features.start)
    return MatchedImages(
        tracks=tracks, pairs=pairs, inliers=inliers, keyframes=keyframes, nodes=len(trajectory.t_ns)
    )


@dataclass(frozen=True)
class _MatchesOnDisk:
    """The common features of m linked pairs as matches, read in blocks of whole pairs."""

    links: CameraLinks  # (m,)
    features: PairFeatures  # of these links
    number: Ints  # (n + 1,) number of each node's first feature, counted through the dive

    def __iter__(self) -> Iterator[FeatureMatches]:
        """Yield the matches of whole pairs, about BLOCK_ROWS at a time."""
        start = self.features.start
        # First pair of each block: the pairs whose rows begin next to multiples of BLOCK_ROWS.
        edges = np.searchsorted(
            start, np.minimum(np.arange(0, start[-1] + BLOCK_ROWS, BLOCK_ROWS), start[-1])
        )
        for low, high in pairwise(edges.tolist()):
            pairs = slice(low, high)
            rows = read_rows(self.features.rows, slice(*start[[low, high]].tolist()))
            size = np.diff(start[low : high + 1])
            yield FeatureMatches(
                first=np.repeat(self.number[self.links.first[pairs]], size) + rows["first"],
                second=np.repeat(self.number[self.links.second[pairs]], size) + rows["second"],
                distance=rows["distance"],
            )


def stereo_by_node(stereo: NodeStereo) -> list[StereoMatches]:
    """Split the matches between two cameras by node."""
    rows = [slice(a, b) for a, b in zip(stereo.start[:-1], stereo.start[1:], strict=True)]
    return [
        StereoMatches(top=stereo.top[k], bottom=stereo.bottom[k], point=stereo.point[k])
        for k in rows
    ]


def _verified_links(links: CameraLinks) -> list[Link]:
    """Convert links to relative motions (4, 4) with covariance, against which tracks are tested."""
    relative = Poses(links.quaternion, links.translation).matrix()
    return [
        Link(first=int(a), second=int(b), motion=Motion(motion, covariance), scaled=bool(scaled))
        for a, b, motion, covariance, scaled in zip(
            links.first, links.second, relative, links.covariance, links.scaled, strict=True
        )
    ]


def _most_frequent_reason(pairs: NodePairs) -> str:
    """Say why most pairs failed, for the error when none matched."""
    if not len(pairs):
        return "no two images were near enough to be compared"
    code = int(np.bincount(pairs.reason).argmax())
    return f"of {len(pairs)} pairs most failed by: {REASON_TEXTS[Reason(code)]}"
