# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Harris corners with Zernike moments beside SIFT features [KimEustice2009 III-A].

Corners [HarrisStephens1988] follow the SIFT features of an image. They have no score (NaN), and
descriptors that are zero from the last moment on, by which they are told apart. Corners are matched
with corners and SIFT features with SIFT features, and corners are at most a share of the matches.
The share is steered as in the source, by the distance that the Zernike vectors of two corners may
have: here it is chosen for each set of matches so that the share is reached.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import factorial

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Array, Floats32, Ints, Mask, Pixels
from hullrecon.vision.features.descriptors import (
    WIDTH,
    Described,
    FeatureSet,
    Putative,
    match_descriptors,
    root_sift,
)
from hullrecon.vision.features.extraction import (
    Features,
    add_colors,
    find_sift,
    is_clear_of_border,
    level_image,
    to_raw_pixels,
)
from hullrecon.vision.options import FeatureOptions

ORDER = 12  # largest n: 48 moments without the mean
RINGS, ANGLES = 8, 48  # exact from ORDER / 2 + 1 rings and 2 ORDER + 1 angles


@cache
def disc_points() -> Array:
    """List the sample points (RINGS * ANGLES, 2) of the unit disc, ring by ring from inside."""
    radius, angle = np.sqrt(_rings()[0])[:, None], _angles()
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).reshape(-1, 2)


@cache
def orders() -> Ints:
    """List n and m (k, 2) of the moments: n from 1 to ORDER, m >= 0 of the same parity.

    The mean (0, 0) is not among them.
    """
    return np.array([(n, m) for n in range(1, ORDER + 1) for m in range(n % 2, n + 1, 2)], np.int64)


@cache
def basis() -> NDArray[np.complex128]:
    """Evaluate the functions V_nm (k, RINGS * ANGLES) at the sample points.

    The integral of |V|^2 over the disc is 1.
    """
    radius, turn = np.sqrt(_rings()[0]), np.exp(1j * _angles())
    rows = [
        np.sqrt((n + 1) / np.pi) * np.outer(radial(n, m, radius), turn**m)
        for n, m in orders().tolist()
    ]
    return np.array(rows).reshape(len(rows), -1)


@cache
def weights() -> Array:
    """Weight the sample points (RINGS * ANGLES,) by the area for which each stands."""
    return np.repeat(_rings()[1] * np.pi / ANGLES, ANGLES)


def radial(n: int, m: int, radius: Array) -> Array:
    """Evaluate Zernike's radial polynomial R_nm at each radius, 0 to 1."""
    half, less = (n + m) // 2, (n - m) // 2
    terms = [
        (-1) ** k
        * factorial(n - k)
        / (factorial(k) * factorial(half - k) * factorial(less - k))
        * radius ** (n - 2 * k)
        for k in range(less + 1)
    ]
    return np.asarray(np.sum(terms, axis=0), np.float64)


def zernike_moments(patches: Floats32) -> NDArray[np.complex128]:
    """Compute the moments A_nm (p, k) of patches (p, RINGS * ANGLES) sampled at the disc's points.

    A patch turned by an angle has the same moments times exp(-i m angle): their magnitudes stay.
    """
    return np.asarray(patches.astype(np.float64) @ (weights() * basis().conj()).T)


def zernike_magnitudes(patches: Floats32) -> Floats32:
    """Compute the magnitudes (p, k) of the moments. Those of m > 0 stand for -m too."""
    twice = np.where(orders()[:, 1] > 0, np.sqrt(2.0), 1.0)
    return np.asarray(np.abs(zernike_moments(patches)) * twice, np.float32)


def _rings() -> tuple[Array, Array]:
    """Compute squared radii of the rings and their weights (RINGS,), which sum to 1.

    They are the nodes of Gauss-Legendre quadrature over the squared radius.
    """
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    return np.asarray(0.5 * (node + 1), np.float64), np.asarray(0.5 * weight, np.float64)


def _angles() -> Array:
    """List the angles (ANGLES,) rad of the sample points on a ring."""
    return np.asarray(np.arange(ANGLES) * (2 * np.pi / ANGLES), np.float64)


CORNERS = 0.5  # of features.max_features: as many corners at most
RADIUS_PX = 10.0  # of a patch, in the reduced image
SMOOTHING_PX = 1.0  # of a patch before it is sampled at a spacing of about a pixel
HARRIS_K = 0.04
BLOCK_PX = 5  # over which gradients are summed
# Least response over the image's largest. It grows with the fourth power of contrast.
QUALITY = 1e-3
# From stronger corners and from SIFT features, at least: a place is not measured twice.
APART_PX = 1


