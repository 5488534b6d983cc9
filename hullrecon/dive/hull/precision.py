# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell in which steps a mesh's coordinates were stored: single precision, or few decimals.

An STL stores single precision. Far from the origin, as in map coordinates, its steps are
centimetres to half a metre.
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array

FAR = 20.0  # times the largest extent, from the origin; nearer single precision is fine enough
ENOUGH_CORNERS = 20  # fewer may lie in steps because the ship's shape is so simple
NEAR_SINGLE = 0.1  # of a step of single precision: a number written as text is rounded once more
DECIMALS = 10.0 ** np.arange(2, -4, -1)  # in the mesh's unit: steps of numbers rounded as text


def stored_step(vertices: Array, is_single: bool = False) -> float:
    """Find the step, in the mesh's unit, to which coordinates (n, 3) were rounded.

    Far from the origin, the steps of single precision or of few decimals may be too coarse for a
    hull. Zero near the origin, where this is not examined, where coordinates were not rounded, and
    where there are too few corners to know. is_single: the file stores single precision.
    """
    size = np.abs(vertices).max(axis=0)
    if size.max() < FAR * np.ptp(vertices, axis=0).max():
        return 0.0
    if not is_single and len(np.unique(vertices, axis=0)) < ENOUGH_CORNERS:
        return 0.0
    steps = np.spacing(size.astype(np.float32)).astype(float)
    near = np.abs(vertices.astype(np.float32).astype(float) - vertices) <= NEAR_SINGLE * steps
    single = np.where(is_single | near.all(axis=0), steps, 0.0)
    decimal = [_decimal_step(column) for column in vertices.T]
    return float(np.max([single, decimal]))


def _decimal_step(values: Array) -> float:
    """Find the largest power of ten of which all values (n,) are multiples, zero if none."""
    for step in DECIMALS:
        whole = values / step
        if (np.abs(whole - np.round(whole)) < 1e-6).all():
            return float(step)
    return 0.0
