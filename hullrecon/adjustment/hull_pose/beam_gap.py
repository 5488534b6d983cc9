# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare where the DVL's beams end with where the cameras see the hull."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.robust import SIGNIFICANT, robust_sigma
from hullrecon.rows import spread_rows
from hullrecon.typing import Array

BESIDE_M = 0.1  # largest distance from a beam's line of a landmark that is taken to lie on it
FARTHEST = 0.5  # largest distance along the beam from its end to that landmark, share of the range
MOST_BEAMS, LEAST_BEAMS = 500, 20  # that are looked at, and that must have a landmark
# Largest gap that wrong mounts explain: two mounts, measured by hand to a centimetre and a degree,
# with beams that meet the hull at 30 degrees
LARGEST_GAP_M = 0.05


def gap_beyond_beams(
    ends: Array, directions: Array, range_m: Array, landmarks: Array
) -> tuple[float, float] | None:
    """Measure how far behind the ends of the DVL's beams the landmarks lie.

    With it a refusal of the CAD model can say that the ranges or a mount are wrong instead. For
    each beam the landmark nearest to its line is taken, and the gap is measured along the beam.
    Beams without a landmark within BESIDE_M of their line are skipped.

    Parameters
    ----------
    ends, directions
        End points (n, 3) m of the beams, and unit vectors (n, 3) along them.
    range_m
        Ranges of the beams (n,).
    landmarks
        Positions (l, 3) m, in the same frame as `ends`.

    Returns
    -------
    gap_m, share
        Median gap in m, positive where landmarks lie behind the ends, and as a share of the range.
        None where ends and landmarks agree, or where fewer than LEAST_BEAMS have a landmark.
    """
    gaps = []
    # at most MOST_BEAMS beams, evenly over the dive
    rows = spread_rows(len(ends), MOST_BEAMS)
    for end, direction, reach_m in zip(ends[rows], directions[rows], range_m[rows], strict=True):
        from_end = landmarks - end
        along_m = from_end @ direction
        beside_m = np.linalg.norm(from_end - along_m[:, None] * direction, axis=1)
        beside_m[np.abs(along_m) > FARTHEST * reach_m] = np.inf
        if len(beside_m) and beside_m.min() < BESIDE_M:
            gaps.append((along_m[beside_m.argmin()], reach_m))
    if len(gaps) < LEAST_BEAMS:
        return None
    gap_m, reach_m = np.array(gaps).T
    middle_m = float(np.median(gap_m))
    sigma_m = robust_sigma(gap_m) / np.sqrt(len(gap_m))
    if abs(middle_m) < max(LARGEST_GAP_M, SIGNIFICANT * sigma_m):
        return None
    return middle_m, float(np.median(gap_m / reach_m))
