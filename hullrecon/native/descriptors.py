# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compute descriptors of detected keypoints."""

from __future__ import annotations

from collections.abc import Sequence

from hullrecon.typing import Array, Floats32, Ints, Pixels


def describe_keypoints(levels: Sequence[Floats32], keypoints: Array, level: Ints) -> Pixels:
    """Compute SIFT descriptors (n, 128) of keypoints, of length 512 except for rounding.

    Raises InputError for keypoints outside of their level, and for levels narrower than 10 px.

    Parameters
    ----------
    levels
        Smoothed images (h, w) of a scale space.
    keypoints
        (n, 4) u, v, sigma in pixels of the level (first pixel's centre 0, 0), and the angle of the
        gradient in radians from u towards -v.
    level
        (n,) number of each keypoint's level.
    """
    from hullrecon.native.compiled import native  # loads the solver's libraries

    descriptors: Pixels = native.describe_keypoints(list(levels), keypoints, level)
    return descriptors
