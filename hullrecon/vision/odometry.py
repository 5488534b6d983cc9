# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Motion from stereo images alone, pair after pair: what navigation stands on where there is no DVL."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.matching import PairMatch, match_pair
from hullrecon.vision.stereo.node_view import View, stereo_of_node, view_of_node
from hullrecon.vision.stereo.rectification import Rig
from hullrecon.vision.tracks.landmarks import NodeFeatures


def view(rig: Rig, features: NodeFeatures, options: MatchOptions) -> View:
    """A node with its stereo matches, nothing known about the depth of the scene."""
    stereo = stereo_of_node(rig, features.top, features.bottom, None, options)
    return view_of_node(rig, features.top, features.bottom, stereo, None, options.sigma_px)


def chain(rig: Rig, nodes: Sequence[int], read: Callable[[int], NodeFeatures], options: MatchOptions) -> list[PairMatch]:
    """The match of each node with the next; its `motion` is second_from_first of the leading cameras, None where it failed.

    read: a node's features by its number. Two nodes are in memory at a time.
    """
    out: list[PairMatch] = []
    before: View | None = None
    for place, node in enumerate(nodes):
        here = view(rig, read(node), options)
        if before is not None:
            out.append(match_pair(rig, before, here, None, options, (options.seed, nodes[place - 1], node), True))
        before = here
    return out
