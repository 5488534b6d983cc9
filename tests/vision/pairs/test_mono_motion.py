# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import exp
from hullrecon.vision.pairs import mono_inliers, mono_motion, two_view
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.stereo_adjustment import correlation_inflation
from hullrecon.vision.pairs.two_view import PossibleMotion

TRUE = exp([[0.3, 0.02, 0.05, 0.02, -0.05, 0.01]]).matrix()[0]
LENGTH = float(np.linalg.norm(TRUE[:3, 3]))
UNIT = TRUE.copy()
UNIT[:3, 3] /= LENGTH
SIGMA = 0.5 / 1200.0  # half a pixel
KNOWN = np.diag([0.02**2] * 3 + [0.01**2] * 3)


def matches(relief_m=0.2, n=200, seed=0, sigma=SIGMA, motion=TRUE, width=1.0):
    """Ideal coordinates (n, 2) in both views of a wall 1.5 m ahead with that relief."""
    rng = np.random.default_rng(seed)
    fixed = np.random.default_rng(99)
    x, y = width * fixed.uniform(-0.5, 0.7, n), width * fixed.uniform(-0.35, 0.35, n)
    points = np.column_stack([x, y, 1.5 + relief_m * fixed.standard_normal(n)])
    there = points @ motion[:3, :3].T + motion[:3, 3]
    noise = sigma * rng.standard_normal((2, n, 2))
    return points[:, :2] / points[:, 2:] + noise[0], there[:, :2] / there[:, 2:] + noise[1]


def off(turn=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0)):
    """The true motion, turned and its direction moved."""
    out = UNIT.copy()
    out[:3, :3] = UNIT[:3, :3] @ Rotation.from_rotvec(turn).as_matrix()
    moved = UNIT[:3, 3] + np.asarray(shift)
    out[:3, 3] = moved / np.linalg.norm(moved)
    return out


def five(found, truth=UNIT):
    """(5,): error of the rotation, and of the direction in the tangent basis of the truth."""
    turn = Rotation.from_matrix(truth[:3, :3].T @ found[:3, :3]).as_rotvec()
    return np.concatenate([turn, mono_motion.tangent_basis(truth[:3, 3]).T @ found[:3, 3]])


def test_without_noise_motion_is_found_from_guess_that_is_off():
    found, _ = mono_motion.refine(off((0.02, -0.01, 0.02), (0.0, 0.1, -0.1)), *matches(sigma=0.0))
    np.testing.assert_allclose(found, UNIT, atol=1e-7)


def test_five_numbers_scatter_as_their_covariance_says():
    errors, covariances = [], []
    for seed in range(200):
        found, covariance = mono_motion.refine(UNIT, *matches(seed=seed))
        errors.append(five(found))
        covariances.append(covariance)
    predicted = np.sqrt(np.diag(np.mean(covariances, axis=0)))
    np.testing.assert_allclose(np.std(errors, axis=0), predicted, rtol=0.2)


def test_derivatives_are_those_of_distance():
    first, second = matches(sigma=0.0)
    residual, jacobian = mono_motion.linearise(UNIT, first, second)
    np.testing.assert_allclose(residual, 0, atol=1e-12)
    for k in range(5):
        step = 1e-6 * np.eye(5)[k]
        plus, minus = (
            mono_motion.linearise(mono_motion._apply_step(UNIT, s), first, second)[0]
            for s in (step, -step)
        )
        np.testing.assert_allclose(jacobian[:, k], (plus - minus) / 2e-6, atol=1e-6)


def test_twice_noise_is_twice_sigma():
    fine, coarse = (mono_motion.refine(UNIT, *matches(sigma=s))[1] for s in (SIGMA, 2 * SIGMA))
    np.testing.assert_allclose(np.sqrt(np.diag(coarse) / np.diag(fine)), 2, rtol=0.05)


