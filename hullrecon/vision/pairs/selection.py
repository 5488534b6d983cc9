# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Select the nodes to be compared: neighbours, and nodes of other legs that saw the same hull."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri  # not scipy.stats, which takes a quarter of a second to load

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.threads import in_threads
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.camera_track import CameraTrack

MAX_OVERLAP = 0.98  # with the last keyframe: a node that overlaps it by more is no keyframe
# Rise of the overlap above the smallest one in between that shows that the vehicle came back, and
# did not just move slowly
RETURN = 0.2
GRID = 8  # cells of a footprint along each side
FINE_GRID = 32  # the same for keyframes, where small steps matter
QUANTILES = 6  # of a relative position along each axis, by which its distribution is sampled
BLOCK = 1000  # pairs whose quantiles are in memory at a time
BLOCKS_AT_A_TIME = 2  # of footprints, in threads
COVARIANCE_BLOCK = 60_000  # pairs whose covariances are computed at a time, each by factoring anew
REFERENCE_M = 2.0  # side of the cubes in which a node's sigmas are taken relative to one of them
SETTLED_MARGIN = 1.01  # on bounds of sigmas, for their rounding
GRID_POINTS = 1_000_000  # of footprints, in memory at a time
MOST_GAIN = 1e3  # nats; a link with more would determine a motion that is as good as unknown


@dataclass(frozen=True, kw_only=True)
class Proposal:
    """Pairs of nodes to be compared, sorted by (first, second)."""

    first: Ints  # (m,) nodes
    second: Ints  # (m,) > first
    across: Mask  # (m,) nodes of two legs, not neighbours
    overlap: Array  # (m,) of the predicted footprints, NaN where no depth is known

    def __len__(self) -> int:
        return len(self.first)

    def take(self, rows: Ints | Mask) -> Proposal:
        """Select some of the pairs."""
        return Proposal(
            first=self.first[rows],
            second=self.second[rows],
            across=self.across[rows],
            overlap=self.overlap[rows],
        )


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

    They are proposed even where the track predicts no overlap.
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

    Only pairs between whose nodes the vehicle left the footprint and came back [KimEustice2009].
    Neighbours, and keyframes of unknown depth, are left out. There may be no pair.

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
    first, second = _near(track, keyframes, depth_m, camera, options.sequential)
    overlap = footprint_overlap(track, first, second, depth_m, camera)
    ranks = np.searchsorted(keyframes, first), np.searchsorted(keyframes, second)
    lowest = _lowest_between(track, keyframes, *ranks, depth_m, camera, options.min_overlap)
    came_back = (lowest == 0) | (overlap > lowest + RETURN)
    came_back &= ~np.isin(first * len(track) + second, compared)
    first, second, overlap = first[came_back], second[came_back], overlap[came_back]
    probability, expected = expect_overlap(
        track, first, second, depth_m, camera, options.min_overlap
    )
    keep = probability >= min_probability
    return Revisits(
        proposal=Proposal(
            first=first[keep],
            second=second[keep],
            across=np.ones(int(keep.sum()), bool),
            overlap=overlap[keep],
        ),
        probability=probability[keep],
        expected_overlap=expected[keep],
    )


