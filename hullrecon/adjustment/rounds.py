# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One solve after the other: which measurements enter a round, with what weights, and what it
leaves to the next.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.native_settings import native_settings
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem import (
    hard_em,
    intrinsics,
    iteration_history,
    selection,
    weighting,
)
from hullrecon.adjustment.problem.assembly import Selection, assemble, state_from_unknowns
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.state import State, Weights
from hullrecon.errors import StageError
from hullrecon.records.iterations import reached_cost
from hullrecon.rig import Rig
from hullrecon.typing import Array

Report = Callable[[str], None]
LEAST_MAX_PX = 2.0  # in rounds before the last, whose path may still be off
# Damping holds what many measurements share, a single camera's scale and the bends of a long path,
# far more than it holds the steps: with Ceres' 1e4 such a mode hardly moves while each iteration's
# gain falls below the tolerance.
INITIAL_RADIUS = 1e8
NO_STRUCTURE_M = 0.5  # off the hull: a mismatch, not something that stands on it
log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What one round leaves to the next: measured, with the intrinsics found so far; the unknowns;
    sigmas and weights; the largest reprojection error that counts, px, where the sigma is the pixel
    sigma.
    """

    measured: Measurements
    state: State
    weights: Weights
    max_px: float


@dataclass(frozen=True, kw_only=True)
class RoundResult:
    """One solve: the measurements chosen and the weights that it used, the problem at its start and
    at its solution, its history, and the estimate after it.
    """

    chosen: Selection
    weights: Weights
    start: native.Problem
    problem: native.Problem
    result: native.Result
    history: iteration_history.Round
    after: Estimate


@dataclass(frozen=True, kw_only=True)
class RoundSolver:
    """Solves rounds, counts and reports them. calibrated: the rig with the intrinsics of the
    calibration.
    """

    calibrated: Rig
    options: AdjustOptions
    report: Report
    history: list[iteration_history.Round] = field(default_factory=list)
    begun_s: float = field(default_factory=time.perf_counter)

    def coarse_rounds(self, start: Estimate, count: int) -> list[RoundResult]:
        """Return rounds on some well-seen landmarks, each from the one before."""
        rounds: list[RoundResult] = []
        for _ in range(count):
            rounds.append(self.solve_round(rounds[-1].after if rounds else start))
        return rounds

    def solve_round(
        self, before: Estimate, *, final: bool = False, hold_hull_pose: bool = False
    ) -> RoundResult:
        """Return the round from an estimate: choose and weight measurements, solve, estimate the
        next sigmas.
        """
        options, measured = self.options, before.measured
        state = replace(
            before.state, landmark=selection.triangulate_landmarks(measured, before.state)
        )
        max_px = before.max_px * before.weights.pixel_ratio
        max_px = max_px if final else np.maximum(LEAST_MAX_PX, max_px)
        chosen = choose_measurements(measured, state, max_px, options, final)
        weights = replace(before.weights, surface=weighting.surface_weights(state, chosen, options))
        problem = assemble(measured, state, weights, chosen, options.as_published, hold_hull_pose)
        problem = intrinsics.free_intrinsics(problem, self.calibrated, options)
        began_s = time.perf_counter() - self.begun_s
        result = _solve(problem, options, final)
        history = self._record(measured, result, weights, chosen, began_s)
        state = state_from_unknowns(state, result.unknowns, chosen)
        measured = intrinsics.apply_intrinsics(measured, problem, result)
        found = weighting.estimate_weights(measured, state, chosen, weights, options)
        self.report(_describe_round(len(self.history), result, chosen, found))
        return RoundResult(
            chosen=chosen,
            weights=weights,
            start=problem,
            problem=problem.started_from(result.unknowns),
            result=result,
            history=history,
            after=Estimate(
                measured=measured,
                state=state,
                weights=found,
                max_px=options.outlier_sigmas * found.pixel,
            ),
        )

    def _record(
        self,
        measured: Measurements,
        result: native.Result,
        weights: Weights,
        chosen: Selection,
        began_s: float,
    ) -> iteration_history.Round:
        """Return the round for the history; its table goes to the log (`--verbose`)."""
        done = iteration_history.Round(
            record=result.iterations,
            weights=weights,
            depth_sigma_m=weighting.depth_sigma(measured, weights),
            landmarks=len(chosen.landmarks),
            converged=result.converged,
            message=result.message,
            began_s=began_s,
        )
        self.history.append(done)
        for line in iteration_history.lines(len(self.history), done):
            log.debug("%s", line)
        return done


def choose_measurements(
    measured: Measurements, state: State, max_px: Array, options: AdjustOptions, final: bool
) -> Selection:
    """Return anchor landmarks for a coarse round, all landmarks but isolated ones off the hull for
    the final one.

    Raises StageError when fewer than 20 agree with the navigation.
    """
    chosen = selection.select_measurements(measured, state, max_px)
    if final and state.hull is not None and not options.as_published:
        off = np.abs(state.hull.deviation(state.landmark[chosen.landmarks]))
        off_hull = off > hard_em.label_boundary(options.on_hull_sigma_m, options.off_hull_sigma_m)
        chosen = selection.drop_isolated_landmarks(measured, state, chosen, off_hull)
    if options.method == "geva" and state.hull is not None:
        # pulled to the hull, a mismatch near the camera passes through the camera's plane, and the
        # solve stalls there
        far = np.abs(state.hull.deviation(state.landmark[chosen.landmarks])) > NO_STRUCTURE_M
        chosen = replace(chosen, landmarks=chosen.landmarks[~far])
    if not final:
        chosen = selection.choose_anchors(measured, chosen, options.anchors)
    if measured.tracks is not None and len(chosen.landmarks) < 20:
        raise StageError(
            f"only {len(chosen.landmarks)} landmarks agree with the navigation",
            remedy="check camera mounts and time offsets, or lower matches' thresholds",
        )
    return chosen


def _solve(problem: native.Problem, options: AdjustOptions, final: bool) -> native.Result:
    solve = (
        hard_em.solve if options.labels == "outer" and options.method == "maxmix" else native.solve
    )
    settings = replace(
        native_settings(options),
        max_iterations=options.max_iterations,
        function_tolerance=options.function_tolerance if final else 10 * options.function_tolerance,
        initial_radius=INITIAL_RADIUS,
    )
    return solve(problem, settings)


def _describe_round(number: int, result: native.Result, chosen: Selection, weights: Weights) -> str:
    record = result.iterations
    cost = reached_cost(record.cost, record.accepted)
    return (
        f"round {number}: {len(record.cost) - 1} iterations, cost {cost[0]:.6g} to {cost[-1]:.6g}, "
        f"{len(chosen.landmarks)} landmarks, {int((result.label == 1).sum())} on the hull, pixel sigma now {weights.pixel:.2f}"
    )
