# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Join verified matches to tracks of landmarks.

Matched features are joined to connected components. A landmark has at most one observation at each
node. Components that break this are joined again, the best match first, without the matches that
would bring a second feature of a node.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.records.tracks import Tracks
from hullrecon.rows import Rows
from hullrecon.typing import Array, Floats32, Ints, Ints32, Mask
from hullrecon.vision.stereo.matching import StereoMatches
from hullrecon.vision.stereo.node_view import NodeFeatures


@dataclass(frozen=True, kw_only=True)
class FeatureMatches(Rows):
    """Verified matches of pairs of nodes."""

    first: Ints  # (m,) features of leading cameras, numbered through the dive
    second: Ints  # (m,)
    distance: Floats32  # (m,) of their descriptors


def first_numbers(count: Ints) -> Ints:
    """Compute the number of each node's first feature (n + 1,), counted through the dive.

    count: features (n,) of each node. The last entry is the number of all features.
    """
    return np.concatenate([[0], np.cumsum(count)])


def build_tracks(
    count: Ints,
    stereo: Sequence[StereoMatches],
    matches: Iterable[FeatureMatches],
    read: Callable[[int], NodeFeatures],
    single_node: bool,
    find_outliers: Callable[[Ints32, Ints, Array, Array], Mask] | None = None,
) -> Tracks:
    """Build the tracks of all landmarks: which features of which nodes show one point.

    Outliers, and landmarks that only one node saw, are left out (but see single_node).

    Parameters
    ----------
    count
        Number (n,) of features of each node's leading camera.
    stereo
        Matches between each node's cameras.
    matches
        Matches between nodes, in blocks. They are iterated over several times.
    read
        Reads a node's features by its number.
    single_node
        Keep also landmarks that a single node saw, with both cameras.
    find_outliers
        Selects the observations (m,) to be dropped, given node (m,), landmark (m,), top and bottom
        pixels (m, 2).
    """
    # Features that any match uses, numbered through the dive.
    start = first_numbers(count)
    marked = np.zeros(start[-1], bool)
    for block in matches:
        marked[block.first] = marked[block.second] = True
    for k, node_stereo in enumerate(stereo if single_node else ()):
        marked[start[k] + node_stereo.top] = True
    used = np.flatnonzero(marked)
    node = (np.searchsorted(start, used, side="right") - 1).astype(np.int32)
    # Join them to landmarks. A feature with a stereo match alone is a landmark of its own.
    label = join_matches(node, _Renumbered(matches, used))
    label[label < 0] = label.max(initial=-1) + 1 + np.arange(int((label < 0).sum()))
    top, bottom, response, color = _observations(used - start[node], node, stereo, read)
    # Drop outliers. Keep landmarks of several nodes, and with single_node stereo ones of one node.
    keep = np.ones(len(used), bool)
    if find_outliers is not None:
        keep &= ~find_outliers(node, label, top, bottom)
    shared = np.bincount(label[keep], minlength=int(label.max(initial=-1)) + 1) > 1
    both = np.isfinite(top[:, 0]) & np.isfinite(bottom[:, 0])
    keep &= shared[label] | (both & single_node)
    # Number the landmarks without gaps, and sort observations by landmark, then node.
    label = np.unique(label[keep], return_inverse=True)[1].astype(np.int64)
    order = np.argsort(label, kind="stable")  # nodes ascend
    rows = np.flatnonzero(keep)[order]
    mean_color = _mean_color(label, color[keep])
    label = label[order]
    # One statement each: it frees the memory of all observations before the next one takes more.
    top = top[rows]
    bottom = bottom[rows]
    response = response[rows]
    return Tracks(
        landmark=label,
        node=node[rows].astype(np.int64),
        top=top,
        bottom=bottom,
        response=response,
        color=mean_color,
    )


@dataclass(frozen=True)
class _Renumbered:
    """Matches in blocks, with features renumbered by their row in `used`."""

    matches: Iterable[FeatureMatches]
    used: Ints  # (u,) numbers of all features that the matches use, ascending

    def __iter__(self) -> Iterator[FeatureMatches]:
        """Yield the matches in blocks, with features renumbered."""
        for block in self.matches:
            first, second = (
                np.searchsorted(self.used, rows) for rows in (block.first, block.second)
            )
            yield FeatureMatches(first=first, second=second, distance=block.distance)


