# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The work on one node and on a block of pairs, as functions that can be sent to other processes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hullrecon.vision.features.extraction import nothing
from hullrecon.vision.features.store import FeatureStore
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import PairMatch, match_pair
from hullrecon.vision.stereo.matching import StereoMatches
from hullrecon.vision.stereo.node_view import DepthPrior, View, stereo_of_node, view_of_node
from hullrecon.vision.stereo.rectification import Rig
from hullrecon.vision.tracks.landmarks import NodeFeatures


@dataclass(frozen=True)
class Node:
    """image: rows in the two cameras' indices, -1 where none."""

    image: tuple[int, int]
    depth: DepthPrior | None
    stereo: StereoMatches


@dataclass(frozen=True)
class Pair:
    first: int
    second: int
    expected: Motion | None
    full_search: bool


@dataclass(frozen=True)
class Bench:
    """What the workers need, picklable: where the features lie, the rig and the options."""

    features: Path
    rig: Rig
    lower: bool  # a bottom camera was carried
    options: MatchOptions

    def read(self, image: tuple[int, int]) -> NodeFeatures:
        top = FeatureStore(self.features, "camera_top").read(image[0])
        return NodeFeatures(top, FeatureStore(self.features, "camera_bottom").read(image[1]) if self.lower else nothing())

    def saliency(self, node: Node) -> float:
        """Of the image that leads."""
        top = FeatureStore(self.features, "camera_top").saliency(node.image[0])
        return top or (FeatureStore(self.features, "camera_bottom").saliency(node.image[1]) if self.lower else 0.0)

    def view(self, node: Node) -> View:
        features = self.read(node.image)
        return view_of_node(self.rig, features.top, features.bottom, node.stereo, node.depth, self.options.sigma_px)


@dataclass(frozen=True)
class MatchNode:
    """Picklable: the stereo matches of one node."""

    bench: Bench

    def __call__(self, node: Node) -> tuple[int, StereoMatches]:
        """Number of the leading camera's features, and the matches between the two."""
        features = self.bench.read(node.image)
        stereo = stereo_of_node(self.bench.rig, features.top, features.bottom, node.depth, self.bench.options)
        return len(features.leading), stereo


@dataclass(frozen=True)
class MatchPairs:
    """Picklable: a block of pairs, with the nodes that they touch."""

    bench: Bench

    def __call__(self, block: tuple[dict[int, Node], list[Pair]]) -> list[PairMatch]:
        nodes, pairs = block
        views = {number: self.bench.view(node) for number, node in nodes.items()}
        options, rig = self.bench.options, self.bench.rig
        return [
            match_pair(
                rig, views[p.first], views[p.second], p.expected, options, (options.seed, p.first, p.second), p.full_search
            )
            for p in pairs
        ]
