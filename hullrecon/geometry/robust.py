# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Robust spread of values with outliers, and quantiles of weighted values."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array

# one sigma of normal values over the median of their distances from the middle: 1 / Phi^-1(3/4)
NORMAL_MAD = 1.4826


def robust_sigma(values: Array, about: float | None = None) -> float:
    """Estimate the sigma of values (n,) by their median distance from `about`.

    Values are taken as normal, with up to half of them outliers. `about` is their median unless
    given. NaN for no values.
    """
    if not len(values):
        return float("nan")
    distance = values - (np.median(values) if about is None else about)
    np.abs(distance, out=distance)
    return float(NORMAL_MAD * np.median(distance, overwrite_input=True))


def weighted_quantile(values: Array, weight: Array, share: float) -> float:
    """Find the value at which the cumulated weight reaches that share."""
    order = np.argsort(values, kind="stable")
    total = np.cumsum(weight[order])
    at = np.searchsorted(total, share * total[-1])
    return float(values[order][min(int(at), len(values) - 1)])
