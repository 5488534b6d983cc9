# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import exp, from_rpy
from hullrecon.vision.pairs import stereo_adjustment
from hullrecon.vision.pairs.stereo_adjustment import (
    NodeObservations,
    adjust_stereo_motion,
    correlation_inflation,
    image_cells,
)
from hullrecon.vision.stereo.matching import rectify, triangulate

MOTION = exp([[0.2, -0.05, 0.03, 0.02, -0.08, 0.04]]).matrix()[0]
TOP_FROM_BOTTOM = from_rpy([0.002, 0.1, -0.001], [0.003, -0.002, 0.004])
SIGMA = 0.3 / 650


def image(points):
    return points[:, :2] / points[:, 2:]


def wall(count=300):
    rng = np.random.default_rng(0)
    return np.column_stack([rng.uniform(-0.5, 0.5, (count, 2)), rng.uniform(1.2, 1.6, count)])


def observe(points, rng, noise=SIGMA, rig=TOP_FROM_BOTTOM):
    """What a node whose top camera has the points (m, 3) in its axes sees of them with that rig,
    triangulated by the nominal one.
    """
    lead, other = (
        image(p) + noise * rng.standard_normal((len(points), 2))
        for p in (points, rig.inverse().apply(points))
    )
    turned = rectify(TOP_FROM_BOTTOM)
    return NodeObservations(
        lead=lead,
        other=other,
        point=triangulate(turned, turned.rectify_top(lead), turned.rectify_bottom(other)),
    )


def both_nodes(seed=1, noise=SIGMA, rig=TOP_FROM_BOTTOM, points=None):
    rng = np.random.default_rng(seed)
    points = wall() if points is None else points
    return observe(points, rng, noise, rig), observe(
        points @ MOTION[:3, :3].T + MOTION[:3, 3], rng, noise, rig
    )


def adjust(nodes, start=MOTION):
    return adjust_stereo_motion(start, *nodes, TOP_FROM_BOTTOM.inverse().matrix()[0])


def error(found, truth=MOTION):
    """(6,): of the translation, and of the rotation perturbed on the right."""
    turn = Rotation.from_matrix(truth[:3, :3].T @ found[:3, :3]).as_rotvec()
    return np.r_[found[:3, 3] - truth[:3, 3], turn]


def whitened_rms(found):
    chi2 = [
        error(f.second_from_first) @ np.linalg.solve(f.covariance, error(f.second_from_first)) / 6
        for f in found
    ]
    return np.sqrt(np.mean(chi2))


def test_without_noise_motion_is_found_from_guess_that_is_off():
    start = MOTION @ exp([[0.003, -0.002, 0.002, 0.001, 0.002, -0.001]]).matrix()[0]
    np.testing.assert_allclose(
        adjust(both_nodes(noise=0.0), start).second_from_first, MOTION, atol=1e-8
    )


def test_motions_of_noisy_pairs_scatter_as_covariance_says():
    assert 0.9 < whitened_rms([adjust(both_nodes(seed)) for seed in range(60)]) < 1.12


def test_errors_that_neighbours_share_are_in_covariance():
    """Each point found six times, at the scales and orientations of one blob, with one error: six
    witnesses are one.
    """
    shared = [
        [n.take(np.repeat(np.arange(300), 6)) for n in both_nodes(seed)] for seed in range(40)
    ]
    assert 0.85 < whitened_rms([adjust(nodes) for nodes in shared]) < 1.25


def test_wrong_matches_do_not_move_it():
    first, second = both_nodes(noise=SIGMA)
    rng = np.random.default_rng(4)
    wrong = rng.permutation(300)[:45]
    second.lead[wrong] += rng.normal(0, 10 * SIGMA, (45, 2))
    found, clean = adjust((first, second)), adjust(both_nodes(noise=SIGMA))
    sigma = np.sqrt(np.diag(clean.covariance))
    assert (np.abs(error(found.second_from_first, clean.second_from_first)) < 1.5 * sigma).all()
    assert (np.sqrt(np.diag(found.covariance)) < 1.5 * sigma).all()


def test_features_that_one_camera_of_node_missed_count_for_less():
    first, second = both_nodes()
    whole = adjust((first, second))
    second.other[:], second.point[:] = np.nan, np.nan
    half = adjust((first, second))
    assert np.linalg.det(half.covariance) > np.linalg.det(whole.covariance)
    chi2 = error(half.second_from_first) @ np.linalg.solve(
        half.covariance, error(half.second_from_first)
    )
    assert chi2 < 25


def test_points_of_second_node_alone_will_do():
    first, second = both_nodes()
    first.other[:], first.point[:] = np.nan, np.nan
    found = adjust((first, second))
    assert np.abs(error(found.second_from_first)).max() < 0.01


def test_without_stereo_points_there_is_no_motion():
    first, second = both_nodes()
    for node in (first, second):
        node.point[:] = np.nan
    assert adjust((first, second)) is None


def test_point_behind_every_camera_says_nothing():
    """As a wrong stereo match gives, or a step that takes it there: it ended the run, for its
    information is nil.
    """
    first, second = both_nodes()
    without = adjust((first.take(slice(1, None)), second.take(slice(1, None))))
    first.point[0] = second.point[0] = [0.1, 0.2, -1.3]
    found = adjust((first, second))
    np.testing.assert_allclose(found.second_from_first, without.second_from_first, atol=1e-12)
    np.testing.assert_allclose(found.covariance, without.covariance, rtol=1e-9)


