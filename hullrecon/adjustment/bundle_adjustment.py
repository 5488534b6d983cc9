# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Model-assisted bundle adjustment of a dive [Ozog2016 4.2] (docs/methods.md 6), from dead reckoning to the adjusted dive."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.hull_pose import estimate, registration
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem import hard_em, intrinsics, iteration_history, pruning, selection, weighting
from hullrecon.adjustment.problem.assembly import Selection, assemble, state_from_unknowns
from hullrecon.adjustment.problem.deviation_field import grid_over
from hullrecon.adjustment.problem.measurements import Measurements, Rig, return_points
from hullrecon.adjustment.problem.state import State, Weights
from hullrecon.errors import StageError
from hullrecon.records.iterations import reached
from hullrecon.typing import Array

Report = Callable[[str], None]
NO_STRUCTURE_M = 0.5  # off the hull: a mismatch, not something that stands on it
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Adjusted:
    """The end of the story. start: the first round's problem as dead reckoning left it;
    problem and result: of the last round, at its solution; rig: with the intrinsics found; ground: what the place was
    settled on."""

    state: State
    weights: Weights
    chosen: Selection
    center: Array
    start: native.Problem
    problem: native.Problem
    result: native.Result
    registration: registration.Registration | None
    rounds: tuple[iteration_history.Round, ...]
    rig: Rig
    ground: estimate.HullPoseEvidence | None


def adjust(m: Measurements, options: AdjustOptions, report: Report) -> Adjusted:
    """Solve in rounds: each settles outliers and sigmas for the next. Raises StageError when nothing usable comes out."""
    begun, rounds = time.perf_counter(), list[iteration_history.Round]()
    calibrated = m.rig
    state, registered = _start(m, options, report)
    center = registered.center if registered else np.zeros(3)
    weights = weighting.initial_weights(m, options)
    most_px = 40.0  # dead-reckoned poses err by centimetres across legs: some tens of pixels at a metre
    outcome, first, ground = None, None, None
    settle = m.cad_model is not None and not options.as_published and options.rounds > 1
    for k in range(options.rounds):
        last = k == options.rounds - 1
        if last and settle and outcome is not None:
            ground, state = _grounded(m, state, outcome[2], outcome[1], center)
        state = replace(state, landmark=selection.triangulate_landmarks(m, state))
        chosen = _chosen(m, state, most_px, options, last)
        weights = replace(weights, surface=weighting.surface_weights(m, state, chosen, options))
        problem = assemble(m, state, weights, chosen, center, options.as_published, hold_hull_pose=last and settle)
        problem = intrinsics.free_intrinsics(problem, calibrated, options)
        first = first or problem
        began = time.perf_counter() - begun
        result = _solved(problem, options, last)
        rounds.append(_told(len(rounds) + 1, m, result, weights, chosen, began))
        outcome = (problem, result, chosen, weights)
        state = state_from_unknowns(state, result.unknowns, chosen, center)
        m = intrinsics.apply_intrinsics(m, problem, result)
        weights = weighting.estimate_weights(m, state, chosen, weights, options)
        most_px = max(2.0, options.outlier_sigmas * weights.pixel)
        report(_round_in_words(k, result, chosen, weights))
    assert outcome is not None
    assert first is not None
    problem, result, chosen, used = outcome
    done = Adjusted(
        state,
        used,
        chosen,
        center,
        first,
        problem.started_from(result.unknowns),
        result,
        registered,
        tuple(rounds),
        m.rig,
        ground,
    )
    return _without_lost(m, done)


def _start(m: Measurements, options: AdjustOptions, report: Report) -> tuple[State, registration.Registration | None]:
    rig, nodes = m.rig, m.trajectory.poses()
    empty = np.full((selection.landmark_count(m), 3), np.nan)
    state = State(
        nodes=nodes,
        tray=m.trajectory.tray.copy(),
        landmark=empty,
        T_g_M=None,
        T_s_ct=rig.T_s_ct.nominal if rig.T_s_ct and m.tracks is not None else None,
        T_ct_cb=rig.T_ct_cb.nominal if rig.T_ct_cb and m.tracks is not None else None,
        T_s_d=rig.T_s_d.nominal,
        navigation=np.zeros(6),
        grid=None,
        field=np.zeros(0),
    )
    if m.cad_model is None:
        return state, None
    points = _register_points(m, state)
    found = registration.register(points, m.cad_model, rig.sigma_range)
    report(f"registered {len(points)} points to the CAD model, {100 * found.fitness:.0f} % within three sigma")
    grid = None
    if not options.as_published:
        at = m.cad_model.chart.to_chart(found.global_from_hull.inverse().apply(points))[:, :2]
        grid = grid_over(at[np.isfinite(at).all(1)], m.cad_model.deviation_length)
    return replace(state, T_g_M=found.global_from_hull, grid=grid, field=np.zeros(grid.size if grid else 0)), found


def _grounded(
    m: Measurements, state: State, chosen: Selection, result: native.Result, center: Array
) -> tuple[estimate.HullPoseEvidence, State]:
    """What the dive is laid on, and T_g_M there."""
    assert m.cad_model is not None
    assert state.T_g_M is not None
    points = estimate.collect_hull_points(m, state, chosen, result.label)
    ground, best = estimate.fit_hull_pose(points, state.T_g_M, m.cad_model, center)
    return ground, replace(state, T_g_M=estimate.profile_mean_pose(ground, best))


