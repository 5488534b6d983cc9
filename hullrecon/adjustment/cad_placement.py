# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The CAD model's place: registered to a path that was solved without it, solved, and judged.

Images and navigation determine the path to centimetres over the survey. A CAD model that is
registered to a path that is still bent pulls it into a wrong minimum. So the CAD model comes after
the path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon.adjustment.cad_acceptance import (
    accept_registration,
    accept_round,
    accept_shape,
    add_fitting_unit_and_heading,
    lying_side,
)
from hullrecon.adjustment.exceeded_priors import widen_exceeded_priors
from hullrecon.adjustment.hull_pose import estimate, registration
from hullrecon.adjustment.hull_pose.segments import Segments, find_segments, register_segments
from hullrecon.adjustment.hull_pose.shape_comparison import ShapeComparison, compare_shape
from hullrecon.adjustment.problem import selection
from hullrecon.adjustment.problem.deviation_field import grid_over
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.problem.state import HullState, State
from hullrecon.adjustment.rounds import Estimate, Phase, RoundResult, RoundSolver, Verdict
from hullrecon.errors import StageError
from hullrecon.typing import Array

MIN_POINTS = 30  # least number of points to register


@dataclass(frozen=True, kw_only=True)
class Placement:
    """The CAD model's pose relative to the path, and how well its shape fits the survey."""

    registration: registration.Registration
    segments: Segments | None = None  # of a path that outages cut; None: the path is not cut
    evidence: estimate.HullPoseEvidence | None = None  # points that the hull's pose is fitted to
    shape: ShapeComparison | None = None  # the shape of these points, compared with the CAD model's
    # rad, by which the tray's angles may be off instead, where it lies far from its guess
    tray_offset: float | None = None


def place_cad_model(path: Phase, cad_model: CadModel, solver: RoundSolver) -> Phase:
    """Register the CAD model to a path, solve a round with it, and judge it.

    The hull's pose in the resulting estimate is the mean of the profile likelihood along the hull.
    With `adjust.rounds = 1` no round is solved here, and only the registration is judged.
    """
    segments = None if path.last is None else segments_of_path(path.last, solver)
    placed = register(path.estimate, cad_model, solver, segments)
    if not placed.verdict.accepted:
        return placed
    if nothing_on_cad_model(path.estimate.measured, solver):
        reason = "the method naive puts no landmark on it, and there is no range of a DVL"
        return replace(placed, verdict=Verdict(accepted=False, reason=reason))
    rounds = solver.coarse_rounds(placed.estimate, min(1, solver.options.rounds - 1))
    if not rounds:
        return placed
    # Ranges and CAD model may contradict a prior on which the path alone has too little
    # information.
    widened, conflict = widen_exceeded_priors(Phase.of(rounds, rounds[-1].after), solver), None
    if widened is not None and widened.last is not None:
        rounds, conflict = (*rounds, widened.last), widened.verdict.length_conflict
    verdict = accept_round(rounds[-1], solver)
    if not verdict.accepted:
        return Phase.of(rounds, placed.estimate, verdict, placed.placement)
    verdict = replace(verdict, length_conflict=conflict)
    placed = Phase.of(rounds, placed.estimate, verdict, placed.placement)
    return estimate_hull_pose(rounds[-1], placed, solver)


def register(
    solved: Estimate, cad_model: CadModel, solver: RoundSolver, segments: Segments | None = None
) -> Phase:
    """Register the CAD model to a solved path, and judge the registration.

    A phase is returned for a refused registration too, and its verdict says why.

    Parameters
    ----------
    solved
        The path, solved without the CAD model.
    cad_model
        The mesh, and the package's guess of its pose, around which starts are tried.
    solver
        Reports the result.
    segments
        Segments into which outages cut the path. None: the path is not cut.

    Raises
    ------
    StageError
        Where there is nothing to register.
    """
    measured, state = solved.measured, solved.state
    if segments is None:
        points = _points_to_register(measured, state)
        found = registration.register(points, cad_model, measured.rig.priors.range_sigma_m)
    else:
        found, state = _register_segments(solved, cad_model, segments)
        points = _points_to_register(measured, state)
    fitting = f"{100 * found.fitness:.0f} %"
    solver.report(f"registered {len(points)} points to the CAD model, {fitting} within three sigma")
    hull = _hull_state(found, points, solver.strategy.deviation_field)
    state = replace(state, hull=replace(hull, segments=segments))
    # A model that lies on its side is refused, however well it fits
    on_its_side = lying_side(cad_model)
    if on_its_side is not None:
        verdict = Verdict(accepted=False, reason=on_its_side.sentence)
    else:
        verdict = add_fitting_unit_and_heading(
            accept_registration(found, segments),
            found,
            points if segments is None else None,
            measured.rig.priors.range_sigma_m,
        )
    return Phase.of(
        rounds=(),
        estimate=replace(solved, state=state),
        verdict=verdict,
        placement=Placement(registration=found, segments=segments),
    )


def segments_of_path(solved: RoundResult, solver: RoundSolver) -> Segments | None:
    """Find the segments into which outages cut a path that was solved without the CAD model.

    None where the path is not cut, where there are no DVL ranges, or without a deviation field.
    """
    measured = solved.after.measured
    if measured.returns is None or not solver.strategy.deviation_field:
        return None
    node = measured.returns.node[~measured.returns.flagged]  # of each range
    return find_segments(solved.problem, solver.settings, measured.odometry, node)


