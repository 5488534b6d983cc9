# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of a patch: two rectangles by the integral image, and boundary to centroid.

[Aulinas2011 4.3.1], [ViolaJones2004].
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from hullrecon.typing import Array

DARK = 0.55  # of the floor's level
PROPORTIONS = tuple(range(1, 13))


@dataclass(frozen=True, kw_only=True)
class Rectangles:
    """A window cut in two: its value is the mean of the first part less the mean of the second.

    The source takes the difference of sums. Sums of parts of unequal size have a value on plain
    floor too, which moves with its level.
    """

    first: int  # parts of the window, of first + second
    second: int
    along: str  # "range": first left, second right; "track": first above, second below
    inner: bool = False  # of the middle two thirds of the rows alone, which the thing fills

    @property
    def name(self) -> str:
        """Name it by its proportion."""
        return f"{self.first}:{self.second} {self.along}{', inner' if self.inner else ''}"

    def value(self, integral: Array, by_sums: bool = False) -> Array:
        """Evaluate the feature on patches, by their integral images (n, rows + 1, columns + 1)."""
        rows, columns = integral.shape[1] - 1, integral.shape[2] - 1
        top, bottom = (rows // 6, rows - rows // 6) if self.inner else (0, rows)
        if self.along == "range":
            cut = round(columns * self.first / (self.first + self.second))
            first = (top, bottom, 0, cut)
            second = (top, bottom, cut, columns)
        else:
            cut = top + round((bottom - top) * self.first / (self.first + self.second))
            first = (top, cut, 0, columns)
            second = (cut, bottom, 0, columns)
        if by_sums:
            return sum_in(integral, *first) - sum_in(integral, *second)
        return mean_in(integral, *first) - mean_in(integral, *second)


def all_rectangles() -> list[Rectangles]:
    """List the windows cut in two in either direction, in every proportion up to 12:1."""
    cuts = [(k, 1) for k in PROPORTIONS] + [(1, k) for k in PROPORTIONS[1:]]
    return [
        Rectangles(first=first, second=second, along=along, inner=inner)
        for along, inner in (("range", False), ("track", False), ("range", True))
        for first, second in cuts
    ]


def integral_images(pictures: Array) -> Array:
    """Sum pictures (n, r, c) above and to the left of each pixel: (n, r + 1, c + 1)."""
    return np.pad(pictures.cumsum(axis=1).cumsum(axis=2), ((0, 0), (1, 0), (1, 0)))


def sum_in(integral: Array, top: int, bottom: int, left: int, right: int) -> Array:
    """Sum a rectangle of each picture (n,) by four look-ups in its integral image.

    It has the rows top to bottom and the columns left to right, without the last ones.
    """
    return np.asarray(
        integral[:, bottom, right]
        + integral[:, top, left]
        - integral[:, top, right]
        - integral[:, bottom, left]
    )


def mean_in(integral: Array, top: int, bottom: int, left: int, right: int) -> Array:
    """Compute the mean of each picture (n,) over a rectangle, as `sum_in`."""
    return sum_in(integral, top, bottom, left, right) / ((bottom - top) * (right - left))


CENTROID_NAMES = (
    "boundary to centroid, mean",
    "boundary to centroid, spread",
    "centroid, along range",
    "share of dark",
)


def centroid_distances(picture: Array) -> Array:
    """Describe a patch (r, c) by the distances of a dark object's boundary from its centroid (4,).

    The object is the largest region darker than DARK, and none gives zeros. The features are the
    mean of the distances as a share of the patch's width, their spread as a share of their mean,
    then the centroid's column and the object's area as shares of the patch.
    """
    rows, columns = picture.shape
    smooth = cv2.medianBlur(picture.astype(np.float32), 3)
    dark = (smooth < DARK).astype(np.uint8)
    count, labels, stats, middles = cv2.connectedComponentsWithStats(dark)
    if count < 2:
        return np.zeros(4)
    largest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    outlines, _ = cv2.findContours(
        (labels == largest).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
    )
    boundary = max(outlines, key=len)[:, 0].astype(float)
    distance = np.linalg.norm(boundary - middles[largest], axis=1)
    mean = float(distance.mean())
    return np.array(
        [
            mean / columns,
            distance.std() / max(mean, 1e-9),
            middles[largest][0] / columns,
            stats[largest, cv2.CC_STAT_AREA] / (rows * columns),
        ]
    )


def describe(pictures: Array) -> tuple[Array, list[str]]:
    """Evaluate all features (n, f) of patches (n, r, c), and name the features."""
    integral = integral_images(pictures)
    rectangles = all_rectangles()
    values = np.column_stack([shape.value(integral) for shape in rectangles])
    by_centroid = np.array([centroid_distances(picture) for picture in pictures])
    names = [shape.name for shape in rectangles] + list(CENTROID_NAMES)
    return np.hstack([values, by_centroid]), names


def separation(targets: Array, others: Array) -> Array:
    """Measure how far each feature sets targets (n, f) apart from others (m, f), in sigmas."""
    spread = np.sqrt(0.5 * (targets.var(axis=0) + others.var(axis=0)))
    return np.asarray(np.abs(targets.mean(axis=0) - others.mean(axis=0)) / spread)
