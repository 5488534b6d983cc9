# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Select the nodes to be compared: neighbours, and nodes of other legs that saw the same hull."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.expected_overlap import expect_overlap, scene_middles
from hullrecon.vision.pairs.footprints import footprint_overlap

MAX_OVERLAP = 0.98  # with the last keyframe: a node that overlaps it by more is no keyframe
# Rise of the overlap above the smallest one in between that shows that the vehicle came back, and
# did not just move slowly
RETURN = 0.2
FINE_GRID = 32  # cells of a keyframe's footprint along each side, as small steps matter
BLOCK = 1000  # points whose neighbours are searched at a time
MOST_GAIN = 1e3  # nats; a link with more would determine a motion that is as good as unknown


@dataclass(frozen=True, kw_only=True)
class Proposal(Rows):
    """Pairs of nodes to be compared, sorted by (first, second)."""

    first: Ints  # (m,) nodes
    second: Ints  # (m,) > first
    across: Mask  # (m,) nodes of two legs, not neighbours
    overlap: Array  # (m,) of the predicted footprints, NaN where no depth is known


@dataclass(frozen=True, kw_only=True)
class Revisits:
    """Pairs of nodes that may show the same hull, seen on two passes."""

    proposal: Proposal  # m pairs
    probability: Array  # (m,) that they overlap enough
    expected_overlap: Array  # (m,) share of the first footprint that the second covers, if they do


def select_keyframes(track: CameraTrack, usable: Mask, depth_m: Array, camera: CameraModel) -> Ints:
    """Select the nodes whose image shows some hull that the last keyframe's does not.

    Only these are compared with others, so that a vehicle at rest adds no work. A node is left out
    if it overlaps both the node before it and the last keyframe by more than MAX_OVERLAP. Nodes of
    unknown depth are always keyframes.

    Parameters
    ----------
    track
        Poses of the leading cameras.
    usable
        Nodes (n,) with an image.
    depth_m
        Depth (n,) of the scene, NaN where unknown.
    camera
        Model that footprints are computed with.
    """
    nodes = np.flatnonzero(usable)
    if len(nodes) < 2:
        return nodes
    step = footprint_overlap(track, nodes[:-1], nodes[1:], depth_m, camera, grid=FINE_GRID)
    kept = [int(nodes[0])]
    for node, close in zip(nodes[1:].tolist(), (step > MAX_OVERLAP).tolist(), strict=True):
        if close:
            ends = np.array([kept[-1]]), np.array([node])
            if footprint_overlap(track, *ends, depth_m, camera, grid=FINE_GRID)[0] > MAX_OVERLAP:
                continue
        kept.append(node)
    return np.array(kept, np.int64)


def propose_neighbours(
    track: CameraTrack, keyframes: Ints, depth_m: Array, camera: CameraModel, options: MatchOptions
) -> Proposal:
    """Propose each keyframe with the `sequential` following ones, to hold the path together.

    They are proposed even where the track predicts no overlap. keyframes: nodes, ascending.
    depth_m: (n,) of the scene by node, NaN where unknown.
    """
    first, second = _sequential(keyframes, options.sequential)
    order = np.lexsort((second, first))
    first, second = first[order], second[order]
    overlap = footprint_overlap(track, first, second, depth_m, camera)
    return Proposal(first=first, second=second, across=np.zeros(len(first), bool), overlap=overlap)


