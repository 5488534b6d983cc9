# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.hull_position import HullError, area_sigma
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.records.solution import HullPose


def _hull_pose(covariance: np.ndarray) -> HullPose:
    """Upside down in g, with the survey's middle at x = 2."""
    return HullPose(
        global_from_hull=from_mount([0, 0, 0, 180, 0, 0]),
        covariance=covariance,
        survey_center=np.array([2.0, 0, 0]),
    )


def test_a_hull_that_turns_about_the_surveys_middle_carries_the_dive_around_it() -> None:
    off = HullError(hull_pose=_hull_pose(np.eye(6)), error=np.array([0, 0, 0, 0, 0, np.pi / 2]))
    moved = off.poses(Poses(np.array([[0.0, 0, 0, 1]]), np.array([[3.0, 0, 1]])))
    np.testing.assert_allclose(moved.translation, [[2.0, -1.0, 1.0]], atol=1e-12)
    np.testing.assert_allclose(moved.rotation.as_rotvec(), [[0, 0, -np.pi / 2]], atol=1e-12)
    np.testing.assert_array_equal(off.points(np.array([[3.0, 0, 1]])), moved.translation)


def test_a_hull_that_lies_off_to_one_side_leaves_the_dive_on_the_other() -> None:
    off = HullError(hull_pose=_hull_pose(np.eye(6)), error=np.array([0.1, 0.2, 0.3, 0, 0, 0]))
    np.testing.assert_allclose(off.points(np.zeros((1, 3))), [[-0.1, 0.2, 0.3]], atol=1e-12)


def test_the_sigma_of_an_area_is_how_much_it_grows_with_one_sigma_of_each_error() -> None:
    """Three square metres a metre along and four across, of errors that are correlated."""
    covariance = np.zeros((6, 6))
    covariance[:2, :2] = [[0.04, 0.01], [0.01, 0.09]]
    slope = np.array([3.0, 4.0])
    found = area_sigma(lambda off: 7 + float(slope @ off.error[:2]), _hull_pose(covariance))
    assert found == pytest.approx(np.sqrt(slope @ covariance[:2, :2] @ slope), abs=1e-4)
