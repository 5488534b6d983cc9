# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Choose the local origin of files with coordinates in single precision."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array

FAR_M = 1000.0  # farther from zero, a step of single precision may be longer than 0.1 mm


def local_origin(points: Array) -> Array:
    """Choose an origin (3,) in whole metres near points (n, 3). Zero if none is beyond FAR_M."""
    known = points[np.isfinite(points).all(axis=1)]
    if not len(known) or np.abs(known).max() <= FAR_M:
        return np.zeros(3)
    return np.asarray(np.round(0.5 * (known.min(axis=0) + known.max(axis=0))))
