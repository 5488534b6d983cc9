# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The work on one node and on a block of pairs, as callables that can be sent to other processes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Mask
from hullrecon.vision.features.extraction import no_features
from hullrecon.vision.features.store import FeatureStore
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pair_match import PairMatch
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import PairMatcher
from hullrecon.vision.stereo.matching import StereoMatches, no_matches
from hullrecon.vision.stereo.node_view import DepthPrior, NodeView, stereo_of_node, view_of_node
from hullrecon.vision.tracks.landmarks import NodeFeatures


@dataclass(frozen=True, kw_only=True)
class MatchNode:
    """A node to be matched. image: rows in the two cameras' indices, -1 where none."""

    image: tuple[int, int]
    depth: DepthPrior | None
    stereo: StereoMatches


@dataclass(frozen=True, kw_only=True)
class NodePair:
    """Two nodes to be compared: their numbers, navigation's motion, and whether to search
    everywhere where that fails.
    """

    first: int
    second: int
    expected: Motion | None
    full_search: bool


@dataclass(frozen=True, kw_only=True)
class MatchWorker:
    """What every process needs, picklable: the folder of the features, the rig and the options."""

    features: Path
    rig: Rig
    options: MatchOptions

    def read(self, image: tuple[int, int], stereo: StereoMatches) -> NodeFeatures:
        """Return the features of both cameras; none for a camera that was not carried. stereo: the
        matches between them.
        """
        bottom = (
            FeatureStore(self.features, Camera.BOTTOM).read(image[1])
            if self.rig.stereo_mount is not None
            else no_features()
        )
        return NodeFeatures(
            top=FeatureStore(self.features, Camera.TOP).read(image[0]), bottom=bottom, stereo=stereo
        )

    def bottom_leads(self, nodes: Sequence[MatchNode]) -> Mask:
        """Return at which nodes (n,) the bottom camera leads."""
        return np.array([self.read(node.image, node.stereo).bottom_leads for node in nodes], bool)

    def saliency(self, node: MatchNode) -> float:
        """Return the local saliency of the image that leads."""
        blind = self.read(node.image, node.stereo).bottom_leads
        top = 0.0 if blind else FeatureStore(self.features, Camera.TOP).saliency(node.image[0])
        return top or (
            FeatureStore(self.features, Camera.BOTTOM).saliency(node.image[1])
            if self.rig.stereo_mount is not None
            else 0.0
        )

    def view(self, node: MatchNode) -> NodeView:
        """Return the node as pair matching wants it."""
        features = self.read(node.image, node.stereo)
        return view_of_node(
            self.rig, features.top, features.bottom, node.stereo, node.depth, self.options.sigma_px
        )


@dataclass(frozen=True)
class MatchStereo:
    """Matches the two cameras of one node."""

    worker: MatchWorker

    def __call__(self, node: MatchNode) -> tuple[int, StereoMatches]:
        """Return the number of the leading camera's features, and the matches between the two."""
        features = self.worker.read(node.image, no_matches())
        stereo = stereo_of_node(
            self.worker.rig, features.top, features.bottom, node.depth, self.worker.options
        )
        return len(replace(features, stereo=stereo).leading), stereo


@dataclass(frozen=True)
class MatchPairs:
    """Matches a block of pairs, with the nodes that they touch."""

    worker: MatchWorker

    def __call__(self, block: tuple[dict[int, MatchNode], list[NodePair]]) -> list[PairMatch]:
        """Return the matches of each pair."""
        nodes, pairs = block
        views = {number: self.worker.view(node) for number, node in nodes.items()}
        matcher, seed = PairMatcher(self.worker.rig, self.worker.options), self.worker.options.seed
        return [
            matcher.match(
                views[p.first],
                views[p.second],
                p.expected,
                (seed, p.first, p.second),
                p.full_search,
            )
            for p in pairs
        ]
