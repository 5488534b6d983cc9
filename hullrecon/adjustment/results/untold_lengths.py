# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell whether anything but the DVL says how long a dive's lengths are.

A wrong speed of sound makes the velocities and the ranges of a DVL too long alike. In the solve the
ranges have no error in common, so that the sigma of the scale that it gives does not hold that.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import Adjusted
from hullrecon.adjustment.partition import join
from hullrecon.adjustment.problem.weighting import sigma_of_common_scale
from hullrecon.adjustment.stereo_calibration import DVL_SCALE

RangeTable = TypeVar("RangeTable", native.RangeTable, native.PlaneRangeTable)
# With this sigma of their common scale, in sigmas of the DVL's scale, ranges tell nothing of that
FREE = 10.0
MOSTLY_PRIOR = 0.5  # variance of the scale over its prior's, above which the dive tells less of it


def only_dvl_tells_lengths(adjusted: Adjusted) -> bool:
    """Tell whether the dive knows its lengths less well than the prior of the DVL's scale does.

    Without the ranges, lengths are in the baseline of two cameras, in depths where the vehicle
    climbs, in positions, and in the form of a CAD model. False without velocities of a DVL.
    """
    problem = adjusted.problem
    if adjusted.chosen.bottom.any() or not problem.odometry.by_navigation[:, :, 0].any():
        return False
    if adjusted.state.hull is not None:
        problem = problem.free("T_g_M")
    prior = float(problem.priors.navigation_sigma[DVL_SCALE])
    problem = replace(
        problem,
        ranges=_untold_by(problem.ranges, FREE * prior),
        plane_ranges=_untold_by(problem.plane_ranges, FREE * prior),
    )
    found = join.covariance(problem, adjusted.plan, adjusted.settings, of_landmarks=False)
    return bool(found.navigation[DVL_SCALE, DVL_SCALE] > MOSTLY_PRIOR * prior**2)


def _untold_by(ranges: RangeTable, share: float) -> RangeTable:
    """Widen the sigma of ranges so that they tell their common scale no better than to `share`."""
    least_m = sigma_of_common_scale(ranges.measured, share)
    return replace(ranges, sigma=np.maximum(ranges.sigma, least_m))
