# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Overlap of two images by their footprints: what each shows of the scene that the other shows."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.threads import in_threads
from hullrecon.typing import Array, Ints
from hullrecon.vision.pairs.camera_track import CameraTrack

GRID = 8  # cells of a footprint along each side
BLOCKS_AT_A_TIME = 2  # of footprints, in threads
GRID_POINTS = 250_000  # of footprints, in memory at a time: few pairs have several blocks too


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
    the smaller one of the two. NaN where the depth is unknown. first, second: (m,) nodes. depth_m:
    (n,) by node. grid: points of a footprint along each side.
    """
    out, block = np.zeros(len(first)), max(1, GRID_POINTS // grid**2)

    def fill(start: int) -> None:
        """Compute the overlap of a block of pairs."""
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
    image = ideal_in_target(track.relative_poses(source, target), depth_m[source], camera, grid)
    share = share_within(image, *image_limits(camera))
    return np.asarray(np.where(np.isfinite(depth_m[source]), share, np.nan))


def ideal_in_target(relative: Array, depth: Array, camera: CameraModel, grid: int) -> Array:
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


def share_within(image: Array, low: Array, high: Array) -> Array:
    """Compute the share of points (..., n, 2) between two corners (2,) of the image."""
    x, y = image[..., 0], image[..., 1]
    inside = (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1])
    return np.asarray(inside.mean(axis=-1))


def image_limits(camera: CameraModel) -> tuple[Array, Array]:
    """Compute the ideal coordinates (2,) of an image's first and last corner."""
    low, high = camera.undistort([[-0.5, -0.5], [camera.width - 0.5, camera.height - 0.5]])
    return low, high
