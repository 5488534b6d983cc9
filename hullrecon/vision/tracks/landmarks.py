# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The Tracks record from verified pair matches and the stereo matches of single nodes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hullrecon.records.tracks import Tracks
from hullrecon.typing import Array, Floats32, Ints, Mask
from hullrecon.vision.features.extraction import Features
from hullrecon.vision.stereo.leading import bottom_leads
from hullrecon.vision.stereo.matching import StereoMatches, no_matches
from hullrecon.vision.tracks.union import join_matches


@dataclass(frozen=True, kw_only=True)
class NodeFeatures:
    """Features of a node's two cameras, empty where one has no image, and the matches between the
    two.
    """

    top: Features
    bottom: Features
    stereo: StereoMatches = field(default_factory=no_matches)

    @property
    def leading(self) -> Features:
        """Return the features of the camera that leads."""
        return self.bottom if self.bottom_leads else self.top

    @property
    def bottom_leads(self) -> bool:
        """Return whether the bottom camera leads."""
        return bottom_leads(self.top, self.bottom, self.stereo)


@dataclass(frozen=True, kw_only=True)
class FeatureMatches:
    """Verified matches of all pairs, features of the nodes' leading cameras numbered through the
    dive: first and second (m,), descriptor distance (m,).
    """

    first: Ints
    second: Ints
    distance: Floats32


def first_numbers(count: Ints) -> Ints:
    """Return the number (n + 1,) of each node's first feature, and that behind the last; count
    (n,): features of each node.
    """
    return np.concatenate([[0], np.cumsum(count)])


def build_tracks(
    count: Ints,
    stereo: Sequence[StereoMatches],
    matches: FeatureMatches,
    read: Callable[[int], NodeFeatures],
    single_node: bool,
    find_outliers: Callable[[Ints, Ints, Array, Array], Mask] | None = None,
) -> Tracks:
    """Return the tracks of all landmarks that two nodes share and, with `single_node`, of those
    that one stereo node saw.

    count (n,): features of each node's leading camera. stereo: matches of each node, rows into its
    cameras. read: a node's features by its number. find_outliers: from node, landmark, top and
    bottom pixels to the observations to be dropped.
    """
    start = first_numbers(count)
    marked = np.zeros(start[-1], bool)
    marked[matches.first] = marked[matches.second] = True
    for k, node_stereo in enumerate(stereo if single_node else ()):
        marked[start[k] + node_stereo.top] = True
    used = np.flatnonzero(marked)
    node = np.searchsorted(start, used, side="right") - 1
    ends = np.searchsorted(used, matches.first), np.searchsorted(used, matches.second)
    label = join_matches(node, *ends, matches.distance)
    label[label < 0] = label.max(initial=-1) + 1 + np.arange(int((label < 0).sum()))
    top, bottom, response, color = _observations(used - start[node], node, stereo, read)
    keep = (
        np.ones(len(used), bool)
        if find_outliers is None
        else ~find_outliers(node, label, top, bottom)
    )
    shared = np.bincount(label[keep], minlength=int(label.max(initial=-1)) + 1) > 1
    both = np.isfinite(top[:, 0]) & np.isfinite(bottom[:, 0])
    keep &= shared[label] | (both & single_node)
    label = np.unique(label[keep], return_inverse=True)[1].astype(np.int64)
    node, top, bottom, response, color = (
        node[keep],
        top[keep],
        bottom[keep],
        response[keep],
        color[keep],
    )
    order = np.lexsort((node, label))
    return Tracks(
        landmark=label[order],
        node=node[order],
        top=top[order],
        bottom=bottom[order],
        response=response[order],
        color=_mean_color(label, color),
    )


def _observations(
    row: Ints, node: Ints, stereo: Sequence[StereoMatches], read: Callable[[int], NodeFeatures]
) -> tuple[Array, Array, Array, Array]:
    """Return pixels in the top and in the bottom image, NaN where not seen, the detector's response
    in the mean of both, NaN for corners, and colours; node (m,) ascending.
    """
    top, bottom, color = (
        np.full((len(row), 2), np.nan),
        np.full((len(row), 2), np.nan),
        np.zeros((len(row), 3)),
    )
    response = np.full(len(row), np.nan)
    for k in np.unique(node):
        rows = slice(*np.searchsorted(node, [k, k + 1]))
        features = read(int(k))
        seen = features.leading.keypoints[row[rows], :2]
        color[rows] = features.leading.color[row[rows]]
        response[rows] = _responses(features.leading)[row[rows]]
        if features.bottom_leads:
            bottom[rows] = seen
            continue
        top[rows] = seen
        pair = np.full(len(features.top), -1)
        pair[stereo[k].top] = stereo[k].bottom
        other = pair[row[rows]]
        bottom[rows][other >= 0] = features.bottom.keypoints[other[other >= 0], :2]
        response[rows][other >= 0] += _responses(features.bottom)[other[other >= 0]]
        response[rows][other >= 0] /= 2
    return top, bottom, response, color


def _responses(features: Features) -> Array:
    """Return the detector's response (n,); NaN for corners."""
    return np.where(features.corner, np.nan, features.keypoints[:, 3])


def _mean_color(label: Ints, color: Array) -> NDArray[np.uint8]:
    count = np.maximum(np.bincount(label), 1)
    mean = np.stack([np.bincount(label, color[:, c]) / count for c in range(3)], axis=1)
    return np.rint(mean).astype(np.uint8)
