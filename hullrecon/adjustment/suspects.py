# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whose error explains that the measurements of a dive contradict each other (docs/methods.md 6).

Each sensor in turn is left out of the solved path, or what it may be wrong in becomes unknown, and
the path is solved again: who, left out, makes the rest agree?
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.findings.adjustment import CORRECTED

LEFT_OUT = 1e3  # by which the sigmas of a measurement that is left out grow
FREE_SHARE, FREE_RAD, FREE_M = 1.0, 1.0, 1.0  # prior sigmas of what becomes unknown
FREE_DRIFT_RAD_S = 0.01
LOOSE_TRAY_RAD = np.radians(10.0)  # of each reading of the tray: its angles are not forgotten
ITERATIONS = 50  # of a trial, which starts at the solved path
TOLERANCE = 1e-5
HELD, HELD_PX = 1e-6, 1e-3  # prior sigmas of intrinsics that stay
# A suspect explains as much as the best if so large a share of the contradiction is gone without it
EXPLAINS = 0.9
CERTAIN = 3.0  # sigmas of the squares that rows without error take with them when they are left out
FOCAL, CENTER = slice(0, 2), slice(2, 4)  # of a camera's intrinsics
SCALE, DRIFT, ROLL, PITCH = range(4)  # places among the errors of navigation
# Truth over what a DVL measured, beyond which its scale explains nothing: feet are 3.28 to a metre
LEAST_SCALE, MOST_SCALE = 0.25, 4.0
# Suspects as a whole, by their own errors
WHOLES = {"dvl-velocities": {"dvl-scale", "dvl-mount"}}


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A suspect, and what of a contradiction is gone without it."""

    suspect: str  # a key of SUSPECTS of hullrecon/findings/adjustment.py
    gain: float  # squares of residuals that are gone, beyond those of the rows left out
    rows: int  # measurements that are left out, or unknowns that are freed
    found: float | None  # its own error by the rest: share, rad; None where it was left out

    @property
    def is_certain(self) -> bool:
        """Tell whether more is gone than noise explains."""
        return self.gain > self.spread

    @property
    def spread(self) -> float:
        """Compute the spread of `gain` where the rows left out have no error."""
        return float(CERTAIN * np.sqrt(2 * self.rows))

    @property
    def corrects(self) -> bool:
        """Tell whether the adjustment can take this suspect's error out."""
        return self.suspect in CORRECTED


@dataclass(frozen=True)
class _Suspect:
    name: str
    doubt: Callable[[native.Problem], native.Problem]  # leaves it out, or frees its own unknowns
    rows: int  # of measurements that are left out, or unknowns that are freed
    # its own error (problem, solution), where that was freed
    found: Callable[[native.Problem, native.Unknowns], float] | None = None


def try_suspects(problem: native.Problem, settings: native.Options) -> tuple[Trial, ...]:
    """Solve a path again without each suspect, the best explanation first.

    Parameters
    ----------
    problem
        A round without the CAD model at its solution, its priors as the package states them.
    settings
        Of its solve.
    """
    before = _solved(problem, settings)[0]
    trials = [_try(suspect, problem, settings, before) for suspect in _suspects(problem)]
    return tuple(sorted(trials, key=lambda trial: -trial.gain))


def _try(
    suspect: _Suspect, problem: native.Problem, settings: native.Options, before: float
) -> Trial:
    """Solve without a suspect. before: squares of the residuals with it."""
    squares, unknowns = _solved(suspect.doubt(problem), settings)
    return Trial(
        suspect=suspect.name,
        gain=before - squares - suspect.rows,
        rows=suspect.rows,
        found=None if suspect.found is None else suspect.found(problem, unknowns),
    )


