# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Priors of sensors and mounts that a dive contradicts, widened to the error that it shows.

See docs/methods.md 6.

Where a package states that its DVL is right to half a per cent and it is off by three per cent, the
estimate ends between the prior and the truth, with a sigma that the prior made too small. So the
prior is taken off again. Let x be the estimate's distance from the prior's mean, p the prior's
sigma and P the posterior variance. Without the prior the dive gives x / g with the variance P / g,
where g = 1 - P / p^2 is the share of the prior's variance that the dive takes away. If the prior is
right, x / g has the variance p^2 + P / g.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hullrecon.adjustment.partition import join
from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.rounds import ACCEPTED, Phase, RoundSolver, Verdict
from hullrecon.adjustment.stereo_calibration import DVL_SCALE, widen_ranges
from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses
from hullrecon.rig import Rig
from hullrecon.typing import Array, Mask

MANY_SIGMAS = 4.0  # sigmas of a prior beyond which a dive is said to contradict it
# With a right prior x has the variance p^2 g. Beyond five of its sigmas it is no chance, as in
# navigation/suspects, if the dive determines the unknown at all (LEAST_GAINED of its prior's
# variance): scales of 78 dives without a wrong one had 2.2 at most, one with velocities 15 % too
# short 10.9.
SURPRISING = 5.0
LEAST_GAINED = 0.01
ROTATION = slice(3, 6)  # rows of a mount's prior
# Errors of navigation whose priors may be widened. The sixth, the tray's backlash, is left out: its
# prior is also that of each swing of the tray.
CONSTANT_ERRORS = 5
MOUNTS = ("tray_from_top", "tray_from_dvl")
# Blocks of the native problem by the priors that may be widened
BLOCKS = {"navigation": "navigation", "tray_from_top": "T_s_ct", "tray_from_dvl": "T_s_d"}


class WithoutPrior(NamedTuple):
    """What a dive alone says of unknowns (k,), in sigmas of their priors."""

    value: Array  # (k,)
    sigma: Array  # (k,)
    contradicts: Mask  # (k,) the prior


def without_prior(deviation: Array, variance: Array) -> WithoutPrior:
    """Take the priors of unknowns off their estimates.

    Parameters
    ----------
    deviation
        Distance (k,) of the estimates from the priors' means, in the priors' sigmas.
    variance
        Variance (k,) of the estimates, in squares of the priors' sigmas.
    """
    gained = np.maximum(1 - variance, 1e-9)  # g of the module's docstring
    return WithoutPrior(
        value=deviation / gained,
        sigma=np.sqrt(np.maximum(variance, 0) / gained),
        contradicts=(np.abs(deviation) > SURPRISING * np.sqrt(gained)) & (gained > LEAST_GAINED),
    )


@dataclass(frozen=True, kw_only=True)
class _PriorDeviation:
    """How far the estimate of an unknown lies from the mean of its prior."""

    deviation: Array  # (k,) in the prior's sigmas
    to_sigmas: Array  # (k, m) from the unknown's tangent to those sigmas

    def may_be_exceeded(self) -> bool:
        """Tell whether `widening` could widen the prior, whatever the covariance is.

        The covariance is expensive, so it is computed only where this is True.
        """
        return bool(np.abs(self.deviation).max() > SURPRISING * np.sqrt(LEAST_GAINED))

    def widening(self, covariance: Array) -> Array:
        """Compute the factors (k,) by which the prior's sigmas have to grow, 1 where it holds.

        covariance (m, m): of the estimate, in the unknown's tangent.
        """
        variance = np.diag(self.to_sigmas @ covariance @ self.to_sigmas.T)
        alone = without_prior(self.deviation, variance)
        return np.where(alone.contradicts, np.abs(alone.value), 1.0)


