# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks as measurements of the hull's surface."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.casting import Scene

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Measured:
    """Landmarks that measure the base surface, in its frame. row (n,): in the Solution; position, foot on the base and outward
    normal there (n, 3); offset (n,) m, signed distance to the base; sigma (n,) m along the normal; views (n,)."""

    row: Ints
    position: Array
    foot: Array
    normal: Array
    offset: Array
    sigma: Array
    views: Ints

    def __len__(self) -> int:
        return len(self.row)

    def take(self, which: NDArray[np.bool_] | Ints) -> Measured:
        return Measured(**{f.name: getattr(self, f.name)[which] for f in fields(self)})


def measure(scene: Scene, position: Array, covariance: Array, views: Ints, farthest_m: float, largest_sigma_m: float) -> Measured:
    """What landmarks (n, 3) with covariances (n, 3, 3) say about the surface of `scene`.

    Left out: those not finite, seen by one image only, farther off than `farthest_m`, less certain along the normal than
    `largest_sigma_m`, and those whose closest point is the base's rim, beside which they lie rather than above it.
    """
    row = np.flatnonzero(np.isfinite(position).all(axis=1) & (views >= 2))
    near = scene.closest(position[row])
    gap = position[row] - near.foot
    sideways = np.linalg.norm(gap - near.normal * np.einsum("ni,ni->n", gap, near.normal)[:, None], axis=1)
    variance = np.einsum("ni,nij,nj->n", near.normal, covariance[row], near.normal)
    sigma = np.sqrt(np.where(variance > 0, variance, np.inf))
    good = (np.abs(near.distance) <= farthest_m) & (sigma <= largest_sigma_m)
    good &= sideways <= 0.005 + 0.7 * np.abs(near.distance)
    kept = Measured(row, position[row], near.foot, near.normal, near.distance, sigma, views[row])
    return kept.take(good)