def choose_informative(
    first: Ints, second: Ints, probability: Array, gain: Array, least: float
) -> Ints:
    """Choose the pairs whose expected information gain is at least `least` nats.

    The others would cost a comparison and hardly improve the path. Greedy, the largest expected
    gain first. The path is solved only after all of them are compared. So a pair whose nodes were
    chosen k - 1 times already counts as the k-th measurement of the same motion, which gains less
    than the first [docs/methods.md (59b)]. Returns rows of the pairs, ascending. There may be none.

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
    worth = probability * gain
    rows = np.lexsort((second, first, -worth))
    taken: dict[int, int] = {}
    chosen = []
    for row in rows[worth[rows] >= least].tolist():
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


def expect_overlap(
    track: CameraTrack,
    first: Ints,
    second: Ints,
    depth_m: Array,
    camera: CameraModel,
    min_overlap: float,
) -> tuple[Array, Array]:
    """Predict the share of the first footprint that the second covers, on an uncertain path.

    The scene is moved to quantiles of its position in the second camera, each as probable as the
    others, and the share is computed at each. Parameters are those of `propose_revisits`. first,
    second: (m,) nodes.

    Returns
    -------
    probability
        (m,) that the share is at least min_overlap. 0 where the depth is unknown.
    expected
        (m,) mean of those shares that are at least min_overlap. 0 where none is.
    """
    probability, expected = np.zeros(len(first)), np.zeros(len(first))
    for start in range(0, len(first), COVARIANCE_BLOCK):
        source, target = (nodes[start : start + COVARIANCE_BLOCK] for nodes in (first, second))
        depth = np.nan_to_num(depth_m[source], nan=1.0)
        relative = track.relative_poses(source, target)
        # A pair known well enough needs no covariance of its own. With zeros, all its quantiles are
        # at the mean.
        covariance = np.zeros((len(source), 3, 3))
        rest = ~_is_settled(track, source, target, depth, camera)
        covariance[rest] = scene_in_target(track, source[rest], target[rest], depth[rest])[1]
        for k in range(0, len(source), BLOCK):
            rows = slice(k, k + BLOCK)
            share = _shares_at_quantiles(relative[rows], covariance[rows], depth[rows], camera)
            enough = share >= min_overlap
            out = slice(start + k, start + k + len(share))
            probability[out] = enough.mean(axis=1)
            expected[out] = (share * enough).sum(axis=1) / np.maximum(enough.sum(axis=1), 1)
    return np.where(np.isfinite(depth_m[first]), probability, 0.0), expected


def scene_in_target(
    track: CameraTrack, source: Ints, target: Ints, depth: Array
) -> tuple[Array, Array]:
    """Compute target_from_source (m, 4, 4), and how uncertainly the target sees the source's scene.

    The covariance (m, 3, 3), m^2, is that of the scene's centre in the target camera
    (docs/methods.md (59)). The centre is the point on the source's optical axis at `depth` (m,).
    """
    relative = track.relative_poses(source, target)
    by_motion = _point_by_motion(relative, _middle(depth))
    covariance = track.errors.relative_covariance(source, target)
    return relative, by_motion @ covariance @ by_motion.swapaxes(1, 2)


def _middle(depth: Array) -> Array:
    """Place the middles (m, 3) of scenes at depths (m,) in their cameras."""
    return np.stack([0 * depth, 0 * depth, depth], axis=1)


def _point_by_motion(relative: Array, point: Array) -> Array:
    """Derive points (m, 3), moved by target_from_source (m, 4, 4), by that motion: (m, 3, 6).

    By its translation, then its rotation perturbed on the right, as in Motion.
    """
    unit = np.broadcast_to(np.eye(3), (len(point), 3, 3))
    return np.concatenate([unit, -relative[:, :3, :3] @ cross_matrix(point)], axis=2)


def _is_settled(
    track: CameraTrack, source: Ints, target: Ints, depth: Array, camera: CameraModel
) -> Mask:
    """Mark pairs (m,) known so well that the overlap is the same at all quantiles.

    It spares the covariance of each such pair. Upper bounds of the sigmas decide. The error of two
    nodes relative to each other is the difference of their errors relative to a third node, so its
    sigma is at most the sum of theirs. One node in each cube of the space is the third for the
    sources in it: the covariances of few nodes with many cost far less than those of all pairs.

    Parameters
    ----------
    track
        Poses of the leading cameras, with the uncertainty of relative poses.
    source, target
        Nodes (m,).
    depth
        Depth (m,) of the sources' scenes, m.
    camera
        Model of both cameras.
    """
    # The third node of each source, and the covariances of both ends relative to it.
    nodes, n = np.unique(np.concatenate([source, target])), len(track)
    cube = np.floor(track.global_from_camera.translation[nodes] / REFERENCE_M)
    _, first, number = np.unique(cube, axis=0, return_index=True, return_inverse=True)
    third = np.zeros(n, np.int64)
    third[nodes] = nodes[first][number.reshape(-1)]
    key = np.unique(np.concatenate([end * n + third[source] for end in (source, target)]))
    covariance = track.errors.relative_covariance(key // n, key % n)
    # The scene's middle in both cameras, and the bound (m,) of its sigma: each end adds its own.
    scene = _middle(depth)
    in_target = track.relative_poses(source, target)
    seen = np.einsum("mij,mj->mi", in_target[:, :3, :3], scene) + in_target[:, :3, 3]
    sigma_m = np.zeros(len(source))
    for end, point in ((source, scene), (target, seen)):
        row = np.searchsorted(key, end * n + third[source])
        by_motion = _point_by_motion(track.relative_poses(end, third[source]), point)
        variance = np.sum((by_motion @ covariance[row]) * by_motion, axis=(1, 2))
        sigma_m += np.sqrt(np.maximum(variance, 0.0))
    # Ideal coordinates by which the farthest quantile may move the scene: less than half a cell of
    # the grid changes no share.
    farthest = np.hypot(*np.repeat(_quantiles().max(), 2)) * sigma_m / depth
    low, high = _image_limits(camera)
    return np.asarray(SETTLED_MARGIN * farthest < 0.5 * (high - low).min() / GRID)


def _quantiles() -> Array:
    """Compute the middles (QUANTILES,) of equally probable parts of a standard normal."""
    return np.asarray(ndtri((np.arange(QUANTILES) + 0.5) / QUANTILES))


def _image_limits(camera: CameraModel) -> tuple[Array, Array]:
    """Compute the ideal coordinates (2,) of an image's first and last corner."""
    low, high = camera.undistort([[-0.5, -0.5], [camera.width - 0.5, camera.height - 0.5]])
    return low, high


