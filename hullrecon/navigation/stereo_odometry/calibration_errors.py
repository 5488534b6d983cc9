# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimate how wrong the stereo calibration is from the dive's own features."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.navigation.stereo_odometry.pair_motion import CalibrationEffect
from hullrecon.typing import Array

ITERATIONS = 20
# of an error of the disparity, rad: where the iterations begin, 2 px in a lens of 1,000 px
LARGEST = 2e-3


def calibration_moment(evidence: Sequence[CalibrationEffect], prior_sigma: Array) -> Array:
    """Estimate the second moment (k, k) of the calibration's errors from what motions show of them.

    prior_sigma (k,): NaN where unknown. The unknown errors share one sigma: the most likely given
    all motions of the dive (expectation maximisation with an empirical prior). A good calibration
    shows small errors, and the errors that no motion can see, such as the scale, are then taken to
    be small too. A rough calibration is taken to be rough in them too.
    """
    information = np.sum([e.information for e in evidence], axis=0)
    gradient = np.sum([e.gradient for e in evidence], axis=0)
    unknown = np.isnan(prior_sigma)
    sigma = np.where(unknown, LARGEST, prior_sigma)
    free = sigma > 0
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
