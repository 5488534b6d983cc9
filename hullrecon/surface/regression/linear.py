# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Linear interpolation between returns [Ozog2016 3.2.2.1], on the hull's chart instead of the xy
plane.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.robust import robust_sigma
from hullrecon.typing import Array


def interpolate(at: Array, values: Array, wanted: Array) -> Array:
    """Return values (m,) at (m, 2), linear on the Delaunay triangles of (n, 2); outside them the
    nearest value.
    """
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

    if len(at) < 4 or np.linalg.matrix_rank(at - at.mean(axis=0), tol=1e-6) < 2:
        return np.asarray(NearestNDInterpolator(at, values)(wanted))
    inside = np.asarray(LinearNDInterpolator(at, values)(wanted))
    return np.where(np.isfinite(inside), inside, NearestNDInterpolator(at, values)(wanted))


def scatter_sigma(at: Array, values: Array, neighbours: int = 6) -> float:
    """Return one robust sigma of a value about the surface: its median distance from the mean of
    its neighbours, scaled.
    """
    count = min(neighbours, len(at) - 1)
    if count < 1:
        return 0.0
    _, near = nearest(at, at, count + 1)
    off = values - values[near[:, 1:]].mean(axis=1)
    return float(robust_sigma(off, about=0.0) / np.sqrt(1 + 1 / count))