def test_vehicle_that_stood_still_has_no_direction():
    _, covariance = mono_motion.refine(UNIT, *matches(sigma=0.0, motion=np.eye(4)))
    assert np.sqrt(np.linalg.eigvalsh(covariance)[-2:]).min() > 0.5
    assert np.sqrt(np.linalg.eigvalsh(mono_motion.refine(UNIT, *matches())[1]).max()) < 0.02


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("count", [60, 200, 1000])
def test_noise_gives_no_direction_to_vehicle_that_stood_still(seed, count):
    """Its matches move by their noise alone, which was once taken for information: a sigma of 0.03
    rad.
    """
    seen = matches(n=count, seed=seed, motion=np.eye(4))
    for start in (
        UNIT,
        off(shift=(0.0, 1.0, 0.0)),
        np.block([[np.eye(3), np.array([[0.0], [0.0], [1.0]])], [0, 0, 0, 1]]),
    ):
        _, covariance = mono_motion.refine(start, *seen)
        assert np.sqrt(np.linalg.eigvalsh(covariance)[-2:]).min() > 0.3
        # the rotation is known all the same
        assert np.sqrt(np.linalg.eigvalsh(covariance)[:3]).max() < 0.03


def test_noise_share_is_that_of_many_draws_at_any_size():
    """The information of matches that stand still, over many draws, is the share."""
    still = np.eye(4)
    still[:3, 3] = UNIT[:3, 3]
    for sigma in (SIGMA, 4 * SIGMA):
        found = []
        for seed in range(60):
            jacobian = mono_motion.linearise(
                still, *matches(seed=seed, sigma=sigma, motion=np.eye(4))
            )[1]
            found.append(jacobian[:, 3:].T @ jacobian[:, 3:] / sigma**2)
        share = mono_motion.noise_share(still, *matches(sigma=sigma, motion=np.eye(4))).sum(axis=0)
        np.testing.assert_allclose(np.mean(found, axis=0), share, atol=0.05 * np.trace(share))


def test_vehicle_that_moved_loses_no_information_by_it():
    motion, covariance = mono_motion.refine(UNIT, *matches())
    residual, jacobian = mono_motion.linearise(motion, *matches())
    plain = np.linalg.inv(mono_motion._information(jacobian, mono_motion._variance(residual)))
    each = jacobian[:, :, None] * jacobian[:, None]
    shared = correlation_inflation(
        each, jacobian * residual[:, None], mono_motion._variance(residual), matches()[0]
    )
    np.testing.assert_allclose(
        np.sqrt(np.diag(covariance)), np.sqrt(shared * np.diag(plain)), rtol=1e-3
    )


def test_errors_that_neighbours_share_are_in_covariance():
    """Each point found six times, with one error: six witnesses are one."""
    chi2 = []
    for seed in range(60):
        motion, covariance = mono_motion.refine(
            UNIT, *(np.repeat(xy, 6, axis=0) for xy in matches(seed=seed))
        )
        chi2.append(five(motion) @ np.linalg.solve(covariance, five(motion)) / 5)
    assert 0.85 < np.sqrt(np.mean(chi2)) < 1.25


@pytest.mark.parametrize("direction", [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0], [0.6, 0, 0.8]])
def test_tangent_basis_is_across(direction):
    basis = np.column_stack([mono_motion.tangent_basis(np.array(direction)), direction])
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-14)


def test_length_is_navigations_and_as_uncertain():
    covariance = 1e-6 * np.eye(5)
    found = mono_motion.with_length(UNIT, covariance, Motion(TRUE, KNOWN))
    np.testing.assert_allclose(found.second_from_first, TRUE, atol=1e-12)
    direction = UNIT[:3, 3]
    assert direction @ found.covariance[:3, :3] @ direction == pytest.approx(0.02**2)
    across = mono_motion.tangent_basis(direction)
    np.testing.assert_allclose(
        across.T @ found.covariance[:3, :3] @ across, 1e-6 * LENGTH**2 * np.eye(2), atol=1e-15
    )
    np.testing.assert_allclose(found.covariance[3:, 3:], 1e-6 * np.eye(3))


