# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Root mean squares of errors."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array


def rms(values: Array) -> float:
    """Return the root mean square, NaN of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if np.size(values) else float("nan")


def rms_length(vectors: Array) -> float:
    """Return the root mean square length of vectors (n, 3)."""
    return rms(np.linalg.norm(vectors, axis=1))
