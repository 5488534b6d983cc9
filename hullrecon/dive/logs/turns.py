# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare the turns that an IMU's rates measured with those of its orientation."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.records.clock import NS
from hullrecon.typing import Array, Ints

SHARED = 0.8  # squared correlation from which on one signal is a scaled copy of the other


def turns_within_seconds(
    t_ns: Ints, rotation: Rotation, rates: Array
) -> tuple[Array, Array, Array]:
    """Compute by how much an IMU turned in each second, by its rates and by its orientation.

    Parameters
    ----------
    t_ns : (n,) stamps in order
    rotation : (n,) orientations
    rates : (n, 3) rad/s, in the IMU's axes. Readings with NaN are left out

    Returns
    -------
    tuple
        (m, 3) integrals of the rates, turns of the orientation as rotation vectors, both rad, and
        how long each took, s. All are empty with fewer than two readings.
    """
    known = np.isfinite(rates).all(axis=1)
    t_ns, rates = t_ns[known], rates[known]
    if len(t_ns) < 2:
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
    lasts_s = np.diff(t_ns) / NS
    # Integral of the rates up to each reading, and the first reading of each second
    total = np.concatenate(
        [np.zeros((1, 3)), np.cumsum(0.5 * (rates[1:] + rates[:-1]) * lasts_s[:, None], axis=0)]
    )
    rows = np.unique(np.searchsorted(t_ns, np.arange(t_ns[0], t_ns[-1], NS)))
    attitude = rotation[np.flatnonzero(known)[rows]]
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec()
    return np.diff(total[rows], axis=0), turned, np.diff(t_ns[rows]) / NS


def scale_between(first: Array, second: Array) -> float | None:
    """Fit the factor from one signal (n, 3) to another by least squares.

    None where the two are not proportional, as where one of them does not change.
    """
    squares, product = float((first**2).sum()), float((first * second).sum())
    together = product > 0 and product**2 > SHARED * squares * float((second**2).sum())
    return product / squares if together else None
