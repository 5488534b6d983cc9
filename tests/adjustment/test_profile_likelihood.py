# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from adjustment.scenes import ERROR, TRUTH, cad_model, side, survey
from scipy.linalg import cho_factor

from hullrecon.adjustment.hull_pose import cad_error
from hullrecon.adjustment.hull_pose.pose_cost import HullPoseCost, perturb_pose
from hullrecon.adjustment.hull_pose.profile_likelihood import (
    Valley,
    inflate_covariance,
    minimise_cost,
    moment_of_minima,
    posterior_covariance,
    profile,
    raise_to_moment,
)
from hullrecon.adjustment.hull_pose.registration import thin_points
from hullrecon.geometry import poses
from hullrecon.geometry.pose_solver import LinearisedCost

ALONG = np.array([1.0, 0.0, 0.0])


@lru_cache
def profiled(fullness, span=(2.0, 11.0), sigma=0.02, start_off_m=0.0):
    mesh = side(fullness)
    points = thin_points(TRUTH.apply(survey(mesh, np.random.default_rng(4), span)), 0.3, 600)
    model = cad_model(mesh, TRUTH, 0 * ERROR)
    model = model.__class__(**{**model.__dict__, "deviation_sigma": sigma})
    center = TRUTH.inverse().apply(points).mean(0)
    known = cad_error.CadError(sigma=sigma, length=model.deviation_length, noise=0.01, offset=0.0)
    factor = cho_factor(
        cad_error.distance_covariance(known, model, TRUTH.inverse().apply(points)), lower=True
    )
    cost = HullPoseCost(points=points, cad_model=model, center=center, factor=factor)
    start = perturb_pose(TRUTH, center, np.r_[start_off_m, 0, 0, 0, 0, 0])
    return profile(Valley(cost=cost, direction=ALONG), start, reach=3.0), center


def started_off(shift_m):
    return profiled(1.0, start_off_m=shift_m)


def test_a_cylinder_leaves_the_prior_s_sigma_along_itself():
    found, _ = profiled(0.0)
    assert found.sigma == pytest.approx(1.0, abs=0.1)
    assert found.mean == pytest.approx(0.0, abs=0.2)


def test_curvature_narrows_the_profile_and_truth_lies_within():
    found, _ = profiled(1.0, sigma=0.005)
    assert found.sigma < 0.5
    assert abs(found.mean) < 3 * found.sigma


def test_the_cost_is_lowest_near_the_mean():
    found, _ = profiled(1.0, sigma=0.005)
    assert abs(found.step[np.argmin(found.cost)] - found.mean) < 2 * found.sigma
    assert found.cost.min() == 0.0


def test_inflation_gives_the_profile_s_sigma_and_never_less():
    found, _ = profiled(1.0)
    along = np.r_[found.global_from_hull.rotation.as_matrix()[0] @ ALONG, np.zeros(3)]
    wider = inflate_covariance(1e-6 * np.eye(6), found, found.global_from_hull)
    assert np.sqrt(along @ wider @ along) == pytest.approx(found.sigma, rel=0.05)
    np.testing.assert_array_equal(
        inflate_covariance(1e2 * np.eye(6), found, found.global_from_hull), 1e2 * np.eye(6)
    )


def test_the_tangent_follows_the_valley():
    found, center = profiled(1.0)
    moved = perturb_pose(found.global_from_hull, center, 0.1 * found.tangent)
    shift = found.global_from_hull.inverse().apply(moved.apply(center[None]))[0] - center
    assert shift[0] == pytest.approx(0.1, rel=0.1)


def test_the_tangent_does_not_depend_on_where_the_search_starts():
    """Between two fits alone it does: each ends in a flat valley, or at a facet's edge."""
    tangents = np.array(
        [found.tangent for found, _ in (profiled(1.0), *map(started_off, (0.05, 0.1, 0.15)))]
    )
    assert np.ptp(tangents[:, :3], axis=0).max() < 0.02
    assert np.ptp(tangents[:, 3:], axis=0).max() < 0.004


