# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""An imaging sonar's image of beams by ranges [Ozog2016 3.2.3] (docs/methods.md 14).

Frame `sonar`: z along the middle of the fan, beams in the y-z plane, x out of it. On the display u
grows with the bearing and v towards the instrument; gamma cancels where distances are compared, so
they are kept in metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class SonarFan:
    """The fan of a sonar."""

    bearing: Array  # (beams,) rad, rising
    beam: Array  # (beams,) number in the image
    range_m: Array  # (ranges,) rising
    half_elevation: float  # rad

    def locate(self, points: Array) -> tuple[Array, Array]:
        """Locate points (n, 3) in the image. NaN outside it.

        Returns
        -------
        place
            range bin and beam number (n, 2).
        ratio
            r/R (n,) on the display.
        """
        x, y, z = points.T
        level = np.hypot(y, z)
        distance, bearing, elevation = np.hypot(level, x), np.arctan2(y, z), np.arctan2(x, level)
        first, last = self.range_m[0], self.range_m[-1]
        n_r = (distance - first) * (len(self.range_m) - 1) / (last - first)
        n_b = np.interp(bearing, self.bearing, self.beam)
        held = (
            (distance >= first) & (distance <= last)
            & (bearing >= self.bearing[0]) & (bearing <= self.bearing[-1])
            & (np.abs(elevation) <= self.half_elevation)
        )  # fmt: skip
        return np.stack([n_r, n_b], axis=1), np.where(
            held, self._away(distance, bearing) / self._farthest(), np.nan
        )

    def rays(self, bearings: int, elevations: int) -> Array:
        """Spread unit vectors (bearings * elevations, 3) in `sonar` over the aperture."""
        psi, theta = np.meshgrid(
            np.linspace(self.bearing[0], self.bearing[-1], bearings),
            np.linspace(-self.half_elevation, self.half_elevation, elevations),
        )
        level = np.cos(theta)
        return np.stack([np.sin(theta), level * np.sin(psi), level * np.cos(psi)], axis=-1).reshape(
            -1, 3
        )

    def _best(self) -> float:
        """Compute the metres ahead of the instrument at v = 3h/4.

        The display ends at the nearest range shown.
        """
        near = self.range_m[0] * float(np.cos(np.abs(self.bearing).max()))
        return float(self.range_m[-1] - 0.75 * (self.range_m[-1] - near))

    def _away(self, distance: Array, bearing: Array) -> Array:
        return np.hypot(distance * np.sin(bearing), distance * np.cos(bearing) - self._best())

    def _farthest(self) -> float:
        corners = [
            (r, b) for r in self.range_m[[0, -1]] for b in (self.bearing[0], 0.0, self.bearing[-1])
        ]
        return max(float(self._away(np.float64(r), np.float64(b))) for r, b in corners)  # type: ignore[arg-type]


def build_fan(directions: Array, range_m: Array, elevation_rad: float) -> SonarFan:
    """Build a fan from the beams' unit vectors in `sonar` (beams, 3).

    `elevation_rad`: full aperture out of the fan.
    """
    bearing = np.arctan2(directions[:, 1], directions[:, 2])
    order = np.argsort(bearing, kind="stable")
    return SonarFan(
        bearing=bearing[order],
        beam=order.astype(float),
        range_m=range_m,
        half_elevation=0.5 * elevation_rad,
    )
