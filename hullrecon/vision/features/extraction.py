# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of one image: contrast levelled by CLAHE, SIFT found by OpenCV, RootSIFT descriptors as bytes, colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from hullrecon.dive.config.schema import NotNegative, Positive, Section
from hullrecon.typing import Floats32, Pixels


class FeatureOptions(Section, frozen=True):
    """Section [features] of dive.toml."""

    clahe_clip: Annotated[
        NotNegative, Meta(description="ratio, contrast limit of the equalisation; 0 leaves the image as it is")
    ] = 3.0
    clahe_tiles: Annotated[int, Meta(ge=1, le=64, description="tiles of the equalisation along each side")] = 8
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
    small, step = _reduce(_level(gray, options), options.reduction)
    found, descriptors = sift.detectAndCompute(small, None)
    if not found:
        return no_features()
    table = np.array([(p.pt[0], p.pt[1], p.size, p.response) for p in found], np.float32)
    table[:, :2] = (table[:, :2] + np.float32(0.5)) * step - np.float32(0.5)
    table[:, 2] *= step.mean()
    order = np.lexsort((table[:, 3], table[:, 2], table[:, 0], table[:, 1]))
    return Features(table[order], root_sift(descriptors[order]), _colors(image, table[order]))


def root_sift(descriptors: Floats32) -> Pixels:
    """Return the Hellinger form: square root of the L1-normalised vector (unit length), times 512, as bytes."""
    share = descriptors / np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-9)
    return np.asarray(np.minimum(np.rint(np.sqrt(share) * 512.0), 255), np.uint8)


def _level(gray: Pixels, options: FeatureOptions) -> Pixels:
    import cv2

    if options.clahe_clip == 0:
        return gray
    leveller = cv2.createCLAHE(options.clahe_clip, (options.clahe_tiles, options.clahe_tiles))
    return np.asarray(leveller.apply(gray)).astype(np.uint8, copy=False)


def _reduce(gray: Pixels, reduction: float) -> tuple[Pixels, Floats32]:
    """Return the image shrunk (area mean, which also thins the noise) and the step (2,) from its pixels to the raw ones."""
    import cv2

    height, width = gray.shape
    size = (max(1, round(width / reduction)), max(1, round(height / reduction)))
    if size == (width, height):
        return gray, np.ones(2, np.float32)
    small = cv2.resize(gray, size, interpolation=cv2.INTER_AREA)
    return np.asarray(small), np.array([width / size[0], height / size[1]], np.float32)


def _colors(image: Pixels, keypoints: Floats32) -> Pixels:
    column = np.clip(np.rint(keypoints[:, 0]).astype(np.int64), 0, image.shape[1] - 1)
    row = np.clip(np.rint(keypoints[:, 1]).astype(np.int64), 0, image.shape[0] - 1)
    color = image[row, column]
    return np.repeat(color[:, None], 3, axis=1) if image.ndim == 2 else np.ascontiguousarray(color)
