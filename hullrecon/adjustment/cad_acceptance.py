# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The CAD model registered to a path that was solved without it, and whether it is accepted.

Images and navigation determine the path to centimetres over the survey. A CAD model that is
registered to a path that is still bent pulls it into a wrong minimum. So the CAD model comes after
the path. It is accepted only if the measurements that the path explained without it are explained
as well with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.hull_pose import estimate, registration
from hullrecon.adjustment.hull_pose.beam_gap import gap_beyond_beams
from hullrecon.adjustment.hull_pose.other_headings import (
    describe_height,
    describe_turn,
    find_fitting_heading,
    height_below_guess,
    stated_model,
    turn_from_guess,
)
from hullrecon.adjustment.hull_pose.other_units import find_fitting_unit
from hullrecon.adjustment.hull_pose.segments import Segments, find_segments, register_segments
from hullrecon.adjustment.hull_pose.shape_comparison import ShapeComparison, compare_shape
from hullrecon.adjustment.problem import selection
from hullrecon.adjustment.problem.deviation_field import grid_over
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.problem.state import HullState, State
from hullrecon.adjustment.rounds import (
    ACCEPTED,
    Estimate,
    Phase,
    RoundResult,
    RoundSolver,
    Verdict,
)
from hullrecon.dive.hull.afloat import find_sunk
from hullrecon.dive.hull.symmetry import find_lying_side
from hullrecon.errors import StageError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.meshes.units import UNIT_NAMES
from hullrecon.typing import Array

