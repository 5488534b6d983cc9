# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of one image: contrast levelled, OpenCV's SIFT, RootSIFT, colours, saliency.

An effect that moves a feature depending on its position in the image acts as a wrong lens:
hundredths of a pixel bend a path of 45 m by centimetres (docs/methods.md 4). So contrast is
levelled by a sliding window instead of tiles, relative to the local brightness, and features near
the border are dropped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Floats32, Ints, Mask, Pixels
from hullrecon.vision.features.descriptors import WIDTH, first_at_place, root_sift
from hullrecon.vision.features.scale_space import OCTAVE_LAYERS, describe_keypoints
from hullrecon.vision.options import FeatureOptions

# SIFT [Lowe2004]: OpenCV's defaults, but for half its contrast threshold
CONTRAST_THRESHOLD = 0.02
EDGE_THRESHOLD = 10.0  # largest ratio of a feature's two curvatures

# Grey levels of the levelled image: its mean, and one sigma of the local contrast.
MID_GREY, SPREAD = 128.0, 32.0
DARKEST = 16.0  # grey levels added to the local mean: in darker parts contrast is noise
# Least local contrast, relative to the local mean, that is raised to the full spread. A camera's
# noise is 1 %. With this limit plain paint gives fewer than ten features.
LEAST_CONTRAST = 0.05
# Least distance from the border in diameters of a feature. Nearer, features are displaced by up to
# 0.2 px, beyond not at all: SIFT's smoothing reaches 1.9 diameters.
CLEAR_SIZES = 2.0
# The same in sigmas of the levelling window. Nearer, features are displaced by up to 0.024 px,
# beyond by 0.001 px.
CLEAR_WINDOWS = 1.5

WORD_BITS = 8  # bits of a word for the saliency: planes that divide descriptor space
WORD_SEED = 20130629  # seed of these planes: any will do, but it must stay the same


@dataclass(frozen=True)
class Features:
    """The features of one image."""

    keypoints: Floats32  # (n, 4) u, v in raw pixels (first pixel's centre 0, 0), diameter, score
    descriptors: Pixels  # (n, 128) RootSIFT times 512
    color: Pixels  # (n, 3) RGB

    def __len__(self) -> int:
        return len(self.keypoints)

    @property
    def scored(self) -> Mask:
        """Features (n,) with a score. Those of another kind, which a study may add, have NaN."""
        return np.isfinite(self.keypoints[:, 3])

    @property
    def place(self) -> Ints:
        """Number (n,) of the feature that stands for all at one pixel."""
        return first_at_place(self.keypoints)


def no_features() -> Features:
    """Make the empty features of a missing image."""
    return Features(
        np.zeros((0, 4), np.float32), np.zeros((0, WIDTH), np.uint8), np.zeros((0, 3), np.uint8)
    )


def extract(image: Pixels, options: FeatureOptions) -> Features:
    """Find the features of an image (h, w) or (h, w, 3) RGB, ordered by v, then u, then scale.

    Those near the border are dropped, as it displaces them.
    """
    levelled, step = level_image(image, options)

    def clear(found: Floats32) -> Mask:
        window_px = options.level_window * image.shape[1]
        return is_clear_of_border(to_raw_pixels(found, step), image.shape, window_px)

    keypoints, descriptors = find_sift(levelled, options.max_features, clear)
    return add_colors(image, to_raw_pixels(keypoints, step), descriptors)


def level_image(image: Pixels, options: FeatureOptions) -> tuple[Pixels, Floats32]:
    """Shrink an image to grey levels of even contrast, in which features are found.

    Returns
    -------
    levelled
        The image (h, w) to find features in.
    step
        Raw pixels (2,) along u and v in one pixel of it.
    """
    import cv2

    # Threads would change nothing but the load: processes are the parallel level.
    cv2.setNumThreads(1)
    gray = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    small, step = _reduce(gray, options.reduction)
    return _level(small, options.level_window * small.shape[1]), step


def find_sift(
    levelled: Pixels, max_features: int, select: Callable[[Floats32], Mask] | None = None
) -> tuple[Floats32, Pixels]:
    """Find SIFT keypoints (n, 4) of a levelled image, in its pixels, with RootSIFT descriptors.

    The strongest max_features are taken, ordered by v, u, diameter and score. Of these only those
    that `select` chooses are described and returned, all if it is None.
    """
    import cv2

    sift = cv2.SIFT.create(
        nfeatures=max_features,
        nOctaveLayers=OCTAVE_LAYERS,
        contrastThreshold=CONTRAST_THRESHOLD,
        edgeThreshold=EDGE_THRESHOLD,
        enable_precise_upscale=True,  # else every keypoint is off by a quarter of a pixel
    )
    found = sift.detect(levelled, None)
    if not found:
        return np.zeros((0, 4), np.float32), np.zeros((0, WIDTH), np.uint8)
    # Column by column: a tuple for each keypoint takes six times as long
    table = np.column_stack(
        [
            cv2.KeyPoint.convert(found),
            [p.size for p in found],
            [p.response for p in found],
            [p.angle for p in found],
            [p.octave for p in found],
        ]
    )
    table = table[np.lexsort((table[:, 3], table[:, 2], table[:, 0], table[:, 1]))]
    if select is not None:
        table = table[select(table[:, :4].astype(np.float32))]
    descriptors = describe_keypoints(levelled, table[:, [0, 1, 2, 4]], table[:, 5].astype(int))
    return table[:, :4].astype(np.float32), root_sift(descriptors.astype(np.float32))


