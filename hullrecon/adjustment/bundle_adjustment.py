# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Model-assisted bundle adjustment of a dive [Ozog2016 4.2] (docs/methods.md 6), from dead reckoning to the adjusted dive."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.hull_pose import estimate, registration
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem import hard_em, intrinsics, iteration_history, pruning, selection, weighting
from hullrecon.adjustment.problem.assembly import Selection, assemble, state_from_unknowns
from hullrecon.adjustment.problem.deviation_field import grid_over
from hullrecon.adjustment.problem.measurements import CadModel, Measurements, return_points
from hullrecon.adjustment.problem.state import HullState, State, Weights
from hullrecon.errors import StageError
from hullrecon.estimation.rig_priors import Rig
from hullrecon.records.iterations import reached
from hullrecon.typing import Array

Report = Callable[[str], None]
FIRST_MAX_PX = 40.0  # dead-reckoned poses err by centimetres across legs: some tens of pixels at a metre
LEAST_MAX_PX = 2.0
NO_STRUCTURE_M = 0.5  # off the hull: a mismatch, not something that stands on it
log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What one round leaves to the next: measured, with the intrinsics found so far; the unknowns; sigmas and weights; the
    largest reprojection error that counts, px."""

    measured: Measurements
    state: State
    weights: Weights
    max_px: float


@dataclass(frozen=True, kw_only=True)
class RoundResult:
    """One solve: the measurements chosen and the weights that it used, the problem at its start and at its solution, its
    history, and the estimate after it."""

    chosen: Selection
    weights: Weights
    start: native.Problem
    problem: native.Problem
    result: native.Result
    history: iteration_history.Round
    after: Estimate


@dataclass(frozen=True, kw_only=True)
class Adjusted:
    """The adjusted dive. start: the first round's problem as dead reckoning left it; problem and result: of the last round, at
    its solution; rig: with the intrinsics found; evidence: what the hull pose was fitted to (None where no round held it)."""

    state: State
    weights: Weights
    chosen: Selection
    start: native.Problem
    problem: native.Problem
    result: native.Result
    registration: registration.Registration | None
    rounds: tuple[iteration_history.Round, ...]
    rig: Rig
    evidence: estimate.HullPoseEvidence | None


def adjust(measured: Measurements, options: AdjustOptions, report: Report) -> Adjusted:
    """Return the dive adjusted in rounds, each with the outliers and sigmas that the one before found.

    Raises StageError when too little agrees to be adjusted.
    """
    solver = _RoundSolver(measured.rig, options, report)
    start, registered = _start(measured, options, report)
    # Coarse rounds: some well-seen landmarks find poses, outliers and sigmas at a fraction of the last round's cost.
    rounds = solver.coarse_rounds(start)
    # The hull pose: solves slide along the hull, the profile of its likelihood does not.
    evidence, ready = _estimate_hull_pose(rounds, options) if rounds else (None, start)
    # The final round: every landmark, with the hull pose held.
    rounds.append(solver.solve_round(ready, final=True, hold_hull_pose=evidence is not None))
    return _drop_lost_landmarks(rounds, registered, evidence)


@dataclass(frozen=True)
class _RoundSolver:
    """Solves rounds, counts and reports them. calibrated: the rig with the intrinsics of the calibration."""

    calibrated: Rig
    options: AdjustOptions
    report: Report
    history: list[iteration_history.Round] = field(default_factory=list)
    begun_s: float = field(default_factory=time.perf_counter)

    def coarse_rounds(self, start: Estimate) -> list[RoundResult]:
        """Return all rounds but the last one."""
        rounds: list[RoundResult] = []
        for _ in range(self.options.rounds - 1):
            rounds.append(self.solve_round(rounds[-1].after if rounds else start))
        return rounds

    def solve_round(self, before: Estimate, *, final: bool = False, hold_hull_pose: bool = False) -> RoundResult:
        """Return the round from an estimate: choose and weight measurements, solve, estimate the next sigmas."""
        options, measured = self.options, before.measured
        state = replace(before.state, landmark=selection.triangulate_landmarks(measured, before.state))
        chosen = choose_measurements(measured, state, before.max_px, options, final)
        weights = replace(before.weights, surface=weighting.surface_weights(state, chosen, options))
        problem = assemble(measured, state, weights, chosen, options.as_published, hold_hull_pose)
        problem = intrinsics.free_intrinsics(problem, self.calibrated, options)
        began_s = time.perf_counter() - self.begun_s
        result = _solve(problem, options, final)
        history = self._record(measured, result, weights, chosen, began_s)
        state = state_from_unknowns(state, result.unknowns, chosen)
        measured = intrinsics.apply_intrinsics(measured, problem, result)
        found = weighting.estimate_weights(measured, state, chosen, weights, options)
        max_px = max(LEAST_MAX_PX, options.outlier_sigmas * found.pixel)
        self.report(_describe_round(len(self.history), result, chosen, found))
        return RoundResult(
            chosen=chosen,
            weights=weights,
            start=problem,
            problem=problem.started_from(result.unknowns),
            result=result,
            history=history,
            after=Estimate(measured=measured, state=state, weights=found, max_px=max_px),
        )

    def _record(
        self, measured: Measurements, result: native.Result, weights: Weights, chosen: Selection, began_s: float
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


def _start(measured: Measurements, options: AdjustOptions, report: Report) -> tuple[Estimate, registration.Registration | None]:
    """Return the dead-reckoned dive, laid onto the CAD model where there is one."""
    rig, seen = measured.rig, measured.tracks is not None
    state = State(
        nodes=measured.trajectory.poses(),
        tray=measured.trajectory.tray.copy(),
        landmark=np.full((selection.landmark_count(measured), 3), np.nan),
        T_s_ct=rig.T_s_ct.nominal if rig.T_s_ct and seen else None,
        T_ct_cb=rig.T_ct_cb.nominal if rig.T_ct_cb and seen else None,
        T_s_d=rig.T_s_d.nominal,
        navigation=np.zeros(6),
        hull=None,
    )
    registered = None
    if measured.cad_model is not None:
        points = _points_to_register(measured, state)
        registered = registration.register(points, measured.cad_model, rig.sigma_range)
        report(f"registered {len(points)} points to the CAD model, {100 * registered.fitness:.0f} % within three sigma")
        state = replace(state, hull=_hull_state(measured.cad_model, registered, points, options))
    weights = weighting.initial_weights(measured, options)
    return Estimate(measured=measured, state=state, weights=weights, max_px=FIRST_MAX_PX), registered


def _hull_state(cad_model: CadModel, found: registration.Registration, points: Array, options: AdjustOptions) -> HullState:
    hull = HullState(
        cad_model=cad_model,
        global_from_hull=found.global_from_hull,
        survey_center=found.center,
        grid=None,
        field=np.zeros(0),
    )
    if options.as_published:
        return hull
    at = hull.to_chart(points)
    grid = grid_over(at[np.isfinite(at).all(1)], cad_model.deviation_length)
    return replace(hull, grid=grid, field=np.zeros(grid.size))


def _points_to_register(measured: Measurements, state: State) -> Array:
    """Return what is laid onto the CAD model, in g: DVL returns, or stereo landmarks where no ranges were carried."""
    if measured.returns is not None and (~measured.returns.flagged).sum() >= 30:
        points, _ = return_points(measured.returns, state.nodes, state.tray, measured.rig.tray_origin, state.T_s_d)
        return points[~measured.returns.flagged]
    landmarks = selection.triangulate_landmarks(measured, state)
    landmarks = landmarks[np.isfinite(landmarks[:, 0])]
    if len(landmarks) < 30:
        raise StageError(
            "nothing to lay onto the CAD model: fewer than 30 DVL returns and landmarks",
            remedy="check topics.dvl and the cameras, or remove [hull] to run without a CAD model",
        )
    return landmarks


def _estimate_hull_pose(rounds: list[RoundResult], options: AdjustOptions) -> tuple[estimate.HullPoseEvidence | None, Estimate]:
    """Return what the hull pose was fitted to, and the last estimate with the pose at the mean of its profile; as published and
    without a CAD model, the estimate as it is."""
    last, ready = rounds[-1], rounds[-1].after
    hull = ready.state.hull
    if hull is None or options.as_published:
        return None, ready
    points = estimate.collect_hull_points(ready.measured, ready.state, last.chosen, last.result.label)
    evidence, best = estimate.fit_hull_pose(points, hull.global_from_hull, hull.cad_model, hull.survey_center)
    hull = replace(hull, global_from_hull=estimate.profile_mean_pose(evidence, best))
    return evidence, replace(ready, state=replace(ready.state, hull=hull))


def choose_measurements(measured: Measurements, state: State, max_px: float, options: AdjustOptions, final: bool) -> Selection:
    """Return anchor landmarks for a coarse round, all landmarks but isolated ones off the hull for the final one.

    Raises StageError when fewer than 20 agree with the navigation.
    """
    chosen = selection.select_measurements(measured, state, max_px)
    if final and state.hull is not None and not options.as_published:
        off = np.abs(state.hull.deviation(state.landmark[chosen.landmarks]))
        off_hull = off > hard_em.label_boundary(options.sigma_on, options.sigma_off)
        chosen = selection.drop_isolated_landmarks(measured, state, chosen, off_hull)
    if options.method == "geva" and state.hull is not None:
        # pulled to the hull, a mismatch near the camera passes through the camera's plane, and the solve stalls there
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
    solve = hard_em.solve if options.labels == "outer" and options.method == "maxmix" else native.solve
    settings = native.Options(
        method=options.method,
        sigma_on=options.sigma_on,
        sigma_off=options.sigma_off,
        max_iterations=options.max_iterations,
        function_tolerance=options.function_tolerance if final else 10 * options.function_tolerance,
        threads=options.threads,
    )
    return solve(problem, settings)


def _drop_lost_landmarks(
    rounds: list[RoundResult],
    registered: registration.Registration | None,
    evidence: estimate.HullPoseEvidence | None,
) -> Adjusted:
    """Return the adjusted dive without landmarks that the last solve pushed behind their cameras or metres off the hull:
    nothing determines them."""
    last, state = rounds[-1], rounds[-1].after.state
    chosen, problem, result = last.chosen, last.problem, last.result
    sound = selection.select_measurements(last.after.measured, state, max_px=1e3).landmarks
    keep = np.isin(chosen.landmarks, sound)
    if not keep.all():
        lost = chosen.landmarks[~keep]
        landmark = state.landmark.copy()
        landmark[lost] = np.nan
        log.info("%d landmarks were lost in the solve and are left out", len(lost))
        state = replace(state, landmark=landmark)
        chosen = replace(chosen, landmarks=chosen.landmarks[keep])
        result = pruning.drop_label_rows(result, keep[problem.surface.landmark])
        problem = pruning.drop_landmarks(problem, keep)
    return Adjusted(
        state=state,
        weights=last.weights,
        chosen=chosen,
        start=rounds[0].start,
        problem=problem,
        result=result,
        registration=registered,
        rounds=tuple(r.history for r in rounds),
        rig=last.after.measured.rig,
        evidence=evidence,
    )


def _describe_round(number: int, result: native.Result, chosen: Selection, weights: Weights) -> str:
    record = result.iterations
    cost = reached(record.cost, record.accepted)
    return (
        f"round {number}: {len(record.cost) - 1} iterations, cost {cost[0]:.6g} to {cost[-1]:.6g}, "
        f"{len(chosen.landmarks)} landmarks, {int((result.label == 1).sum())} on the hull, pixel sigma now {weights.pixel:.2f}"
    )