MIN_POINTS = 30  # least number of points to register
MAX_SIGMAS_OFF = 8.0  # largest distance from the package's guess of the hull pose, in its sigmas
MAX_MISSED = 0.2  # share of the beams that miss the CAD model
MIN_ON_HULL = 0.2  # share of the landmarks on its surface
# With the CAD model, the RMS of a group's whitened residuals may be at most so many times the RMS
# without it. Growth that follows from fewer unknowns is taken off before (`residual_growth`).
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
# An explanation of a refusal is named too if the points that fit with it are at least this share of
# those that fit with the best explanation
AS_WELL = 0.9
# Possible causes, where the CAD model fits with no explanation that is tried. The tray's angles are
# a part of the path, logged or taken to be constant.
ANYBODY = (
    ": the model, its unit, hull.pose, the path, the tray's angles or the ranges from it are wrong"
)
FREE_ITERATIONS = 15  # of the solve without the CAD model, which starts close to its solution


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
    placed = Phase.of(rounds, placed.estimate, accept(rounds[-1], solver), placed.placement)
    return estimate_hull_pose(rounds[-1], placed, solver) if placed.verdict.accepted else placed


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
        verdict = _add_fitting_unit_and_heading(
            _accept_registration(found, segments),
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


def sunk(cad_model: CadModel) -> Finding | None:
    """Say how deep a ship lies under water at the package's guess. None where it floats."""
    axes, sigma_m = cad_model.chart.ship_axes, cad_model.guess_sigma[:3]
    return find_sunk(cad_model.mesh, axes, cad_model.guess, sigma_m)


def lying_side(cad_model: CadModel) -> Finding | None:
    """Say which side a CAD model lies on at the package's guess. None where it is upright."""
    return find_lying_side(cad_model.mesh, cad_model.chart.ship_axes, cad_model.guess)


def _accept_registration(found: registration.Registration, segments: Segments | None) -> Verdict:
    """Accept a registration that most points fit, within MAX_SIGMAS_OFF sigmas of the guess.

    A refusal says how far off it is: turned, higher or lower, or in sigmas where it is neither.

    Parameters
    ----------
    found
        The registration, whose fitness and distance from the guess are judged.
    segments
        Segments into which outages cut the path, which a refusal mentions. None: it is not cut.
    """
    if found.fitness < registration.GOOD_FITNESS:
        what = "it is placed"
        if segments is not None:
            what = f"it and the {len(segments)} segments that outages leave of the path are placed"
        return Verdict(
            accepted=False,
            reason=f"only {100 * found.fitness:.0f} % of the surveyed points lie within three "
            f"sigma of it, wherever {what}{ANYBODY}",
        )
    if found.sigmas_off > MAX_SIGMAS_OFF:
        turn = turn_from_guess(found)
        lower_m = height_below_guess(found)
        reason = (
            f"it fits only {found.sigmas_off:.0f} times farther from hull.pose than "
            "hull.pose_sigma says"
        )
        if turn is not None:
            reason = describe_turn(turn)
        elif lower_m is not None:
            reason = describe_height(lower_m)
        return Verdict(accepted=False, reason=reason)
    return ACCEPTED


def _add_fitting_unit_and_heading(
    verdict: Verdict,
    found: registration.Registration,
    points: Array | None,
    range_sigma_m: float,
) -> Verdict:
    """Add to a refusal in which other unit, or at which heading, the CAD model would fit.

    Parameters
    ----------
    verdict
        On the registration. Returned unchanged where it is accepted.
    found
        The registration that the verdict is on, with the CAD model and its guess.
    points
        (n, 3) m in g, on the hull. None: nothing is tried, as for a path that outages cut.
    range_sigma_m
        Sigma of a DVL range.
    """
    if verdict.accepted or points is None:
        return verdict
    fitting: list[tuple[float, str]] = []
    stated = stated_model(found)
    in_unit = find_fitting_unit(points, stated, range_sigma_m)
    if in_unit is not None:
        unit, read = in_unit
        words = (
            f"read in {UNIT_NAMES[unit]} it fits {100 * read.fitness:.0f} % of the points where "
            f'hull.pose says (hull.units = "{unit}")'
        )
        fitting.append((read.fitness, words))
    turned = None
    if turn_from_guess(found) is None:  # otherwise the reason names the turn already
        turned = find_fitting_heading(points, stated, range_sigma_m)
    if turned is not None:
        fitting.append((turned[1], describe_turn(turned[0])))
    if not fitting:
        return verdict
    enough = AS_WELL * max(fitness for fitness, _ in fitting)
    named = [words for fitness, words in fitting if fitness >= enough]
    return replace(verdict, reason="; ".join([str(verdict.reason).removesuffix(ANYBODY), *named]))


def segments_of_path(solved: RoundResult, solver: RoundSolver) -> Segments | None:
    """Find the segments into which outages cut a path that was solved without the CAD model.

    None where the path is not cut, or where there are no DVL ranges.
    """
    measured = solved.after.measured
    if measured.returns is None or not solver.strategy.deviation_field:
        return None
    node = measured.returns.node[~measured.returns.flagged]
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


def accept(found: RoundResult, solver: RoundSolver) -> Verdict:
    """Judge a round that was solved with the CAD model.

    The CAD model is refused where beams or landmarks miss it, or where images and navigation are
    explained worse with it than without it.
    """
    reason = next(_reasons_to_refuse(found, solver), None)
    return ACCEPTED if reason is None else Verdict(accepted=False, reason=reason)


def _reasons_to_refuse(found: RoundResult, solver: RoundSolver) -> Iterator[str]:
    """Yield the reasons to refuse the CAD model after a round with it, most important first.

    The DVL's beams miss it, few landmarks lie on it, or residuals of images and navigation grow.
    The caller takes the first reason alone, and what comes after it is not computed.
    """
    ray_hit, label, settings = found.result.ray_hit, found.result.label, solver.settings
    missed = float(np.mean(~ray_hit)) if len(ray_hit) else 0.0
    if missed > MAX_MISSED:
        yield f"{100 * missed:.0f} % of the DVL's beams miss it"
    on_hull = float(np.mean(label == 1)) if len(label) else 1.0
    if settings.method == "maxmix" and on_hull < MIN_ON_HULL:
        because = _describe_contradicting_ranges(found.after)
        yield f"only {100 * on_hull:.0f} % of the landmarks lie on its surface{because}"
    if not len(found.problem.stereo.node) + len(found.problem.mono.node):
        # Without images the path follows navigation exactly. Its residuals are about zero, and grow
        # with any CAD model.
        return
    growth = residual_growth(found.problem, settings)
    worse = [name for name, ratio in growth.items() if ratio > MAX_GROWTH[name]]
    if "attitude" in worse and stated_attitude_rms(found, settings) <= 1:
        worse.remove("attitude")
    if worse:
        parts = ", ".join(f"{name} by {100 * (growth[name] - 1):.0f} %" for name in worse)
        yield f"with it, the residuals grow: {parts}"


def _describe_contradicting_ranges(solved: Estimate) -> str:
    """Describe how the DVL's ranges end before or behind the landmarks. Empty where they agree.

    The registration rests on the ranges. So where they are wrong, landmarks are off the CAD model
    though it is right.
    """
    measured, state = solved.measured, solved.state
    if measured.returns is None:
        return ""
    fair = ~measured.returns.flagged
    beams = state.mounted(measured.rig).dvl_points(measured.returns, state.path)
    landmarks = state.landmark[np.isfinite(state.landmark).all(axis=1)]
    gap = gap_beyond_beams(
        beams.points[fair], beams.directions[fair], measured.returns.range_m[fair], landmarks
    )
    if gap is None:
        return ""
    gap_m, share = gap
    return (
        f", for the DVL's ranges, which place it, end {abs(gap_m):.2f} m (a range's "
        f"{100 * abs(share):.0f} %) {'before' if gap_m > 0 else 'behind'} the landmarks that the "
        "cameras see there: these ranges, dvl.mount or camera.top.mount is wrong, not the model"
    )


def stated_attitude_rms(found: RoundResult, settings: native.Options) -> float:
    """Compute the RMS residual of depth, roll, pitch and tray in the sigmas that dive.toml states.

    The sigma of the tray's angle that the solve estimated is not used here. With one camera the
    solve hardly separates the tray's angle from the pitch, and follows the noise of both. The
    estimated sigma is then too small, and even a right CAD model seems to make the residuals grow.
    """
    stated = found.after.measured.rig.priors.tray_sigma_rad / found.weights.tray
    tray = replace(found.problem.tray, sigma=found.problem.tray.sigma * stated)
    cost = native.evaluate(
        replace(found.problem, tray=tray), replace(settings, method="naive"), jacobian=False
    ).cost_by_factor
    # The cost is half the chi-square. Attitude has rows of depth, roll and pitch
    rows = len(tray.node) + 3 * len(found.problem.attitude.node)
    return float(np.sqrt(2 * (cost["attitude"] + cost["tray"]) / max(rows, 1)))


def residual_growth(problem: native.Problem, settings: native.Options) -> dict[str, float]:
    """Divide the RMS of each group's whitened residuals with the CAD model by that without it.

    Unknowns that the CAD model determines no longer follow the noise of navigation, so that its
    residuals grow even with a right CAD model. Where a ratio is beyond MAX_GROWTH, the chi-square
    without the CAD model is therefore increased by what such unknowns absorbed.

    Parameters
    ----------
    problem
        The round with the CAD model, at its solution.
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
    free = native.solve(without, replace(naive, max_iterations=FREE_ITERATIONS))
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
            native.covariance(without_cad, naive, of_landmarks=False),
            native.covariance(problem, settings, of_landmarks=False),
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
        verdict=accept_shape(shape, placement.registration.sigmas_off),
        placement=replace(placement, evidence=evidence, shape=shape),
    )


def accept_shape(shape: ShapeComparison, sigmas_off: float) -> Verdict:
    """Judge by its shape whether the surveyed hull is that of the CAD model.

    Parameters
    ----------
    shape
        The surveyed shape, compared with the CAD model's.
    sigmas_off
        How far the hull was found from the package's guess of its pose, in the guess's sigmas.
    """
    reason = next(_reasons_against_shape(shape, sigmas_off), None)
    return ACCEPTED if reason is None else Verdict(accepted=False, reason=reason)


def _reasons_against_shape(shape: ShapeComparison, sigmas_off: float) -> Iterator[str]:
    """Yield reasons why the surveyed hull is not that of the CAD model, most important first.

    The caller takes the first alone. A hull that was found far from the package's guess has to
    pass more: its shape must confirm the CAD model, and deviate by no more than stated. Parameters
    are those of `accept_shape`.
    """
    times = f"{np.sqrt(shape.deviation):.1f} times hull.deviation_sigma over metres"
    if shape.is_of_another_hull:
        yield (
            f"the hull leaves it by {times}: the model, that sigma, the path, the tray's angles "
            "or the DVL's ranges are wrong"
        )
    if shape.fits_better_scaled:
        yield (
            "stretched along its axes it fits the surveyed part better, by a chi-square of "
            f"{shape.scale_chi2:.0f} with three degrees of freedom: its proportions, its scale, "
            "the path, the tray's angles or the DVL's ranges are wrong"
        )
    if sigmas_off <= registration.GUESS_SIGMAS:
        return
    far = f"it fits {sigmas_off:.1f} times farther from hull.pose than hull.pose_sigma says"
    if not shape.fits_better_than_plane:
        yield f"{far}, and the surveyed part of the hull is too plain to tell that it is this one"
    if shape.exceeds_stated_error:
        yield f"{far}, and there the hull leaves it by {times}"
