# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Join verified matches to tracks of landmarks.

Matched features are united. A landmark has one observation a node: unions that break this are built
again, the best match first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.records.tracks import Tracks
from hullrecon.typing import Array, Floats32, Ints, Mask
from hullrecon.vision.stereo.matching import StereoMatches
from hullrecon.vision.stereo.node_view import NodeFeatures


@dataclass(frozen=True, kw_only=True)
class FeatureMatches:
    """Verified matches of all pairs of nodes."""

    first: Ints  # (m,) features of leading cameras, numbered through the dive
    second: Ints  # (m,)
    distance: Floats32  # (m,) of their descriptors


def first_numbers(count: Ints) -> Ints:
    """Count the features before each node (n + 1,), given those (n,) of each."""
    return np.concatenate([[0], np.cumsum(count)])


def build_tracks(
    count: Ints,
    stereo: Sequence[StereoMatches],
    matches: FeatureMatches,
    read: Callable[[int], NodeFeatures],
    single_node: bool,
    find_outliers: Callable[[Ints, Ints, Array, Array], Mask] | None = None,
) -> Tracks:
    """Build the tracks of all landmarks.

    Parameters
    ----------
    count
        Features (n,) of each node's leading camera.
    stereo
        Matches between each node's cameras.
    matches
        Between nodes.
    read
        A node's features by its number.
    single_node
        Keep also landmarks that one node saw, with both cameras.
    find_outliers
        From node, landmark, top and bottom pixels (m,) to observations (m,) to be dropped.
    """
    start = first_numbers(count)
    marked = np.zeros(start[-1], bool)
    marked[matches.first] = marked[matches.second] = True
    for k, node_stereo in enumerate(stereo if single_node else ()):
        marked[start[k] + node_stereo.top] = True
    used = np.flatnonzero(marked)
    node = np.searchsorted(start, used, side="right") - 1
    first, second = np.searchsorted(used, matches.first), np.searchsorted(used, matches.second)
    label = join_matches(node, first, second, matches.distance)
    label[label < 0] = label.max(initial=-1) + 1 + np.arange(int((label < 0).sum()))
    top, bottom, response, color = _observations(used - start[node], node, stereo, read)
    keep = np.ones(len(used), bool)
    if find_outliers is not None:
        keep &= ~find_outliers(node, label, top, bottom)
    shared = np.bincount(label[keep], minlength=int(label.max(initial=-1)) + 1) > 1
    both = np.isfinite(top[:, 0]) & np.isfinite(bottom[:, 0])
    keep &= shared[label] | (both & single_node)
    label = np.unique(label[keep], return_inverse=True)[1].astype(np.int64)
    order = np.lexsort((node[keep], label))
    rows = np.flatnonzero(keep)[order]
    return Tracks(
        landmark=label[order],
        node=node[rows],
        top=top[rows],
        bottom=bottom[rows],
        response=response[rows],
        color=_mean_color(label, color[keep]),
    )


def _observations(
    row: Ints, node: Ints, stereo: Sequence[StereoMatches], read: Callable[[int], NodeFeatures]
) -> tuple[Array, Array, Array, Array]:
    """Look up observations: feature `row` (m,) of the leading camera of `node` (m,), ascending.

    Returns
    -------
    top, bottom
        Pixels (m, 2) in either image, NaN where not seen.
    response
        The detector's (m,), the mean of both images.
    color
        (m, 3).
    """
    top, bottom = np.full((len(row), 2), np.nan), np.full((len(row), 2), np.nan)
    color, response = np.zeros((len(row), 3)), np.full(len(row), np.nan)
    for k in np.unique(node):
        rows = slice(*np.searchsorted(node, [k, k + 1]))
        features = read(int(k))
        seen = features.leading.keypoints[row[rows], :2]
        color[rows] = features.leading.color[row[rows]]
        response[rows] = features.leading.keypoints[row[rows], 3]
        if features.bottom_leads:
            bottom[rows] = seen
            continue
        top[rows] = seen
        pair = np.full(len(features.top), -1)
        pair[stereo[k].top] = stereo[k].bottom
        other = pair[row[rows]]
        both = other >= 0
        bottom[rows][both] = features.bottom.keypoints[other[both], :2]
        response[rows][both] += features.bottom.keypoints[other[both], 3]
        response[rows][both] /= 2
    return top, bottom, response, color


def _mean_color(label: Ints, color: Array) -> NDArray[np.uint8]:
    count = np.maximum(np.bincount(label), 1)
    mean = np.stack([np.bincount(label, color[:, c]) / count for c in range(3)], axis=1)
    return np.rint(mean).astype(np.uint8)


def join_matches(node_of: Ints, first: Ints, second: Ints, quality: NDArray[np.floating]) -> Ints:
    """Assign each feature (n,) a landmark, numbered by its first feature. -1 where unmatched.

    A component that would hold two features of one node is built again, best match first, leaving
    out the matches that bring the conflict.

    Parameters
    ----------
    node_of
        Node (n,) of each feature.
    first, second
        Matched features (m,).
    quality
        Of the matches (m,), smaller is better.
    """
    label = _components(len(node_of), first, second)
    torn = _conflicting(label, node_of)
    edge_torn = torn[label[first]]
    if edge_torn.any():
        rows = np.flatnonzero(edge_torn)
        rows = rows[np.lexsort((second[rows], first[rows], quality[rows]))]
        kept = rows[_without_conflict(node_of, first[rows], second[rows])]
        edges = np.sort(np.concatenate([np.flatnonzero(~edge_torn), kept]))
        first, second = first[edges], second[edges]
        label = _components(len(node_of), first, second)
    matched = np.zeros(len(node_of), bool)
    matched[first] = matched[second] = True
    out = np.full(len(node_of), -1, np.int64)
    _, start, inverse = np.unique(label[matched], return_index=True, return_inverse=True)
    out[matched] = np.argsort(np.argsort(start))[inverse]
    return out


def _components(n: int, first: Ints, second: Ints) -> Ints:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(first), np.int8), (first, second)), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


def _conflicting(label: Ints, node_of: Ints) -> Mask:
    """Select the components with two features of one node."""
    order = np.lexsort((node_of, label))
    same = (np.diff(label[order]) == 0) & (np.diff(node_of[order]) == 0)
    out = np.zeros(int(label.max(initial=0)) + 1, bool)
    out[label[order[1:]][same]] = True
    return out


def _without_conflict(node_of: Ints, first: Ints, second: Ints) -> Mask:
    """Select the edges, taken in order, that join two groups without a common node.

    A loop, but only over the torn components.
    """
    group: dict[int, dict[int, int]] = {}  # feature -> its group: node -> feature
    kept = np.zeros(len(first), bool)
    for k, (a, b) in enumerate(zip(first.tolist(), second.tolist(), strict=True)):
        one = group.setdefault(a, {int(node_of[a]): a})
        other = group.setdefault(b, {int(node_of[b]): b})
        if one is other:
            kept[k] = True
        elif not one.keys() & other.keys():
            small, large = sorted((one, other), key=len)
            large.update(small)
            group.update(dict.fromkeys(small.values(), large))
            kept[k] = True
    return kept
