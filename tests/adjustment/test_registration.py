# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
from adjustment.scenes import ERROR, TRUTH, cad_model, lying, side, survey

from hullrecon.adjustment.hull_pose import registration
from hullrecon.adjustment.hull_pose.cad_error import matern32
from hullrecon.adjustment.hull_pose.observability import find_weak_directions
from hullrecon.adjustment.hull_pose.pose_cost import frame_at, perturb_pose
from hullrecon.adjustment.hull_pose.registration import register, thin_points
from hullrecon.geometry.meshes.mesh import Mesh


def test_a_curved_side_is_found_from_a_wrong_guess():
    rng = np.random.default_rng(0)
    mesh = side(1.0)
    points = TRUTH.apply(survey(mesh, rng))
    found = register(points, cad_model(mesh, TRUTH, ERROR), 0.01)
    middle = frame_at(found.center)
    apart = (found.global_from_hull @ middle).inverse() @ TRUTH @ middle
    step = np.r_[
        found.global_from_hull.rotation.apply(apart.translation)[0], apart.rotation.as_rotvec()[0]
    ]
    # 99 % of chi-square with six degrees of freedom
    assert step @ np.linalg.solve(found.covariance, step) < 16.8
    assert np.sqrt(np.mean(found.residual**2)) < 0.015
    assert found.fitness > 0.95


def test_a_hull_of_unknown_height_is_found_metres_above_its_guess():
    plain = side(1.0)
    strakes = 0.15 * np.sin(2 * np.pi * plain.vertices[:, 2] / 1.6)  # it nearly fits each of them
    mesh = Mesh(plain.vertices + np.c_[0 * strakes, strakes, 0 * strakes], plain.faces)
    points = TRUTH.apply(survey(mesh, np.random.default_rng(0)))
    given = cad_model(mesh, TRUTH, np.r_[0.2, 0.0, 1.8, np.zeros(3)])
    sigma = given.guess_sigma.copy()
    sigma[2] = 2.4  # as without a measured depth
    found = register(points, replace(given, guess_sigma=sigma), 0.01)
    apart = found.global_from_hull.apply(found.center[None]) - TRUTH.apply(found.center[None])
    assert abs(apart[0, 2]) < 0.1
    assert registration.at_other_heights(given.guess, given, found.center) == []


def test_wider_search_keeps_sigma_of_package_guess(monkeypatch):
    mesh = side(1.0)
    points = TRUTH.apply(survey(mesh, np.random.default_rng(0)))
    given = cad_model(mesh, TRUTH, ERROR)
    near, asked = registration._register_from, []

    def poor_at_first(*words):
        asked.append(words[2].guess_sigma)
        return replace(near(*words), fitness=0.5 if len(asked) == 1 else 1.0)

    monkeypatch.setattr(registration, "_register_from", poor_at_first)
    found = register(points, given, 0.01)
    assert (asked[1] > asked[0]).all()
    assert found.fitness > 0.95
    assert found.sigmas_off == 1.0
    np.testing.assert_array_equal(found.cad_model.guess_sigma, given.guess_sigma)


def test_a_cylinder_slides_along_itself_and_says_so():
    rng = np.random.default_rng(1)
    mesh = side(0.0)
    found = register(TRUTH.apply(survey(mesh, rng)), cad_model(mesh, TRUTH, ERROR), 0.01)
    turn = np.kron(np.eye(2), np.eye(3))
    turn[:3, :3] = found.global_from_hull.rotation.as_matrix()[0].T
    weak = find_weak_directions(turn @ found.covariance @ turn.T, np.eye(3))
    assert weak[0]["kind"] == "position"
    assert np.abs(weak[0]["direction"][0]) > 0.99
    assert weak[0]["sigma"] == pytest.approx(1.0, abs=0.1)  # what the guess said, no more
    assert "along the hull" in weak[0]["sentence"]