def test_sigma_of_parabolic_valley_is_that_of_hessian():
    """A tight prior along the hull makes it one."""
    mesh = side(0.0)
    points = thin_points(TRUTH.apply(survey(mesh, np.random.default_rng(4))), 0.3, 600)
    model = replace(
        cad_model(mesh, TRUTH, 0 * ERROR), guess_sigma=np.r_[0.05, 0.3, 0.3, np.radians([1, 1, 5])]
    )
    center = TRUTH.inverse().apply(points).mean(0)
    known = cad_error.CadError(sigma=0.02, length=model.deviation_length, noise=0.01, offset=0.0)
    factor = cho_factor(
        cad_error.distance_covariance(known, model, TRUTH.inverse().apply(points)), lower=True
    )
    cost = HullPoseCost(points=points, cad_model=model, center=center, factor=factor)
    valley = Valley(cost=cost, direction=ALONG)
    best, _ = minimise_cost(valley, TRUTH)
    along = np.r_[best.rotation.as_matrix()[0] @ ALONG, np.zeros(3)]
    hessian = np.sqrt(along @ posterior_covariance(valley, best) @ along)
    assert profile(valley, best, reach=0.2).sigma == pytest.approx(hessian, rel=0.1)
    assert hessian == pytest.approx(0.05, rel=0.1)


class TurningHull:
    """A cost of the hull's pose that turns it about its forward axis, and leaves it free across."""

    center = np.zeros(3)
    turn_rad, width_m = 1.2, 0.5

    def linearise(self, pose):
        off = np.r_[pose.translation[0], pose.rotation.as_rotvec()[0] - [self.turn_rad, 0, 0]]
        weight = np.r_[self.width_m**-2, 0.01, self.width_m**-2, np.full(3, 100.0)]
        return LinearisedCost(
            cost=0.5 * float(weight @ off**2), gradient=weight * off, information=np.diag(weight)
        )

    def update(self, pose, step):
        return perturb_pose(pose, self.center, step)


def test_a_hull_that_turns_stays_at_its_step_along_the_profile():
    upright = poses.from_rpy([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    valley = Valley(cost=TurningHull(), direction=np.array([0.0, 0.0, 1.0]))
    assert profile(valley, upright, reach=2.0).sigma == pytest.approx(TurningHull.width_m, rel=0.01)


class TwoHeights:
    """A cost of the hull's pose that fits at two heights, with half the sum of squares of each."""

    center = np.zeros(3)
    widths_m = np.array([0.02, 0.05])

    def __init__(self, apart_m, worse):
        self.apart_m, self.worse = apart_m, worse

    def linearise(self, pose):
        height = pose.translation[0, 2]
        off = (height - np.array([0.0, self.apart_m])) / self.widths_m
        near = int(height > self.apart_m / 2)
        information = np.diag([1.0, 1.0, self.widths_m[near] ** -2, 1.0, 1.0, 1.0])
        gradient = np.zeros(6)
        gradient[2] = off[near] / self.widths_m[near]
        cost = 0.5 * off[near] ** 2 + near * self.worse
        return LinearisedCost(cost=cost, gradient=gradient, information=information)

    def update(self, pose, step):
        return perturb_pose(pose, self.center, step)


@pytest.mark.parametrize("worse", [0.0, 1.0, 30.0])
def test_the_moment_of_two_minima_holds_both_as_they_weigh(worse):
    apart_m = 2.0
    valley = Valley(cost=TwoHeights(apart_m, worse), direction=np.array([0.0, 0.0, 1.0]))
    lower = poses.from_rpy([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    starts = [poses.from_rpy([0.0, 0.0, h], [0.0, 0.0, 0.0]) for h in (-0.5, 1.7, 2.3)]
    moment = moment_of_minima(valley, lower, starts)
    narrow, wide = TwoHeights.widths_m
    share = wide * np.exp(-worse) / (narrow + wide * np.exp(-worse))
    expected = (1 - share) * narrow**2 + share * (wide**2 + apart_m**2)
    assert moment[2, 2] == pytest.approx(expected, rel=0.01)
    np.testing.assert_allclose(np.diag(moment)[[0, 1, 3, 4, 5]], 1.0)


def test_a_covariance_is_raised_where_the_moment_exceeds_it_and_nowhere_else():
    covariance, moment = np.diag([4.0, 1.0, 9.0]), np.diag([1.0, 25.0, 9.0])
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    raised = raise_to_moment(turn @ covariance @ turn.T, turn @ moment @ turn.T)
    np.testing.assert_allclose(turn.T @ raised @ turn, np.diag([4.0, 25.0, 9.0]), atol=1e-9)
