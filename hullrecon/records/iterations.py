# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the record of a solve (iterations.npz, docs/formats.md).

It has a row for each iteration, one round after another.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Array, Ints, Mask


def reached_cost(cost: Array, accepted: Mask) -> Array:
    """Compute the cost (k,) at the last accepted point of each row.

    The record's cost is that of the point tried, which may have been refused.
    """
    return np.asarray(cost[np.maximum.accumulate(np.where(accepted, np.arange(len(cost)), 0))])


def count(rounds: Ints) -> int:
    """Count the iterations of all rounds, without their starts, from the round (k,) of each row."""
    return len(rounds) - len(np.unique(rounds))


def broken(at: NDArray[np.number], values: NDArray[np.number], rounds: Ints) -> tuple[Array, Array]:
    """Insert NaN into a curve (k,) over `at` wherever a round begins, so that a plot breaks there.

    Costs of two rounds do not compare. at: (k,) abscissae. rounds: (k,) round of each row.
    """
    starts = np.flatnonzero(np.diff(rounds)) + 1
    return np.insert(np.asarray(at, float), starts, np.nan), np.insert(
        np.asarray(values, float), starts, np.nan
    )
