# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Model-assisted bundle adjustment of a dive [Ozog2016 4.2] (docs/methods.md 6), from a first path
to the adjusted dive.

First a path, from images and navigation; then a place, where the CAD model lies under that path;
then labels and ranges, solved with the rest. A stage that explains the data of the one before worse
is refused, and what the one before found is delivered.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.exceeded_priors import widen_exceeded_priors
from hullrecon.adjustment.hull_pose import estimate, registration
from hullrecon.adjustment.hull_pose.form import Form
from hullrecon.adjustment.hull_pose.stretches import Stretches
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.placement import (
    LaidModel,
    RegisteredModel,
    estimate_hull_pose,
    form_against,
    nothing_on_it,
    reason_against,
    register_cad_model,
    stretches_of_path,
)
from hullrecon.adjustment.problem import iteration_history, pruning, selection, weighting
from hullrecon.adjustment.problem.assembly import Selection
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.problem.state import State, Weights
from hullrecon.adjustment.rounds import Estimate, Report, RoundResult, RoundSolver
from hullrecon.adjustment.stereo_calibration import StereoContradiction, free_contradicted_rig
from hullrecon.rig import Rig

# dead-reckoned poses err by centimetres across legs: some tens of pixels at a metre
FIRST_MAX_PX = 40.0
log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Adjusted:
    """The adjusted dive. start: the first round's problem as it began; problem and result: of the
    last round, at its solution; rig: with the intrinsics found; evidence: what the hull pose was
    fitted to, form: whether that has the CAD model's form (None where no round held it); stretches:
    into which outages cut the path, each laid onto the CAD model for itself; refusal: why the CAD
    model was left out, None where it was not (or there is none); stereo and length_conflict: as of
    FirstPath.
    """

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
    form: Form | None
    refusal: str | None
    stretches: Stretches | None = None
    stereo: StereoContradiction | None = None
    length_conflict: float | None = None


@dataclass(frozen=True, kw_only=True)
class FirstPath:
    """The path from images and navigation: its rounds, the estimate after them, the solver that
    goes on. stereo: what contradicts the stereo rig's calibration; length_conflict: share by which
    the DVL's velocities contradict all else about lengths, where one camera cannot tell. Both None
    where nothing does.
    """

    solver: RoundSolver
    rounds: tuple[RoundResult, ...]
    straight: Estimate
    stereo: StereoContradiction | None = None
    length_conflict: float | None = None


@dataclass(frozen=True, kw_only=True)
class CheckedModel:
    """The CAD model laid under a path, the rounds solved with it, where their points lie on it
    (None after no round), and why it is refused (None where it is not).
    """

    registered: RegisteredModel
    rounds: tuple[RoundResult, ...]
    laid: LaidModel | None
    refusal: str | None


def adjust(measured: Measurements, options: AdjustOptions, report: Report) -> Adjusted:
    """Return the dive adjusted in rounds, each with the outliers and sigmas that the one before
    found.

    Raises StageError when too little agrees to be adjusted.
    """
    path = find_path(measured, options, report)
    adjusted = _adjust_from(path, measured.cad_model, options, report)
    return replace(adjusted, stereo=path.stereo, length_conflict=path.length_conflict)


def _adjust_from(
    path: FirstPath, cad_model: CadModel | None, options: AdjustOptions, report: Report
) -> Adjusted:
    if cad_model is None:
        return adjust_without_cad_model(path)
    checked = check_cad_model(path, cad_model, options, report)
    if checked.refusal is not None:
        report(f"the CAD model is left out: {checked.refusal}")
        without = adjust_without_cad_model(path, checked.rounds)
        form = None if checked.laid is None else checked.laid.form
        return replace(
            without,
            registration=checked.registered.registration,
            form=form,
            refusal=checked.refusal,
        )
    return adjust_with_cad_model(path, checked)