@dataclass(frozen=True)
class MatchWithCorners:
    """Matches SIFT features and corners, each among themselves. Picklable."""

    share: float  # of the matches that may be corners, 0 to 0.5

    def __call__(
        self, first: Described, second: Described, allowed: tuple[Ints, Ints] | None
    ) -> Putative:
        """Match SIFT features and corners, each among themselves, as `match_descriptors` does.

        All matches of SIFT features are kept. Of the corners' matches only those of smallest
        distance are, so that they are at most `share` of all. allowed: features of the first and of
        the second image that may match, all pairs if None.
        """
        corner = is_corner(first.descriptor), is_corner(second.descriptor)
        if not corner[0].any() or not corner[1].any():
            return _match_kind(first, second, allowed, ~corner[0], ~corner[1])
        sift = _match_kind(first, second, allowed, ~corner[0], ~corner[1])
        corners = _match_kind(first, second, allowed, *corner)
        room = int(self.share / (1 - self.share) * len(sift) + 1e-9)
        alike = corners.take(np.sort(np.argsort(corners.distance, kind="stable")[:room]))
        return Putative(
            first=np.concatenate([sift.first, alike.first]),
            second=np.concatenate([sift.second, alike.second]),
            distance=np.concatenate([sift.distance, alike.distance]),
        )


def is_corner(descriptor: Floats32 | Pixels) -> Mask:
    """Tell corners from SIFT features by their descriptors (n, 128)."""
    return np.asarray(~descriptor[:, len(orders()) :].any(axis=1))


def _match_kind(
    first: Described,
    second: Described,
    allowed: tuple[Ints, Ints] | None,
    of_first: Mask,
    of_second: Mask,
) -> Putative:
    """Match the features of one kind, of_first (n,) and of_second (m,), among the allowed pairs."""
    if allowed is not None:
        like = of_first[allowed[0]] & of_second[allowed[1]]
        return match_descriptors(first, second, (allowed[0][like], allowed[1][like]))
    here = FeatureSet(descriptor=first.descriptor[of_first], place=first.place[of_first])
    there = FeatureSet(descriptor=second.descriptor[of_second], place=second.place[of_second])
    return match_descriptors(here, there, None)


def extract_with_corners(image: Pixels, options: FeatureOptions) -> Features:
    """Find the features of an image as `extract`, with corners behind the SIFT features.

    There are none where SIFT finds nothing.
    """
    levelled, step = level_image(image, options)
    found, descriptors = find_sift(levelled, options.max_features)
    if not len(found):
        return add_colors(image, found, descriptors)
    keypoints = to_raw_pixels(found, step)
    clear = is_clear_of_border(keypoints, image.shape, options.level_window * image.shape[1])
    place, _ = find_corners(levelled, found[:, :2], int(CORNERS * options.max_features))
    table = np.column_stack(
        [place, np.full(len(place), 2 * RADIUS_PX), np.full(len(place), np.nan)]
    )
    corners = to_raw_pixels(table.astype(np.float32), step)
    return add_colors(
        image,
        np.concatenate([keypoints[clear], corners]),
        np.concatenate([descriptors[clear], describe_corners(levelled, place)]),
    )


def find_corners(image: Pixels, sift: Floats32, most: int) -> tuple[Floats32, Floats32]:
    """Find the strongest corners, at most that many, sorted by v, then u.

    A corner whose patch would leave the image is left out. Places are interpolated by a parabola
    along either axis.

    Parameters
    ----------
    image
        Levelled (h, w).
    sift
        Places (k, 2) of its SIFT features, which no corner repeats.

    Returns
    -------
    place, response
        (n, 2) u, v and Harris responses (n,).
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
    """Find where (n,) a parabola through values at -1, 0 and 1 is largest, in -1 to 1.

    The middle value is the largest. Where all three are equal, it is 0.
    """
    bend = before - 2 * at + after
    return np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1), 0).astype(
        np.float32
    )


def describe_corners(image: Pixels, place: Floats32) -> Pixels:
    """Describe the patches around places (n, 2) of an image (h, w) by bytes (n, 128).

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
    """Sample the smoothed image (n, samples) at the disc's points around each place (n, 2)."""
    import cv2

    smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), SMOOTHING_PX)
    at: Array = place[:, None, :] + RADIUS_PX * disc_points()
    u, v = (np.ascontiguousarray(at[..., k], np.float32) for k in range(2))
    return np.asarray(cv2.remap(smooth, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