def _shares_at_quantiles(
    relative: Array, covariance: Array, depth: Array, camera: CameraModel
) -> Array:
    """Compute the shares (m, q) of the source footprints that the targets see at q quantiles.

    The quantiles are of the scene's position across the target camera's axis. Where none is half a
    cell of the grid from the mean position, the share at the mean is taken for all.

    Parameters
    ----------
    relative
        target_from_source (m, 4, 4).
    covariance
        (m, 3, 3) of the scene's centre in the target camera.
    depth
        (m,) of the source's scene, m.
    camera
        Model of both cameras.
    """
    # Square root of the covariance across the axis: it turns quantiles of a standard normal into
    # shifts of the scene, over its depth in ideal coordinates.
    values, vectors = np.linalg.eigh(covariance[:, :2, :2])
    root = vectors * np.sqrt(np.maximum(values, 0))[:, None]
    drawn = np.stack(np.meshgrid(_quantiles(), _quantiles()), axis=-1).reshape(-1, 2)
    shift = np.einsum("mij,qj->mqi", root, drawn) / depth[:, None, None]
    image = _ideal_in_target(relative, depth, camera, GRID)
    low, high = _image_limits(camera)
    out = np.repeat(_share_within(image, low, high)[:, None], len(drawn), axis=1)
    uncertain = np.flatnonzero((np.abs(shift) > 0.5 * (high - low) / GRID).any(axis=(1, 2)))
    out[uncertain] = _share_within(image[uncertain, None] + shift[uncertain, :, None], low, high)
    return out


def _share_within(image: Array, low: Array, high: Array) -> Array:
    """Compute the share of points (..., n, 2) between two corners (2,) of the image."""
    x, y = image[..., 0], image[..., 1]
    inside = (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1])
    return np.asarray(inside.mean(axis=-1))


def _ideal_in_target(relative: Array, depth: Array, camera: CameraModel, grid: int) -> Array:
    """Transfer a grid of points of each source image to the target camera.

    The scene is taken as a plane across the source's axis. relative: target_from_source (m, 4, 4).
    depth: (m,) of that plane, m. grid: points along each side of the image. Returns ideal
    coordinates (m, grid^2, 2), infinite behind the target, so that no image contains them.
    """
    middle = (np.arange(grid) + 0.5) / grid
    u, v = np.meshgrid(middle * camera.width - 0.5, middle * camera.height - 0.5)
    rays = np.hstack([camera.undistort(np.stack([u.ravel(), v.ravel()], 1)), np.ones((grid**2, 1))])
    points = rays[None] * depth[:, None, None]
    seen = points @ relative[:, :3, :3].swapaxes(1, 2) + relative[:, None, :3, 3]
    ahead = seen[..., 2] > 0.05  # m in front of the target
    depth_there = np.where(ahead, seen[..., 2], 1.0)[..., None]
    return np.asarray(np.where(ahead[..., None], seen[..., :2] / depth_there, np.inf))


