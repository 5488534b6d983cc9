# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""An object's place has a covariance of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.base_surface import BaseSurface, HullError, area_sigma, hull_position
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.records.solution import HullPose
from hullrecon.records.surface import Surface

CENTER, NORMAL = np.array([1.5, 2.1, 2.0]), np.array([0.0, 1.0, 0.0])
SHARED = np.tile(np.diag([0.3, 0.02, 0.05]) ** 2, (5, 1, 1))


@pytest.fixture
def base(wall) -> BaseSurface:
    n = len(wall.vertices)
    return BaseSurface(
        cad_model=wall,
        surveyed=Surface(
            vertices=wall.vertices,
            faces=wall.faces,
            deviation=np.zeros(n),
            sigma=np.ones(n),
            support=np.ones(n, np.int64),
        ),
        chart=PlaneChart(np.array([0.0, 2.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])),
        result_from_global=from_mount([0, 0, 8, 180, 0, 0]),
        frame_spacing_m=None,
    )


def test_an_objects_sigmas_are_its_landmarks_and_its_own_shapes(base: BaseSurface) -> None:
    place = hull_position(CENTER, NORMAL, SHARED, 0.015, 0.01, base)
    np.testing.assert_allclose(place.sigma, np.hypot([0.3, 0.05, 0.02], [0.01, 0.01, 0.015]))
    np.testing.assert_allclose(
        np.sqrt(np.diag(place.covariance)), np.hypot([0.3, 0.02, 0.05], [0.01, 0.015, 0.01])
    )


def test_its_depth_is_as_uncertain_as_its_place_upwards(base: BaseSurface) -> None:
    place = hull_position(CENTER, NORMAL, SHARED, 0.0, 0.0, base)
    assert place.depth == pytest.approx(6.0)
    assert place.depth_sigma == pytest.approx(0.05)


def test_depth_has_sigma_of_separately_known_water(
    base: BaseSurface,
) -> None:
    beside = replace(base, depth_sigma_m=0.09)
    assert hull_position(CENTER, NORMAL, SHARED, 0.0, 0.0, beside).depth_sigma == pytest.approx(
        0.09
    )
    assert hull_position(CENTER, NORMAL, SHARED, 0.0, 0.03, beside).depth_sigma == pytest.approx(
        np.hypot(0.09, 0.03)
    )


def test_its_address_is_no_finer_than_its_sigma(base: BaseSurface) -> None:
    row = hull_position(CENTER, NORMAL, SHARED, 0.0, 0.0, base).members(base)
    assert row["address"] == "1.5 ± 0.3 m along, 2.00 ± 0.05 m across, 6.0 ± 0.1 m below waterline"
    assert (row["along"], row["girth"], row["side"], row["frame"]) == (1.5, 2.0, None, None)


def test_without_a_pressure_sensor_no_depth_is_given(base: BaseSurface) -> None:
    dry = replace(base, depth_known=False)
    row = hull_position(CENTER, NORMAL, SHARED, 0.0, 0.0, dry).members(dry)
    assert (row["depth"], row["depth_sigma"]) == (None, None)
    assert "waterline" not in str(row["address"])


def test_off_the_chart_an_object_has_no_chart_coordinates(base: BaseSurface) -> None:
    lost = hull_position(np.full(3, np.nan), NORMAL, SHARED, 0.0, 0.0, base).members(
        replace(base, depth_known=False)
    )
    assert (lost["along"], lost["girth"], lost["side"]) == (None, None, None)


def _hull_pose(covariance: np.ndarray) -> HullPose:
    """Upside down in g, with the survey's middle at x = 2."""
    return HullPose(
        global_from_hull=from_mount([0, 0, 0, 180, 0, 0]),
        covariance=covariance,
        survey_center=np.array([2.0, 0, 0]),
    )


def test_turned_hull_carries_dive_around_survey_middle() -> None:
    off = HullError(hull_pose=_hull_pose(np.eye(6)), error=np.array([0, 0, 0, 0, 0, np.pi / 2]))
    moved = off.poses(Poses(np.array([[0.0, 0, 0, 1]]), np.array([[3.0, 0, 1]])))
    np.testing.assert_allclose(moved.translation, [[2.0, -1.0, 1.0]], atol=1e-12)
    np.testing.assert_allclose(moved.rotation.as_rotvec(), [[0, 0, -np.pi / 2]], atol=1e-12)
    np.testing.assert_array_equal(off.points(np.array([[3.0, 0, 1]])), moved.translation)


def test_shifted_hull_leaves_dive_on_other_side() -> None:
    off = HullError(hull_pose=_hull_pose(np.eye(6)), error=np.array([0.1, 0.2, 0.3, 0, 0, 0]))
    np.testing.assert_allclose(off.points(np.zeros((1, 3))), [[-0.1, 0.2, 0.3]], atol=1e-12)


def test_area_sigma_is_growth_by_one_sigma_of_each_error() -> None:
    """Three square metres a metre along and four across, of errors that are correlated."""
    covariance = np.zeros((6, 6))
    covariance[:2, :2] = [[0.04, 0.01], [0.01, 0.09]]
    slope = np.array([3.0, 4.0])
    found = area_sigma(lambda off: 7 + float(slope @ off.error[:2]), _hull_pose(covariance))
    assert found == pytest.approx(np.sqrt(slope @ covariance[:2, :2] @ slope), abs=1e-4)