def propose_revisits(
    track: CameraTrack,
    keyframes: Ints,
    depth_m: Array,
    camera: CameraModel,
    options: MatchOptions,
    min_probability: float,
    compared: Ints,
) -> Revisits:
    """Find the pairs of keyframes that probably show the same hull, and were not compared yet.

    These are pairs between whose nodes the vehicle left the footprint and came back
    [KimEustice2009]. Neighbours, and keyframes of unknown depth, are left out. There may be none.

    Parameters
    ----------
    track
        Poses of the leading cameras, with the uncertainty of relative poses.
    keyframes
        The nodes to choose from, ascending.
    depth_m
        Depth (n,) of the scene by node, NaN where unknown.
    camera
        Model that footprints are computed with.
    options
        Gives how many following keyframes are neighbours (`sequential`), and min_overlap.
    min_probability
        Least probability that two footprints have min_overlap in common.
    compared
        Pairs (first * n + second) that were compared already.
    """
    first, second = _preselect_near(track, keyframes, depth_m, camera, options.sequential)
    overlap = footprint_overlap(track, first, second, depth_m, camera)
    among_keyframes = np.searchsorted(keyframes, first), np.searchsorted(keyframes, second)
    lowest = _lowest_between(
        track, keyframes, *among_keyframes, depth_m, camera, options.min_overlap
    )
    came_back = (lowest == 0) | (overlap > lowest + RETURN)
    came_back &= ~np.isin(first * len(track) + second, compared)
    first, second, overlap = first[came_back], second[came_back], overlap[came_back]
    probability, expected = expect_overlap(
        track, first, second, depth_m, camera, options.min_overlap
    )
    keep = probability >= min_probability
    return Revisits(
        proposal=Proposal(
            first=first, second=second, across=np.ones(len(first), bool), overlap=overlap
        ).take(keep),
        probability=probability[keep],
        expected_overlap=expected[keep],
    )


def choose_informative(
    first: Ints, second: Ints, probability: Array, gain: Array, least: float
) -> Ints:
    """Choose the pairs whose expected information gain is at least `least` nats.

    The others would cost a comparison and hardly improve the path. The pair with the largest
    expected gain is chosen first. The path is solved only after all of them are compared. So a pair
    whose nodes were chosen k - 1 times already counts as the k-th measurement of the same motion,
    which gains less than the first [docs/methods.md (59b)]. Returns rows of the pairs, ascending.
    There may be none.

    Parameters
    ----------
    first, second
        Nodes (m,).
    probability
        (m,) that each pair matches.
    gain
        (m,) information gain of the path if it does, nats.
    least
        Least expected gain, probability times gain, of a chosen pair, nats.
    """
    expected_gain = probability * gain
    rows = np.lexsort((second, first, -expected_gain))
    taken: dict[int, int] = {}
    chosen = []
    for row in rows[expected_gain[rows] >= least].tolist():
        a, b = int(first[row]), int(second[row])
        before = taken.get(a, 0) + taken.get(b, 0)
        if probability[row] * _gain_of_next(float(gain[row]), before) >= least:
            taken[a], taken[b] = taken.get(a, 0) + 1, taken.get(b, 0) + 1
            chosen.append(row)
    return np.sort(np.array(chosen, np.int64))


def _gain_of_next(gain: float, before: int) -> float:
    """Compute the information gain, nats, of one more measurement of a motion.

    gain: that of the first measurement. before: equal measurements that precede this one. A motion
    is taken as six numbers that are measured equally well. So each measurement gains 3 ln(v / w),
    where it reduces their variance from v to w.
    """
    ratio = math.expm1(min(gain, MOST_GAIN) / 3)  # of the variance known to that measured
    return 3 * math.log((1 + (before + 1) * ratio) / (1 + before * ratio))


def _sequential(nodes: Ints, reach: int) -> tuple[Ints, Ints]:
    """Pair each of the nodes (n,) with the `reach` following ones: first and second (m,)."""
    steps = range(1, min(reach, len(nodes) - 1) + 1)
    first = [nodes[:-k] for k in steps]
    second = [nodes[k:] for k in steps]
    none = np.zeros(0, np.int64)
    return np.concatenate([none, *first]), np.concatenate([none, *second])


