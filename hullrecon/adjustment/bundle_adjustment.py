# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Model-assisted bundle adjustment of a dive [Ozog2016 4.2] (docs/methods.md 6).

First a path from images and navigation, then the pose of the CAD model relative to that path, then
labels and ranges solved with the rest. A phase that explains the previous phase's measurements
worse is refused, and the previous phase's result is delivered.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.cad_acceptance import lying_side, sunk
from hullrecon.adjustment.cad_placement import Placement, place_cad_model
from hullrecon.adjustment.contradictions import (
    accept_corrections,
    believe_place,
    doubt_tray,
    explain_refusal,
    is_ill_timed,
)
from hullrecon.adjustment.exceeded_priors import contradicts_priors, widen_exceeded_priors
from hullrecon.adjustment.options import PRODUCT, AdjustOptions, Strategy
from hullrecon.adjustment.partition.plan import Plan
from hullrecon.adjustment.problem import iteration_history, selection, weighting
from hullrecon.adjustment.problem.assembly import Selection
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.observations import landmark_count
from hullrecon.adjustment.problem.state import State, Weights
from hullrecon.adjustment.rounds import (
    Estimate,
    Keep,
    Phase,
    Report,
    RoundResult,
    RoundSolver,
    Verdict,
    make_anew,
)
from hullrecon.adjustment.stereo_calibration import free_contradicted_rig
from hullrecon.rig import Rig
from hullrecon.typing import Array

# Outlier limit of the first round: dead-reckoned poses err by centimetres across legs, which is
# some tens of pixels at a metre
FIRST_MAX_PX = 40.0
# Reprojection error beyond which a landmark of the last solve is lost. One behind its cameras has
# no reprojection error, and is lost as well.
LOST_PX = 1e3
log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Adjusted:
    """The adjusted dive."""

    state: State
    weights: Weights
    chosen: Selection  # the measurements of the last round
    plan: Plan  # how the last round was divided into parts
    start: native.Problem  # the first round's problem, at its start values
    problem: native.Problem  # the last round's problem, at its solution
    result: native.Result  # of the last round
    rounds: tuple[iteration_history.Round, ...]  # the solver's record of each round
    rig: Rig  # with the intrinsics that were estimated, and the priors that were widened
    lenses: Array  # (2, 2 LENS_MODES) px, estimated displacements of the top and bottom lens
    verdict: Verdict  # on the CAD model, and what of the dive package was contradicted
    placement: Placement | None  # of the CAD model; None without one
    strategy: Strategy
    settings: native.Options  # of the solves


def adjust(
    measured: Measurements,
    options: AdjustOptions,
    report: Report,
    strategy: Strategy = PRODUCT,
    keep: Keep = make_anew,
) -> Adjusted:
    """Adjust images, ranges, navigation and the CAD model of a dive together.

    Parameters
    ----------
    measured
        Measurements, rig and CAD model of the dive.
    options
        The section [adjust] of dive.toml.
    report
        Called with one line of text after each round and decision.
    strategy
        What is solved for. The sources' variants are in hullrecon/studies.
    keep
        Returns the phases that an interrupted run has finished, and keeps new ones.

    Raises
    ------
    StageError
        When too little agrees to be adjusted.
    ContradictionError
        When measurements contradict each other by more than a correction may take out.
    """
    solver = RoundSolver(
        calibrated=measured.rig, options=options, strategy=strategy, report=report, keep=keep
    )
    # `once` solves a phase, or returns what an interrupted run has kept of it.
    settled = solver.once(lambda: solve_path_and_place(measured, solver), "path and place")

    # Then labels and ranges: all landmarks, with the CAD model if it is accepted.
    return solve_all_landmarks(settled, solver)


def solve_path_and_place(measured: Measurements, solver: RoundSolver) -> Phase:
    """Solve the path, then register the CAD model to it and judge it. Raises as `adjust`.

    A CAD model that is refused raises nothing: the path goes on alone, and the verdict says why.
    """
    # First the path, from images and navigation.
    path = solver.once(lambda: solve_path(measured, solver), "path")

    # Then the place: the CAD model registered to that path, and judged.
    placed = None
    if measured.cad_model is not None:
        placed = place_cad_model(path, measured.cad_model, solver)
        if not placed.verdict.accepted:
            # A model that lies on its side, or under water, is wrong whatever the sensors say.
            drowned = sunk(measured.cad_model) if measured.returns is not None else None
            if lying_side(measured.cad_model) is None and drowned is None:
                placed = explain_refusal(path, placed, solver)
            elif drowned is not None:
                reason = f"{placed.verdict.reason}; {drowned.sentence}"
                placed = replace(placed, verdict=replace(placed.verdict, reason=reason))
            solver.report(f"the CAD model is left out: {placed.verdict.reason}")
        else:
            believe_place(path, placed, measured.rig, solver)
            placed = doubt_tray(path, placed)
    return join_path_and_place(path, placed)


