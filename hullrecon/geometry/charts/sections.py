# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sections of a hull in polar coordinates about an axis inside it: radius of the skin, and girth.

Coordinates are in the ship's axes: x forward, y port, z up. The angle phi about the axis is zero
straight down and positive to port.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class Sections:
    """A grid of stations and angles about an axis, with radius and girth of the skin."""

    axis_y: float  # m
    axis_z: float  # m
    reach: float  # m, distance from the axis at which rays start, outside the hull
    station: Array  # (k,) m, x
    angle: Array  # (m,) rad, phi
    radius: (
        Array  # (k, m) m, of the skin from the axis. Small gaps are bridged, NaN above the sheer
    )
    girth: Array  # (k, m) m, arc length from phi = 0
    whole: Mask  # (k - 1, m - 1) cells that lie on the skin

    def rays(self, along: Array, angle: Array) -> tuple[Array, Array]:
        """Compute rays toward the axis: origins (n, 3) m outside of the hull, and directions.

        along, angle: (n,) x of each ray, m, and its angle about the axis, rad.
        """
        outward = np.stack([np.zeros_like(angle), np.sin(angle), -np.cos(angle)], axis=1)
        axis = np.stack(
            [along, np.full_like(along, self.axis_y), np.full_like(along, self.axis_z)], axis=1
        )
        return axis + self.reach * outward, -outward

    def girth_at(self, points: Array) -> Array:
        """Compute the girth (n,) m of points (n, 3) m on the skin, in the ship's axes.

        NaN outside the cells that lie wholly on the skin, and for points of another, inner skin.
        """
        y, z = points[:, 1] - self.axis_y, points[:, 2] - self.axis_z
        angle = np.arctan2(y, -z)
        radius = self._interpolate(self.radius, points[:, 0], angle)
        girth = self._interpolate(self.girth, points[:, 0], angle)
        on_skin = np.abs(np.hypot(y, z) - radius) <= self.slack_at(points[:, 0], angle)
        return np.where(on_skin & self._inside(points[:, 0], angle), girth, np.nan)

    def angle_of(self, along_girth: Array) -> tuple[Array, Array]:
        """Compute angle, rad, and radius, m, (n,) of points (n, 2) of x and girth, m.

        The angle is found by bisection, as girth grows with it. The radius is NaN outside the cells
        that lie wholly on the skin.
        """
        # Find the two neighbouring angles between whose girths the point's lies
        row, share = self._cell(self.station, along_girth[:, 0])
        known = np.isfinite(along_girth).all(axis=1)
        low, high = np.zeros(len(row), int), np.full(len(row), len(self.angle) - 1)
        for _ in range(int(np.ceil(np.log2(len(self.angle))))):
            middle = (low + high) // 2
            under = self._girth_between(row, share, middle) <= np.nan_to_num(along_girth[:, 1])
            low, high = (
                np.where(under, middle, low),
                np.where(under, high, np.maximum(middle, low + 1)),
            )
        low = np.minimum(low, len(self.angle) - 2)
        start, stop = self._girth_between(row, share, low), self._girth_between(row, share, low + 1)
        with np.errstate(invalid="ignore"):  # beyond the sheer both ends are infinite
            part = (along_girth[:, 1] - start) / np.where(stop > start, stop - start, 1.0)
        fits = (
            known
            & (part >= -1e-9)
            & (part <= 1 + 1e-9)
            & self.whole[row, low]
            & self._spanned(along_girth[:, 0])
        )
        angle = self.angle[low] + np.clip(part, 0, 1) * (self.angle[low + 1] - self.angle[low])
        radius = self._interpolate(self.radius, along_girth[:, 0], angle)
        return angle, np.where(fits, radius, np.nan)

    def slack_at(self, along: Array, angle: Array) -> Array:
        """Compute by how much, m, the skin's radius (n,) may differ from its interpolation.

        along, angle: (n,) m and rad, as of `rays`. A point farther from the interpolated radius is
        of another skin. It is the range of the radii at the cell's corners, plus a tenth of the
        step between stations for a chine or a plate's edge inside the cell.
        """
        row, _ = self._cell(self.station, along)
        column, _ = self._cell(self.angle, angle)
        corners = np.stack([self.radius[row + i, column + j] for i in (0, 1) for j in (0, 1)])
        with np.errstate(invalid="ignore"):
            return np.asarray(
                corners.max(axis=0)
                - corners.min(axis=0)
                + 0.1 * (self.station[1] - self.station[0])
            )

    def _girth_between(self, row: Ints, share: Array, column: Ints) -> Array:
        """Interpolate the girth (n,) between two stations, at the angle of a column.

        Above the sheer it is -inf or inf, so that a bisection stays below it.

        Parameters
        ----------
        row, share
            (n,) first of the two stations, and position between them, 0 to 1.
        column
            (n,) number of the angle.
        """
        girth = self.girth[row, column] * (1 - share) + self.girth[row + 1, column] * share
        return np.where(np.isnan(girth), np.where(self.angle[column] < 0, -np.inf, np.inf), girth)

    def _interpolate(self, table: Array, along: Array, angle: Array) -> Array:
        """Interpolate a table (k, m) of stations and angles bilinearly at x and angles (n,)."""
        row, a = self._cell(self.station, along)
        column, b = self._cell(self.angle, angle)
        lower = table[row, column] * (1 - b) + table[row, column + 1] * b
        upper = table[row + 1, column] * (1 - b) + table[row + 1, column + 1] * b
        return np.asarray(lower * (1 - a) + upper * a)

    def _inside(self, along: Array, angle: Array) -> Mask:
        return self.whole[
            self._cell(self.station, along)[0], self._cell(self.angle, angle)[0]
        ] & self._spanned(along)

    def _spanned(self, along: Array) -> Mask:
        return np.asarray((along >= self.station[0] - 1e-9) & (along <= self.station[-1] + 1e-9))

    @staticmethod
    def _cell(nodes: Array, at: Array) -> tuple[Ints, Array]:
        """Find cells (n,) of a grid with even nodes (k,), and positions (n,) in them, 0 to 1.

        Values beyond the grid are clipped to it. NaN goes to the first cell.
        """
        place = np.nan_to_num((at - nodes[0]) / (nodes[1] - nodes[0]))
        cell = np.clip(np.floor(place), 0, len(nodes) - 2).astype(np.int64)
        return cell, np.clip(place - cell, 0.0, 1.0)
