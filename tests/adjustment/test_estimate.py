# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull's pose from points on it, with the CAD model's error as correlated noise."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from adjustment.scenes import TRUTH, cad_model, lying, side, survey
from adjustment.solved_dives import solved

from hullrecon.adjustment.hull_pose import estimate
from hullrecon.adjustment.hull_pose.observability import find_weak_directions
from hullrecon.adjustment.hull_pose.pose_cost import frame_at, perturb_pose, signed_distances
from hullrecon.adjustment.hull_pose.registration import register, thin_points
from hullrecon.adjustment.results.covariance import hull_axes
from hullrecon.geometry import poses
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.tessellation import tessellation_error

ALONG = np.array([1.0, 0.0, 0.0])
CURVED, CYLINDER = 1.0, 0.0
GUESS_ERROR = np.r_[0.3, 0.1, -0.1, np.radians([0.4, -0.4, 1.5])]


@lru_cache
def placed(fullness, structure_m=0.0):
    """A side of that fullness, points on it, a guess that is off about the survey; and what is
    found.
    """
    mesh, rng = side(fullness), np.random.default_rng(5)
    local = survey(mesh, rng)
    local[:, 1] += structure_m * ((abs(local[:, 0] - 6) < 0.4) & (abs(local[:, 2] - 2.5) < 0.4))
    points = thin_points(TRUTH.apply(local + 0.003 * rng.standard_normal(local.shape)), 0.35, 500)
    center = TRUTH.inverse().apply(points).mean(0)
    model = cad_model(mesh, TRUTH, 0 * GUESS_ERROR)
    model = replace(model, guess=perturb_pose(TRUTH, center, GUESS_ERROR), deviation_sigma=0.01)
    on_hull = estimate.HullPoints(xyz=points, by_range=np.zeros_like(points))
    evidence, best = estimate.fit_hull_pose(on_hull, model.guess, model, center)
    return evidence, best, estimate.profile_mean_pose(evidence, best)


def apart(found, center):
    """(6,): the found T_g_M less the truth, translation in M, about the centre."""
    middle = frame_at(center)
    return ((TRUTH @ middle).inverse() @ found @ middle).log()[0]


@lru_cache
def covariance_of(fullness):
    evidence, _, found = placed(fullness)
    return estimate.hull_pose_covariance(evidence, found)


def axes_of(fullness):
    """The same along the hull's axes."""
    return hull_axes(covariance_of(fullness), placed(fullness)[2])


def along_axes(evidence, found):
    return hull_axes(estimate.hull_pose_covariance(evidence, found), found)


def test_curved_hull_is_found_within_three_sigmas():
    evidence, _, found = placed(CURVED)
    error, covariance = apart(found, evidence.center), axes_of(CURVED)
    assert np.all(np.abs(error) < 3 * np.sqrt(np.diag(covariance)))
    assert abs(error[1]) < 0.03
    assert np.abs(error[5]) < np.radians(1.0)


def test_profile_mean_on_curved_hull_is_nearer_than_guess():
    evidence, _, found = placed(CURVED)
    assert abs(apart(found, evidence.center)[0]) < abs(
        apart(evidence.cad_model.guess, evidence.center)[0]
    )


def test_cylinder_keeps_place_along_it_at_guess():
    evidence, _, found = placed(CYLINDER)
    assert apart(found, evidence.center)[0] == pytest.approx(
        apart(evidence.cad_model.guess, evidence.center)[0], abs=0.2
    )
    sigma = np.sqrt(axes_of(CYLINDER)[0, 0])
    assert sigma == pytest.approx(evidence.cad_model.guess_sigma[0], rel=0.25)


def test_along_a_cylinder_is_named_as_weak_and_across_it_is_not():
    weak = find_weak_directions(axes_of(CYLINDER), np.eye(3))
    positions = [w for w in weak if w["kind"] == "position"]
    assert len(positions) == 1
    assert abs(positions[0]["direction"][0]) > 0.98
    assert "along the hull" in positions[0]["sentence"]


def test_cylinder_is_profiled_along_any_axis_of_its_file():
    evidence, _, found = placed(CYLINDER)
    model, turn = lying(evidence.cad_model)
    turned = poses.from_matrix(
        np.block([[turn.T, np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])
    )
    there = replace(evidence, cad_model=model, center=turn @ evidence.center)
    sigma, plain = (
        np.sqrt(np.diag(c)[:3]) for c in (along_axes(there, found @ turned), axes_of(CYLINDER))
    )
    np.testing.assert_allclose(turn.T @ sigma, plain, rtol=0.02)
    at = np.array([[6.0, 3.0, 2.0], [-4.0, 2.0, 1.0]])
    mean = estimate.profile_mean_pose(there, found @ turned)
    np.testing.assert_allclose(
        mean.apply(at @ turn.T), estimate.profile_mean_pose(evidence, found).apply(at), atol=0.01
    )


def test_curvature_makes_the_place_along_the_hull_surer():
    of_curved, of_cylinder = (np.sqrt(axes_of(of)[0, 0]) for of in (CURVED, CYLINDER))
    assert of_curved < 0.8 * of_cylinder


@pytest.mark.parametrize("fullness", [CURVED, CYLINDER])
def test_covariance_is_no_narrower_than_points_allow(fullness):
    evidence, covariance = placed(fullness)[0], covariance_of(fullness)
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-6, atol=1e-12)
    assert (np.linalg.eigvalsh(covariance) > 0).all()
    assert covariance[0, 0] <= 1.5 * (evidence.cad_model.guess_sigma[:3] ** 2).max()


