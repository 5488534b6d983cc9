# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimate how wrong the stereo calibration is from the dive's own features."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.navigation.stereo_odometry.pair_motion import CalibrationEffect
from hullrecon.typing import Array

ITERATIONS = 20
# first guess of an unknown error's sigma, rad of disparity: 2 px at a focal length of 1,000 px
LARGEST = 2e-3


def calibration_moment(evidence: Sequence[CalibrationEffect], prior_sigma: Array) -> Array:
    """Estimate the second moment (k, k) of the calibration's errors from the motions of a dive.

    It is the covariance plus the square of what the motions show, as the path is not corrected for
    these errors: its sigmas have to cover them whole. Held errors have zeros. Errors of unknown
    sigma share one, which is estimated by expectation maximisation. A good calibration shows small
    errors in the motions. Errors that no motion can show, such as the scale, are then taken to be
    as small. Those of a rough calibration are taken to be as large.

    Parameters
    ----------
    evidence
        How the features of each measured motion depend on the errors.
    prior_sigma
        Sigma (k,) of each error, 0 where it is held, NaN where unknown.
    """
    information = np.sum([e.information for e in evidence], axis=0)
    gradient = np.sum([e.gradient for e in evidence], axis=0)
    unknown = np.isnan(prior_sigma)
    sigma = np.where(unknown, LARGEST, prior_sigma)
    free = sigma > 0  # the others are held
    out = np.zeros((len(sigma), len(sigma)))
    for _ in range(ITERATIONS):
        prior = np.diag(sigma[free] ** -2.0)
        covariance = np.linalg.inv(information[np.ix_(free, free)] + prior)
        found = -covariance @ gradient[free]
        out[np.ix_(free, free)] = covariance + np.outer(found, found)
        if not unknown.any():
            break
        sigma = np.where(unknown, np.sqrt(max(float(np.diag(out)[unknown].mean()), 1e-16)), sigma)
    return out
