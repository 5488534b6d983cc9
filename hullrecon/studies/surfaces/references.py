# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""References of the regression that leave the CAD model out of it, as [Ozog2016 3.2.2] has them."""

from __future__ import annotations

import numpy as np

from hullrecon.errors import StageError
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.plane_chart import PlaneChart, fit_plane_chart
from hullrecon.surface.build import MIN_FACING, Facts
from hullrecon.typing import Array

INDEPENDENT = "The CAD model's shape does not enter the regression of the returns."
MAX_FOLDED_SHARE = 0.01  # of the returns that may lie where the hull turns away from the plane


def offsets_from_plane(
    points: Array, chart: Chart, sensors: Array
) -> tuple[Chart, PlaneChart | None, Facts]:
    """Regress offsets from a plane through the points (n, 3).

    Raises StageError where the hull bends too far around for a plane.
    """
    plane = _plane(points, sensors)
    _, normals = chart.from_chart(chart.to_chart(points)[:, :2])
    facing = normals[np.isfinite(normals).all(axis=1)] @ plane.axes[2]
    if np.mean(facing < MIN_FACING) > MAX_FOLDED_SHARE:
        raise StageError(
            "the hull bends too far around for a plane",
            where="surface",
            remedy="take the CAD model as reference, or a shorter survey",
        )
    return plane, None, {"reference": "plane", "comparison": INDEPENDENT}


def heights_over_plane(
    points: Array, chart: Chart, sensors: Array
) -> tuple[Chart, PlaneChart | None, Facts]:
    """Regress heights over a plane through the points (n, 3), numbered by the hull's chart."""
    return chart, _plane(points, sensors), {"reference": "none", "comparison": INDEPENDENT}


def _plane(points: Array, sensors: Array) -> PlaneChart:
    return fit_plane_chart(points, sensors.mean(axis=0), np.array([0.0, 0.0, 1.0]))
