# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The scale space in which OpenCV's SIFT finds keypoints, and their descriptors in it [Lowe2004].

OpenCV finds the keypoints. Its descriptors would take three quarters of the time, so that they are
computed by a native kernel in half of it. One number of RootSIFT in some 20,000 differs from
OpenCV's (benchmarks.descriptors).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from hullrecon import native
from hullrecon.typing import Array, Floats32, Ints, Pixels

OCTAVE_LAYERS = 3  # scales in an octave
SIGMA_PX = 1.6  # blur of an octave's first level
CAMERA_SIGMA_PX = 0.5  # blur that a raw image is assumed to have, as in OpenCV


def describe_keypoints(levelled: Pixels, keypoints: Array, octave: Ints) -> Pixels:
    """Describe keypoints of an image by SIFT.

    Parameters
    ----------
    levelled
        The image (h, w) in which OpenCV's SIFT found them, with `enable_precise_upscale`.
    keypoints
        (n, 4) u, v, diameter in pixels of the image, angle in degrees, as OpenCV gives them.
    octave
        (n,) OpenCV's packed number: octave in the lowest byte, layer in the next.

    Returns
    -------
    Pixels
        Descriptors (n, 128), of length 512 but for rounding.
    """
    # OpenCV numbers octaves from -1, of the doubled image, as a signed byte. Here from 0.
    doubled = (octave + 1 & 0xFF).astype(np.int64)
    layer = octave >> 8 & 0xFF
    # All Gaussian levels up to the highest octave needed, in one list.
    levels = [
        level
        for octave_levels in islice(_octaves(levelled), int(doubled.max(initial=-1)) + 1)
        for level in octave_levels
    ]
    # Pixels of the keypoint's octave in one pixel of the image: 2 in the doubled one, then 1, 1/2.
    scale = np.ldexp(1.0, 1 - doubled)
    u_px, v_px, diameter_px, angle_deg = keypoints.T
    placed = (u_px * scale, v_px * scale, 0.5 * diameter_px * scale, np.radians(360 - angle_deg))
    return native.describe_keypoints(
        levels, np.column_stack(placed), doubled * (OCTAVE_LAYERS + 1) + layer
    )


def _octaves(image: Pixels) -> Iterator[list[Floats32]]:
    """Yield the Gaussian levels of each octave, from the doubled image on.

    Level 0 is the octave's base. Keypoints are found in levels 1 to OCTAVE_LAYERS.
    """
    import cv2

    height, width = image.shape
    base = np.asarray(
        cv2.warpAffine(
            image.astype(np.float32),
            np.array([[0.5, 0, 0], [0, 0.5, 0]], np.float32),
            (2 * width, 2 * height),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REFLECT,
        )
    )
    base = _blur(base, 2 * CAMERA_SIGMA_PX, SIGMA_PX)
    while True:
        levels = [base]
        for layer in range(OCTAVE_LAYERS):
            before, after = (SIGMA_PX * 2 ** (k / OCTAVE_LAYERS) for k in (layer, layer + 1))
            levels.append(_blur(levels[-1], before, after))
        yield levels
        # The last level has twice the blur of the base: every second pixel of it is the next base.
        half = levels[-1].shape[1] // 2, levels[-1].shape[0] // 2
        base = np.asarray(cv2.resize(levels[-1], half, interpolation=cv2.INTER_NEAREST), np.float32)


def _blur(picture: Floats32, before_px: float, after_px: float) -> Floats32:
    """Smooth a picture from a blur of sigma before_px to a larger one."""
    import cv2

    sigma = np.sqrt(after_px**2 - before_px**2)
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), sigma), np.float32)
