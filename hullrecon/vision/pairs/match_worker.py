# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The work on one node and on a block of pairs, which other processes can do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.records.trajectory import Exposures
from hullrecon.rig import Rig
from hullrecon.typing import Mask
from hullrecon.vision.features.extraction import no_features
from hullrecon.vision.features.store import FeatureStore
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import MatchStrategy, PairMatcher
from hullrecon.vision.pairs.pair_match import PairMatch
from hullrecon.vision.stereo.exposure import DEPTHS_M, move_features, settle_depths
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
    exposure: Exposures | None = None  # one row; None: exposed at the node's time


@dataclass(frozen=True, kw_only=True)
class NodePair:
    """Two nodes to be compared."""

    first: int
    second: int
    expected: Motion | None  # navigation's motion between them
    full_search: bool  # search the whole image where the search near `expected` finds nothing


@dataclass(frozen=True, kw_only=True)
class MatchWorker:
    """The inputs that every process needs to match nodes. Picklable."""

    features: Path  # folder of the features artifact
    rig: Rig
    options: MatchOptions
    strategy: MatchStrategy = field(default_factory=MatchStrategy)

    def read(self, node: MatchNode) -> NodeFeatures:
        """Read the features of both cameras, moved to where they were at the node's time.

        So later steps need one pose for a node, whenever its images were exposed. Empty for a
        camera that the vehicle does not carry.
        """
        seen = self._as_found(node)
        if node.exposure is None:
            return seen
        return move_features(self.rig, seen, float(node.exposure.depth_m[0]), node.exposure)

    def _as_found(self, node: MatchNode) -> NodeFeatures:
        """Read the features of both cameras where they were found in the images."""
        bottom = (
            FeatureStore(self.features, Camera.BOTTOM).read(node.image[1])
            if self.rig.stereo_mount is not None
            else no_features()
        )
        top = FeatureStore(self.features, Camera.TOP).read(node.image[0])
        return NodeFeatures(top=top, bottom=bottom, stereo=node.stereo)

    def bottom_leads(self, nodes: Sequence[MatchNode]) -> Mask:
        """Select the nodes (n,) whose leading camera is the bottom one.

        It needs their stereo matches: cameras that match each other both see.
        """
        return np.array([self.read(node).bottom_leads for node in nodes], bool)

    def saliency(self, node: MatchNode) -> float:
        """Look up the local saliency of the leading camera's image.

        It is low where there is little to recognise, as on plain paint. Where the top camera leads
        but has no image, the bottom camera's image is taken.
        """
        if not self.read(node).bottom_leads:
            top = FeatureStore(self.features, Camera.TOP).saliency(node.image[0])
            if top or self.rig.stereo_mount is None:
                return top
        return FeatureStore(self.features, Camera.BOTTOM).saliency(node.image[1])

    def match_stereo(self, node: MatchNode) -> tuple[int, StereoMatches]:
        """Match the two cameras of a node, which gives depths of the scene.

        There are no matches with one camera or one image, or where one of the images is noise.
        Returns the count of the leading camera's features, and the matches.
        """
        features = self._as_found(replace(node, stereo=no_matches()))
        if node.exposure is None:
            stereo = self._match_cameras(features, node.depth)
        else:
            stereo = self._match_moved(features, node.depth, node.exposure)
        return len(replace(features, stereo=stereo).leading), stereo

    def _match_moved(
        self, seen: NodeFeatures, prior: DepthPrior | None, exposure: Exposures
    ) -> StereoMatches:
        """Match two cameras that were exposed at different times.

        Features are moved to the node's time, for which the depth of the scene is needed. Where the
        DVL did not measure it, several depths are tried and the one with the most matches is taken.
        """
        depth_m = float(exposure.depth_m[0])
        tried = [
            self._match_cameras(move_features(self.rig, seen, depth, exposure), prior)
            for depth in ((depth_m,) if np.isfinite(depth_m) else DEPTHS_M)
        ]
        matched = replace(seen, stereo=max(tried, key=len))
        return settle_depths(self.rig, matched, depth_m, exposure)

    def _match_cameras(self, features: NodeFeatures, prior: DepthPrior | None) -> StereoMatches:
        """Match two cameras as if exposed together. prior: depth to search, None where unknown."""
        return stereo_of_node(
            self.rig,
            features.top,
            features.bottom,
            prior,
            self.options,
            self.strategy.match_descriptors,
        )

    def match_pairs(
        self, block: tuple[dict[int, MatchNode], Sequence[NodePair]]
    ) -> list[PairMatch]:
        """Match a block of pairs, preparing each of its nodes once.

        block: the nodes of these pairs by number, and the pairs. Returns the result of each pair,
        in order. A pair that failed has the reason.
        """
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
        """Read a node and prepare the features of its leading camera for pair matching."""
        features = self.read(node)
        return view_of_node(self.rig, features, node.depth, self.options.sigma_px)
