# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of one image: contrast levelled, SIFT found by OpenCV, RootSIFT descriptors as bytes, colours.

What moves a feature depending on where in the image it lies acts as a wrong lens: hundredths of a pixel bend a path of 45 m by
centimetres (docs/methods.md 4). So the levelling knows no tiles, follows the light, and features are kept clear of the border.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from hullrecon.dive.config.schema import Positive, Section
from hullrecon.typing import Floats32, Mask, Pixels


class FeatureOptions(Section, frozen=True):
    """Section [features] of dive.toml."""

    level_window: Annotated[
        float,
        Meta(
            ge=0.0,
            le=1.0,
            description="ratio, of the image's width: sigma of the window that levels contrast; 0 leaves it as it is",
        ),
    ] = 0.025
    max_features: Annotated[int, Meta(ge=50, le=100_000, description="features of an image; the strongest are kept")] = 4000
    contrast_threshold: Annotated[
        Positive, Meta(description="ratio, smallest contrast of a feature (SIFT contrastThreshold)")
    ] = 0.02
    edge_threshold: Annotated[
        Positive, Meta(description="ratio, largest of a feature's two curvatures (SIFT edgeThreshold)")
    ] = 10.0
    octave_layers: Annotated[int, Meta(ge=1, le=8, description="scales in an octave (SIFT nOctaveLayers)")] = 3
    reduction: Annotated[
        float, Meta(ge=1.0, le=8.0, description="ratio, images are shrunk by this before SIFT doubles them")
    ] = 2.0


MID_GREY, SPREAD = 128.0, 32.0  # of a levelled image: its mean, and one sigma of contrast that stands out of the noise
DARKEST = 16.0  # grey levels, added to the local mean: below, contrast is noise
LEAST_CONTRAST = 0.05  # of the local mean; 1 % is a camera's noise, on plain paint fewer features than ten are found in it
CLEAR_SIZES = 2.0  # from the border, in diameters: nearer, up to 0.2 px of bias, beyond none (the smoothing reaches 1.9)


@dataclass(frozen=True)
class Features:
    """keypoints (n, 4) float32: u, v in raw pixels (centre of the first is 0, 0), scale (diameter in px), score;
    descriptors (n, 128) uint8; color (n, 3) uint8 RGB."""

    keypoints: Floats32
    descriptors: Pixels
    color: Pixels

    def __len__(self) -> int:
        return len(self.keypoints)


def no_features() -> Features:
    """Return the features of an image that is not there."""
    return Features(np.zeros((0, 4), np.float32), np.zeros((0, 128), np.uint8), np.zeros((0, 3), np.uint8))


def extract(image: Pixels, options: FeatureOptions) -> Features:
    """Return the features of an image (h, w) or (h, w, 3) RGB, in a fixed order: by v, then u, then scale."""
    import cv2

    cv2.setNumThreads(1)  # several threads would change nothing but the load; processes are the parallel level
    gray = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    sift = cv2.SIFT.create(
        nfeatures=options.max_features,
        nOctaveLayers=options.octave_layers,
        contrastThreshold=options.contrast_threshold,
        edgeThreshold=options.edge_threshold,
        enable_precise_upscale=True,  # else every keypoint is off by a quarter of a pixel
    )
    small, step = _reduce(gray, options.reduction)
    levelled = _level(small, options.level_window * small.shape[1])
    found, descriptors = sift.detectAndCompute(levelled, None)
    if not found:
        return no_features()
    table = np.array([(p.pt[0], p.pt[1], p.size, p.response) for p in found], np.float32)
    table[:, :2] = (table[:, :2] + np.float32(0.5)) * step - np.float32(0.5)
    table[:, 2] *= step.mean()
    clear = _is_clear_of_border(table, gray.shape)
    table, descriptors = table[clear], descriptors[clear]
    order = np.lexsort((table[:, 3], table[:, 2], table[:, 0], table[:, 1]))
    return Features(table[order], root_sift(descriptors[order]), _colors(image, table[order]))


def root_sift(descriptors: Floats32) -> Pixels:
    """Return the Hellinger form: square root of the L1-normalised vector (unit length), times 512, as bytes."""
    share = descriptors / np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-9)
    return np.asarray(np.minimum(np.rint(np.sqrt(share) * 512.0), 255), np.uint8)


def _level(gray: Floats32, window_px: float) -> Pixels:
    """Return the image (h, w) as bytes, its contrast to the local mean brought to one spread everywhere.

    The window slides with the pixel, so a feature is found at the same place of the scene wherever that lies in the image; the
    contrast to the mean, unlike the difference, is the same in any light. Tiles that are equalised apart (CLAHE) move features
    by 0.02 px in their rhythm, and by 0.12 px from image to image.
    """
    import cv2

    if window_px == 0:
        return np.asarray(np.rint(gray), np.uint8)
    mean = cv2.GaussianBlur(gray, (0, 0), window_px)
    contrast = (gray - mean) / (mean + np.float32(DARKEST))
    local = np.sqrt(cv2.GaussianBlur(contrast * contrast, (0, 0), window_px) + np.float32(LEAST_CONTRAST**2))
    levelled = np.float32(MID_GREY) + np.float32(SPREAD) * contrast / local
    return np.asarray(np.clip(np.rint(levelled), 0, 255), np.uint8)


def _is_clear_of_border(keypoints: Floats32, shape: tuple[int, ...]) -> Mask:
    """Return which keypoints (n, 4) were found without what is mirrored beyond the border of an image (h, w)."""
    u, v, reach = keypoints[:, 0], keypoints[:, 1], np.float32(CLEAR_SIZES) * keypoints[:, 2]
    height, width = shape[:2]
    return np.asarray((u >= reach) & (v >= reach) & (u <= width - 1 - reach) & (v <= height - 1 - reach))


def _reduce(gray: Pixels, reduction: float) -> tuple[Floats32, Floats32]:
    """Return the image shrunk (area mean, which also thins the noise) and the step (2,) from its pixels to the raw ones."""
    import cv2

    height, width = gray.shape
    size = (max(1, round(width / reduction)), max(1, round(height / reduction)))
    grey = gray.astype(np.float32)
    if size == (width, height):
        return grey, np.ones(2, np.float32)
    small = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32), np.array([width / size[0], height / size[1]], np.float32)


def _colors(image: Pixels, keypoints: Floats32) -> Pixels:
    column = np.clip(np.rint(keypoints[:, 0]).astype(np.int64), 0, image.shape[1] - 1)
    row = np.clip(np.rint(keypoints[:, 1]).astype(np.int64), 0, image.shape[0] - 1)
    color = image[row, column]
    return np.repeat(color[:, None], 3, axis=1) if image.ndim == 2 else np.ascontiguousarray(color)
