# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Part the hull's form into its relief, which a viewer may exaggerate, and what stands on it:
objects, growth, noise.
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array

RADIUS_M = 0.4  # wider than structures are, narrower than dents and waves of a hull
SPACING_M = 0.05
MAX_SAMPLES = 20_000


def relief_of(points: Array, form: Array) -> Array:
    """Return the relief (n,) m of a form (n,) at points (n, 3): its median within RADIUS_M,
    smoothed.

    The points are thinned to one a cell first, since a mesh is finer where objects are; over wide
    surveys cell and radius grow.
    """
    from scipy.spatial import cKDTree

    if not form.any():
        return np.zeros(len(points))
    spacing = SPACING_M
    samples = _thin(points, spacing)
    while len(samples) > MAX_SAMPLES:
        spacing *= np.sqrt(2.0)
        samples = _thin(points, spacing)
    radius = RADIUS_M * spacing / SPACING_M
    at, samples_form = points[samples], form[samples]
    tree = cKDTree(at)
    neighbours = tree.query_ball_point(at, radius, return_sorted=True)
    medians = np.array([np.median(samples_form[near]) for near in neighbours])
    smooth = np.array(
        [medians[near].mean() for near in tree.query_ball_point(at, radius / 2, return_sorted=True)]
    )
    distance, nearest = tree.query(points, k=min(4, len(at)))
    distance, nearest = (np.reshape(values, (len(points), -1)) for values in (distance, nearest))
    weight = 1.0 / (distance + 0.25 * spacing) ** 2
    return np.asarray((smooth[nearest] * weight).sum(axis=1) / weight.sum(axis=1))


def _thin(points: Array, spacing: float) -> Array:
    """Return the indices of the first point in each cube of that side."""
    _, first = np.unique(np.floor(points / spacing).astype(np.int64), axis=0, return_index=True)
    return np.sort(first)