def test_where_points_lie_behind_every_camera_there_is_no_motion():
    first, second = both_nodes()
    for node in (first, second):
        node.point[:, 2] *= -1
    assert adjust((first, second)) is None


@pytest.mark.parametrize("axis", range(6))
def test_error_of_rig_moves_motion_as_its_derivative_says(axis):
    step = np.zeros(6)
    step[axis] = 2e-4
    turned = Rotation.from_rotvec(step[3:]) * TOP_FROM_BOTTOM.rotation
    true = type(TOP_FROM_BOTTOM)(turned.as_quat(), TOP_FROM_BOTTOM.translation + step[:3])
    as_told, as_built = adjust(both_nodes(noise=0.0)), adjust(both_nodes(noise=0.0, rig=true))
    # the rig that is told is off by minus the step
    expected = -as_told.calibration.by_calibration[:, :6] @ step
    np.testing.assert_allclose(
        error(as_built.second_from_first),
        expected,
        atol=0.03 * np.abs(as_told.calibration.by_calibration[:, :6] * 2e-4).max(),
    )


def test_shared_errors_inflate_by_number_independent_by_one():
    rng = np.random.default_rng(3)
    cell = np.repeat(np.arange(200), 4)
    jacobian = rng.standard_normal((800, 5))
    information = jacobian[:, :, None] * jacobian[:, None]

    def factor(noise):
        fitted = np.linalg.lstsq(jacobian, noise, rcond=None)[0]
        return stereo_adjustment._cluster_factor(
            information, jacobian * (noise - jacobian @ fitted)[:, None], 1.0, cell
        )

    assert np.mean([factor(rng.standard_normal(800)) for _ in range(50)]) < 1.1
    jacobian = np.repeat(rng.standard_normal((200, 5)), 4, axis=0)  # one point, four times
    information = jacobian[:, :, None] * jacobian[:, None]
    shared = [factor(np.repeat(rng.standard_normal(200), 4)) for _ in range(50)]
    assert np.mean(shared) == pytest.approx(4, rel=0.1)


def test_one_cell_alone_says_nothing_about_correlation():
    rng = np.random.default_rng(3)
    jacobian = rng.standard_normal((50, 5))
    assert (
        correlation_inflation(
            jacobian[:, :, None] * jacobian[:, None], jacobian, 1.0, np.full((50, 2), 0.01)
        )
        == 1.0
    )


def test_cells_are_numbered_by_where_features_lie():
    cell = image_cells(np.array([[0.01, 0.01], [0.09, 0.02], [0.11, 0.01], [-0.01, 0.01]]), 0.1)
    assert cell[0] == cell[1]
    assert len(set(cell.tolist())) == 3


def disparity_error(nodes, coefficients):
    """The two nodes as a lens would show them whose disparity is off by that field (6,), ideal
    units.
    """
    baseline = np.array([0.0, 1.0])  # the bottom camera stands below: a nearer point moves up in it

    def seen(node):
        x, y = node.lead.T / stereo_adjustment.FIELD
        field = np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], axis=1) @ coefficients
        other = node.other - field[:, None] * baseline
        turned = rectify(TOP_FROM_BOTTOM)
        point = triangulate(turned, turned.rectify_top(node.lead), turned.rectify_bottom(other))
        return NodeObservations(lead=node.lead, other=other, point=point)

    return [seen(node) for node in nodes]


def test_error_of_disparity_is_seen_by_its_slope():
    """A motion cannot take up a depth that changes over the image."""
    slope = 6e-4 * np.eye(6)[1]
    found = adjust(disparity_error(both_nodes(points=wall(2000)), slope))
    prior = np.eye(6) * 1e-2**-2
    evidence = found.calibration
    covariance = np.linalg.inv(evidence.information[6:, 6:] + prior)
    estimate = -covariance @ evidence.gradient[6:]
    sigma = np.sqrt(covariance[1, 1])
    assert abs(estimate[1]) > 4 * sigma
    assert abs(abs(estimate[1]) - 6e-4) < 4 * sigma


def test_sound_calibration_shows_no_error_of_disparity():
    evidence = adjust(both_nodes()).calibration
    covariance = np.linalg.inv(evidence.information[6:, 6:] + np.eye(6) * 1e-2**-2)
    estimate = -covariance @ evidence.gradient[6:]
    assert (np.abs(estimate) < 4 * np.sqrt(np.diag(covariance))).all()


@pytest.mark.parametrize("term", range(6))
def test_error_of_disparity_moves_motion_as_its_derivative_says(term):
    field = 5e-5 * np.eye(6)[term]
    sound, off = adjust(both_nodes()), adjust(disparity_error(both_nodes(), field))
    moved = error(off.second_from_first, sound.second_from_first)
    expected = sound.calibration.by_calibration[:, 6 + term] * 5e-5
    sign = np.sign(moved @ expected)
    np.testing.assert_allclose(sign * moved, expected, atol=0.1 * np.abs(expected).max() + 2e-6)


def test_evidence_is_symmetric_and_not_negative():
    information = adjust(both_nodes()).calibration.information
    np.testing.assert_allclose(
        information, information.T, rtol=1e-6, atol=1e-3 * np.abs(information).max() * 1e-6
    )
    assert np.linalg.eigvalsh(information).min() > -1e-6 * np.abs(information).max()
