# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The side of its backlash on which the tray hangs, from the adjusted angles [Ozog2016 4.2.6].

Backlash is a bias of the angle that flips with the direction of motion. After a solve with a loose
tray the sides show as two levels of (adjusted - logged); a two-state Viterbi path over time finds
them better than the noisy logged motion does.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.robust import robust_sigma
from hullrecon.typing import Array, Ints


def estimate_sides(excess: Array, prior_direction: Array, flip_cost: float = 4.0) -> Array:
    """Estimate on which side of its backlash the tray hangs at each node, +1 or -1 (n,).

    The side explains measured - adjusted = backlash * side.

    Parameters
    ----------
    excess
        Measured minus adjusted angle (n,), rad.
    prior_direction
        Kept where no backlash shows (levels closer than their spread).
    flip_cost
        Cost of a change of side, in half squares of the excess's sigma.
    """
    low, high = _two_levels(excess)
    sigma = max(
        robust_sigma(np.minimum(np.abs(excess - low), np.abs(excess - high)), about=0.0), 1e-5
    )
    if high - low < 3 * sigma or len(excess) < 10:
        return prior_direction
    fit = np.stack([(excess - low) ** 2, (excess - high) ** 2], axis=1) / (2 * sigma**2)
    path = _viterbi(np.minimum(fit, 1.5 * flip_cost), flip_cost)
    return np.where(path == 1, 1.0, -1.0)


def _two_levels(values: Array) -> tuple[float, float]:
    """Find the centres of two clusters by k-means in one dimension, started at the quartiles."""
    low, high = (float(q) for q in np.percentile(values, [25, 75]))
    for _ in range(20):
        upper = np.abs(values - high) < np.abs(values - low)
        if upper.all() or not upper.any():
            break
        low, high = float(np.median(values[~upper])), float(np.median(values[upper]))
    return low, high


def _viterbi(cost: Array, flip_cost: float) -> Ints:
    """Find the path of two states (n, 2) of least cost; a change of state costs `flip_cost`."""
    n = len(cost)
    best, back = cost[0].copy(), np.zeros((n, 2), np.int64)
    for i in range(1, n):
        stay, change = best, best[::-1] + flip_cost
        back[i] = np.where(change < stay, [1, 0], [0, 1])
        best = np.minimum(stay, change) + cost[i]
    path = np.zeros(n, np.int64)
    path[-1] = int(np.argmin(best))
    for i in range(n - 1, 0, -1):
        path[i - 1] = back[i, path[i]]
    return path
