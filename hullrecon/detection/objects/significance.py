# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How likely hull without a structure is to look like one."""

from __future__ import annotations

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.objects.regions import Region
from hullrecon.geometry.robust import robust_sigma
from hullrecon.typing import Array


def roughness(found: HullAsFound) -> float:
    """Return one robust sigma of the measured heights: hull and noise without structures, m."""
    height = found.height[found.measured]
    return robust_sigma(height) if len(height) else 0.0


def height_sigma(found: HullAsFound, region: Region) -> float:
    """Return one sigma of a region's height, m: of its top and of the hull beneath it.

    Neighbouring vertices share landmarks, so the top counts as one vertex.
    """
    top = float(np.median(found.sigma[region.core]))
    hull = float(np.median(region.hull.sigma(found.base.vertices[region.core])))
    return float(np.hypot(top, hull))


def relief_left(over_m: Array, sigma_m: Array) -> float:
    """Estimate the relief that smoothing left out, m.

    It is the scatter of landmarks' heights (n,) over the surface beyond their own sigmas (n,).
    Where landmarks are too far apart for the relief, the surface passes between them. Zero without
    landmarks.
    """
    if not len(over_m):
        return 0.0
    return float(
        np.sqrt(max(0.0, robust_sigma(over_m, about=0.0) ** 2 - float(np.median(sigma_m)) ** 2))
    )


def p_value(height_m: float, sigma_m: float, roughness_m: float, places: float) -> float:
    """Return the two-sided probability that bare hull reaches this height at any place.

    `places`: how many were looked at.
    """
    from scipy.special import ndtr  # not scipy.stats, which takes seconds to load

    score = abs(height_m) / max(np.hypot(sigma_m, roughness_m), 1e-6)
    return float(-np.expm1(max(1.0, places) * np.log1p(-min(2 * float(ndtr(-score)), 1 - 1e-16))))
