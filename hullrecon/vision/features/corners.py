# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Harris corners [HarrisStephens1988], each described by Zernike moments of the patch around it
[KimEustice2009 III-A].
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array, Floats32, Pixels
from hullrecon.vision.features.descriptors import WIDTH, root_sift
from hullrecon.vision.features.zernike import disc_points, zernike_magnitudes

RADIUS_PX = 10.0  # of the patch, in the reduced image
SMOOTHING_PX = 1.0  # of the patch before it is sampled at a spacing of about a pixel
HARRIS_K = 0.04
BLOCK_PX = 5  # over which gradients are summed
# least response over the image's largest; it grows with the fourth power of contrast
QUALITY = 1e-3
# at least, from stronger corners and from SIFT features: what one says already is not said twice
APART_PX = 1


def find_corners(image: Pixels, sift: Floats32, most: int) -> tuple[Floats32, Floats32]:
    """Return places (n, 2) u, v and Harris responses (n,) of at most that many corners, the
    strongest, by v, then u.

    image (h, w): levelled; sift (k, 2): places of its SIFT features, which no corner repeats. A
    corner whose patch would leave the image is left out. Places are those of the response's largest
    value by a parabola along either axis.
    """
    import cv2
    from scipy.spatial import cKDTree

    response = np.asarray(cv2.cornerHarris(image, BLOCK_PX, 3, HARRIS_K))
    window = np.ones((2 * APART_PX + 1, 2 * APART_PX + 1), np.uint8)
    peak = (response >= cv2.dilate(response, window)) & (response > QUALITY * response.max())
    margin = int(RADIUS_PX) + 2
    v, u = (places + margin for places in np.nonzero(peak[margin:-margin, margin:-margin]))
    height = response[v, u]
    across = _vertex(response[v, u - 1], height, response[v, u + 1])
    down = _vertex(response[v - 1, u], height, response[v + 1, u])
    place = np.column_stack([u + across, v + down]).astype(np.float32)
    new = (
        np.flatnonzero(cKDTree(sift).query(place)[0] > APART_PX)
        if len(sift) and len(place)
        else np.arange(len(place))
    )
    kept = np.sort(new[np.argsort(-height[new], kind="stable")[:most]])
    return place[kept], height[kept]


def _vertex(before: Floats32, at: Floats32, after: Floats32) -> Floats32:
    """Return where a parabola through values at -1, 0 and 1 is largest, given that the middle one
    is not exceeded.
    """
    bend = before - 2 * at + after
    return np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1), 0).astype(
        np.float32
    )


def describe_corners(image: Pixels, place: Floats32) -> Pixels:
    """Return descriptors (n, 128) uint8 of the patches around places (n, 2) of an image (h, w).

    They are the magnitudes of the Zernike moments, which do not change where the patch is turned,
    filled up with zeros. They have the form of RootSIFT, unit vectors times 512, so that both kinds
    are stored and compared alike (never with each other).
    """
    out = np.zeros((len(place), WIDTH), np.float32)
    if len(place):
        magnitudes = zernike_magnitudes(sample_patches(image, place))
        out[:, : magnitudes.shape[1]] = magnitudes
    return root_sift(out)


def sample_patches(image: Pixels, place: Floats32) -> Floats32:
    """Return the image (n, samples) at the disc's points around each place (n, 2), smoothed."""
    import cv2

    smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), SMOOTHING_PX)
    at: Array = place[:, None, :] + RADIUS_PX * disc_points()
    u, v = (np.ascontiguousarray(at[..., k], np.float32) for k in range(2))
    return np.asarray(cv2.remap(smooth, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