def best_explanations(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """Choose the trial that explains most, and those that explain as much.

    A sensor as a whole is not named where one of its own errors explains as much.
    """
    certain = [trial for trial in trials if trial.is_certain and not _is_absurd(trial)]
    if not certain:
        return ()
    enough = EXPLAINS * certain[0].gain - certain[0].spread
    best = [trial for trial in certain if trial.gain >= enough]
    named = {trial.suspect for trial in best}
    wholes = {whole for whole, parts in WHOLES.items() if named & parts}
    return tuple(trial for trial in best if trial.suspect not in wholes)


def _is_absurd(trial: Trial) -> bool:
    """Tell whether a suspect's own error is one that no sensor has."""
    if trial.suspect != "dvl-scale" or trial.found is None:
        return False
    return not LEAST_SCALE < 1 + trial.found < MOST_SCALE


def _solved(problem: native.Problem, settings: native.Options) -> tuple[float, native.Unknowns]:
    """Solve, and sum the robust squares of all whitened residuals."""
    naive = replace(settings, method="naive")
    result = native.solve(
        problem, replace(naive, max_iterations=ITERATIONS, function_tolerance=TOLERANCE)
    )
    solved = problem.started_from(result.unknowns)
    cost = native.evaluate(solved, naive, jacobian=False).cost_by_factor
    return 2 * sum(cost.values()), result.unknowns


def _suspects(problem: native.Problem) -> list[_Suspect]:
    """List the suspects that a problem has."""
    has_images = len(problem.stereo.node) + len(problem.mono.node) > 0
    nodes, steps = len(problem.attitude.node), len(problem.odometry.first)
    found = [
        _Suspect("pressure", lambda p: _without_attitude(p, [0]), nodes),
        _Suspect("dvl-scale", _free_navigation({SCALE: FREE_SHARE}), 1, _scale),
        _Suspect("tray", _loosen_tray, len(problem.tray.node)),
    ]
    if problem.priors.T_s_d is not None:
        found.append(_Suspect("dvl-mount", _free_mount("T_s_d"), 3, _turn("T_s_d")))
    biases = _free_navigation({DRIFT: FREE_DRIFT_RAD_S, ROLL: FREE_RAD, PITCH: FREE_RAD})
    found.append(_Suspect("imu", biases, 3, _tilt))
    if len(problem.plane_ranges.plane):
        found.append(_Suspect("dvl-ranges", _without_planes, len(problem.plane_ranges.plane)))
    if len(problem.positions.node):
        found.append(_Suspect("positions", _without_positions, 2 * len(problem.positions.node)))
    if not has_images:
        return found
    found.append(_Suspect("dvl-velocities", _without_velocities, 3 * steps))
    found.append(_Suspect("focal-length", _free_intrinsics(FOCAL), 2, _focal_ratio))
    found.append(_Suspect("principal-point", _free_intrinsics(CENTER), 2, _center_shift_px))
    if problem.priors.T_s_ct is not None:
        found.append(_Suspect("camera-mount", _free_mount("T_s_ct"), 6, _turn("T_s_ct")))
    if len(problem.stereo.node):
        found.append(_Suspect("stereo-rig", _free_stereo_rig, 6, _baseline))
    return found


def _free_navigation(
    sigma: Mapping[int, float],
) -> Callable[[native.Problem], native.Problem]:
    def free(problem: native.Problem) -> native.Problem:
        wide = problem.priors.navigation_sigma.copy()
        for place, value in sigma.items():
            wide[place] = max(wide[place], value)
        return replace(problem, priors=replace(problem.priors, navigation_sigma=wide))

    return free


def _free_mount(block: str) -> Callable[[native.Problem], native.Problem]:
    def free(problem: native.Problem) -> native.Problem:
        prior = getattr(problem.priors, block)
        loose = np.diag(np.r_[np.full(3, 1 / FREE_M), np.full(3, 1 / FREE_RAD)])
        if block == "T_s_d":  # its position is held: nothing sees it
            loose[:3] = prior.sqrt_information[:3]
        wide = replace(prior, sqrt_information=loose)
        return replace(problem, priors=replace(problem.priors, **{block: wide}))

    return free


def _free_stereo_rig(problem: native.Problem) -> native.Problem:
    value = problem.unknowns.T_ct_cb
    if problem.priors.T_ct_cb is not None:
        value = problem.priors.T_ct_cb.value
    length_m = max(float(np.linalg.norm(value[:3])), 1e-6)
    loose = np.diag(np.r_[np.full(3, 1 / (FREE_SHARE * length_m)), np.full(3, 1 / FREE_RAD)])
    wide = native.MotionPrior(value=value, sqrt_information=loose)
    return replace(problem, priors=replace(problem.priors, T_ct_cb=wide)).free("T_ct_cb")


def _free_intrinsics(places: slice) -> Callable[[native.Problem], native.Problem]:
    def free(problem: native.Problem) -> native.Problem:
        sigma = np.r_[np.full(4, HELD_PX), np.full(5, HELD)]
        sigma[places] = FREE_SHARE * problem.unknowns.intrinsics_top[FOCAL]
        cameras = ["intrinsics_top"]
        if len(problem.stereo.node) or (problem.mono.camera == 1).any():
            cameras.append("intrinsics_bottom")
        priors = replace(problem.priors, intrinsics_sigma=sigma)
        return replace(problem, priors=priors).free(*cameras)

    return free


def _without_attitude(problem: native.Problem, columns: Sequence[int]) -> native.Problem:
    sigma = problem.attitude.sigma.copy()
    sigma[:, columns] *= LEFT_OUT
    return replace(problem, attitude=replace(problem.attitude, sigma=sigma))


def _loosen_tray(problem: native.Problem) -> native.Problem:
    sigma = np.hypot(problem.tray.sigma, LOOSE_TRAY_RAD)
    return replace(problem, tray=replace(problem.tray, sigma=sigma))


def _without_planes(problem: native.Problem) -> native.Problem:
    return replace(
        problem, plane_ranges=native.PlaneRangeTable(), plane_pairs=native.PlanePairTable()
    )


def _without_positions(problem: native.Problem) -> native.Problem:
    sigma = LEFT_OUT * problem.positions.sigma
    return replace(problem, positions=replace(problem.positions, sigma=sigma))


def _without_velocities(problem: native.Problem) -> native.Problem:
    rows = problem.odometry.sqrt_information.copy()
    rows[:, :3] /= LEFT_OUT
    return replace(problem, odometry=replace(problem.odometry, sqrt_information=rows))


def _scale(_: native.Problem, unknowns: native.Unknowns) -> float:
    return float(unknowns.navigation[SCALE])


def _tilt(_: native.Problem, unknowns: native.Unknowns) -> float:
    return float(np.hypot(unknowns.navigation[ROLL], unknowns.navigation[PITCH]))


def _turn(block: str) -> Callable[[native.Problem, native.Unknowns], float]:
    def turn(problem: native.Problem, unknowns: native.Unknowns) -> float:
        nominal = Rotation.from_quat(getattr(problem.priors, block).value[3:])
        found = Rotation.from_quat(getattr(unknowns, block)[3:])
        return float((nominal.inv() * found).magnitude())

    return turn


def _focal_ratio(problem: native.Problem, unknowns: native.Unknowns) -> float:
    return float(np.mean(unknowns.intrinsics_top[:2] / problem.unknowns.intrinsics_top[:2]))


def _center_shift_px(problem: native.Problem, unknowns: native.Unknowns) -> float:
    shift = unknowns.intrinsics_top[CENTER] - problem.unknowns.intrinsics_top[CENTER]
    return float(np.linalg.norm(shift))


def _baseline(problem: native.Problem, unknowns: native.Unknowns) -> float:
    before, after = (np.linalg.norm(of.T_ct_cb[:3]) for of in (problem.unknowns, unknowns))
    return float(after / before - 1)
