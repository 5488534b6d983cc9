# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Map coordinates of a chart, in which rasters and vector layers show the hull from outside.

Along to the right and girth upwards show a hull from inside, mirrored. On the map x grows to the
right and y upwards for a viewer outside, who stands upright: on the port side x is minus along (the
bow is on the left), on the starboard side y is minus girth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.viewing_side import flips
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class OutsideMap:
    """The chart as a map of the hull seen from the water: x = x_sign along, y = y_sign girth, m."""

    x_sign: int
    y_sign: int
    frame: str  # of the chart, M or g

    @property
    def flips(self) -> tuple[bool, bool]:
        """Whether along grows to the left, and girth downwards."""
        return self.x_sign < 0, self.y_sign < 0

    @property
    def name(self) -> str:
        """Name of the coordinate system, with its definition to distinguish the four maps."""
        of = (
            "hull chart of the ship (frame M)"
            if self.frame == "M"
            else "chart of the survey (frame g)"
        )
        x, y = ("-" * (sign < 0) for sign in (self.x_sign, self.y_sign))
        return f"{of} seen from outside: x = {x}along, y = {y}girth"

    @property
    def wkt(self) -> str:
        """The map as a local engineering system in WKT 1, which old programs read too.

        In metres, tied to no place on Earth.
        """
        datum = "the ship" if self.frame == "M" else "start of the dive"
        axes = 'AXIS["x",EAST],AXIS["y",NORTH]'
        return f'LOCAL_CS["{self.name}",LOCAL_DATUM["{datum}",32767],UNIT["metre",1],{axes}]'

    def document(self) -> dict[str, object]:
        """Describe the map for JSON documents."""
        return {
            "along_from_x": self.x_sign,
            "girth_from_y": self.y_sign,
            "name": self.name,
            "wkt": self.wkt,
        }

    def to_map(self, along_girth: Array) -> Array:
        """Convert chart points (n, 2) to map coordinates (n, 2)."""
        return np.asarray(along_girth, float) * [self.x_sign, self.y_sign]

    def to_chart(self, xy: Array) -> Array:
        """Convert map coordinates (n, 2) to chart points (n, 2)."""
        return np.asarray(xy, float) * [self.x_sign, self.y_sign]


def outside_map(chart: Chart, points: Array, frame: str) -> OutsideMap:
    """Choose the map of a chart for viewers of points (n, 3).

    All layers of a dive take the same points: the surface of the survey.
    """
    left, down = flips(chart, chart.to_chart(points)[:, :2])
    return OutsideMap(x_sign=-1 if left else 1, y_sign=-1 if down else 1, frame=str(frame))
