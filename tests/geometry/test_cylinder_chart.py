# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The chart of a hull that bends, without a CAD model."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.charts.chart import chart_for_points, chart_from_arrays
from hullrecon.geometry.charts.cylinder_chart import CylinderChart
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.typing import Array

RADIUS = 1.3  # m of the bilge
BOTTOM = 1.0  # m from the keel to where the bilge begins


def section(girth: Array) -> tuple[Array, Array]:
    """Places (n, 2) m to port and up from the keel, and outward normals, by girth (n,) m."""
    side, away = np.sign(girth), np.abs(girth)
    turn = np.clip((away - BOTTOM) / RADIUS, 0.0, np.pi / 2)
    up = np.maximum(away - BOTTOM - RADIUS * np.pi / 2, 0.0)
    out = np.minimum(away, BOTTOM) + RADIUS * np.sin(turn)
    place = np.stack([side * out, RADIUS * (1 - np.cos(turn)) + up], axis=1)
    return place, np.stack([side * np.sin(turn), -np.cos(turn)], axis=1)


def hull(low: float, high: float, gap: tuple[float, float] = (0, 0)) -> tuple[Array, Array, Array]:
    """Girth (n,), points of a hull and the sensors that see them (n, 3), in g."""
    rng = np.random.default_rng(5)
    girth = rng.uniform(low, high, 4000)
    girth = girth[(girth < gap[0]) | (girth > gap[1])]
    (place, normal), along = section(girth), rng.uniform(0, 6, len(girth))
    points = np.stack([along, -place[:, 0], 4 - place[:, 1]], axis=1)
    outward = np.stack([0 * along, -normal[:, 0], -normal[:, 1]], axis=1)
    return girth, points, points + 1.15 * outward


def noisy(points: Array) -> Array:
    """Points (n, 3) as a DVL measures them, to a centimetre."""
    return points + np.random.default_rng(6).normal(0, 0.01, points.shape)


def test_chart_of_a_flat_side_is_a_plane() -> None:
    _, points, sensors = hull(3.5, 6.0)
    assert isinstance(chart_for_points(noisy(points), sensors), PlaneChart)


@pytest.mark.parametrize(
    ("low", "high", "gap", "most"),
    [
        (0.2, 6.0, (0, 0), 0.04),  # from the bottom around the bilge
        (-6.0, 6.0, (0, 0), 0.04),  # from side to side under the keel: no plane shows that
        (0.2, 6.0, (1.6, 2.6), 0.08),  # half of the bilge unseen
    ],
)
def test_girth_of_a_bent_hull_is_arc(
    low: float, high: float, gap: tuple[float, float], most: float
) -> None:
    girth, points, sensors = hull(low, high, gap)
    chart = chart_for_points(noisy(points), sensors)
    assert isinstance(chart, CylinderChart)
    at = chart.to_chart(points)
    sense, start = np.polyfit(girth, at[:, 1], 1)
    assert np.abs(at[:, 1] - np.sign(sense) * girth - start).max() < most
    assert np.abs(at[:, 2]).max() < 0.05
    assert np.ptp(at[:, 0]) == pytest.approx(np.ptp(points[:, 0]), abs=0.02)


def test_chart_of_a_stem_is_bent_along() -> None:
    girth, points, sensors = hull(-6.0, 6.0)
    # the hull stood on its end: what was along is up
    chart = chart_for_points(points[:, [2, 1, 0]], sensors[:, [2, 1, 0]])
    at = chart.to_chart(points[:, [2, 1, 0]])
    assert np.ptp(at[:, 0]) == pytest.approx(np.ptp(girth), rel=0.02)
    assert np.corrcoef(at[:, 1], -points[:, 0])[0, 1] > 0.999


def test_cylinder_leads_there_and_back_and_is_left_handed() -> None:
    _, points, sensors = hull(-3.0, 6.0)
    chart = chart_for_points(noisy(points), sensors)
    # 0.3 m off the hull on either side, and 0.5 m beyond what was seen
    wanted = chart.to_chart(points) * [1.1, 1.1, 0] + [0, 0, 0.3] * np.resize([1, -1], (4000, 1))
    place, normal = chart.from_chart(wanted[:, :2])
    space = place + normal * wanted[:, 2:]
    assert np.allclose(chart.to_chart(space), wanted, atol=1e-6)
    again = chart_from_arrays(chart.to_arrays())
    assert np.array_equal(again.to_chart(space), chart.to_chart(space))
    step = 1e-4
    along, girth = (chart.from_chart(wanted[:, :2] + d)[0] - place for d in np.eye(2) * step)
    turn = (np.cross(along, girth) * normal).sum(axis=1) / step**2
    assert np.allclose(turn, -1.0, atol=0.01)


def test_cylinder_knows_nothing_of_unknown_places() -> None:
    _, points, sensors = hull(0.2, 6.0)
    chart = chart_for_points(np.vstack([points, [np.nan] * 3]), sensors)
    assert isinstance(chart, CylinderChart)
    assert np.isnan(chart.to_chart(np.full((1, 3), np.nan))).all()
    for part in chart.from_chart(np.array([[0.0, np.nan]])):
        assert np.isnan(part).all()
