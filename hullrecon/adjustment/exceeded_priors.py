# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Priors of sensors and mounts that a dive contradicts, widened to what it shows.

See docs/methods.md 6.

Where a package says that its DVL is right to half a per cent and it is not, by three, the solve
ends somewhere between, with a sigma that the prior made small. Of an estimate x with prior sigma p
and posterior variance P the dive alone gives x / g, with the variance P / g, where g = 1 - P / p^2.
If the prior is right, x / g has the variance p^2 + P / g.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.rounds import ACCEPTED, Phase, RoundSolver, Verdict
from hullrecon.adjustment.stereo_calibration import DVL_SCALE, widen_ranges
from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses
from hullrecon.rig import Rig
from hullrecon.typing import Array

MANY_SIGMAS = 4.0  # of what the package allows
# A prior is widened only beyond so many of the sigmas with which the dive alone knows the unknown,
# and only if the dive takes away that share of the prior's variance: what a dive hardly knows, as a
# lever arm along a straight leg, small errors of other sensors may seem to contradict.
MANY_OF_ITS_OWN = 8.0
LEAST_GAINED = 0.25
ROTATION = slice(3, 6)  # rows of a mount's prior
# errors of navigation: the tray's backlash, the sixth, is a prior of each swing as well
CONSTANT_ERRORS = 5
MOUNTS = ("tray_from_top", "tray_from_dvl")
# blocks of the native problem by the priors that may be widened
BLOCKS = {"navigation": "navigation", "tray_from_top": "T_s_ct", "tray_from_dvl": "T_s_d"}


@dataclass(frozen=True, kw_only=True)
class _Prior:
    """How far the estimate of an unknown lies from its prior."""

    deviation: Array  # (k,) in the prior's sigmas
    to_sigmas: Array  # (k, m) from the unknown's tangent to those sigmas

    def may_be_exceeded(self) -> bool:
        """Tell whether any covariance would let `widening` widen the prior."""
        return bool(
            np.abs(self.deviation).max()
            > MANY_OF_ITS_OWN * np.sqrt(LEAST_GAINED * (1 - LEAST_GAINED))
        )

    def widening(self, covariance: Array) -> Array:
        """Compute by how much each sigma is to grow (k,), 1 where the prior holds.

        covariance (m, m): of the estimate, in the unknown's tangent.
        """
        left = np.diag(self.to_sigmas @ covariance @ self.to_sigmas.T)
        gained = np.maximum(1 - left, 1e-9)
        of_the_dive = np.abs(self.deviation) / gained  # as it would be without the prior
        sigma = np.sqrt(np.maximum(left, 0) / gained)
        surprising = (of_the_dive > MANY_SIGMAS * np.hypot(1, sigma)) & (
            of_the_dive > MANY_OF_ITS_OWN * sigma
        )
        return np.where(surprising & (gained > LEAST_GAINED), of_the_dive, 1.0)


def widen_exceeded_priors(path: Phase, solver: RoundSolver) -> Phase | None:
    """Widen the priors that a solved path contradicts, and solve a round with them.

    None where it contradicts none.
    """
    solved = path.estimate
    rig, state = solved.measured.rig, solved.state
    priors = _priors(rig, state)
    if not any(prior.may_be_exceeded() for prior in priors.values()):
        return None
    if path.last is None:
        return None
    try:
        covariance = native.covariance(
            path.last.problem, replace(solver.settings, method="naive"), of_landmarks=False
        )
    except StageError:
        return None  # something is not determined at all; the last round says what
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
    """Tell whether an estimate lies beyond what the package allows, widened or not."""
    solved = path.estimate
    priors = _priors(solved.measured.rig, solved.state).values()
    return any(bool(np.abs(prior.deviation).max() > MANY_SIGMAS) for prior in priors)


def _priors(rig: Rig, state: State) -> dict[str, _Prior]:
    """Collect the priors of navigation and of the mounts' rotations by name.

    A mount's position is left out: a focal length that is off looks like a camera that stands
    nearer or farther.
    """
    rows = np.diag(1 / rig.priors.navigation_sigma)[:CONSTANT_ERRORS]
    out = {"navigation": _Prior(deviation=rows @ state.navigation, to_sigmas=rows)}
    for name in MOUNTS:
        nominal, rows, found = (getattr(of, name) for of in (rig, rig.priors, state.mounts))
        if nominal is not None and rows is not None and found is not None:
            by, to_child = displacement(nominal, found)
            rows = rows[ROTATION]
            out[name] = _Prior(deviation=rows @ by, to_sigmas=rows @ to_child)
    return out


def displacement(nominal: Poses, found: Poses) -> tuple[Array, Array]:
    """Compute how far a mount was found from its nominal pose (6,), in the child's axes.

    The second value (6, 6) turns the unknown's tangent, whose translation is in the parent's axes,
    into those axes.
    """
    to_child = np.eye(6)
    to_child[:3, :3] = nominal.rotation.inv().as_matrix()[0]
    shift = to_child[:3, :3] @ (found.translation - nominal.translation)[0]
    turn = (nominal.rotation.inv() * found.rotation).as_rotvec()[0]
    return np.r_[shift, turn], to_child


def _widen(rig: Rig, widening: dict[str, Array]) -> Rig:
    """Widen the rig's priors by factors (k,) of the sigmas, by name."""
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