def widen_exceeded_priors(path: Phase, solver: RoundSolver) -> Phase | None:
    """Widen the priors that a solved path contradicts, and solve a round with them.

    None where the path contradicts no prior, where an unknown is not determined at all, or where
    the path has no solved round.

    path: solved without the CAD model or with it.
    """
    solved = path.estimate
    rig = solved.measured.rig
    priors = _prior_deviations(rig, solved.state)
    if path.last is None or not any(prior.may_be_exceeded() for prior in priors.values()):
        return None
    try:
        settings = solver.settings
        if solved.state.hull is None:
            settings = replace(settings, method="naive")
        covariance = join.covariance(
            path.last.problem, path.last.plan, settings, of_landmarks=False
        )
    except StageError:
        return None  # an unknown is not determined at all; the last round reports which
    widening = {
        name: prior.widening(getattr(covariance, BLOCKS[name])) for name, prior in priors.items()
    }
    if all((factor == 1).all() for factor in widening.values()):
        return None
    solver.report(f"priors that the dive contradicts are widened: {_describe(widening)}")
    widened = replace(solved, measured=replace(solved.measured, rig=_widen(rig, widening)))
    verdict = ACCEPTED
    if widening["navigation"][DVL_SCALE] > 1:
        # A wrong speed of sound scales the ranges as well: a second camera, depths and the CAD
        # model decide.
        share = float(rig.priors.navigation_sigma[DVL_SCALE] * widening["navigation"][DVL_SCALE])
        widened = replace(widened, weights=widen_ranges(widened, share))
        verdict = Verdict(length_conflict=share if rig.bottom is None else None)
    result = solver.solve_round(widened)
    return Phase.of((result,), result.after, verdict)


def contradicts_priors(path: Phase) -> bool:
    """Tell whether an estimate lies beyond MANY_SIGMAS of its prior, widened or not."""
    solved = path.estimate
    priors = _prior_deviations(solved.measured.rig, solved.state).values()
    return any(bool(np.abs(prior.deviation).max() > MANY_SIGMAS) for prior in priors)


def _prior_deviations(rig: Rig, state: State) -> dict[str, _PriorDeviation]:
    """Compute how far navigation errors and rotations of mounts lie from their priors, by name.

    Positions of mounts are left out: a wrong focal length looks like a camera that stands nearer or
    farther.
    """
    rows = np.diag(1 / rig.priors.navigation_sigma)[:CONSTANT_ERRORS]
    out = {"navigation": _PriorDeviation(deviation=rows @ state.navigation, to_sigmas=rows)}
    for name in MOUNTS:
        nominal, rows, found = (getattr(of, name) for of in (rig, rig.priors, state.mounts))
        if nominal is not None and rows is not None and found is not None:
            by, to_child = displacement(nominal, found)
            rows = rows[ROTATION]
            out[name] = _PriorDeviation(deviation=rows @ by, to_sigmas=rows @ to_child)
    return out


def displacement(nominal: Poses, found: Poses) -> tuple[Array, Array]:
    """Compute how far an estimated mount lies from its nominal pose.

    Parameters
    ----------
    nominal, found
        Poses parent_from_child, as calibrated and as estimated.

    Returns
    -------
    displacement
        (6,) translation m and rotation rad, in the child's axes.
    to_child
        (6, 6) from the unknown's tangent, whose translation is in the parent's axes, to the
        child's axes.
    """
    to_child = np.eye(6)
    to_child[:3, :3] = nominal.rotation.inv().as_matrix()[0]
    shift = to_child[:3, :3] @ (found.translation - nominal.translation)[0]
    turn = (nominal.rotation.inv() * found.rotation).as_rotvec()[0]
    return np.r_[shift, turn], to_child


def _widen(rig: Rig, widening: dict[str, Array]) -> Rig:
    """Multiply the sigmas of the rig's priors by factors.

    widening: factors (k,) of the errors of navigation and of each mount's rotation, by
    the prior's name.
    """
    navigation = rig.priors.navigation_sigma.copy()
    navigation[:CONSTANT_ERRORS] *= widening["navigation"]
    mounts = {
        name: getattr(rig.priors, name) / np.r_[np.ones(3), widening[name]][:, None]
        for name in MOUNTS
        if name in widening
    }
    return rig.with_priors(navigation_sigma=navigation, **mounts)


def _describe(widening: dict[str, Array]) -> str:
    return ", ".join(
        f"{name} by {factor.max():.1f}" for name, factor in widening.items() if (factor > 1).any()
    )
