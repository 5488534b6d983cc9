# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Default values of the fields of a problem's tables."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from hullrecon.typing import Array, Ints32, Mask

IDENTITY: Array = np.array([0.0, 0, 0, 0, 0, 0, 1])
IDENTITY.setflags(write=False)


def floats(*shape: int) -> Array:
    """Default of a field: a table without rows, or zeros."""
    default: Array = field(default_factory=lambda: np.zeros(shape))
    return default


def integers(*shape: int) -> Ints32:
    """Default of a field: a table without rows."""
    default: Ints32 = field(default_factory=lambda: np.zeros(shape, np.int32))
    return default


def mask(*shape: int) -> Mask:
    """Default of a field: a table without rows."""
    default: Mask = field(default_factory=lambda: np.zeros(shape, np.bool_))
    return default


def motion() -> Array:
    """Default of a field: the identity."""
    default: Array = field(default_factory=IDENTITY.copy)
    return default


def pinhole() -> Array:
    """Default of a field: intrinsics of unit focal length."""
    default: Array = field(default_factory=lambda: np.array([1.0, 1, 0, 0, 0, 0, 0, 0, 0]))
    return default
