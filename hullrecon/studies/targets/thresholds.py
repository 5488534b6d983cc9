# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Detect targets by two thresholds: a bright spot with a shadow behind it [Aulinas2011 Fig. 4.9].

The source prints no numbers for its thresholds and kernels.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from hullrecon.studies.targets.side_scan import ACROSS_M, ALTITUDE_M, FAR_M, level_over_range
from hullrecon.typing import Array, Floats32, Ints, Mask

MEDIAN_PX = 5
LOW, HIGH = 0.5, 1.55  # of the floor's level, after the median
GROW = (3, 7)  # rows, columns that shadows grow by, and bright spots
LEAST_HEIGHT_M, LEAST_WIDTH_PX = 0.2, 5  # of what is to be found: gives a shadow's least area
LEAST_SPOT_PX = 20


@dataclass(frozen=True, kw_only=True)
class Detection:
    """Targets found in a tile, with the pictures on the way."""

    levelled: Floats32  # gain over the range taken off; the floor is 1
    smooth: Floats32  # after the median filter
    dark: Mask  # below the low threshold
    bright: Mask  # above the high threshold
    shadows: Mask  # dark, grown and large enough for their range
    spots: Mask  # bright, grown
    found: Mask  # spots with a shadow behind them, and these shadows
    row: Ints  # (n,) middle of each target's spot
    column: Ints  # (n,) its near edge


def detect_by_thresholds(tile: Array) -> Detection:
    """Detect targets in a tile: median, two thresholds, morphology, then both together."""
    # 1 The level of the floor at each range. The source has none: its sonar corrects its gain.
    levelled = level_over_range(tile)
    # 2 Salt and pepper.
    smooth = np.asarray(cv2.medianBlur(levelled, MEDIAN_PX), dtype=np.float32)
    # 3 Shadows: 'erode' of the bright grows the dark.
    dark = smooth < LOW
    grown = cv2.erode((~dark).astype(np.uint8), np.ones(GROW, np.uint8)) == 0
    shadows = _large_enough(grown)
    # 4 Bright spots.
    bright = smooth > HIGH
    spots = cv2.dilate(_without_specks(bright), np.ones(GROW, np.uint8)) > 0
    # 5 Both, the shadow on the far side of the spot.
    found, row, column = _pair(spots, shadows)
    return Detection(
        levelled=levelled,
        smooth=smooth,
        dark=dark,
        bright=bright,
        shadows=shadows,
        spots=spots,
        found=found,
        row=row,
        column=column,
    )


def _large_enough(dark: Mask) -> Mask:
    """Keep dark regions as long as the least target's shadow at their range."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(dark.astype(np.uint8))
    keep = np.zeros(count, bool)
    for k in range(1, count):
        near_column = stats[k, cv2.CC_STAT_LEFT] + stats[k, cv2.CC_STAT_WIDTH]
        range_m = FAR_M - near_column * ACROSS_M
        least_px = LEAST_HEIGHT_M * range_m / (ALTITUDE_M - LEAST_HEIGHT_M) / ACROSS_M
        keep[k] = (
            stats[k, cv2.CC_STAT_WIDTH] >= least_px
            and stats[k, cv2.CC_STAT_AREA] >= LEAST_WIDTH_PX * least_px
        )
    return np.asarray(keep[labels])


def _without_specks(bright: Mask) -> Mask:
    """Drop bright regions of a few pixels."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(bright.astype(np.uint8))
    keep = stats[:count, cv2.CC_STAT_AREA] >= LEAST_SPOT_PX
    keep[0] = False
    return np.asarray(keep[labels].astype(np.uint8))


def _pair(spots: Mask, shadows: Mask) -> tuple[Mask, Ints, Ints]:
    """Keep bright spots (rows, columns) that have a shadow on their far side, left of their middle.

    Returns a mask of what was found, spots with their shadows, and of each target the row of its
    middle and the column of its near edge.
    """
    count, labels, stats, middles = cv2.connectedComponentsWithStats(spots.astype(np.uint8))
    _, shade = cv2.connectedComponents(shadows.astype(np.uint8))
    found, rows, columns = np.zeros(spots.shape, bool), [], []
    for k in range(1, count):
        left, top = stats[k, cv2.CC_STAT_LEFT], stats[k, cv2.CC_STAT_TOP]
        wide, high = stats[k, cv2.CC_STAT_WIDTH], stats[k, cv2.CC_STAT_HEIGHT]
        behind = shade[top : top + high, max(0, left - 2) : left + wide // 2]
        met = np.unique(behind[behind > 0])
        if len(met) == 0:
            continue
        found |= (labels == k) | np.isin(shade, met)
        rows.append(round(middles[k][1]))
        columns.append(left + wide - GROW[1] // 2)
    return found, np.array(rows, int), np.array(columns, int)