def _preselect_near(
    track: CameraTrack, nodes: Ints, depth_m: Array, camera: CameraModel, reach: int
) -> tuple[Ints, Ints]:
    """Preselect pairs of nodes that may overlap, so that overlaps are computed of these alone.

    Their scenes' centres are within a footprint's diagonal and 3 sigma of the relative position,
    which count as at most three diagonals. Neighbours, at most `reach` keyframes apart, and nodes
    of unknown depth are left out.
    """
    known = np.flatnonzero(np.isfinite(depth_m[nodes]))
    none = np.zeros(0, np.int64)
    if len(known) < 2:
        return none, none
    at = nodes[known]
    middle = track.global_from_camera[at].apply(scene_middles(depth_m[at]))
    size = float(np.median(depth_m[at])) * np.hypot(
        camera.width / camera.fx, camera.height / camera.fy
    )
    # The relative sigma of two nodes is at most the sum of their sigmas relative to a third one.
    sigma_m = track.relative_sigma(at, np.full(len(at), at[len(at) // 2]))
    first, second = _within_reach(middle, size, 3 * sigma_m, 3 * size)
    apart = known[second] - known[first] > reach
    return at[first[apart]].astype(np.int64), at[second[apart]].astype(np.int64)


def _within_reach(
    points: Array, distance_m: float, margin_m: Array, most_margin_m: float
) -> tuple[Ints, Ints]:
    """Find pairs of points closer than a distance plus the margins of both, none of them twice.

    Parameters
    ----------
    points
        (n, 3) m.
    distance_m
        Allowed to every pair.
    margin_m
        (n,) of each point.
    most_margin_m
        Largest sum of both margins.

    Returns
    -------
    first, second
        (k,) with first < second, sorted.
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    parts = [np.zeros((0, 2), np.int64)]
    for start in range(0, len(points), BLOCK):
        rows = np.arange(start, min(start + BLOCK, len(points)))
        # Twice its own margin: each pair is found from the end with the larger one.
        found = tree.query_ball_point(
            points[rows], distance_m + np.minimum(2 * margin_m[rows], most_margin_m)
        )
        a = np.repeat(rows, [len(near) for near in found])
        b = np.concatenate([*found]).astype(np.int64)
        reach = distance_m + np.minimum(margin_m[a] + margin_m[b], most_margin_m)
        near = np.linalg.norm(points[a] - points[b], axis=1) <= reach
        # Of the two directions in which a pair may be found, that from the larger margin is kept.
        keep = near & ((margin_m[a] > margin_m[b]) | ((margin_m[a] == margin_m[b]) & (a < b)))
        parts.append(np.sort(np.column_stack([a, b])[keep], axis=1))
    pairs = np.concatenate(parts)
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return pairs[:, 0], pairs[:, 1]


def _lowest_between(
    track: CameraTrack,
    nodes: Ints,
    first: Ints,
    second: Ints,
    depth_m: Array,
    camera: CameraModel,
    least: float,
) -> Array:
    """Find the smallest overlap (m,) of the first node with the nodes between it and the second.

    It distinguishes a revisit, where the vehicle went away and came back, from one slow pass. 0
    once it fell below `least`: the vehicle has left. Nodes of unknown depth are ignored.

    Parameters
    ----------
    track, depth_m, camera
        As in `propose_revisits`, to compute overlaps.
    nodes
        The keyframes, in order.
    first, second
        Rows (m,) of the pairs' nodes among the keyframes.
    least
        Overlap below which the vehicle has left the footprint.
    """
    # One step along all nodes at a time: `running` is the smallest overlap of each node with its
    # followers so far, `inside` the nodes whose footprint the vehicle has not left yet.
    lowest, running = np.zeros(len(first)), np.ones(len(nodes))
    inside = np.flatnonzero(np.isfinite(depth_m[nodes]))
    for step in range(1, int((second - first).max(initial=0)) + 1):
        due = (second - first == step) & np.isin(first, inside)
        lowest[due] = running[first[due]]
        inside = inside[inside + step < len(nodes)]
        overlap = footprint_overlap(track, nodes[inside], nodes[inside + step], depth_m, camera)
        running[inside] = np.fmin(running[inside], overlap)
        inside = inside[~(overlap < least)]
        if len(inside) == 0:
            break
    return lowest