def find_path(measured: Measurements, options: AdjustOptions, report: Report) -> FirstPath:
    """Return the path without the CAD model: some well-seen landmarks find poses, outliers and
    sigmas at a fraction of the cost.
    """
    solver = RoundSolver(calibrated=measured.rig, options=options, report=report)
    start = _start(measured, options)
    with_cad = measured.cad_model is not None
    rounds = solver.coarse_rounds(start, max(options.rounds - 1, int(with_cad)))
    straight = rounds[-1].after if rounds else start
    if not rounds or options.as_published:
        return FirstPath(solver=solver, rounds=tuple(rounds), straight=straight)
    freed = free_contradicted_rig(straight, solver)
    if freed is not None:
        rounds, straight = [*rounds, freed.round], freed.estimate
    widened = widen_exceeded_priors(rounds[-1], straight, solver)
    if widened is not None:
        rounds, straight = [*rounds, widened.round], widened.round.after
    return FirstPath(
        solver=solver,
        rounds=tuple(rounds),
        straight=straight,
        stereo=None if freed is None else freed.contradiction,
        length_conflict=None if widened is None else widened.length_conflict,
    )


def check_cad_model(
    path: FirstPath, cad_model: CadModel, options: AdjustOptions, report: Report
) -> CheckedModel:
    """Return the CAD model laid under that path, and whether what follows from it may be believed."""
    stretches = stretches_of_path(path.rounds[-1], options) if path.rounds else None
    registered = register_cad_model(path.straight, cad_model, options, report, stretches)
    refusal = registered.refusal or nothing_on_it(path.straight.measured, options)
    rounds = (
        []
        if refusal
        else path.solver.coarse_rounds(registered.estimate, min(1, options.rounds - 1))
    )
    refusal = refusal or (reason_against(rounds[-1], options) if rounds else None)
    laid = None if refusal or not rounds else estimate_hull_pose(rounds[-1], options)
    if laid is not None and laid.form is not None:
        refusal = form_against(laid.form, registered.registration.sigmas_off)
    return CheckedModel(registered=registered, rounds=tuple(rounds), laid=laid, refusal=refusal)


def adjust_with_cad_model(path: FirstPath, checked: CheckedModel) -> Adjusted:
    """Return the dive with labels: the hull pose at the mean of its profile, every landmark, all
    solved with it held.
    """
    laid = checked.laid or LaidModel(ready=checked.registered.estimate)
    last = path.solver.solve_round(laid.ready, final=True, hold_hull_pose=laid.evidence is not None)
    adjusted = _drop_lost_landmarks([*path.rounds, *checked.rounds, last])
    registered = checked.registered
    return replace(
        adjusted,
        registration=registered.registration,
        stretches=registered.stretches,
        evidence=laid.evidence,
        form=laid.form,
    )


def adjust_without_cad_model(path: FirstPath, refused: tuple[RoundResult, ...] = ()) -> Adjusted:
    """Return the path solved with all landmarks; refused: rounds with a CAD model that is left out,
    for the history.
    """
    return _drop_lost_landmarks(
        [*path.rounds, *refused, path.solver.solve_round(path.straight, final=True)]
    )


def _start(measured: Measurements, options: AdjustOptions) -> Estimate:
    """Return the first path, dead reckoning where no other was found, without the CAD model."""
    rig, seen = measured.rig, measured.tracks is not None
    path = measured.start or measured.trajectory.track().path
    state = State(
        nodes=path.poses,
        tray=path.tray.copy(),
        landmark=np.full((selection.landmark_count(measured), 3), np.nan),
        mounts=rig.mounts
        if seen
        else replace(rig.mounts, tray_from_top=None, top_from_bottom=None),
        navigation=np.zeros(6),
        hull=None,
    )
    return Estimate(
        measured=measured,
        state=state,
        weights=weighting.initial_weights(measured, options),
        max_px=FIRST_MAX_PX,
    )


def _drop_lost_landmarks(rounds: list[RoundResult]) -> Adjusted:
    """Return the adjusted dive without landmarks that the last solve pushed behind their cameras or
    metres off the hull: nothing determines them.
    """
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
        registration=None,
        rounds=tuple(r.history for r in rounds),
        rig=last.after.measured.rig,
        evidence=None,
        form=None,
        refusal=None,
    )