def test_weak_directions_name_each_ship_axis_once():
    axes = np.eye(6)
    axes[3:5, 3:5] = np.array([[0.8, -0.6], [0.6, 0.8]])
    covariance = axes @ np.diag(np.r_[1e-6, 0.2, 1e-6, np.radians([0.9, 2.0, 0.6])]) ** 2 @ axes.T
    found = find_weak_directions(covariance, np.eye(3))
    assert [w["sigma"] for w in found] == pytest.approx([0.2, *np.radians([2.0, 0.9, 0.6])])
    position, *attitude = [w["sentence"] for w in found]
    assert position.startswith("The position across the hull is uncertain by 0.20 m")
    assert attitude == [
        # hypot(0.6 * 0.9, 0.8 * 2.0)
        "The trim of the hull is uncertain by 1.69 degrees (one sigma).",
        "The heel of the hull is uncertain by 1.40 degrees (one sigma).",
        "The heading of the hull is uncertain by 0.60 degrees (one sigma).",
    ]


@pytest.mark.parametrize(
    "ship_axes",
    [
        [[1, 0, 0], [0, 0, -1], [0, 1, 0]],  # y up
        [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],  # along y
        [[0, -1, 0], [0, 0, 1], [-1, 0, 0]],  # x down, the bow against y
    ],
)
def test_weak_direction_sentences_use_ship_axes(ship_axes):
    in_hull = np.kron(np.eye(2), np.array(ship_axes, float).T)
    sigma = np.r_[0.3, 0.2, 0.1, np.radians([3.0, 2.0, 1.0])]
    found = find_weak_directions(
        in_hull @ np.diag(sigma**2) @ in_hull.T, np.array(ship_axes, float)
    )
    assert [w["sentence"].partition(" (one")[0] for w in found] == [
        "The position along the hull is uncertain by 0.30 m",
        "The position across the hull is uncertain by 0.20 m",
        "The position vertically is uncertain by 0.10 m",
        "The heel of the hull is uncertain by 3.00 degrees",
        "The trim of the hull is uncertain by 2.00 degrees",
        "The heading of the hull is uncertain by 1.00 degrees",
    ]
    for weak, axis in zip(found, [*ship_axes, *ship_axes], strict=True):
        np.testing.assert_allclose(weak["direction"], np.abs(axis))  # in M


def test_starts_follow_ship_axes_of_any_model_file():
    model, center = cad_model(side(1.0), TRUTH, ERROR), np.array([6.0, 3.0, 2.0])
    turned, turn = lying(model)
    points = TRUTH.apply(survey(side(1.0), np.random.default_rng(0)))[:400]
    for plain, found in (
        (registration._starts(model, center), registration._starts(turned, turn @ center)),
        (
            registration._distant_starts(points, model, center),
            registration._distant_starts(points, turned, turn @ center),
        ),
    ):
        at = np.array([[6.0, 3.0, 2.0], [-4.0, 2.0, 1.0], [0.0, 0.0, 5.0]])
        for one, other in zip(plain, found, strict=True):
            np.testing.assert_allclose(other.apply(at @ turn.T), one.apply(at), atol=1e-9)


def test_thinning_averages_voxels_and_obeys_limit():
    points = np.array([[0.1, 0.1, 0.1], [0.3, 0.1, 0.1], [2.5, 0.2, 0.2]])
    np.testing.assert_allclose(thin_points(points, 1.0, 10), [[0.2, 0.1, 0.1], [2.5, 0.2, 0.2]])
    assert len(thin_points(np.random.default_rng(2).uniform(0, 3, (5000, 3)), 0.05, 300)) <= 300


def test_matern_starts_at_its_variance_and_falls():
    at = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 1.5]])
    k = matern32(at, 0.02, (3.0, 1.5))
    expected = 4e-4 * (1 + np.sqrt(3)) * np.exp(-np.sqrt(3))
    np.testing.assert_allclose(np.diag(k), 4e-4)
    np.testing.assert_allclose(k[0, 1:], expected)


def test_a_step_turns_about_the_centre():
    center = np.array([20.0, 4.0, 2.0])
    moved = perturb_pose(TRUTH, center, np.r_[0, 0, 0, 0.0, 0.0, 0.1])
    np.testing.assert_allclose(moved.apply(center[None]), TRUTH.apply(center[None]), atol=1e-12)
    assert (TRUTH.inverse() @ moved).rotation.magnitude()[0] == pytest.approx(0.1)