def _register_segments(
    solved: Estimate, cad_model: CadModel, segments: Segments
) -> tuple[registration.Registration, State]:
    """Register the CAD model to the longest segment, and move the other segments onto the model.

    The fitness of the returned registration is the share of the points of all segments that fit
    after the move. The returned state holds the moved path.
    """
    measured, state = solved.measured, solved.state
    assert measured.returns is not None
    sigma_m, node = measured.rig.priors.range_sigma_m, measured.returns.node
    points = _returns_in_global(measured, state)
    moved = register_segments(
        segments, state.nodes, points, node[~measured.returns.flagged], cad_model, sigma_m
    )
    found, state = moved.registration, replace(state, nodes=moved.nodes)
    points = _returns_in_global(measured, state)
    return replace(found, fitness=registration.share_within(points, found, sigma_m)), state


def nothing_on_cad_model(measured: Measurements, solver: RoundSolver) -> bool:
    """Tell whether no measurement would have a residual from the CAD model.

    The method "naive" has no surface factors, so that only DVL ranges would.
    """
    ranges = 0 if measured.returns is None else int((~measured.returns.flagged).sum())
    return solver.strategy.method == "naive" and not ranges


def _hull_state(
    found: registration.Registration, points: Array, deviation_field: bool
) -> HullState:
    """Make the hull's start values: the registered pose, and a deviation field of zeros.

    Parameters
    ----------
    found
        The registration, which gives CAD model, pose and the survey's middle.
    points
        (n, 3) m in g, on the hull, which the field's grid covers.
    deviation_field
        Make a field. Otherwise the hull is the CAD model exactly.
    """
    hull = HullState(
        cad_model=found.cad_model,
        global_from_hull=found.global_from_hull,
        survey_center=found.center,
        grid=None,
        field=np.zeros(0),
    )
    if not deviation_field:
        return hull
    at = hull.to_chart(points)
    grid = grid_over(at[np.isfinite(at).all(1)], found.cad_model.deviation_length)
    return replace(hull, grid=grid, field=np.zeros(grid.size))


def _points_to_register(measured: Measurements, state: State) -> Array:
    """Collect points on the hull (n, 3) m in g: DVL returns, or landmarks where they are few.

    Raises StageError where there are fewer than MIN_POINTS of either.
    """
    if measured.returns is not None and (~measured.returns.flagged).sum() >= MIN_POINTS:
        return _returns_in_global(measured, state)
    if measured.returns is None and measured.tracks is None:
        raise StageError(
            "nothing measures the hull: there is no DVL range and no image",
            remedy="`hullrecon run --to navigate` gives the path alone",
        )
    landmarks = selection.triangulate_landmarks(measured, state)
    landmarks = landmarks[np.isfinite(landmarks[:, 0])]
    if len(landmarks) < MIN_POINTS:
        raise StageError(
            f"nothing to register to the CAD model: fewer than {MIN_POINTS} DVL returns and "
            "landmarks",
            remedy="without [hull] in dive.toml a run goes on without a CAD model",
        )
    return landmarks


def _returns_in_global(measured: Measurements, state: State) -> Array:
    """Compute the ends (n, 3) m in g of the DVL's beams, without flagged returns."""
    assert measured.returns is not None
    ends = state.mounted(measured.rig).dvl_points(measured.returns, state.path)
    return ends.points[~measured.returns.flagged]


def estimate_hull_pose(last: RoundResult, placed: Phase, solver: RoundSolver) -> Phase:
    """Estimate the hull's pose and judge its shape by the points that lie on it.

    Where the hull deviates from the CAD model by more than the package states, the stated error is
    widened to what the points show.

    Parameters
    ----------
    last
        The last round with the CAD model, whose landmarks have labels.
    placed
        The phase of the CAD model so far. Its verdict, placement and estimate are replaced.
    solver
        Its strategy says whether there is a deviation field. Without one nothing is estimated.
    """
    ready, placement = last.after, placed.placement
    hull = ready.state.hull
    if hull is None or placement is None or not solver.strategy.deviation_field:
        return replace(placed, estimate=ready)
    points = estimate.collect_hull_points(
        ready.measured, ready.state, last.chosen, last.result.label
    )
    evidence, best = estimate.fit_hull_pose(
        points, hull.global_from_hull, hull.cad_model, hull.survey_center
    )
    shape = compare_shape(evidence, best)
    if shape.needs_wider_sigma:
        sigma = hull.cad_model.deviation_sigma * float(np.sqrt(shape.deviation))
        wider = replace(hull.cad_model, deviation_sigma=sigma, contradicted=True)
        hull = replace(hull, cad_model=wider)
        evidence, best = estimate.fit_hull_pose(points, best, wider, hull.survey_center)
    hull = replace(hull, global_from_hull=estimate.profile_mean_pose(evidence, best))
    return replace(
        placed,
        estimate=replace(ready, state=replace(ready.state, hull=hull)),
        verdict=replace(
            accept_shape(shape, placement.registration.sigmas_off),
            length_conflict=placed.verdict.length_conflict,
        ),
        placement=replace(placement, evidence=evidence, shape=shape),
    )
