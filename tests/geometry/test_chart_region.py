# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Parts of the hull between limits of its chart, on a half cylinder of 3 m radius and 20 m."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.charts.chart import Chart, chart_for_hull
from hullrecon.geometry.charts.region import MOST_CELLS, chart_limits, region_cells
from hullrecon.geometry.meshes.mesh import Mesh

HALF_GIRTH = 1.5 * np.pi


@pytest.fixture(scope="module")
def chart(steel: Mesh) -> Chart:
    return chart_for_hull(steel)


@pytest.mark.parametrize(
    ("along", "girth", "area"),
    [
        ((5.03, 9.07), (-1.52, 2.01), 4.04 * 3.53),
        ((5.0, 9.0), None, 4.0 * 2 * HALF_GIRTH),
        (None, (0.0, 1.0), 20.0),
        ((18.0, 99.0), (-4.0, 0.0), 8.0),
        ((30.0, 40.0), None, 0.0),
    ],
)
def test_the_area_is_that_of_the_surface_between_the_limits(
    chart: Chart, steel: Mesh, along, girth, area: float
) -> None:
    """Up to the sheer it ends some centimetres below it, as the chart does."""
    assert region_cells(chart, steel, along, girth).area.sum() == pytest.approx(
        area, rel=0.01 if girth else 0.02
    )


def test_cells_lie_on_surface_within_limits(chart: Chart, steel: Mesh) -> None:
    cells = region_cells(chart, steel, (5.0, 6.0), (1.0, 2.0))
    along, girth, offset = chart.to_chart(cells.middle).T
    assert (along.min(), along.max(), girth.min(), girth.max()) == pytest.approx(
        (5.025, 5.975, 1.025, 1.975), abs=2e-3
    )
    assert np.abs(offset).max() < 1e-6
    assert np.einsum("ni,ni->n", cells.normal, cells.middle - [0, 0, 3.0])[0] > 0


def test_area_of_leaning_hull_is_that_of_surface(steel: Mesh) -> None:
    """A bow that narrows by one in two: its plating is longer than the ship's axis along it."""
    leaning = Mesh(
        np.c_[steel.vertices[:, 0], steel.vertices[:, 1:] * (1.2 - 0.05 * steel.vertices[:, :1])],
        steel.faces,
    )
    cells = region_cells(chart_for_hull(leaning), leaning, None, None)
    a, b, c = leaning.vertices[leaning.faces].transpose(1, 0, 2)
    assert cells.area.sum() == pytest.approx(
        np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2, rel=0.02
    )


def test_a_large_part_has_wider_cells(
    chart: Chart, steel: Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hullrecon.geometry.charts.region.MOST_CELLS", 500)
    cells = region_cells(chart, steel, None, None)
    assert len(cells.area) <= 600
    assert cells.area.sum() == pytest.approx(20 * 2 * HALF_GIRTH, rel=0.02)
    assert MOST_CELLS == 200_000


def test_the_limits_of_the_chart_are_those_of_the_mesh(chart: Chart, steel: Mesh) -> None:
    np.testing.assert_allclose(
        chart_limits(chart, steel), [[0, 20], [-HALF_GIRTH, HALF_GIRTH]], atol=0.2
    )
    nothing = Mesh(np.full((1, 3), np.nan), np.zeros((0, 3), np.int32))
    assert chart_limits(chart, nothing).tolist() == [[0, 0], [0, 0]]
