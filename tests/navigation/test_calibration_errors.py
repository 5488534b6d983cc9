# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.navigation.stereo_odometry.calibration_errors import calibration_moment
from hullrecon.navigation.stereo_odometry.pair_motion import CalibrationEffect

UNKNOWN = np.full(3, np.nan)


def seen(truth, sigma, motions=30, seed=1):
    """What motions say of three errors, each seen with that sigma (inf: not at all) by all of them
    together.
    """
    rng = np.random.default_rng(seed)
    information = np.diag(1 / np.asarray(sigma) ** 2) / motions
    scatter = np.sqrt(np.diag(information))[None] * rng.standard_normal((motions, 3))
    return [
        CalibrationEffect(
            by_error=np.zeros((6, 3)),
            information=information,
            gradient=-information @ truth + noise,
        )
        for noise in scatter
    ]


def sigmas(moment):
    return np.sqrt(np.diag(moment))


def test_good_calibration_bounds_errors_that_no_motion_sees():
    found = sigmas(calibration_moment(seen(np.zeros(3), [1e-5, 1e-5, np.inf]), UNKNOWN))
    assert found.max() < 5e-5


def test_a_rough_calibration_is_rough_in_what_no_motion_sees():
    found = sigmas(
        calibration_moment(seen(np.array([2e-3, -3e-3, 0.0]), [1e-5, 1e-5, np.inf]), UNKNOWN)
    )
    np.testing.assert_allclose(found[:2], [2e-3, 3e-3], rtol=0.02)
    assert 1e-3 < found[2] < 6e-3


def test_given_error_that_nothing_sees_keeps_its_prior_sigma():
    prior = np.array([4e-3, np.nan, 0.0])
    found = sigmas(calibration_moment(seen(np.zeros(3), [np.inf, 1e-5, np.inf]), prior))
    assert found[0] == pytest.approx(4e-3)
    assert found[1] < 5e-5
    assert found[2] == 0


def test_given_error_that_motions_see_gets_their_sigma():
    moment = calibration_moment(seen(np.zeros(3), [1e-4, 1e-4, 1e-4]), np.full(3, 0.01))
    assert sigmas(moment).max() < 5e-4


def test_errors_that_cancel_in_what_is_seen_stay_tied():
    """Only the sum of two is seen, and it is small: each may be large, their sum is not."""
    together = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0]]) * 1e10
    effect = CalibrationEffect(
        by_error=np.zeros((6, 3)), information=together, gradient=np.zeros(3)
    )
    moment = calibration_moment([effect], np.full(3, 1e-3))
    assert sigmas(moment)[0] == pytest.approx(1e-3 / np.sqrt(2), rel=0.01)
    assert moment[:2, :2].sum() < 1e-9
