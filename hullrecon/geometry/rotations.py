# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rotations in batches, beside those of `scipy.spatial.transform`."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.typing import Array


def cross_matrix(vectors: Array) -> Array:
    """Return [v]x, (..., 3, 3), of vectors (..., 3): `[v]x w = v x w`."""
    x, y, z = np.moveaxis(np.asarray(vectors, float), -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*np.shape(vectors)[:-1], 3, 3)


def roll_pitch_yaw(rotation: Rotation) -> Array:
    """Return roll, pitch, yaw (n, 3), rad, with R = Rz(yaw) Ry(pitch) Rx(roll)."""
    return np.atleast_2d(rotation.as_euler("xyz"))
