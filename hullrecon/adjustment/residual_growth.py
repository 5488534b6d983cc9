# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Growth of residuals with the CAD model, relative to those of a path solved without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.partition import join
from hullrecon.adjustment.partition.plan import Plan
from hullrecon.adjustment.rounds import RoundResult
from hullrecon.errors import StageError

# With the CAD model, the RMS of a group's whitened residuals may be at most this multiple of the
# RMS without it. Growth that follows from fewer unknowns is taken off before (`residual_growth`).
MAX_GROWTH = {"images": 1.02, "odometry": 1.1, "attitude": 1.1, "positions": 1.1}
# Groups of measurements that the path explains, and their factors in the native problem
GROUPS = {
    "images": ("stereo", "mono"),
    "odometry": ("odometry",),
    "attitude": ("attitude", "tray"),
    "positions": ("position",),
}
# Quantile of a chi-square up to which residuals may grow. Its degrees of freedom are the unknowns
# that the CAD model determines instead of navigation.
FREED_QUANTILE = 0.999
FREE_ITERATIONS = 15  # of the solve without the CAD model, which starts close to its solution


def residual_growth(
    problem: native.Problem, plan: Plan, settings: native.Options
) -> dict[str, float]:
    """Divide the RMS of each group's whitened residuals with the CAD model by that without it.

    Unknowns that the CAD model determines no longer follow the noise of navigation, so that its
    residuals grow even with a right CAD model. Where a ratio is beyond MAX_GROWTH, the chi-square
    without the CAD model is therefore increased by what such unknowns absorbed.

    Parameters
    ----------
    problem
        The round with the CAD model, at its solution.
    plan
        Its parts.
    settings
        The options with which it was solved.

    Returns
    -------
    dict
        Ratio of each of GROUPS that has residuals.
    """
    without = replace(problem, ranges=native.RangeTable(), surface=native.SurfaceTable()).hold(
        "T_g_M", "deviation"
    )
    naive = replace(settings, method="naive")
    free = join.solve(without, plan, replace(naive, max_iterations=FREE_ITERATIONS))
    without_cad = without.started_from(free.unknowns)
    # The same measurements, at the solution with the CAD model and at that without it
    chi2_with, chi2_without = (_chi2_by_group(p, naive) for p in (without, without_cad))
    growth = {
        name: float(np.sqrt(chi2_with[name] / chi2_without[name]))
        for name in GROUPS
        if chi2_without[name] > 0
    }
    if all(ratio <= MAX_GROWTH[name] for name, ratio in growth.items()):
        return growth
    try:
        absorbed = _absorbed_chi2(
            join.covariance(without_cad, plan, naive, of_landmarks=False),
            join.covariance(problem, plan, settings, of_landmarks=False),
        )
    except StageError:
        return growth  # an unknown is not determined at all, and there is no leverage
    return {
        name: float(np.sqrt(chi2_with[name] / (chi2_without[name] + absorbed[name])))
        for name in growth
    }


def _chi2_by_group(problem: native.Problem, settings: native.Options) -> dict[str, float]:
    """Compute the robust chi-square of each of GROUPS: twice the cost of its factors."""
    cost = native.evaluate(problem, settings, jacobian=False).cost_by_factor
    return {name: 2 * sum(cost[factor] for factor in factors) for name, factors in GROUPS.items()}


def _absorbed_chi2(without_cad: native.Covariance, with_cad: native.Covariance) -> dict[str, float]:
    """Compute by how much each group's chi-square may grow as it determines fewer unknowns.

    The leverage of a group is the number of unknowns that it determines, and these absorb as many
    degrees of freedom of its noise. Unknowns that the CAD model determines absorb no more of it:
    the allowed growth is the quantile FREED_QUANTILE of a chi-square with as many degrees of
    freedom as the leverage falls by, or zero where it does not fall. Images determine all landmarks
    either way, so nothing is added for them.

    Parameters
    ----------
    without_cad, with_cad
        Covariances with the leverage of each factor, at the solutions without and with the CAD
        model.

    Returns
    -------
    dict
        Allowed growth of chi-square by the names of GROUPS.
    """
    from scipy.special import chdtri  # not scipy.stats, which takes a quarter of a second to load

    def leverage(marginals: native.Covariance, factors: tuple[str, ...]) -> float:
        return sum(marginals.leverage_by_factor[factor] for factor in factors)

    fewer = {
        name: leverage(without_cad, factors) - leverage(with_cad, factors)
        for name, factors in GROUPS.items()
    }
    return {
        name: float(chdtri(count, 1 - FREED_QUANTILE)) if count > 0 else 0.0
        for name, count in fewer.items()
    }


def stated_attitude_rms(found: RoundResult, settings: native.Options) -> float:
    """Compute the RMS whitened residual of depth, roll, pitch and tray, by the tray's stated sigma.

    The sigma of the tray's angle that the rounds estimated is replaced by that of dive.toml. With
    one camera the solve hardly separates the tray's angle from the pitch, and follows the noise of
    both. The estimated sigma is then too small, and even a right CAD model seems to make the
    residuals grow. Roll and pitch have the sigmas of navigation in every round. That of depths
    stays as estimated.
    """
    stated_over_estimated = found.after.measured.rig.priors.tray_sigma_rad / found.weights.tray
    tray = replace(found.problem.tray, sigma=found.problem.tray.sigma * stated_over_estimated)
    # The surface factor has no part in this sum, and "naive" leaves it out
    cost = native.evaluate(
        replace(found.problem, tray=tray), replace(settings, method="naive"), jacobian=False
    ).cost_by_factor
    # The cost is half the chi-square. Attitude has rows of depth, roll and pitch
    rows = len(tray.node) + 3 * len(found.problem.attitude.node)
    return float(np.sqrt(2 * (cost["attitude"] + cost["tray"]) / max(rows, 1)))
