# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A path whose heading is off, and the CAD model that fits it turned."""

from dataclasses import replace

import numpy as np
import pytest
from adjustment.scenes import TRUTH, cad_model, side, survey
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.hull_pose.other_headings import (
    describe_height,
    describe_turn,
    find_fitting_heading,
    height_below_guess,
    turn_from_guess,
)
from hullrecon.adjustment.hull_pose.pose_cost import perturb_pose
from hullrecon.adjustment.hull_pose.registration import register
from hullrecon.geometry.poses import Poses

MESH = side(1.0)
LOCAL = survey(MESH, np.random.default_rng(0))
BEGAN = TRUTH.apply(LOCAL.min(axis=0)[None])[0]
PLACE = Poses(TRUTH.quaternion, TRUTH.translation - BEGAN)  # global_from_hull
POINTS = PLACE.apply(LOCAL)


def turned(degrees):
    """Points of a path that is turned about where it began."""
    return Rotation.from_euler("z", degrees, degrees=True).apply(POINTS)


def model():
    return cad_model(MESH, PLACE, np.zeros(6))


def test_small_turn_is_told_from_a_guess_that_is_elsewhere():
    found = register(turned(25.0), model(), 0.01)
    assert found.sigmas_off > 3.5
    assert np.degrees(turn_from_guess(found)) == pytest.approx(25.0, abs=3.0)
    assert "imu.mount_deg" in describe_turn(turn_from_guess(found))
    assert "hull.pose" in describe_turn(turn_from_guess(found))
    elsewhere = perturb_pose(PLACE, found.center, np.r_[0.0, 0.0, -1.5, np.zeros(3)])
    away = register(POINTS, replace(model(), guess=elsewhere), 0.01)
    assert away.sigmas_off > 3.5
    assert turn_from_guess(away) is None


@pytest.mark.parametrize("lower_m", [10.1, -3.0])
def test_depths_that_are_all_off_are_told_from_a_turn(lower_m):
    found = register(POINTS, model(), 0.01)
    lower = Poses(PLACE.quaternion, PLACE.translation + np.r_[0.0, 0.0, lower_m])
    off = replace(found, global_from_hull=lower, sigmas_off=10.0, cad_model=_wider(found, 10.0))
    assert height_below_guess(off) == pytest.approx(lower_m, abs=0.05)
    assert turn_from_guess(off) is None
    words = describe_height(height_below_guess(off))
    assert f"{abs(lower_m):.1f} m {'lower' if lower_m > 0 else 'higher'}" in words
    assert ("pressure.unit" in words) == (lower_m == 10.1)
    aside = Poses(PLACE.quaternion, PLACE.translation + np.r_[8.0, 8.0, lower_m])
    assert height_below_guess(replace(off, global_from_hull=aside)) is None


def _wider(found, times):
    return replace(found.cad_model, guess_sigma=times * found.cad_model.guess_sigma)


def test_large_turn_is_found_where_no_pose_nearby_fits():
    degrees = -160.0
    turn, fitness = find_fitting_heading(turned(degrees), model(), 0.01)
    assert fitness > 0.95
    assert np.degrees(turn) == pytest.approx(degrees, abs=5.0)


def test_points_of_no_hull_fit_at_no_heading():
    rough = POINTS + 0.4 * np.random.default_rng(1).standard_normal(POINTS.shape)
    assert find_fitting_heading(rough, model(), 0.01) is None
