# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The raster of a mosaic on the hull's chart: along to the right, girth up, square texels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array


@dataclass(frozen=True)
class Window:
    """Rows and columns of a raster, the ends excluded."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def shape(self) -> tuple[int, int]:
        return max(0, self.bottom - self.top), max(0, self.right - self.left)

    @property
    def empty(self) -> bool:
        return 0 in self.shape

    def meet(self, other: Window) -> Window:
        """Intersect with another window."""
        top, left = max(self.top, other.top), max(self.left, other.left)
        return Window(
            top,
            max(top, min(self.bottom, other.bottom)),
            left,
            max(left, min(self.right, other.right)),
        )

    def parts(self, size: int) -> Iterator[Window]:
        """Yield square windows that fill this one in row-major order, cut off at its ends."""
        for top in range(self.top, self.bottom, size):
            for left in range(self.left, self.right, size):
                yield Window(top, top + size, left, left + size).meet(self)

    def within(self, outer: Window) -> tuple[slice, slice]:
        """Return the row and column slices of this window in an array of the outer window."""
        return (
            slice(self.top - outer.top, self.bottom - outer.top),
            slice(self.left - outer.left, self.right - outer.left),
        )


@dataclass(frozen=True)
class TexelGrid:
    """The raster of a mosaic."""

    west: float  # m along, outer corner of the first texel
    north: float  # m in girth, of the same corner
    step_m: float  # side of a texel
    height: int
    width: int

    @property
    def whole(self) -> Window:
        return Window(0, self.height, 0, self.width)

    def centers(self, rows: Array, columns: Array) -> Array:
        """Compute along and girth, m, of texel centres: (rows, columns, 2).

        Rows and columns may be fractions.
        """
        along = self.west + (columns + 0.5) * self.step_m
        girth = self.north - (rows + 0.5) * self.step_m
        return np.stack(np.broadcast_arrays(along[None, :], girth[:, None]), axis=-1)

    def window_of(self, along_girth: Array, margin_m: float) -> Window:
        """Find the smallest window with the texels within `margin_m` of chart points (n, 2) m.

        It is cut off at the raster's ends. NaN points are left out. The window is empty if there
        are no others.
        """
        good = along_girth[np.isfinite(along_girth).all(axis=1)]
        if not len(good):
            return Window(0, 0, 0, 0)
        low, high = good.min(axis=0) - margin_m, good.max(axis=0) + margin_m
        rows = np.array([self.north - high[1], self.north - low[1]]) / self.step_m
        columns = (np.array([low[0], high[0]]) - self.west) / self.step_m
        found = Window(
            int(np.floor(rows[0])),
            int(np.ceil(rows[1])),
            int(np.floor(columns[0])),
            int(np.ceil(columns[1])),
        )
        return found.meet(self.whole)

    def parts(self, size: int) -> Iterator[Window]:
        """Yield the windows of `tiles`, each cut off where it sticks out of the raster."""
        return self.whole.parts(size)

    def tiles(self, size: int) -> Iterator[Window]:
        """Yield square windows in row-major order. The last may stick out of the raster."""
        for top in range(0, self.height, size):
            for left in range(0, self.width, size):
                yield Window(top, top + size, left, left + size)


def grid_around(along_girth: Array, step_m: float, max_texels: float = 1.5e8) -> TexelGrid:
    """Make the raster that holds chart points (n, 2) m, its corner on a multiple of the step.

    The step is made longer where there would be more than `max_texels`. Raises ValueError without a
    finite point.
    """
    good = along_girth[np.isfinite(along_girth).all(axis=1)]
    if not len(good):
        raise ValueError("no point lies on the chart")
    along, girth = np.ptp(good, axis=0)
    step_m = max(step_m, float(np.sqrt(along * girth / max_texels)))
    west, south = np.floor(good.min(axis=0) / step_m) * step_m
    east, north = np.ceil(good.max(axis=0) / step_m) * step_m
    height, width = max(1, round((north - south) / step_m)), max(1, round((east - west) / step_m))
    return TexelGrid(float(west), float(north), step_m, height, width)
