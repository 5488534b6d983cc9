# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from hullrecon.vision.pairs.gating import in_box, in_ellipse


def pairs(found):
    return set(zip(found[0].tolist(), found[1].tolist(), strict=True))


def test_box_holds_what_is_near_in_both_directions():
    wanted = np.array([[0.0, 0.0], [10.0, 10.0]])
    points = np.array([[0.9, -4.9], [1.1, 0.0], [0.0, 5.1], [10.0, 14.0]])
    assert pairs(in_box(wanted, np.array([1.0, 5.0]), points)) == {(0, 0), (1, 3)}


def test_places_that_are_not_known_pair_with_none():
    wanted = np.array([[np.nan, 0.0], [0.0, 0.0]])
    assert pairs(in_box(wanted, np.ones(2), np.array([[0.0, 0.0], [np.nan, 0.0]]))) == {(1, 0)}


def test_ellipses_equal_plain_test_of_every_pair():
    rng = np.random.default_rng(4)
    wanted, points = rng.uniform(0, 10, (30, 2)), rng.uniform(0, 10, (200, 2))
    root = rng.standard_normal((30, 2, 2)) * rng.choice([0.05, 0.3, 1.5], 30)[:, None, None]
    covariance = root @ root.swapaxes(1, 2) + 0.001 * np.eye(2)
    gap = points[None] - wanted[:, None]
    chi2 = np.einsum("nmi,nij,nmj->nm", gap, np.linalg.inv(covariance), gap)
    assert pairs(in_ellipse(wanted, covariance, points, 9.21)) == set(
        zip(*(m.tolist() for m in np.nonzero(chi2 <= 9.21)), strict=True)
    )


def test_tilted_ellipse_leaves_out_corners_of_its_box():
    covariance = np.array([[[1.0, 0.95], [0.95, 1.0]]])
    points = np.array([[2.0, 2.0], [2.0, -2.0]])
    assert pairs(in_ellipse(np.zeros((1, 2)), covariance, points, 9.21)) == {(0, 0)}


def test_no_features_make_no_pairs():
    assert pairs(in_ellipse(np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros((3, 2)), 9.21)) == set()
    assert pairs(in_box(np.zeros((3, 2)), np.ones(2), np.zeros((0, 2)))) == set()
