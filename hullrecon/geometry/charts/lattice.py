# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Square cells on a chart, on which two surveys of one hull are compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class Lattice:
    """Cells along and in girth."""

    origin: Array  # (2,) m, middle of the first cell
    step_m: float
    shape: tuple[int, int]  # cells along and in girth

    def points(self) -> Array:
        """Compute the middles (a, g, 2) of all cells, m."""
        along, girth = (self.origin[k] + self.step_m * np.arange(self.shape[k]) for k in (0, 1))
        return np.stack(np.meshgrid(along, girth, indexing="ij"), axis=-1)

    def place(self, along_girth: Array) -> Array:
        """Convert chart points (..., 2) to fractional cell numbers."""
        return np.asarray((along_girth - self.origin) / self.step_m)

    def cells(self, along_girth: Array) -> tuple[Ints, Mask]:
        """Find the cells (n, 2) of chart points (n, 2) m, and which (n,) lie in the lattice.

        Cell numbers are clipped to it.
        """
        place = self.place(along_girth)
        inside = np.asarray(np.isfinite(place).all(axis=1))
        number = np.round(np.where(inside[:, None], place, -1.0)).astype(np.int64)
        last = np.array(self.shape) - 1
        inside = inside & ((number >= 0) & (number <= last)).all(axis=1)
        return np.clip(number, 0, last), np.asarray(inside)

    def polygon(self, outline: Array) -> Mask:
        """Mark the cells (a, g) inside a closed line (k, 2) m of chart points.

        No cell is marked where the line has no point.
        """
        import cv2

        mask = np.zeros(self.shape, np.uint8)
        corners = np.round(self.place(outline)[:, ::-1]).astype(np.int32)  # cv2: column first
        if len(corners):
            cv2.fillPoly(mask, [corners], 1)
        return mask.astype(bool)

    def outline(self, mask: Mask) -> Array:
        """Trace the longest closed line (k, 2) around a mask (a, g). Empty without cells."""
        import cv2

        lines, _ = cv2.findContours(
            mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
        )
        longest = max(lines, key=len, default=np.zeros((0, 1, 2)))
        return np.asarray(self.origin + self.step_m * longest[:, 0, ::-1].astype(float))


def lattice_around(points: Array, step_m: float, margin_m: float = 0.0) -> Lattice:
    """Make a lattice around chart points (n, 2) m with a margin. Rows with NaN are left out.

    The middle of its first cell is a multiple of the step.
    """
    good = points[np.isfinite(points).all(axis=1)]
    low = np.floor((good.min(axis=0) - margin_m) / step_m)
    high = np.ceil((good.max(axis=0) + margin_m) / step_m)
    size = (high - low).astype(int) + 1
    return Lattice(origin=low * step_m, step_m=step_m, shape=(int(size[0]), int(size[1])))
