# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Statistics of residuals by factor, in sigmas: RMS near one and few beyond three are healthy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hullrecon import native
from hullrecon.geometry.robust import robust_sigma


def by_factor(evaluation: native.Evaluation) -> dict[str, dict[str, float]]:
    """Compute count, RMS, robust sigma and share beyond three of each factor's residuals."""
    found = {}
    for number, name in enumerate(native.FACTORS):
        values = evaluation.residual[evaluation.factor == number]
        if len(values):
            found[name] = _figures(values)
    return found


def _figures(values: NDArray[np.float64]) -> dict[str, float]:
    return {
        "count": float(len(values)),
        "rms": float(np.sqrt(np.mean(values**2))),
        "robust_sigma": robust_sigma(values),
        "share_beyond_3": float(np.mean(np.abs(values) > 3)),
    }
