# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where on the ship, beside x, y, z."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from hullrecon.dive.config.schema import Hull
from hullrecon.report.export.tables import (
    chart_coordinates,
    trajectory_table,
    vehicle_depth,
)
from hullrecon.report.survey import Survey

POINTS = np.array([[3.0, -1.2, 0.0], [6.0, 2.0, 0.1], [9.0, 0.001, 0.0]])


@dataclass(frozen=True)
class ShipChart:
    """along is x, girth is y; aft of x = 4 it ends."""

    def to_chart(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        out = np.asarray(points, float) * [1, 1, -1]
        out[out[:, 0] < 4] = np.nan
        return out

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        return {"kind": np.array("axis")}


@pytest.fixture
def on_ship(survey: Survey) -> Survey:
    return replace(
        survey,
        surfaces=replace(survey.surfaces, chart=ShipChart()),  # type: ignore[arg-type]
        facts=replace(survey.facts, hull=Hull(mesh="hull.stl", frame_spacing=0.6)),
    )


def test_a_point_has_along_girth_side_and_frame(on_ship: Survey) -> None:
    at = chart_coordinates(on_ship, POINTS)
    np.testing.assert_allclose(at.along, [np.nan, 6.0, 9.0])
    np.testing.assert_allclose(at.girth, [np.nan, 2.0, 0.001])
    assert at.side == ["", "port", "keel"]
    np.testing.assert_allclose(at.frame, [np.nan, 10.0, 15.0])


def test_without_spacing_there_are_no_frames(on_ship: Survey) -> None:
    bare = replace(on_ship, facts=replace(on_ship.facts, hull=Hull(mesh="hull.stl")))
    assert np.isnan(chart_coordinates(bare, POINTS).frame).all()


def test_a_plane_has_neither_side_nor_frame(survey: Survey) -> None:
    at = chart_coordinates(survey, POINTS)
    np.testing.assert_allclose(at.along, POINTS[:, 0])
    assert at.side == ["", "", ""]
    assert np.isnan(at.frame).all()


def test_without_a_chart_all_is_lost(bare: Survey) -> None:
    at = chart_coordinates(bare, POINTS)
    assert np.isnan(np.stack([at.along, at.girth, at.frame])).all()
    assert at.side == ["", "", ""]


def test_depth_is_of_the_adjusted_or_the_reckoned_path(survey: Survey, bare: Survey) -> None:
    np.testing.assert_allclose(vehicle_depth(survey), 2.0)
    np.testing.assert_allclose(vehicle_depth(bare), 2.0)
    blind = replace(bare, facts=replace(bare.facts, has_depth=False))
    (depth,) = (c for c in trajectory_table(blind).columns if c.name == "depth")
    assert set(depth.values) == {""}