def _observations(
    row: Ints,
    node: Ints32,
    stereo: Sequence[StereoMatches],
    read: Callable[[int], NodeFeatures],
) -> tuple[Array, Array, Array, NDArray[np.uint8]]:
    """Look up the pixels, responses and colours of observations, reading each node once.

    Parameters
    ----------
    row
        Row (m,) of each observation's feature in its node's leading camera.
    node
        Node (m,) of each, ascending.
    stereo
        Matches between each node's cameras.
    read
        Reads a node's features by its number.

    Returns
    -------
    top, bottom
        Pixels (m, 2) in either image, NaN where not seen.
    response
        Response (m,) of the detector, the mean of both images.
    color
        RGB (m, 3) in the leading image.
    """
    top, bottom = np.full((len(row), 2), np.nan), np.full((len(row), 2), np.nan)
    color, response = np.zeros((len(row), 3), np.uint8), np.full(len(row), np.nan)
    for k in np.unique(node):
        rows = slice(*np.searchsorted(node, [k, k + 1]))
        features = read(int(k))
        seen = features.leading.keypoints[row[rows], :2]
        color[rows] = features.leading.color[row[rows]]
        response[rows] = features.leading.keypoints[row[rows], 3]
        if features.bottom_leads:
            bottom[rows] = seen
            continue
        # the bottom camera's feature that shows the same point, where there is one
        top[rows] = seen
        pair = np.full(len(features.top), -1)
        pair[stereo[k].top] = stereo[k].bottom
        other = pair[row[rows]]
        both = other >= 0
        bottom[rows][both] = features.bottom.keypoints[other[both], :2]
        response[rows][both] += features.bottom.keypoints[other[both], 3]
        response[rows][both] /= 2
    return top, bottom, response, color


def _mean_color(label: Ints, color: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Average the colours (m, 3) of each landmark's observations; label: (m,) their landmark."""
    count = np.maximum(np.bincount(label), 1)
    mean = np.stack([np.bincount(label, color[:, c]) / count for c in range(3)], axis=1)
    return np.rint(mean).astype(np.uint8)


def join_matches(node_of: Ints32, matches: Iterable[FeatureMatches]) -> Ints:
    """Assign each feature (n,) the number of a landmark, -1 where it has no match.

    Features that matches connect, directly or through others (a component), are one landmark.
    Landmarks are numbered in the order of their first features. A component with two features of
    one node is joined again, the best match first, leaving out the matches that cause the conflict.

    Parameters
    ----------
    node_of
        Node (n,) of each feature.
    matches
        Matches between these features, in blocks. They are iterated over several times.
    """
    label = _components(len(node_of), matches)
    conflicting = _conflicting(label, node_of)
    if conflicting.any():
        matches = _untangle(node_of, matches, conflicting[label])
        label = _components(len(node_of), matches)
    matched = np.zeros(len(node_of), bool)
    for block in matches:
        matched[block.first] = matched[block.second] = True
    first = matched & (label == np.arange(len(label)))
    return np.where(matched, (np.cumsum(first) - 1)[label], -1)


def _components(n: int, matches: Iterable[FeatureMatches]) -> Ints32:
    """Label n features by connected components of the matches.

    The label (n,) of a component is its first feature. Components are merged block by block.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    label = np.arange(n, dtype=np.int32)
    for block in matches:
        # The components so far are the points that the block joins.
        ends = label[np.concatenate([block.first, block.second])]
        points, ends = np.unique(ends, return_inverse=True)
        edges = ends.reshape(2, -1)
        size = (len(points), len(points))
        graph = coo_array((np.ones(edges.shape[1], np.int8), (edges[0], edges[1])), shape=size)
        of_point = connected_components(graph, directed=False)[1]
        _, least = np.unique(of_point, return_index=True)
        joined = np.arange(n, dtype=np.int32)
        joined[points] = points[least][of_point]
        label = joined[label]
    return label


def _conflicting(label: Ints32, node_of: Ints32) -> Mask:
    """Select the components with two features of one node, as a mask (n,) by component label."""
    order = np.lexsort((node_of, label))
    same = (np.diff(label[order]) == 0) & (np.diff(node_of[order]) == 0)
    out = np.zeros(len(label), bool)
    out[label[order[1:]][same]] = True
    return out


@dataclass(frozen=True)
class _Untangled:
    """Matches in blocks, without those of conflicting components that were not kept."""

    matches: Iterable[FeatureMatches]
    conflicting: Mask  # (n,) features of components with two features of one node
    kept: FeatureMatches

    def __iter__(self) -> Iterator[FeatureMatches]:
        for block in self.matches:
            yield block.take(~self.conflicting[block.first])
        yield self.kept


def _untangle(node_of: Ints32, matches: Iterable[FeatureMatches], conflicting: Mask) -> _Untangled:
    """Leave out matches of conflicting components so that none joins two features of one node.

    Two features of one node cannot be one point, so one of the matches between them is wrong. The
    best matches (smallest distance) are kept first. conflicting: (n,) features of such components.
    """
    of_conflicting = [block.take(conflicting[block.first]) for block in matches]
    tangled = of_conflicting[0].followed_by(*of_conflicting[1:])
    tangled = tangled.take(np.lexsort((tangled.second, tangled.first, tangled.distance)))
    kept = tangled.take(_without_conflict(node_of, tangled.first, tangled.second))
    return _Untangled(matches, conflicting, kept)


def _without_conflict(node_of: Ints32, first: Ints, second: Ints) -> Mask:
    """Select the matches (m,), taken in order, that join no two features of one node.

    node_of: node of each feature. first, second: (m,) features of each match. A match joins the
    groups that its two features belong to by the matches before. It is left out where both groups
    have a feature of the same node. Union-find in a Python loop, which is fast enough as it runs
    over conflicting components only.
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
