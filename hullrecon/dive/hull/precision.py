# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell in which steps a mesh's coordinates were stored: single precision, or few decimals.

An STL stores single precision. In map coordinates its steps are centimetres to half a metre.
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array

FAR = 20.0  # of the largest extent: nearer to the origin single precision suits the mesh
ENOUGH_CORNERS = 20  # that fewer lie on a lattice may be the ship's form
NEAR_SINGLE = 0.1  # of a step of single precision: written as text, a number is rounded again
DECIMALS = 10.0 ** np.arange(2, -4, -1)  # m or whatever the unit is: steps of rounded text


def stored_step(vertices: Array, is_single: bool = False) -> float:
    """Find the step, in the mesh's unit, in which coordinates (n, 3) far from the origin lie.

    Zero near the origin, and where they lie in no steps. is_single: the file has single precision.
    """
    size = np.abs(vertices).max(axis=0)
    if size.max() < FAR * np.ptp(vertices, axis=0).max():
        return 0.0
    if not is_single and len(np.unique(vertices, axis=0)) < ENOUGH_CORNERS:
        return 0.0
    steps = np.spacing(size.astype(np.float32)).astype(float)
    off = np.abs(vertices.astype(np.float32).astype(float) - vertices) <= NEAR_SINGLE * steps
    single = np.where(is_single | off.all(axis=0), steps, 0.0)
    decimal = [_decimal_step(column) for column in vertices.T]
    return float(np.max([single, decimal]))


def _decimal_step(values: Array) -> float:
    """Find the largest power of ten of which all values (n,) are multiples, zero if none."""
    for step in DECIMALS:
        whole = values / step
        if (np.abs(whole - np.round(whole)) < 1e-6).all():
            return float(step)
    return 0.0
