# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read from the covariance in a message the sigma of its value, or that the value was lost.

One rule for all types. A negative variance (-1 by sensor_msgs) or an infinite one marks a value
that was not measured. Zero and NaN say nothing. Some drivers mark a lost value by a variance that
is larger than the sensor could ever have, as their filters accept neither. The limits below tell
that, one for each quantity.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.typing import Array

LOST_SIGMA, UNKNOWN_SIGMA = float("inf"), float("nan")
# rad, of a direction of which nothing is known: one evenly spread over the circle
NO_DIRECTION_RAD = float(np.pi / np.sqrt(3))
FASTEST_TURN_RAD_S = 35.0  # 2000 deg/s, the common range of gyroscopes
DEEP_PA = 1e6  # a hundred metres of water: no pressure sensor at a hull is that bad
FAR_M = 1000.0  # a position that may be anywhere in a harbour


def sigma_of(covariance: ArrayLike, axes: Sequence[int]) -> float:
    """Average the variances of some axes of a square covariance into one sigma.

    Parameters
    ----------
    covariance : (n * n,) or (n, n)
    axes : rows whose variances are averaged

    Returns
    -------
    LOST_SIGMA where any of these variances, or the first element, marks a lost value.
    UNKNOWN_SIGMA where all are zero or NaN, which says nothing
    """
    flat = np.asarray(covariance, float).ravel()
    if not flat.size:
        return UNKNOWN_SIGMA
    size = round(flat.size**0.5)
    variance: Array = flat[:: size + 1][list(axes)]
    if flat[0] < 0 or (variance < 0).any() or np.isinf(variance).any():
        return LOST_SIGMA
    given = variance[variance != 0]  # zero says nothing, as does NaN
    return float(np.sqrt(given.mean())) if len(given) else UNKNOWN_SIGMA
