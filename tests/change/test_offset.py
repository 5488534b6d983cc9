# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from change.simulated_surveys import (
    BEFORE,
    NONE,
    SIGMAS,
    Errors,
    _about_center,
    chart,
    drawn,
    survey,
)

from hullrecon.change.offset import estimate_offset, hull_pose_covariance, offset_sigma
from hullrecon.change.relief import relief_on, seen_points
from hullrecon.geometry.charts.lattice import lattice_around
from hullrecon.geometry.poses import exp, from_mount, identity
from hullrecon.records.change import SurveyOffset
from hullrecon.records.solution import HullPose


def offset_of(first, second):
    lattice = lattice_around(
        np.vstack([seen_points(s, chart())[0][:, :2] for s in (first, second)]), 0.02, 0.3
    )
    reliefs = (relief_on(lattice, chart(), first), relief_on(lattice, chart(), second))
    return estimate_offset(first, second, chart(), lattice, reliefs)


def error_of(offset: SurveyOffset, true) -> np.ndarray:
    gap = offset.first_from_second @ true.inverse()
    center = true.apply(offset.center[None])
    return np.r_[(gap.apply(center) - center)[0], gap.rotation.as_rotvec()[0]]


@pytest.fixture(scope="module")
def shifted():
    """The second dive lies 0.4 m farther forward on the CAD model, and 3 cm up, without other
    errors.
    """
    there = Errors(pose=np.array([0.4, 0.0, 0.03, 0, 0, 0]), seed=0, noise_m=0.0)
    return offset_of(survey(BEFORE, NONE), survey(BEFORE, there)), _about_center(
        there.pose
    ).inverse()


def test_a_shift_along_the_hull_is_found_to_millimetres(shifted) -> None:
    offset, true = shifted
    assert np.abs(error_of(offset, true)[:3]).max() < 0.003


def test_offset_does_not_depend_on_wide_hull_pose_sigma() -> None:
    # four sigmas of both are more than the four metres of the patch
    loose = np.array([1.5, *SIGMAS[1:]]) ** 2
    there = Errors(pose=np.array([0.4, 0.0, 0.03, 0, 0, 0]), seed=0, noise_m=0.0)
    first, second = (
        replace(found, hull_pose=replace(found.hull_pose, covariance=np.diag(loose)))
        for found in (survey(BEFORE, NONE), survey(BEFORE, there))
    )
    assert (
        np.abs(error_of(offset_of(first, second), _about_center(there.pose).inverse())[:3]).max()
        < 0.003
    )


def test_its_chi_square_counts_sigmas_of_both_hull_poses(shifted) -> None:
    offset, _ = shifted
    expected = 0.4**2 / (2 * SIGMAS[0] ** 2) + 0.03**2 / (2 * SIGMAS[2] ** 2)
    assert offset.chi_square == pytest.approx(expected, rel=0.25)
    assert 0.4 < offset.p_value < 0.8  # what 4 to 6 of 6 degrees of freedom are


def test_the_offset_is_much_better_known_than_the_hull_poses(shifted) -> None:
    offset, _ = shifted
    known, before = np.sqrt(np.diag(offset.covariance)), np.sqrt(np.diag(offset.prior_covariance))
    assert known[0] < 0.1 * before[0]


def test_errors_are_within_three_of_their_sigmas_over_seeds() -> None:
    nees = []
    for seed in (12, 13):
        a, b = drawn(seed), drawn(seed + 100)
        offset = offset_of(survey(BEFORE, a), survey(BEFORE, b))
        error = error_of(offset, _about_center(a.pose) @ _about_center(b.pose).inverse())
        nees.append(error @ np.linalg.solve(offset.covariance, error))
    assert max(nees) < 22.5  # chi-square of six degrees of freedom at 0.1 %


def test_hull_poses_hold_offset_without_structures() -> None:
    a, b = drawn(14), drawn(114)
    offset = offset_of(survey((), a, hull=5), survey((), b, hull=5))
    sigma = np.sqrt(np.diag(offset.covariance))
    error = error_of(offset, _about_center(a.pose) @ _about_center(b.pose).inverse())
    assert abs(error[0]) < 4 * sigma[0]
    assert sigma[1] < 0.01  # across the hull the form tells
    assert np.isfinite(sigma).all()


def test_a_hull_poses_covariance_is_turned_into_the_hull_frame() -> None:
    covariance = np.diag([0.01, 0.04, 0.09, 1e-6, 1e-6, 1e-6])
    quarter = HullPose(
        global_from_hull=from_mount([0, 0, 0, 0, 0, 90]),
        covariance=covariance,
        survey_center=np.zeros(3),
    )
    turned = hull_pose_covariance(quarter, np.zeros(3))
    assert np.diag(turned)[:3] == pytest.approx([0.04, 0.01, 0.09])


def test_far_from_its_center_a_rotation_moves_the_hull() -> None:
    covariance = np.diag([1e-12] * 3 + [0, 0, 0.01**2])
    pose = HullPose(global_from_hull=identity(), covariance=covariance, survey_center=np.zeros(3))
    there = hull_pose_covariance(pose, np.array([5.0, 0, 0]))
    assert np.sqrt(there[1, 1]) == pytest.approx(0.05)
    assert np.sqrt(there[0, 0]) < 1e-5


def test_offset_sigma_grows_with_distance_from_center() -> None:
    offset = SurveyOffset(
        first_from_second=exp(np.zeros((1, 6))),
        covariance=np.diag([0.001**2] * 3 + [0.001**2] * 3),
        prior_covariance=np.eye(6),
        center=np.zeros(3),
        chi_square=0.0,
        p_value=1.0,
    )
    points = np.array([[0.0, 0, 0], [10.0, 0, 0]])
    near, far = offset_sigma(offset, points, np.array([[0.0, 1, 0]] * 2))
    assert near == pytest.approx(0.001)
    assert far == pytest.approx(np.hypot(0.001, 0.01))
