# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Returns that stand apart from their neighbours [Rusu2008], as [Ozog2016 3.2.2.1] uses it."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.neighbours import nearest
from hullrecon.typing import Array, Mask


def statistical_inliers(points: Array, neighbours: int = 30, deviations: float = 1.0) -> Mask:
    """Return which points (n, 3) belong: by their mean distance to the nearest neighbours, within
    so many deviations.

    [Ozog2016] takes 30 neighbours and one standard deviation.
    """
    count = min(neighbours, len(points) - 1)
    if count < 1:
        return np.ones(len(points), bool)
    distance, _ = nearest(points, points, count + 1)
    mean = distance[:, 1:].mean(axis=1)
    return np.asarray(mean <= mean.mean() + deviations * mean.std())
