# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of one image: contrast levelled, SIFT found by OpenCV, RootSIFT descriptors as bytes,
colours; corners by option.

What moves a feature depending on where in the image it lies acts as a wrong lens: hundredths of a
pixel bend a path of 45 m by centimetres (docs/methods.md 4). So the levelling knows no tiles,
follows the light, and features are kept clear of the border.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from hullrecon.dive.config.schema import Positive, Section
from hullrecon.typing import Floats32, Ints, Mask, Pixels
from hullrecon.vision.features.corners import RADIUS_PX, describe_corners, find_corners
from hullrecon.vision.features.descriptors import WIDTH, root_sift
from hullrecon.vision.features.places import first_at_place

CORNERS = 0.5  # of features.max_features: as many corners at most


class FeatureOptions(Section, frozen=True):
    """Section [features] of dive.toml."""

    level_window: Annotated[
        float,
        Meta(
            ge=0.0,
            le=0.1,
            description="ratio, of the image's width: sigma of the window that levels contrast; 0 leaves it as it is",
        ),
    ] = 0.025
    max_features: Annotated[
        int, Meta(ge=50, le=100_000, description="features of an image; the strongest are kept")
    ] = 4000
    contrast_threshold: Annotated[
        Positive, Meta(description="ratio, smallest contrast of a feature (SIFT contrastThreshold)")
    ] = 0.02
    edge_threshold: Annotated[
        Positive,
        Meta(description="ratio, largest of a feature's two curvatures (SIFT edgeThreshold)"),
    ] = 10.0
    octave_layers: Annotated[
        int, Meta(ge=1, le=8, description="scales in an octave (SIFT nOctaveLayers)")
    ] = 3
    reduction: Annotated[
        float,
        Meta(
            ge=1.0, le=8.0, description="ratio, images are shrunk by this before SIFT doubles them"
        ),
    ] = 2.0


# of a levelled image: its mean, and one sigma of contrast that stands out of the noise
MID_GREY, SPREAD = 128.0, 32.0
DARKEST = 16.0  # grey levels, added to the local mean: below, contrast is noise
# of the local mean; 1 % is a camera's noise, on plain paint fewer features than ten are found in it
LEAST_CONTRAST = 0.05
# from the border, in diameters: nearer, up to 0.2 px of bias, beyond none (the smoothing reaches
# 1.9)
CLEAR_SIZES = 2.0
# from the border, in sigmas of the levelling window: nearer, up to 0.024 px, beyond 0.001 px
CLEAR_WINDOWS = 1.5


@dataclass(frozen=True)
class Features:
    """keypoints (n, 4) float32: u, v in raw pixels (centre of the first is 0, 0), scale (diameter
    in px), score; descriptors (n, 128) uint8; color (n, 3) uint8 RGB. corners: how many of the last
    rows are corners, with the magnitudes of Zernike moments for descriptors; the others are SIFT
    features.
    """

    keypoints: Floats32
    descriptors: Pixels
    color: Pixels
    corners: int = 0

    def __len__(self) -> int:
        return len(self.keypoints)

    @property
    def corner(self) -> Mask:
        """Return which rows (n,) are corners."""
        return np.arange(len(self)) >= len(self) - self.corners

    @property
    def place(self) -> Ints:
        """Return by feature (n,) the row that stands for all at its pixel."""
        return first_at_place(self.keypoints)

    def without_corners(self) -> Features:
        """Return the SIFT features alone."""
        rows = slice(len(self) - self.corners)
        return Features(self.keypoints[rows], self.descriptors[rows], self.color[rows])


def no_features() -> Features:
    """Return the features of an image that is not there."""
    return Features(
        np.zeros((0, 4), np.float32), np.zeros((0, WIDTH), np.uint8), np.zeros((0, 3), np.uint8)
    )


def extract(image: Pixels, options: FeatureOptions, corners: bool = False) -> Features:
    """Return the features of an image (h, w) or (h, w, 3) RGB, in a fixed order: by v, then u, then
    scale.

    corners: behind the SIFT features, where there are any, come corners.
    """
    import cv2

    # several threads would change nothing but the load; processes are the parallel level
    cv2.setNumThreads(1)
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
    order = np.lexsort((table[:, 3], table[:, 2], table[:, 0], table[:, 1]))
    keypoints, vectors = _to_raw(table[order], step), root_sift(descriptors[order])
    window = options.level_window * gray.shape[1]
    clear = _is_clear_of_border(keypoints, gray.shape, window)
    keypoints, vectors = keypoints[clear], vectors[clear]
    if not corners:
        return Features(keypoints, vectors, _colors(image, keypoints))
    place, response = find_corners(levelled, table[:, :2], int(CORNERS * options.max_features))
    size = np.full(len(place), 2 * RADIUS_PX)
    keypoints = np.concatenate(
        [keypoints, _to_raw(np.column_stack([place, size, response]).astype(np.float32), step)]
    )
    vectors = np.concatenate([vectors, describe_corners(levelled, place)])
    return Features(keypoints, vectors, _colors(image, keypoints), len(place))


def _to_raw(keypoints: Floats32, step: Floats32) -> Floats32:
    """Return keypoints (n, 4) of the reduced image in raw pixels; step (2,) from its pixels to
    those.
    """
    out = keypoints.copy()
    out[:, :2] = (out[:, :2] + np.float32(0.5)) * step - np.float32(0.5)
    out[:, 2] *= step.mean()
    return out


def _level(gray: Floats32, window_px: float) -> Pixels:
    """Return the image (h, w) as bytes, its contrast to the local mean brought to one spread
    everywhere.

    The window slides with the pixel, so a feature is found at the same place of the scene wherever
    that lies in the image; the contrast to the mean, unlike the difference, is the same in any
    light. Tiles that are equalised apart (CLAHE) move features by 0.02 px in their rhythm, and by
    0.12 px from image to image.
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


def _is_clear_of_border(keypoints: Floats32, shape: tuple[int, ...], window_px: float) -> Mask:
    """Return which keypoints (n, 4) were found without what is mirrored beyond the border of an
    image (h, w).

    window_px: sigma of the window that levelled its contrast, in raw pixels.
    """
    u, v = keypoints[:, 0], keypoints[:, 1]
    reach = np.maximum(
        np.float32(CLEAR_SIZES) * keypoints[:, 2], np.float32(CLEAR_WINDOWS * window_px)
    )
    height, width = shape[:2]
    return np.asarray(
        (u >= reach) & (v >= reach) & (u <= width - 1 - reach) & (v <= height - 1 - reach)
    )


def _reduce(gray: Pixels, reduction: float) -> tuple[Floats32, Floats32]:
    """Return the image shrunk (area mean, which also thins the noise) and the step (2,) from its
    pixels to the raw ones.
    """
    import cv2

    height, width = gray.shape
    size = (max(1, round(width / reduction)), max(1, round(height / reduction)))
    values = gray.astype(np.float32)
    if size == (width, height):
        return values, np.ones(2, np.float32)
    small = cv2.resize(values, size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32), np.array([width / size[0], height / size[1]], np.float32)


def _colors(image: Pixels, keypoints: Floats32) -> Pixels:
    column = np.clip(np.rint(keypoints[:, 0]).astype(np.int64), 0, image.shape[1] - 1)
    row = np.clip(np.rint(keypoints[:, 1]).astype(np.int64), 0, image.shape[0] - 1)
    color = image[row, column]
    return np.repeat(color[:, None], 3, axis=1) if image.ndim == 2 else np.ascontiguousarray(color)