def solve_path(measured: Measurements, solver: RoundSolver) -> Phase:
    """Solve the path without the CAD model, and widen the package's priors that it contradicts.

    The phase has no rounds, and its estimate is the start, with `adjust.rounds = 1` and no CAD
    model. Raises ContradictionError where corrections cannot be believed (`accept_corrections`).
    """
    # Some well-seen landmarks find poses, outliers and sigmas at a fraction of the cost.
    start = _start(measured, solver.strategy)
    with_cad = measured.cad_model is not None
    rounds = solver.coarse_rounds(start, max(solver.options.rounds - 1, int(with_cad)))
    path = Phase.of(rounds, rounds[-1].after if rounds else start)
    if not rounds or not solver.strategy.systematic_errors:
        return path

    # A contradicted stereo calibration becomes an unknown.
    corrected = path.then(free_contradicted_rig(path, solver))

    # Contradicted priors of navigation and mounts are widened.
    corrected = corrected.then(widen_exceeded_priors(corrected, solver))

    # Corrections stop at what is believable, and where a faulty sensor explains more. A path that
    # nothing corrected (`then` returned it unchanged) and nothing contradicts is taken as it is.
    if corrected is path and not contradicts_priors(path) and not is_ill_timed(path, solver):
        return path
    return accept_corrections(path, corrected, solver)


def join_path_and_place(path: Phase, placed: Phase | None) -> Phase:
    """Join the phases of path and CAD model, and drop their rounds, which hold much memory.

    Where the CAD model is refused, the last round starts from the path alone.

    Parameters
    ----------
    path
        The path, solved without the CAD model.
    placed
        The phase that registered the CAD model and judged it. None without a CAD model.
    """
    joined = path.then(placed)
    refused = placed is not None and not placed.verdict.accepted
    return replace(
        joined, estimate=path.estimate if refused else joined.estimate, first=None, last=None
    )


def solve_all_landmarks(settled: Phase, solver: RoundSolver) -> Adjusted:
    """Solve the last round, with all landmarks.

    With an accepted CAD model each landmark has a label, on the model's surface or off it, and the
    hull's pose is held where it was estimated. Otherwise the path is solved without the CAD model.

    settled: path and place, as of `join_path_and_place`, from whose estimate the round starts.
    """
    placement = settled.placement
    estimated = placement is not None and placement.evidence is not None
    last = solver.solve_round(
        settled.estimate, final=True, hold_hull_pose=estimated and settled.verdict.accepted
    )
    return _adjusted(settled, last, solver)


def _start(measured: Measurements, strategy: Strategy) -> Estimate:
    """Make the start values: the pose graph's path, or dead reckoning where there is none.

    Landmarks are not triangulated yet (NaN), and the start has no CAD model.
    """
    path = measured.start or measured.trajectory.track().path
    mounts = measured.rig.mounts
    if measured.tracks is None:  # no image was matched, so nothing determines the cameras' mounts
        mounts = replace(mounts, tray_from_top=None, top_from_bottom=None)
    return Estimate(
        measured=measured,
        state=State(
            nodes=path.poses,
            tray=path.tray.copy(),
            landmark=np.full((landmark_count(measured), 3), np.nan),
            mounts=mounts,
            navigation=np.zeros(6),  # errors of DVL, attitude, depth and servo: none known yet
            hull=None,
        ),
        weights=weighting.initial_weights(measured, strategy),
        max_px=FIRST_MAX_PX,  # residuals of the first round may be that large
    )


def _adjusted(settled: Phase, last: RoundResult, solver: RoundSolver) -> Adjusted:
    """Collect the adjusted dive, without the landmarks that the last solve lost.

    A lost landmark was pushed behind its cameras or metres off the hull, where no measurement
    determines it. One of them is enough for the covariances not to exist.
    """
    state, chosen, problem, result = last.after.state, last.chosen, last.problem, last.result
    sound = selection.select_measurements(last.after.measured, state, LOST_PX).landmarks
    keep = np.isin(chosen.landmarks, sound)
    if not keep.all():
        lost = chosen.landmarks[~keep]
        landmark = state.landmark.copy()
        landmark[lost] = np.nan
        log.info("%d landmarks were lost in the solve and are left out", len(lost))
        state = replace(state, landmark=landmark)
        chosen = replace(chosen, landmarks=chosen.landmarks[keep])
        result = selection.drop_label_rows(result, keep[problem.surface.landmark])
        problem = selection.drop_landmarks(problem, keep)
    return Adjusted(
        state=state,
        weights=last.weights,
        chosen=chosen,
        plan=last.plan,
        start=settled.start or last.start,
        problem=problem,
        result=result,
        rounds=(*settled.history, last.history),
        rig=last.after.measured.rig,
        lenses=last.after.measured.lenses,
        verdict=settled.verdict,
        placement=settled.placement,
        strategy=solver.strategy,
        settings=solver.settings,
    )