def footprint_overlap(
    track: CameraTrack,
    first: Ints,
    second: Ints,
    depth_m: Array,
    camera: CameraModel,
    grid: int = GRID,
) -> Array:
    """Compute the overlap (m,) of image pairs by the footprints that the track predicts.

    The track is taken as exact. The overlap is the share of a footprint that the other image sees,
    the smaller of both ways. NaN where the depth is unknown. first, second: (m,) nodes. depth_m:
    (n,) by node. grid: points of a footprint along each side.
    """
    out, block = np.zeros(len(first)), max(1, GRID_POINTS // grid**2)

    def fill(start: int) -> None:
        a, b = (nodes[start : start + block] for nodes in (first, second))
        both = (_share(track, *ends, depth_m, camera, grid) for ends in ((a, b), (b, a)))
        out[start : start + block] = np.minimum(*both)

    for _ in in_threads(fill, range(0, len(first), block), most=BLOCKS_AT_A_TIME):
        pass
    return out


def _share(
    track: CameraTrack, source: Ints, target: Ints, depth_m: Array, camera: CameraModel, grid: int
) -> Array:
    """Compute the share (m,) of each source's footprint that its target sees, NaN without depth."""
    image = _ideal_in_target(track.relative_poses(source, target), depth_m[source], camera, grid)
    share = _share_within(image, *_image_limits(camera))
    return np.asarray(np.where(np.isfinite(depth_m[source]), share, np.nan))


def _sequential(nodes: Ints, reach: int) -> tuple[Ints, Ints]:
    """Pair each node with the `reach` following ones."""
    steps = range(1, min(reach, len(nodes) - 1) + 1)
    first = [nodes[:-k] for k in steps]
    second = [nodes[k:] for k in steps]
    none = np.zeros(0, np.int64)
    return np.concatenate([none, *first]), np.concatenate([none, *second])


def _near(
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
    middle = track.global_from_camera[at].apply(
        np.stack([0 * depth_m[at], 0 * depth_m[at], depth_m[at]], axis=1)
    )
    size = float(np.median(depth_m[at])) * np.hypot(
        camera.width / camera.fx, camera.height / camera.fy
    )
    # The relative sigma of two nodes is at most the sum of their sigmas relative to a third one.
    sigma_m = track.relative_sigma(at, np.full(len(at), at[len(at) // 2]))
    first, second = _within_reach(middle, size, 3 * sigma_m, 3 * size)
    apart = known[second] - known[first] > reach
    return at[first[apart]].astype(np.int64), at[second[apart]].astype(np.int64)


def _within_reach(middle: Array, size: float, more: Array, most: float) -> tuple[Ints, Ints]:
    """Find pairs of points closer than `size` plus the margins of both, none of them twice.

    Parameters
    ----------
    middle
        Points (n, 3).
    size
        Distance allowed to every pair, m.
    more
        Margin (n,) of each point, m.
    most
        Largest sum of both margins, m.

    Returns
    -------
    first, second
        (k,) with first < second, sorted.
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(middle)
    parts = [np.zeros((0, 2), np.int64)]
    for start in range(0, len(middle), BLOCK):
        rows = np.arange(start, min(start + BLOCK, len(middle)))
        # Twice its own margin: each pair is found from the end with the larger one.
        found = tree.query_ball_point(middle[rows], size + np.minimum(2 * more[rows], most))
        a = np.repeat(rows, [len(near) for near in found])
        b = np.concatenate([*found]).astype(np.int64)
        reach = size + np.minimum(more[a] + more[b], most)
        near = np.linalg.norm(middle[a] - middle[b], axis=1) <= reach
        # Of the two directions in which a pair may be found, that from the larger margin is kept.
        keep = near & ((more[a] > more[b]) | ((more[a] == more[b]) & (a < b)))
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

    It tells a revisit, where the vehicle went away and came back, from one slow pass. 0 once it
    fell below `least`: the vehicle has left. Nodes of unknown depth are ignored.

    Parameters
    ----------
    track, depth_m, camera
        As in `propose_revisits`, to compute overlaps.
    nodes
        The keyframes, in order.
    first, second
        Ranks (m,) of the pairs' nodes among them.
    least
        Overlap below which the vehicle has left the footprint.
    """
    # One step along all nodes at a time: `running` is the smallest overlap of each node with its
    # followers so far, `inside` the nodes whose footprint the vehicle has not left yet.
    lowest, running = np.zeros(len(first)), np.ones(len(nodes))
    inside = np.flatnonzero(np.isfinite(depth_m[nodes]))
    for step in range(1, int((second - first).max(initial=0)) + 1):
        asked = (second - first == step) & np.isin(first, inside)
        lowest[asked] = running[first[asked]]
        inside = inside[inside + step < len(nodes)]
        overlap = footprint_overlap(track, nodes[inside], nodes[inside + step], depth_m, camera)
        running[inside] = np.fmin(running[inside], overlap)
        inside = inside[~(overlap < least)]
        if len(inside) == 0:
            break
    return lowest
