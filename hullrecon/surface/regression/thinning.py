# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Weighted means over cells of the chart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class Observations:
    """at (n, 2) chart metres; offset (n,) m from the base surface; noise (n,) m; count (n,) returns
    behind each.
    """

    at: Array
    offset: Array
    noise: Array
    count: Ints

    def take(self, which: Mask | Ints) -> Observations:
        return Observations(
            at=self.at[which],
            offset=self.offset[which],
            noise=self.noise[which],
            count=self.count[which],
        )


def cell_means(at: Array, offset: Array, noise: Array, cell_m: float | Array) -> Observations:
    """Return weighted means over the cells of a grid, in the grid's order; noise (n,) is white, so
    means have less of it. cell_m: side of a cell, or its two sides along and in girth.
    """
    corner = np.floor(at / cell_m).astype(np.int64)
    _, cell = np.unique(corner, axis=0, return_inverse=True)
    cell = cell.reshape(-1)
    weight = noise**-2.0
    total = np.bincount(cell, weight)
    mean = [np.bincount(cell, weight * values) / total for values in (at[:, 0], at[:, 1], offset)]
    return Observations(
        at=np.stack(mean[:2], axis=1),
        offset=mean[2],
        noise=np.sqrt(1 / total),
        count=np.bincount(cell),
    )