def to_raw_pixels(keypoints: Floats32, step: Floats32) -> Floats32:
    """Scale keypoints (n, 4), u, v, diameter and score, of the reduced image to raw pixels.

    step: raw pixels (2,) along u and v in one pixel of the reduced image.
    """
    out = keypoints.copy()
    # A pixel's centre has whole coordinates, so that its corner is half a pixel before it
    out[:, :2] = (out[:, :2] + np.float32(0.5)) * step - np.float32(0.5)
    out[:, 2] *= step.mean()
    return out


def is_clear_of_border(keypoints: Floats32, shape: tuple[int, ...], window_px: float) -> Mask:
    """Select keypoints (n, 4) that are far enough from the border not to be displaced by it.

    Near the border, filters work on a mirrored image, which shifts features.

    Parameters
    ----------
    keypoints
        (n, 4) u, v, diameter, score, in raw pixels.
    shape
        Shape (h, w, ...) of the raw image.
    window_px
        Sigma of the window that levelled the contrast, in raw pixels.
    """
    u, v = keypoints[:, 0], keypoints[:, 1]
    reach = np.maximum(
        np.float32(CLEAR_SIZES) * keypoints[:, 2], np.float32(CLEAR_WINDOWS * window_px)
    )
    height, width = shape[:2]
    return np.asarray(
        (u >= reach) & (v >= reach) & (u <= width - 1 - reach) & (v <= height - 1 - reach)
    )


def add_colors(image: Pixels, keypoints: Floats32, descriptors: Pixels) -> Features:
    """Join keypoints (n, 4) and descriptors to features, with the image's RGB at the keypoints.

    The nearest pixel's is taken. image: (h, w) or (h, w, 3). keypoints: u, v first, in its pixels.
    """
    column = np.clip(np.rint(keypoints[:, 0]).astype(np.int64), 0, image.shape[1] - 1)
    row = np.clip(np.rint(keypoints[:, 1]).astype(np.int64), 0, image.shape[0] - 1)
    color = image[row, column]
    if image.ndim == 2:
        return Features(keypoints, descriptors, np.repeat(color[:, None], 3, axis=1))
    return Features(keypoints, descriptors, np.ascontiguousarray(color))


def local_saliency(descriptors: NDArray[np.uint8]) -> float:
    """Rate how much there is to recognise in an image [KimEustice2013], [Ozog2016 2.3.3].

    It is the entropy of the words of its descriptors (n, 128) over the largest possible: 0 without
    descriptors or with all alike, 1 with all words equally frequent. The vocabulary is not learnt:
    the sides of eight random planes on which a descriptor lies make 256 words, so that the score
    depends on no other image.
    """
    if len(descriptors) == 0:
        return 0.0
    planes = (
        np.random.default_rng(WORD_SEED)
        .standard_normal((descriptors.shape[1], WORD_BITS))
        .astype(np.float32)
    )
    # Descriptors are positive: their common mean must not decide the side.
    planes -= planes.mean(axis=0)
    words = (descriptors.astype(np.float32) @ planes > 0) @ (1 << np.arange(WORD_BITS))
    share = np.bincount(words, minlength=1 << WORD_BITS) / len(descriptors)
    share = share[share > 0]
    return max(0.0, float(-(share * np.log2(share)).sum() / WORD_BITS))


def _level(gray: Floats32, window_px: float) -> Pixels:
    """Normalise the local contrast to the same spread everywhere, as bytes (h, w).

    The window (sigma window_px, in pixels of `gray`) slides with the pixel, so that a feature is
    found at the same point of the scene wherever it lies in the image. Contrast is taken relative
    to the local mean, which makes it independent of the brightness of the light. Equalising in
    separate tiles (CLAHE) moves features by 0.02 px with the period of the tiles, and by 0.12 px
    from image to image.
    """
    import cv2

    if window_px == 0:
        return np.asarray(np.rint(gray), np.uint8)
    mean = cv2.GaussianBlur(gray, (0, 0), window_px)
    contrast = (gray - mean) / (mean + np.float32(DARKEST))
    local = np.sqrt(
        cv2.GaussianBlur(contrast * contrast, (0, 0), window_px) + np.float32(LEAST_CONTRAST**2)
    )
    levelled = np.float32(MID_GREY) + np.float32(SPREAD) * contrast / local
    return np.asarray(np.clip(np.rint(levelled), 0, 255), np.uint8)


def _reduce(gray: Pixels, reduction: float) -> tuple[Floats32, Floats32]:
    """Shrink a gray image (h, w) by the factor `reduction`, averaging over areas to reduce noise.

    Returns the image, and the raw pixels (2,) along u and v in one pixel of it.
    """
    import cv2

    height, width = gray.shape
    size = (max(1, round(width / reduction)), max(1, round(height / reduction)))
    values = gray.astype(np.float32)
    if size == (width, height):
        return values, np.ones(2, np.float32)
    small = cv2.resize(values, size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32), np.array([width / size[0], height / size[1]], np.float32)
