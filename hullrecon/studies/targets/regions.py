# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Regions of interest in an image: where edges and hue agree [Aulinas2011 4.4.1, Fig. 4.21].

Each camera image is evened first. Features are SIFT [Lowe2004]: the source's SURF is not in the
free build of OpenCV.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from hullrecon.typing import Array, Floats32, Mask, Pixels

LAMP_PX = 45.0  # sigma of the light's pattern
EDGE_SIGMA_PX, EDGES = 1.5, (40.0, 90.0)  # Canny, grey levels a pixel
JOIN_PX, SPECK_PX = 11, 9  # edges nearer are one region; regions narrower are specks
HUE_SIGMA_PX = 3.0
HUE_AWAY_RAD = np.radians(30.0)  # from the image's mean hue
LEAST_AREA_PX = 400
RATIO = 0.8  # nearest to second nearest neighbour [Lowe2004]
WITHIN_PX = 3.0


@dataclass(frozen=True, kw_only=True)
class Regions:
    """Regions of interest with the pictures on the way, (h, w) each."""

    even: Pixels  # grey, light evened, normalised
    edges: Mask  # by Canny
    joined: Mask  # edges joined, specks dropped
    by_edges: Mask  # regions of these, filled
    hue: Array  # rad, -pi to pi
    away: Mask  # where the blurred hue leaves the mean hue
    by_hue: Mask  # regions of these
    region: Mask  # both


def even_out(image: Pixels) -> Pixels:
    """Make an image (h, w, 3) grey, take the light's pattern off and spread its contrast."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    even = grey / np.maximum(cv2.GaussianBlur(grey, (0, 0), LAMP_PX), 1.0)
    return np.asarray(np.clip(128 + 40 * (even - even.mean()) / even.std(), 0, 255), np.uint8)


def find_regions(image: Pixels) -> Regions:
    """Find the regions of an image (h, w, 3) that edges and hue both single out."""
    even = even_out(image)
    # Line 1: edges, joined where near, specks dropped.
    smooth = cv2.GaussianBlur(even, (0, 0), EDGE_SIGMA_PX)
    edges = cv2.Canny(smooth, *EDGES)
    joined = cv2.morphologyEx(edges, cv2.MORPH_CLOSE, _disc(JOIN_PX))
    joined = cv2.morphologyEx(joined, cv2.MORPH_OPEN, _disc(SPECK_PX))
    by_edges = _filled(joined)
    # Line 2: hue, blurred as a direction, away from its mean.
    hue = hue_of(image)
    toward = cv2.GaussianBlur(
        np.exp(1j * hue).view(float).reshape(*hue.shape, 2), (0, 0), HUE_SIGMA_PX
    )
    blurred = np.arctan2(toward[..., 1], toward[..., 0])
    mean = np.angle(np.exp(1j * blurred).mean())
    away = np.abs(np.angle(np.exp(1j * (blurred - mean)))) > HUE_AWAY_RAD
    by_hue = _filled(away.astype(np.uint8))
    return Regions(
        even=even,
        edges=edges > 0,
        joined=joined > 0,
        by_edges=by_edges,
        hue=hue,
        away=away,
        by_hue=by_hue,
        region=_filled((by_edges & by_hue).astype(np.uint8)),
    )


def hue_of(image: Pixels) -> Array:
    """Compute the hue (h, w) of an image (h, w, 3), rad: shading and highlights leave it alone."""
    red, green, blue = np.moveaxis(image.astype(float), -1, 0)
    return np.asarray(np.arctan2(np.sqrt(3) * (green - blue), 2 * red - green - blue))


def _disc(diameter_px: int) -> Pixels:
    """Make a disc as a structuring element of morphology."""
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter_px, diameter_px)))


def _filled(mask: Pixels) -> Mask:
    """Fill the regions of a mask and drop small ones."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    out = np.zeros(mask.shape, np.uint8)
    large = [line for line in outlines if cv2.contourArea(line) >= LEAST_AREA_PX]
    cv2.drawContours(out, large, -1, 1, cv2.FILLED)
    return np.asarray(out > 0)


@dataclass(frozen=True, kw_only=True)
class Matches:
    """Features of two images' regions, matched."""

    first: Array  # (n, 2) px
    second: Array  # (n, 2)
    inlier: Mask  # (n,) one similarity explains these


def match_regions(first: Pixels, second: Pixels, in_first: Mask, in_second: Mask) -> Matches:
    """Match SIFT features of two images (h, w), as of `even_out`, inside of their regions.

    A match must be clearly better than the next best. Inliers are those that one rotation, scale
    and shift of the image explains. in_first, in_second: the regions (h, w).
    """
    sift = cv2.SIFT.create(contrastThreshold=0.02)
    keys_a, words_a = sift.detectAndCompute(first, in_first.astype(np.uint8))
    keys_b, words_b = sift.detectAndCompute(second, in_second.astype(np.uint8))
    if words_a is None or words_b is None or len(keys_b) < 2:
        return Matches(first=np.empty((0, 2)), second=np.empty((0, 2)), inlier=np.zeros(0, bool))
    pairs = _nearest(words_a, words_b)
    a = np.array([keys_a[i].pt for i, _ in pairs]).reshape(-1, 2)
    b = np.array([keys_b[j].pt for _, j in pairs]).reshape(-1, 2)
    inlier = np.zeros(len(pairs), bool)
    if len(pairs) >= 3:
        _, mask = cv2.estimateAffinePartial2D(a, b, ransacReprojThreshold=WITHIN_PX)
        inlier = mask[:, 0] > 0
    return Matches(first=a, second=b, inlier=inlier)


def _nearest(a: Floats32, b: Floats32) -> list[tuple[int, int]]:
    """Pair descriptors of a (n, 128) with the nearest of b, where the second nearest is far off."""
    found = cv2.BFMatcher(cv2.NORM_L2).knnMatch(a, b, k=2)
    return [
        (near.queryIdx, near.trainIdx)
        for near, far in found
        if near.distance < RATIO * far.distance
    ]
