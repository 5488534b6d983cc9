# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Matches joined into landmarks: union of what was matched, one observation a node, conflicts
split.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Ints, Mask


def join_matches(node_of: Ints, first: Ints, second: Ints, quality: NDArray[np.floating]) -> Ints:
    """Return the landmark number (n,) of each feature: -1 where unmatched; numbered by first
    feature.

    node_of (n,): node of each feature. first, second (m,): matched features. quality (m,): smaller
    is better. A component that would hold two features of one node is built again, best match
    first, leaving out what brings the conflict.
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
    """Return by component whether two of its features lie in one node."""
    order = np.lexsort((node_of, label))
    same = (np.diff(label[order]) == 0) & (np.diff(node_of[order]) == 0)
    out = np.zeros(int(label.max(initial=0)) + 1, bool)
    out[label[order[1:]][same]] = True
    return out


def _without_conflict(node_of: Ints, first: Ints, second: Ints) -> Mask:
    """Return the edges, in their order, that join two groups without a common node. A loop, but
    only over the torn components.
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
