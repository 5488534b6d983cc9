# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The map of a chart shows the hull as a viewer outside sees it, upright."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.charts.outside_map import OutsideMap, outside_map
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.meshes.mesh import Mesh


@pytest.mark.parametrize(("y", "signs"), [(3.0, (-1, 1)), (-3.0, (1, -1))])
def test_x_y_and_outward_are_right_handed_and_y_is_up(
    steel: Mesh, y: float, signs: tuple[int, int]
) -> None:
    chart = chart_for_hull(steel)
    points = np.array([[5.0, y, 2.7], [6.0, y, 2.5]])
    seen = outside_map(chart, points, "M")
    assert (seen.x_sign, seen.y_sign) == signs
    along, girth = tangents_at(chart, points)
    right, up = seen.x_sign * along, seen.y_sign * girth
    _, outward = chart.from_chart(chart.to_chart(points)[:, :2])
    assert (np.einsum("ni,ni->n", np.cross(right, up), outward) > 0.9).all()
    assert (up[:, 2] > 0.9).all()


def test_there_and_back_is_the_same() -> None:
    at = np.array([[1.0, 2.0], [-3.0, 4.5]])
    for signs in ((1, 1), (-1, 1), (1, -1)):
        seen = OutsideMap(x_sign=signs[0], y_sign=signs[1], frame="M")
        np.testing.assert_array_equal(seen.to_chart(seen.to_map(at)), at)
        assert seen.flips == (signs[0] < 0, signs[1] < 0)


def test_coordinate_system_is_local_and_metric() -> None:
    from rasterio.crs import CRS

    for frame, words in (("M", "the ship"), ("g", "the survey")):
        seen = OutsideMap(x_sign=-1, y_sign=1, frame=frame)
        crs = CRS.from_wkt(seen.wkt)
        assert not crs.is_geographic
        assert not crs.is_projected
        assert 'UNIT["metre",1]' in crs.to_wkt()
        assert words in crs.to_wkt()
        assert "x = -along, y = girth" in crs.to_wkt()


def test_tangents_are_unit_vectors_on_the_surface() -> None:
    plane = PlaneChart(np.zeros(3), np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, -1]]))
    along, girth = tangents_at(plane, np.array([[3.0, 4.0, 0.2]]))
    np.testing.assert_allclose(along, [[1, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(girth, [[0, 1, 0]], atol=1e-12)


@pytest.mark.parametrize(
    ("up", "turn"),
    [
        ((0, 1, 0), [[1, 0, 0], [0, 0, 1], [0, -1, 0]]),
        ((1, 0, 0), [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
        ((0, 0, -1), [[1, 0, 0], [0, -1, 0], [0, 0, -1]]),
    ],
)
def test_map_is_upright_whichever_axis_is_up(
    steel: Mesh, up: tuple[int, int, int], turn: list[list[int]]
) -> None:
    points = np.array([[5.0, 3.0, 2.7], [6.0, 3.0, 2.5]])
    to_file = np.array(turn, float)
    chart = chart_for_hull(Mesh(steel.vertices @ to_file.T, steel.faces), up)
    turned, plain = (
        outside_map(chart, points @ to_file.T, "M"),
        outside_map(chart_for_hull(steel), points, "M"),
    )
    assert (turned.x_sign, turned.y_sign) == (plain.x_sign, plain.y_sign)
    np.testing.assert_array_equal(chart.ship_axes @ to_file, np.eye(3))
