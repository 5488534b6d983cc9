# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.adjustment.model import Drawing
from hullrecon.adjustment.registration import about, matern32, perturbed, register, thin
from hullrecon.adjustment.weak import weak_directions
from hullrecon.geometry import poses
from hullrecon.geometry.meshes import Mesh


class SideChart:
    """Along and height of a hull's port side; enough for correlation."""

    def to_chart(self, points):
        return np.c_[points[:, 0], points[:, 2], np.zeros(len(points))]


def side(fullness):
    """A port side y(x, z), 30 m long: `fullness` 0 is a cylinder, 1 curves strongly towards both ends."""
    x, z = np.meshgrid(np.linspace(-15, 15, 121), np.linspace(0, 5, 41), indexing="ij")
    y = 4.0 * (1 - fullness * (x / 15) ** 2 * 0.6) * np.sqrt(np.clip(1 - ((5.5 - z) / 6) ** 4, 0.01, None))
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.vstack([np.stack([a, c, b], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    return Mesh(np.stack([x, y, z], -1).reshape(-1, 3), faces.astype(np.int32))


def survey(mesh, rng, span=(2.0, 11.0)):
    v = mesh.vertices
    inside = (v[:, 0] > span[0]) & (v[:, 0] < span[1]) & (v[:, 2] > 0.8) & (v[:, 2] < 4.2)
    return v[inside] + 0.01 * rng.standard_normal((inside.sum(), 3))


def drawing(mesh, truth, error):
    guess = truth @ poses.exp(error)
    sigma = np.r_[1.0, 0.3, 0.3, np.radians([1, 1, 5])]
    return Drawing(mesh, SideChart(), guess, sigma, 0.02, (3.0, 1.5))


TRUTH = poses.from_rpy([10.0, 30.0, 3.0], np.radians([-179.0, 0.5, -95.0]))
ERROR = np.r_[0.5, 0.2, -0.1, np.radians([0.5, -0.5, 2.5])]


def test_a_curved_side_is_found_from_a_wrong_guess():
    rng = np.random.default_rng(0)
    mesh = side(1.0)
    points = TRUTH.apply(survey(mesh, rng))
    found = register(points, drawing(mesh, TRUTH, ERROR), 0.01)
    middle = about(found.center)
    apart = (found.hull_from @ middle).inverse() @ TRUTH @ middle
    step = np.r_[found.hull_from.rotation.apply(apart.translation)[0], apart.rotation.as_rotvec()[0]]
    assert step @ np.linalg.solve(found.covariance, step) < 16.8  # 99 % of chi-square with six degrees of freedom
    assert np.sqrt(np.mean(found.residual**2)) < 0.015
    assert found.fitness > 0.95


def test_a_cylinder_slides_along_itself_and_says_so():
    rng = np.random.default_rng(1)
    mesh = side(0.0)
    found = register(TRUTH.apply(survey(mesh, rng)), drawing(mesh, TRUTH, ERROR), 0.01)
    turn = np.kron(np.eye(2), np.eye(3))
    turn[:3, :3] = found.hull_from.rotation.as_matrix()[0].T
    weak = weak_directions(turn @ found.covariance @ turn.T)
    assert weak[0]["kind"] == "position"
    assert np.abs(weak[0]["direction"][0]) > 0.99
    assert weak[0]["sigma"] == pytest.approx(1.0, abs=0.1)  # what the guess said, no more
    assert "along the hull" in weak[0]["sentence"]


def test_thinning_takes_the_mean_of_each_voxel_and_obeys_the_limit():
    points = np.array([[0.1, 0.1, 0.1], [0.3, 0.1, 0.1], [2.5, 0.2, 0.2]])
    np.testing.assert_allclose(thin(points, 1.0, 10), [[0.2, 0.1, 0.1], [2.5, 0.2, 0.2]])
    assert len(thin(np.random.default_rng(2).uniform(0, 3, (5000, 3)), 0.05, 300)) <= 300


def test_matern_starts_at_its_variance_and_falls():
    at = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 1.5]])
    k = matern32(at, 0.02, (3.0, 1.5))
    expected = 4e-4 * (1 + np.sqrt(3)) * np.exp(-np.sqrt(3))
    np.testing.assert_allclose(np.diag(k), 4e-4)
    np.testing.assert_allclose(k[0, 1:], expected)


def test_a_step_turns_about_the_centre():
    center = np.array([20.0, 4.0, 2.0])
    moved = perturbed(TRUTH, center, np.r_[0, 0, 0, 0.0, 0.0, 0.1])
    np.testing.assert_allclose(moved.apply(center[None]), TRUTH.apply(center[None]), atol=1e-12)
    assert (TRUTH.inverse() @ moved).rotation.magnitude()[0] == pytest.approx(0.1)
