# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The matches of linked images joined to tracks, and what is said of the pairs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses
from hullrecon.records.links import CameraLinks, NodePairs, NodeStereo, PairFeatures
from hullrecon.records.tracks import Tracks
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pair_match import REASON_TEXTS, Reason
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.match_worker import MatchWorker
from hullrecon.vision.stereo.matching import StereoMatches
from hullrecon.vision.tracks.landmarks import FeatureMatches, build_tracks, first_numbers
from hullrecon.vision.tracks.track_verification import Link, contradicted_observations

NO_IMAGES = (
    "look whether images are lit, sharp and of the hull; without [camera.top] and [camera.bottom] in dive.toml a run goes on"
    " with the DVL alone"
)


@dataclass(frozen=True, kw_only=True)
class MatchedImages:
    """The tracks, the pairs that were compared with the number of features that each has in common
    (m,), how many of these are corners (None where none were looked for), and the number of
    keyframes and nodes.
    """

    tracks: Tracks
    pairs: NodePairs
    inliers: Ints
    keyframes: int
    nodes: int
    corners: Ints | None = None

    def counts(self) -> dict[str, int]:
        """Return how many pairs, landmarks and observations there are."""
        matched, tracks = self.pairs.joined, self.tracks
        both = np.isfinite(tracks.top[:, 0]) & np.isfinite(tracks.bottom[:, 0])
        kinds = (
            {}
            if self.corners is None
            else {"matches": int(self.inliers.sum()), "corner_matches": int(self.corners.sum())}
        )
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
            **kinds,
        }

    def failures(self) -> dict[str, int]:
        """Return the number of pairs by the reason why they failed."""
        codes, counts = np.unique(self.pairs.reason[self.pairs.reason > 0], return_counts=True)
        return {
            REASON_TEXTS[Reason(code)]: int(count)
            for code, count in zip(codes, counts, strict=True)
        }

    def chains(self) -> list[int]:
        """Return the sizes of the groups of nodes that matches connect, the largest first; without
        nodes in no pair.
        """
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        pairs, joined = self.pairs, self.pairs.joined
        nodes, index = np.unique(np.concatenate([pairs.first, pairs.second]), return_inverse=True)
        if not len(nodes):
            return []
        a, b = index[: len(pairs)][joined], index[len(pairs) :][joined]
        graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(nodes), len(nodes)))
        return sorted(
            np.bincount(connected_components(graph, directed=False)[1]).tolist(), reverse=True
        )


def join_images(
    worker: MatchWorker,
    image: Ints,
    pairs: NodePairs,
    links: CameraLinks,
    features: PairFeatures,
    stereo: NodeStereo,
    keyframes: int,
) -> MatchedImages:
    """Return the tracks of linked images; observations that verified pairs contradict are dropped.

    image (n, 2): rows in the cameras' indices. links and features: of the pairs joined, in their
    order. Raises StageError where no two images match.
    """
    if not pairs.joined.any():
        raise StageError(
            "no two images could be matched",
            where=f"links: {_most_frequent_reason(pairs)}",
            remedy=NO_IMAGES,
        )
    size, start, by_node = (
        np.diff(features.start),
        first_numbers(stereo.features),
        stereo_by_node(stereo),
    )
    tracks = build_tracks(
        stereo.features,
        by_node,
        FeatureMatches(
            first=np.repeat(start[links.first], size) + features.first,
            second=np.repeat(start[links.second], size) + features.second,
            distance=features.distance,
        ),
        lambda k: worker.read((int(image[k, 0]), int(image[k, 1])), by_node[k]),
        worker.options.single_node,
        partial(_find_contradictions, worker.rig, _verified_links(links), worker.options),
    )
    inliers = np.zeros(len(pairs), np.int64)
    inliers[pairs.joined] = size
    corners = _count_corners(worker, image, by_node, pairs, links, features)
    return MatchedImages(
        tracks=tracks,
        pairs=pairs,
        inliers=inliers,
        keyframes=keyframes,
        nodes=len(image),
        corners=corners,
    )


def _count_corners(
    worker: MatchWorker,
    image: Ints,
    stereo: list[StereoMatches],
    pairs: NodePairs,
    links: CameraLinks,
    features: PairFeatures,
) -> Ints | None:
    """Return how many of the features that each pair has in common (m,) are corners; None where
    there are none.
    """
    if worker.options.harris_share == 0:
        return None  # no image is read for it
    views = (
        worker.read((int(top), int(low)), found).leading
        for (top, low), found in zip(image, stereo, strict=True)
    )
    rows, corners = np.array([(len(view), view.corners) for view in views], np.int64).T
    if not corners.any():
        return None
    pair = np.repeat(np.flatnonzero(pairs.joined), np.diff(features.start))
    node = np.repeat(links.first, np.diff(features.start))
    return np.bincount(pair[features.first >= (rows - corners)[node]], minlength=len(pairs)).astype(
        np.int64
    )


def stereo_by_node(stereo: NodeStereo) -> list[StereoMatches]:
    """Return the matches between the two cameras of each node."""
    rows = [slice(a, b) for a, b in zip(stereo.start[:-1], stereo.start[1:], strict=True)]
    return [
        StereoMatches(top=stereo.top[k], bottom=stereo.bottom[k], point=stereo.point[k])
        for k in rows
    ]


def _verified_links(links: CameraLinks) -> list[Link]:
    relative = Poses(links.quaternion, links.translation).matrix()
    return [
        Link(first=int(a), second=int(b), motion=Motion(motion, covariance), scaled=bool(scaled))
        for a, b, motion, covariance, scaled in zip(
            links.first, links.second, relative, links.covariance, links.scaled, strict=True
        )
    ]


def _find_contradictions(
    rig: Rig,
    links: list[Link],
    options: MatchOptions,
    node: Ints,
    label: Ints,
    top: Array,
    bottom: Array,
) -> Mask:
    return contradicted_observations(rig, node, label, top, bottom, links, options)


def _most_frequent_reason(pairs: NodePairs) -> str:
    if not len(pairs):
        return "no two images were near enough to be compared"
    code = int(np.bincount(pairs.reason).argmax())
    return f"of {len(pairs)} pairs most failed by: {REASON_TEXTS[Reason(code)]}"
