# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Choose the origin about which files of single precision are written."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array

FAR_M = 1000.0  # from here on steps of single precision are longer than 0.1 mm


def local_origin(points: Array) -> Array:
    """Choose an origin (3,) in whole metres near points (n, 3), zero if none is far from zero."""
    known = points[np.isfinite(points).all(axis=1)]
    if not len(known) or np.abs(known).max() <= FAR_M:
        return np.zeros(3)
    return np.asarray(np.round(0.5 * (known.min(axis=0) + known.max(axis=0))))
