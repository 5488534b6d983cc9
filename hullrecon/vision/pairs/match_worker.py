# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The work on one node and on a block of pairs, which other processes can do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Mask
from hullrecon.vision.features.extraction import no_features
from hullrecon.vision.features.store import FeatureStore
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import MatchStrategy, PairMatcher
from hullrecon.vision.pairs.pair_match import PairMatch
from hullrecon.vision.stereo.matching import StereoMatches, no_matches
from hullrecon.vision.stereo.node_view import (
    DepthPrior,
    NodeFeatures,
    NodeView,
    stereo_of_node,
    view_of_node,
)


@dataclass(frozen=True, kw_only=True)
class MatchNode:
    """A node to be matched."""

    image: tuple[int, int]  # rows in the two cameras' indices, -1 for none
    depth: DepthPrior | None  # of the scene, by the DVL
    stereo: StereoMatches  # between its two cameras


@dataclass(frozen=True, kw_only=True)
class NodePair:
    """Two nodes to be compared."""

    first: int
    second: int
    expected: Motion | None  # navigation's motion between them
    full_search: bool  # search everywhere where that finds nothing


@dataclass(frozen=True, kw_only=True)
class MatchWorker:
    """The inputs that every process needs to match nodes. Picklable."""

    features: Path  # folder of the features artifact
    rig: Rig
    options: MatchOptions
    strategy: MatchStrategy = field(default_factory=MatchStrategy)

    def read(self, image: tuple[int, int], stereo: StereoMatches) -> NodeFeatures:
        """Read the features of both cameras, given their matches. None of a camera not carried."""
        bottom = (
            FeatureStore(self.features, Camera.BOTTOM).read(image[1])
            if self.rig.stereo_mount is not None
            else no_features()
        )
        return NodeFeatures(
            top=FeatureStore(self.features, Camera.TOP).read(image[0]), bottom=bottom, stereo=stereo
        )

    def bottom_leads(self, nodes: Sequence[MatchNode]) -> Mask:
        """Select the nodes (n,) at which the bottom camera leads."""
        return np.array([self.read(node.image, node.stereo).bottom_leads for node in nodes], bool)

    def saliency(self, node: MatchNode) -> float:
        """Look up the local saliency of the image that leads."""
        if not self.read(node.image, node.stereo).bottom_leads:
            top = FeatureStore(self.features, Camera.TOP).saliency(node.image[0])
            if top or self.rig.stereo_mount is None:
                return top
        return FeatureStore(self.features, Camera.BOTTOM).saliency(node.image[1])

    def match_stereo(self, node: MatchNode) -> tuple[int, StereoMatches]:
        """Match the two cameras of a node.

        Returns the count of the leading camera's features, and the matches.
        """
        features = self.read(node.image, no_matches())
        stereo = stereo_of_node(
            self.rig,
            features.top,
            features.bottom,
            node.depth,
            self.options,
            self.strategy.match_descriptors,
        )
        return len(replace(features, stereo=stereo).leading), stereo

    def match_pairs(
        self, block: tuple[dict[int, MatchNode], Sequence[NodePair]]
    ) -> list[PairMatch]:
        """Match a block of pairs, given with the nodes that they touch by number."""
        nodes, pairs = block
        views = {number: self.view(node) for number, node in nodes.items()}
        matcher, seed = PairMatcher(self.rig, self.options, self.strategy), self.options.seed
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

    def view(self, node: MatchNode) -> NodeView:
        """Prepare a node for pair matching."""
        features = self.read(node.image, node.stereo)
        return view_of_node(self.rig, features, node.depth, self.options.sigma_px)
