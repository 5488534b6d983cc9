# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Predict the overlap of two images on a path whose poses are uncertain."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri  # not scipy.stats, which takes a quarter of a second to load

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.footprints import GRID, ideal_in_target, image_limits, share_within

QUANTILES = 6  # of a relative position along each axis, by which its distribution is sampled
BLOCK = 1000  # pairs whose quantiles are in memory at a time
COVARIANCE_BLOCK = 60_000  # pairs whose covariances are computed at a time, each by factoring anew
REFERENCE_M = 2.0  # side of the cubes in which a node's sigmas are taken relative to one of them
SETTLED_MARGIN = 1.01  # on bounds of sigmas, for their rounding


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
    others, and the share is computed at each.

    Parameters
    ----------
    track
        Poses of the leading cameras, with the uncertainty of relative poses.
    first, second
        Nodes (m,).
    depth_m
        Depth (n,) of the scene by node, NaN where unknown.
    camera
        Model that footprints are computed with.
    min_overlap
        Least share that counts.

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
        unsettled = ~_is_settled(track, source, target, depth, camera)
        covariance[unsettled] = scene_in_target(
            track, source[unsettled], target[unsettled], depth[unsettled]
        )[1]
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
    by_motion = _point_by_motion(relative, scene_middles(depth))
    covariance = track.errors.relative_covariance(source, target)
    return relative, by_motion @ covariance @ by_motion.swapaxes(1, 2)


def scene_middles(depth: Array) -> Array:
    """Place the middles (m, 3) of scenes at depths (m,) in their cameras."""
    return np.stack([0 * depth, 0 * depth, depth], axis=1)


def _point_by_motion(relative: Array, point: Array) -> Array:
    """Derive points (m, 3), moved by target_from_source (m, 4, 4), by that motion: (m, 3, 6).

    The columns are by its translation, then its rotation perturbed on the right, as in Motion.
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
    scene = scene_middles(depth)
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
    low, high = image_limits(camera)
    return np.asarray(SETTLED_MARGIN * farthest < 0.5 * (high - low).min() / GRID)


def _quantiles() -> Array:
    """Compute the middles (QUANTILES,) of equally probable parts of a standard normal."""
    return np.asarray(ndtri((np.arange(QUANTILES) + 0.5) / QUANTILES))


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
    image = ideal_in_target(relative, depth, camera, GRID)
    low, high = image_limits(camera)
    out = np.repeat(share_within(image, low, high)[:, None], len(drawn), axis=1)
    uncertain = np.flatnonzero((np.abs(shift) > 0.5 * (high - low) / GRID).any(axis=(1, 2)))
    out[uncertain] = share_within(image[uncertain, None] + shift[uncertain, :, None], low, high)
    return out