def test_without_navigation_length_is_one_and_unknown():
    found = mono_motion.with_length(UNIT, 1e-6 * np.eye(5), None)
    assert np.linalg.norm(found.second_from_first[:3, 3]) == pytest.approx(1)
    assert UNIT[:3, 3] @ found.covariance[:3, :3] @ UNIT[:3, 3] == pytest.approx(1)


def chi2(motion, prior=TRUE, covariance=KNOWN):
    expected = Motion(prior, covariance)
    return mono_motion.navigation_chi2(
        mono_motion.with_length(motion, 1e-8 * np.eye(5), expected), expected
    )


def test_true_motion_agrees_other_direction_does_not():
    assert chi2(UNIT) == pytest.approx(0, abs=1e-9)
    across = mono_motion.tangent_basis(UNIT[:3, 3])[:, 0]
    assert chi2(off(shift=0.1 * across)) == pytest.approx((0.1 * LENGTH / 0.02) ** 2, rel=0.05)
    assert chi2(off(shift=across)) > 50
    backwards = UNIT.copy()
    backwards[:3, 3] *= -1
    assert chi2(backwards) > 50


def test_turn_counts_by_its_sigma():
    assert chi2(off(turn=(0.05, 0, 0))) == pytest.approx(25, rel=0.01)


def test_length_that_is_wrong_costs_nothing():
    longer = TRUE.copy()
    longer[:3, 3] *= 1.5
    assert chi2(UNIT, longer) == pytest.approx(0, abs=1e-9)


def test_direction_says_little_where_vehicle_hardly_moved():
    short = TRUE.copy()
    short[:3, 3] *= 0.02
    backwards = UNIT.copy()
    backwards[:3, 3] *= -1
    assert chi2(backwards, short) < 1


def plane_choices():
    """The motions of a wall seen twice without relief, and which is the true one."""
    first, second = matches(relief_m=0.0, sigma=0.01 * SIGMA, width=0.3)
    found = two_view.fit(first, second, 1.5 / 1200)
    assert found.model == "homography"
    choices = two_view.motions_of(found, first, second)
    truth = [float(np.abs(five(c.motion)).max()) < 0.02 for c in choices]
    return choices, truth, (first, second)


def test_surface_normal_settles_motion_of_plane_over_navigation():
    """Navigation is that of the wrong one of the two, but the DVL saw the wall head-on."""
    choices, truth, seen = plane_choices()
    assert sorted(truth) == [False, True]
    wrong = choices[truth.index(False)]
    astray = Motion(wrong.motion, KNOWN)
    found = mono_inliers.choose(choices, seen, astray, (0.0, 0.0, 1.0))
    assert np.abs(five(off_length(found))).max() < 0.02
    other = mono_inliers.choose(choices, seen, astray, tuple(wrong.normal))
    assert np.abs(five(off_length(other))).max() > 0.05


def off_length(motion):
    out = motion.second_from_first.copy()
    out[:3, 3] /= np.linalg.norm(out[:3, 3])
    return out


def test_without_normal_navigation_settles_motion_of_plane():
    """Two motions of one rotation: only the direction tells them apart."""
    across = mono_motion.tangent_basis(UNIT[:3, 3])[:, 0]
    choices = [PossibleMotion(off(shift=2 * across)), PossibleMotion(UNIT)]
    seen = matches(n=6, sigma=0.0)
    priors = Motion(TRUE, 1e-6 * np.eye(6))
    found = mono_inliers.choose(choices, seen, priors, None)
    assert np.abs(five(off_length(found))).max() < 0.02


def test_normal_says_nothing_about_essential_matrix():
    found = mono_inliers.choose([PossibleMotion(UNIT)], matches(), None, (0.0, 0.0, 1.0))
    assert np.abs(five(found.second_from_first)).max() < 0.05