def test_points_on_a_structure_say_nothing_of_the_place():
    with_structure, bare = placed(CURVED, structure_m=0.25), placed(CURVED)
    assert len(with_structure[0].points) < len(bare[0].points)
    assert (
        np.abs(apart(with_structure[2], bare[0].center) - apart(bare[2], bare[0].center))[:3].max()
        < 0.08
    )


def test_the_answer_does_not_depend_on_where_the_search_starts():
    evidence, best, found = placed(CYLINDER)
    again = estimate.profile_mean_pose(
        evidence,
        perturb_pose(
            best, evidence.center, np.r_[TRUTH.rotation.as_matrix()[0] @ [0.1, 0, 0], 0, 0, 0]
        ),
    )
    assert abs(apart(again, evidence.center)[0] - apart(found, evidence.center)[0]) < 0.05


def test_points_of_dive_are_landmarks_on_hull_and_returns():
    found = solved()
    m, adjusted = found.dive.measured, found.adjusted
    label, unranged = adjusted.result.label, replace(m, returns=None)
    both, no_returns, none = (
        estimate.collect_hull_points(measured, adjusted.state, adjusted.chosen, labelled).xyz
        for measured, labelled in ((m, label), (unranged, label), (unranged, 0 * label + 1))
    )
    assert len(both) > len(no_returns) > 50
    assert len(none) > len(no_returns)  # those of the box
    landmarks = found.outcome.solution.landmarks
    on = landmarks.position[landmarks.label == 1]
    nearest = np.linalg.norm(no_returns[:, None] - on[None], axis=2).min(1)
    assert nearest.max() < 0.15


def test_ranges_to_no_scale_leave_the_hull_as_far_off():
    """Ranges of 1.2 m that may all be 8 % long leave a side 0.1 m nearer or farther open."""
    evidence, _, found = placed(CURVED)
    across = TRUTH.rotation.apply([[0.0, 1.0, 0.0]])
    doubtful = replace(evidence, by_range=0.08 * 1.2 * across * np.ones((len(evidence.points), 1)))
    sure, open_ = (
        np.sqrt(hull_axes(estimate.hull_pose_covariance(of, found), found)[1, 1])
        for of in (evidence, doubtful)
    )
    assert np.sqrt(open_**2 - sure**2) == pytest.approx(0.096, rel=0.1)


def test_a_plain_side_leaves_a_height_that_nothing_measured_open():
    """From a start that a round left tilted and low, on a side that is plain above its bilge."""
    curved = side(CURVED)
    x, y, height = curved.vertices.T
    straight = height > 1.8
    y = np.where(
        straight, y * (1 - (3.7 / 6) ** 4) ** 0.5 / (1 - ((5.5 - height) / 6) ** 4) ** 0.5, y
    )
    mesh = Mesh(np.c_[x, y, height], curved.faces)
    at = survey(mesh, np.random.default_rng(5))
    at = at[(at[:, 2] > 2.3) & (at[:, 2] < 4.3)][::4]
    model, center = cad_model(mesh, TRUTH, 0 * GUESS_ERROR), at.mean(0)
    model = replace(model, guess_sigma=np.where(np.arange(6) == 2, 2.1, model.guess_sigma))
    low = TRUTH.rotation.apply([[0.0, 0.0, -2.0]])[0]
    tilted = perturb_pose(TRUTH, center, np.r_[low, 0, np.radians(-4), 0])
    points = estimate.HullPoints(xyz=TRUTH.apply(at), by_range=np.zeros_like(at))
    evidence, found = estimate.fit_hull_pose(points, tilted, model, center)
    sigma_m = np.sqrt(along_axes(evidence, found)[2, 2])
    assert abs(apart(found, center)[2]) < sigma_m
    assert 1.0 < sigma_m < 2.5


def test_a_few_wrong_points_get_no_more_than_their_share():
    """The surface crosses cells in space: those that stood beside it held nothing but what was
    wrong, a point each.
    """
    mesh, rng = side(CURVED), np.random.default_rng(8)
    local = np.repeat(survey(mesh, rng), 20, axis=0) + 0.05 * rng.standard_normal(
        (20 * len(survey(mesh, rng)), 3)
    ) * [1, 0, 1]
    nearest = mesh.index.closest(local)
    wrong = rng.random(len(local)) < 0.03
    off = np.where(
        wrong, 0.045 * rng.choice([-1.0, 1.0], len(local)), 0.002 * rng.standard_normal(len(local))
    )
    points = TRUTH.apply(local + (off - nearest.distance)[:, None] * nearest.gradient)
    kept = estimate.thin_over_surface(points, TRUTH, cad_model(mesh, TRUTH, 0 * GUESS_ERROR))
    distance, _ = signed_distances(kept, TRUTH, np.zeros(3), mesh)
    assert 100 < len(kept) <= estimate.MAX_POINTS
    assert np.mean(np.abs(distance) > 0.03) < 0.03


