# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
from adjustment.scenes import ERROR, TRUTH, drawing, side
from scipy.linalg import cho_factor

from hullrecon.adjustment import misfit
from hullrecon.adjustment.misfit import Misfit

PLACE_PRIOR = 1e-4 * np.eye(6)


def scattered(count, seed, sigma, length, noise, offset=0.0):
    """Points (n, 3) of a 12 by 4 m side and signed distances drawn from a misfit."""
    random = np.random.default_rng(seed)
    drawn = drawing(side(0.0), TRUTH, 0 * ERROR)
    at = np.c_[random.uniform(1, 13, count), np.zeros(count), random.uniform(1, 4, count)]
    nearest = drawn.mesh.vertices[np.argmin(np.linalg.norm(drawn.mesh.vertices[None] - at[:, None], axis=2), axis=1)]
    at[:, 1] = nearest[:, 1]
    field = misfit.covariance(Misfit(sigma, length, noise, offset), drawn, at)
    return drawn, at, np.linalg.cholesky(field) @ random.standard_normal(count)


def test_the_package_s_word_is_the_start():
    drawn = drawing(side(0.0), TRUTH, 0 * ERROR)
    found = misfit.expected(drawn)
    assert (found.sigma, found.length) == (drawn.deviation_sigma, drawn.deviation_length)
    assert found.offset == pytest.approx(0.7 * drawn.deviation_sigma)


@pytest.mark.parametrize("sigma", [0.006, 0.05])
def test_sigma_and_noise_are_found_from_the_distances(sigma):
    drawn, at, distance = scattered(350, 1, sigma, (3.0, 1.5), 0.004)
    found = misfit.fitted(misfit.expected(drawn), drawn, at, distance, np.zeros((350, 6)), PLACE_PRIOR)
    assert found.sigma == pytest.approx(sigma, rel=0.5)
    assert found.noise == pytest.approx(0.004, rel=0.4)


def test_lengths_are_found_together():
    drawn, at, distance = scattered(350, 2, 0.02, (1.0, 0.5), 0.002)
    found = misfit.fitted(misfit.expected(drawn), drawn, at, distance, np.zeros((350, 6)), PLACE_PRIOR)
    assert found.length[0] == pytest.approx(1.0, rel=0.4)
    assert found.length[0] / found.length[1] == pytest.approx(2.0)


def test_what_the_place_explains_is_not_taken_for_misfit():
    drawn, at, distance = scattered(300, 3, 0.005, (3.0, 1.5), 0.002)
    by_place = np.zeros((300, 6))
    by_place[:, 0], by_place[:, 1] = 1.0, at[:, 0] - at[:, 0].mean()
    tilted = distance + by_place @ np.array([0.3, 0.05, 0, 0, 0, 0])
    plain = misfit.fitted(misfit.expected(drawn), drawn, at, distance, by_place, PLACE_PRIOR)
    found = misfit.fitted(misfit.expected(drawn), drawn, at, tilted, by_place, PLACE_PRIOR)
    assert found.sigma == pytest.approx(plain.sigma, rel=0.1)


def test_a_point_on_a_structure_is_stray_and_its_neighbours_are_not():
    drawn, at, distance = scattered(300, 4, 0.01, (3.0, 1.5), 0.002)
    distance[17] += 0.1
    known = Misfit(0.01, (3.0, 1.5), 0.002, 0.014)
    found = misfit.stray(cho_factor(misfit.covariance(known, drawn, at), lower=True), distance)
    assert np.flatnonzero(found).tolist() == [17]


def test_an_offset_of_the_whole_drawing_is_common_to_all_points():
    drawn, at, _ = scattered(40, 5, 0.01, (3.0, 1.5), 0.002)
    known = Misfit(0.01, (3.0, 1.5), 0.002, 0.014)
    without = misfit.covariance(replace(known, offset=0.0), drawn, at)
    np.testing.assert_allclose(misfit.covariance(known, drawn, at) - without, 0.014**2, atol=1e-12)


def test_the_drawing_then_says_what_was_found():
    drawn = drawing(side(0.0), TRUTH, 0 * ERROR)
    known = misfit.with_misfit(drawn, Misfit(0.033, (2.0, 1.0), 0.002, 0.014))
    assert (known.deviation_sigma, known.deviation_length) == (0.033, (2.0, 1.0))
    assert known.mesh is drawn.mesh
