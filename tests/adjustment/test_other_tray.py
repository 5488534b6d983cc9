# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tray angles that are read wrongly are named where the CAD model fits them read otherwise."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from adjustment.test_cad_acceptance import true_path
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.cad_placement import Placement
from hullrecon.adjustment.contradictions import doubt_tray
from hullrecon.adjustment.hull_pose.other_tray import (
    READINGS,
    find_fitting_tray,
    find_tray_offset,
    turned_odometry,
    with_tray,
)
from hullrecon.adjustment.hull_pose.registration import register
from hullrecon.adjustment.hull_pose.shape_comparison import ShapeComparison
from hullrecon.adjustment.rounds import Phase
from hullrecon.errors import ContradictionError
from hullrecon.geometry.poses import Poses

SOLVED = true_path(camera=False)
RIG = SOLVED.state.mounted(SOLVED.measured.rig)
AGREES = ShapeComparison(patterns=20, deviation=0.8, plane=90.0)


def misread(factor):
    """The dive where the logged angles are those of the tray times a factor."""
    m, path = SOLVED.measured, SOLVED.state.path
    turn = (factor - 1) * 0.5 * (path.tray[m.odometry.first] + path.tray[m.odometry.second])
    moved = with_tray(path, m.odometry, factor * path.tray)
    return replace(
        SOLVED,
        state=replace(SOLVED.state, nodes=moved.poses, tray=moved.tray),
        measured=replace(
            m,
            odometry=turned_odometry(m.odometry, turn),
            returns=replace(m.returns, tray_offset=factor * m.returns.tray_offset),
        ),
    )


def found(factor):
    dive = misread(factor)
    m = dive.measured
    return find_fitting_tray(RIG, dive.state.path, m.odometry, m.returns, m.cad_model)


@pytest.mark.parametrize("reading", ["sign", "rad"])
def test_reading_with_which_the_cad_model_fits_is_named(reading):
    named, before_m, after_m = found(1 / READINGS[reading])
    assert named == reading
    assert after_m < 0.5 * before_m


def test_an_accepted_model_is_doubted_where_the_hull_leaves_it():
    path, lies = Phase.of((), misread(-1.0)), SimpleNamespace(sigmas_off=1.0)
    within, beyond = (
        replace(path, placement=Placement(registration=lies, shape=shape))
        for shape in (AGREES, replace(AGREES, deviation=3.0))
    )
    assert doubt_tray(path, within) is within
    with pytest.raises(ContradictionError, match="grow the other way"):
        doubt_tray(path, beyond)


@pytest.mark.parametrize("off_deg", [-14.0, 18.0])
def test_zero_of_the_tray_at_which_the_cad_model_lies_as_guessed_is_named(off_deg):
    off, m, path = np.radians(off_deg), SOLVED.measured, SOLVED.state.path
    odometry = turned_odometry(m.odometry, np.full(len(m.odometry.first), off))
    path = with_tray(path, m.odometry, path.tray + off)
    ends = RIG.dvl_points(m.returns, path).points[~m.returns.flagged]
    right = register(ends, m.cad_model, RIG.priors.range_sigma_m)
    # as it lies turned with the ends about the vehicle's y axis
    turn = Rotation.from_rotvec(off * path.poses.rotation.apply([0.0, 1.0, 0.0]).mean(axis=0))
    wider = replace(m.cad_model, guess_sigma=10 * m.cad_model.guess_sigma)
    turned = Poses(
        (turn * m.cad_model.guess.rotation).as_quat(), m.cad_model.guess.translation.copy()
    )
    lies = replace(right, global_from_hull=turned, sigmas_off=10.0, cad_model=wider)
    found_rad, rms_m = find_tray_offset(RIG, path, odometry, m.returns, lies)
    assert np.degrees(found_rad) == pytest.approx(off_deg, abs=0.1)
    assert rms_m < 0.04
    assert find_tray_offset(RIG, path, odometry, m.returns, right) is None  # it lies as guessed


def test_angles_as_they_are_are_not_doubted():
    assert found(1.0) is None