def test_thinned_points_of_a_curved_hull_lie_on_it():
    """The mean of the points of a wide cell lies inside a bilge by more than the points' noise."""
    mesh, rng = side(CURVED), np.random.default_rng(9)
    local = np.repeat(survey(mesh, rng), 20, axis=0)
    local += 0.3 * rng.standard_normal(local.shape) * [1, 0, 1]
    nearest = mesh.index.closest(local)
    points = TRUTH.apply(local - nearest.distance[:, None] * nearest.gradient)
    model = cad_model(mesh, TRUTH, 0 * GUESS_ERROR)
    kept = estimate.thin_over_surface(points, TRUTH, model, most=25)
    distance, _ = signed_distances(kept, TRUTH, np.zeros(3), mesh)
    assert len(kept) > 10
    np.testing.assert_allclose(distance, 0, atol=1e-4)


def test_registration_finds_offset_whichever_way_guess_errs():
    mesh = side(CURVED)
    points = TRUTH.apply(survey(mesh, np.random.default_rng(2)))
    ends = []
    for sense in (1.0, -1.0):
        model = replace(cad_model(mesh, TRUTH, sense * GUESS_ERROR), deviation_sigma=0.01)
        found = register(points, model, 0.01)
        error = apart(found.global_from_hull, found.center)
        turned = np.sqrt(np.diag(hull_axes(found.covariance, found.global_from_hull)))
        assert np.all(np.abs(error) < 3.5 * turned), sense
        ends.append(error)
    assert np.abs(ends[0] - ends[1])[1] < 0.05


def test_registration_repeats_itself_to_the_byte():
    mesh = side(CURVED)
    points = TRUTH.apply(survey(mesh, np.random.default_rng(2)))
    once, again = (register(points, cad_model(mesh, TRUTH, GUESS_ERROR), 0.01) for _ in range(2))
    assert (
        once.global_from_hull.translation.tobytes() == again.global_from_hull.translation.tobytes()
    )
    assert once.covariance.tobytes() == again.covariance.tobytes()


def test_points_on_one_facet_share_out_its_information():
    """The same hull in coarser facets is known less well."""
    evidence, best, _ = placed(CURVED)
    v = evidence.cad_model.mesh.vertices.reshape(121, 41, 3)[::8, ::8].reshape(-1, 3)
    number = np.arange(len(v)).reshape(16, 6)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.vstack(
        [np.stack([a, c, b], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)]
    ).astype(np.int32)
    coarse = replace(
        evidence,
        cad_model=replace(evidence.cad_model, mesh=type(evidence.cad_model.mesh)(v, faces)),
    )
    at = best.inverse().apply(evidence.points)
    assert (
        tessellation_error(coarse.cad_model.mesh, at).sigma_m
        > 5 * tessellation_error(evidence.cad_model.mesh, at).sigma_m
    )
    fine, rough = (
        np.linalg.det(estimate.hull_pose_covariance(g, best)[:3, :3]) for g in (evidence, coarse)
    )
    assert rough > fine


def test_a_hull_pose_turned_in_g_turns_its_covariance_with_it():
    evidence, _, found = placed(CYLINDER)
    turn = poses.from_rpy([0.0, 0.0, 0.0], [0.0, 0.0, np.radians(70)])
    turned = replace(
        evidence,
        points=turn.apply(evidence.points),
        cad_model=replace(evidence.cad_model, guess=turn @ evidence.cad_model.guess),
    )
    spun = estimate.hull_pose_covariance(turned, turn @ found)
    np.testing.assert_allclose(
        hull_axes(spun, turn @ found), axes_of(CYLINDER), rtol=0.05, atol=1e-5
    )


def test_sigma_of_doubted_model_reaches_from_fit_to_guess():
    evidence, best, _ = placed(CURVED)
    agreed = estimate.hull_pose_covariance(evidence, best)
    contradicted = replace(evidence, cad_model=replace(evidence.cad_model, contradicted=True))
    added = hull_axes(estimate.hull_pose_covariance(contradicted, best) - agreed, best)
    guess = apart(evidence.cad_model.guess, evidence.center) - apart(best, evidence.center)
    np.testing.assert_allclose(np.sqrt(np.diag(added)[:3]), np.abs(guess[:3]), rtol=0.05, atol=0.01)
    # along the line between them, and nowhere else
    assert np.linalg.matrix_rank(added, tol=1e-9) == 1