def _register_points(m: Measurements, state: State) -> Array:
    """What is laid onto the CAD model: DVL returns, or stereo landmarks where no ranges were carried, in g."""
    if m.returns is not None and (~m.returns.flagged).sum() >= 30:
        points, _ = return_points(m.returns, state.nodes, state.tray, m.rig.tray_origin, state.T_s_d)
        return points[~m.returns.flagged]
    landmarks = selection.triangulate_landmarks(m, state)
    landmarks = landmarks[np.isfinite(landmarks[:, 0])]
    if len(landmarks) < 30:
        raise StageError(
            "nothing to lay onto the CAD model: fewer than 30 DVL returns and landmarks",
            remedy="check topics.dvl and the cameras, or remove [hull] to run without a CAD model",
        )
    return landmarks


def _chosen(m: Measurements, state: State, most_px: float, options: AdjustOptions, last: bool) -> Selection:
    """Anchors before the last round, then every landmark but isolated ones off the hull."""
    chosen = selection.select_measurements(m, state, most_px)
    if last and m.cad_model is not None and state.T_g_M is not None and not options.as_published:
        deviation = deviation_from_hull(m, state, state.landmark[chosen.landmarks])
        off = np.abs(deviation) > hard_em.label_boundary(options.sigma_on, options.sigma_off)
        chosen = selection.drop_isolated_landmarks(m, state, chosen, off)
    if options.method == "geva" and m.cad_model is not None and state.T_g_M is not None:
        # drawn to the hull, a mismatch near the lens passes through the camera's plane, and the solve stalls there
        far = np.abs(deviation_from_hull(m, state, state.landmark[chosen.landmarks])) > NO_STRUCTURE_M
        chosen = replace(chosen, landmarks=chosen.landmarks[~far])
    if not last:
        chosen = selection.choose_anchors(m, chosen, options.anchors)
    if m.tracks is not None and len(chosen.landmarks) < 20:
        raise StageError(
            f"only {len(chosen.landmarks)} landmarks agree with the navigation",
            remedy="check camera mounts and time offsets, or lower matches' thresholds",
        )
    return chosen


def deviation_from_hull(m: Measurements, state: State, points: Array) -> Array:
    """Signed distance (n,) of points (n, 3) in g to the hull as it is: the CAD model moved by the field."""
    if m.cad_model is None or state.T_g_M is None:
        raise ValueError("a deviation needs a CAD model")
    at = state.T_g_M.inverse().apply(points)
    distance = native.MeshIndex(m.cad_model.mesh.vertices, m.cad_model.mesh.faces).closest(at).distance
    if state.grid is None:
        return np.asarray(distance)
    return np.asarray(distance - state.grid.value(state.field, m.cad_model.chart.to_chart(at)[:, :2]))


def _solved(problem: native.Problem, options: AdjustOptions, last: bool) -> native.Result:
    solve = hard_em.solve if options.labels == "outer" and options.method == "maxmix" else native.solve
    return solve(problem, _native_options(options, last))


def _native_options(options: AdjustOptions, last: bool) -> native.Options:
    return native.Options(
        method=options.method,
        sigma_on=options.sigma_on,
        sigma_off=options.sigma_off,
        max_iterations=options.max_iterations,
        function_tolerance=options.function_tolerance if last else 10 * options.function_tolerance,
        threads=options.threads,
    )


def _without_lost(m: Measurements, done: Adjusted) -> Adjusted:
    """Leaves out landmarks that the last solve pushed behind their cameras or metres off the hull: nothing determines them."""
    sound = selection.select_measurements(m, done.state, most_px=1e3).landmarks
    keep = np.isin(done.chosen.landmarks, sound)
    if keep.all():
        return done
    lost = done.chosen.landmarks[~keep]
    landmark = done.state.landmark.copy()
    landmark[lost] = np.nan
    log.info("%d landmarks were lost in the solve and are left out", len(lost))
    rows = keep[done.problem.surface.landmark]
    return replace(
        done,
        state=replace(done.state, landmark=landmark),
        chosen=replace(done.chosen, landmarks=done.chosen.landmarks[keep]),
        problem=pruning.drop_landmarks(done.problem, keep),
        result=pruning.drop_label_rows(done.result, rows),
    )


def _told(
    number: int, m: Measurements, result: native.Result, weights: Weights, chosen: Selection, began_s: float
) -> iteration_history.Round:
    """The round for the history; its table goes to the log (`--verbose`)."""
    depth, count = weighting.depth_sigma(m, weights), len(chosen.landmarks)
    done = iteration_history.Round(result.iterations, weights, depth, count, result.converged, result.message, began_s)
    for line in iteration_history.lines(number, done):
        log.debug("%s", line)
    return done


def _round_in_words(k: int, result: native.Result, chosen: Selection, weights: Weights) -> str:
    record = result.iterations
    cost = reached(record.cost, record.accepted)
    return (
        f"round {k + 1}: {len(record.cost) - 1} iterations, cost {cost[0]:.6g} to {cost[-1]:.6g}, "
        f"{len(chosen.landmarks)} landmarks, {int((result.label == 1).sum())} on the hull, pixel sigma now {weights.pixel:.2f}"
    )
