# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where points lie on the ship, as columns beside x, y, z."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.address import is_hull_chart, side_of
from hullrecon.report.survey import Survey
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class ChartCoordinates:
    """Of n points: along and girth (n,) m, NaN off the chart; side (n,), "" where there is none;
    frame (n,), the ship's frame number, NaN without spacing.
    """

    along: Array
    girth: Array
    side: list[str]
    frame: Array


def chart_coordinates(survey: Survey, points: Array) -> ChartCoordinates:
    """Return the coordinates of points (n, 3) in the frame of the results; all are lost without a
    chart.
    """
    chart, hull = survey.surfaces.chart, survey.facts.hull
    lost = np.full(len(points), np.nan)
    if chart is None or not len(points):
        return ChartCoordinates(along=lost, girth=lost, side=[""] * len(points), frame=lost)
    along, girth = chart.to_chart(points)[:, :2].T
    on_ship = is_hull_chart(chart)
    spacing = hull.frame_spacing if hull is not None and on_ship else None
    return ChartCoordinates(
        along=along,
        girth=girth,
        side=[side_of(float(g)) if on_ship and np.isfinite(g) else "" for g in girth],
        frame=along / spacing if spacing else lost,
    )
