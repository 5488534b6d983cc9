# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Directions on the hull: along it and around its girth, at points near it."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.typing import Array

STEP_M = 0.05  # half the length of the central differences on the chart


def tangents_at(chart: Chart, points: Array) -> tuple[Array, Array]:
    """Compute unit vectors (n, 3) along and in girth at points (n, 3) m. NaN off the chart."""
    at = chart.to_chart(points)[:, :2]
    along, girth = (
        _direction(chart, at, np.array(step)) for step in ((STEP_M, 0.0), (0.0, STEP_M))
    )
    return along, girth


def _direction(chart: Chart, at: Array, step: Array) -> Array:
    """Compute unit vectors (n, 3) in the direction of a step (2,) on the chart at points (n, 2)."""
    here, ahead, behind = (chart.from_chart(place)[0] for place in (at, at + step, at - step))
    # At the chart's rim a one-sided difference is taken
    ahead, behind = (np.where(np.isfinite(end), end, here) for end in (ahead, behind))
    return np.asarray((ahead - behind) / np.linalg.norm(ahead - behind, axis=1, keepdims=True))
