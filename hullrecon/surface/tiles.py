# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Regression of a large survey in tiles that overlap.

Memory and time of exact Gaussian processes do not grow with the dive. A kernel that ends at its
length lets an observation be outweighed by nearer ones long before that: a tile sees those within
half a length around it, and where tiles meet their predictions are blended (docs/methods.md 11).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hullrecon.rows import Rows
from hullrecon.surface.gaussian import Kernel, fit_robust
from hullrecon.typing import Array, Ints

MOST = 6000  # observations of a tile, those around it among them: the regression is cubic in them
MARGIN = 0.5  # of the kernel's lengths, around a tile
BLEND = 0.25  # of these, to either side of its border


@dataclass(frozen=True, kw_only=True)
class Observations(Rows):
    """Means of returns over cells of the chart (n)."""

    at: Array  # (n, 2) m on the chart
    offset: Array  # (n,) m from the base surface
    noise: Array  # (n,) m
    count: Ints  # (n,) returns behind each


def cell_means(at: Array, offset: Array, noise: Array, cell_m: float | Array) -> Observations:
    """Average over the cells of a grid, weighted, in the grid's order.

    The noise (n,) is white, so means have less of it. `cell_m`: side of a cell, or its two sides
    along and in girth.
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


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """The field at the places asked for (m)."""

    mean: Array  # (m,) m
    sigma: Array  # (m,) m
    tiles: int  # how many gave them


@dataclass(frozen=True)
class Box:
    """A rectangle of the chart, low and high (2,) m."""

    low: Array
    high: Array

    def around(self, at: Array, by: Array) -> Ints:
        """Find the points (n, 2) inside the box or within (2,) m of it."""
        return np.flatnonzero(((at >= self.low - by) & (at <= self.high + by)).all(axis=1))

    def weight(self, at: Array, by: Array) -> Array:
        """Weigh points (n, 2) from 1 inside to 0 at (2,) m beyond the border."""
        inside = np.minimum(at - (self.low - by), (self.high + by) - at) / (2 * by)
        return np.asarray(np.clip(inside, 0, 1).prod(axis=1))


def regress(kernel: Kernel, seen: Observations, wanted: Array, most: int = MOST) -> Prediction:
    """Predict a zero-mean field at places (m, 2) of the chart, outliers weighed down.

    Raises NotPositiveDefiniteError as `fit` does.
    """
    lengths = np.array(kernel.length)
    corners = np.vstack([seen.at, wanted])
    whole = Box(corners.min(axis=0), corners.max(axis=0))
    boxes = list(_split(whole, seen.at, MARGIN * lengths, most))
    total, mean, sigma = np.zeros((3, len(wanted)))
    for box in boxes:
        rows, near = (
            box.around(wanted, BLEND * lengths),
            seen.take(box.around(seen.at, MARGIN * lengths)),
        )
        if not len(rows):
            continue
        weight = box.weight(wanted[rows], BLEND * lengths) if len(boxes) > 1 else np.ones(len(rows))
        found = _predict(kernel, near, wanted[rows])
        total[rows] += weight
        mean[rows] += weight * found[0]
        sigma[rows] += weight * found[1]
    return Prediction(mean=mean / total, sigma=sigma / total, tiles=len(boxes))


def _predict(kernel: Kernel, seen: Observations, wanted: Array) -> tuple[Array, Array]:
    """Predict mean and sigma (m,). Without observations the kernel decides."""
    if not len(seen.at):
        return np.zeros(len(wanted)), np.full(len(wanted), kernel.sigma)
    found = fit_robust(kernel, seen.at, seen.offset, seen.noise)
    return found.mean(wanted), found.sigma(wanted)


def _split(box: Box, at: Array, margin: Array, most: int) -> Iterator[Box]:
    """Split a box until each part, with its margin, holds at most `most` observations.

    Parts no larger than their margins are not split.
    """
    size = (box.high - box.low) / margin
    if len(box.around(at, margin)) <= most or size.max() <= 1:
        yield box
        return
    axis = int(np.argmax(size))
    middle = 0.5 * (box.low[axis] + box.high[axis])
    for low, high in ((box.low[axis], middle), (middle, box.high[axis])):
        part = Box(box.low.copy(), box.high.copy())
        part.low[axis], part.high[axis] = low, high
        yield from _split(part, at, margin, most)
