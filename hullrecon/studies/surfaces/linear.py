# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Linear interpolation between returns [Ozog2016 3.2.2.1], on the hull's chart.

[Ozog2016] interpolates over the xy plane.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.robust import robust_sigma
from hullrecon.surface.build import Facts, SurfacePoints
from hullrecon.surface.options import SurfaceOptions
from hullrecon.surface.tiles import cell_means
from hullrecon.typing import Array


def by_triangles(
    charted: Array, observed: SurfacePoints, wanted: Array, options: SurfaceOptions
) -> tuple[Array, Array, Facts]:
    """Interpolate between means over quarter cells, with one sigma by their scatter."""
    seen = cell_means(charted[:, :2], charted[:, 2], observed.noise, 0.25 * options.cell_m)
    sigma = scatter_sigma(seen.at, seen.offset)
    facts: Facts = {"method": "linear", "observations": len(seen.at), "scatter_m": sigma}
    return interpolate(seen.at, seen.offset, wanted), np.full(len(wanted), sigma), facts


def interpolate(at: Array, values: Array, wanted: Array) -> Array:
    """Interpolate values at (m, 2) on Delaunay triangles, outside by the nearest."""
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

    if len(at) < 4 or np.linalg.matrix_rank(at - at.mean(axis=0), tol=1e-6) < 2:
        return np.asarray(NearestNDInterpolator(at, values)(wanted))
    inside = np.asarray(LinearNDInterpolator(at, values)(wanted))
    return np.where(np.isfinite(inside), inside, NearestNDInterpolator(at, values)(wanted))


def scatter_sigma(at: Array, values: Array, neighbours: int = 6) -> float:
    """Return one robust sigma of values about the mean of their neighbours."""
    count = min(neighbours, len(at) - 1)
    if count < 1:
        return 0.0
    _, near = nearest(at, at, count + 1)
    off = values - values[near[:, 1:]].mean(axis=1)
    return float(robust_sigma(off, about=0.0) / np.sqrt(1 + 1 / count))
