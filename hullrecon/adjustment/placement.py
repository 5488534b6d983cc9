# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The CAD model laid onto a path that was solved without it, and whether what follows from it may
be believed.

The path that images and navigation give is known to centimetres over the survey; registered under a
path that is still bent, a CAD model pulls it into a wrong basin. So the CAD model comes after the
path, and has to leave what the path explained as well explained as it was.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.hull_pose import estimate, registration
from hullrecon.adjustment.hull_pose.form import Form, compare_form
from hullrecon.adjustment.hull_pose.stretches import Stretches, find_stretches, lay_stretches
from hullrecon.adjustment.native_settings import native_settings
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem import selection
from hullrecon.adjustment.problem.deviation_field import grid_over
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.problem.state import HullState, State
from hullrecon.adjustment.rounds import Estimate, Report, RoundResult
from hullrecon.errors import StageError
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Array

MIN_POINTS = 30
MAX_SIGMAS_OFF = 8.0  # of the package's guess of the hull pose
MAX_MISSED = 0.2  # share of the beams that miss the CAD model
MIN_ON_HULL = 0.2  # share of the landmarks on its surface
# The whitened residuals of what the path explained may grow by so much, root mean square, beyond
# what freed unknowns explain.
MAX_GROWTH = {"images": 1.02, "odometry": 1.1, "attitude": 1.1, "positions": 1.1}
GROUPS = {
    "images": ("stereo", "mono"),
    "odometry": ("odometry",),
    "attitude": ("attitude", "tray"),
    "positions": ("position",),
}
# of the chi-square that unknowns give back which the CAD model determines in place of navigation
FREED_QUANTILE = 0.999


@dataclass(frozen=True, kw_only=True)
class RegisteredModel:
    """The estimate with the CAD model laid onto it; stretches: into which an outage cuts the path,
    each then laid onto the CAD model for itself (None where it holds together); refusal: why it may
    not be believed, None where it may.
    """

    estimate: Estimate
    registration: registration.Registration
    stretches: Stretches | None
    refusal: str | None


def register_cad_model(
    solved: Estimate,
    cad_model: CadModel,
    options: AdjustOptions,
    report: Report,
    stretches: Stretches | None = None,
) -> RegisteredModel:
    """Return the CAD model registered to a solved path. Raises StageError where there is nothing to
    register.
    """
    measured, state = solved.measured, solved.state
    if stretches is None:
        points = _points_to_register(measured, state)
        found = registration.register(points, cad_model, measured.rig.priors.range_sigma_m)
    else:
        found, state = _register_stretches(solved, cad_model, stretches)
        points = _points_to_register(measured, state)
    report(
        f"registered {len(points)} points to the CAD model, {100 * found.fitness:.0f} % within three sigma"
    )
    hull = replace(_hull_state(found, points, options), stretches=stretches)
    refusal = None
    if found.fitness < registration.GOOD_FITNESS:
        laid, besides = "it is laid", ""
        if stretches is not None:
            laid = f"it and the {len(stretches)} stretches that outages leave of the path are laid"
            besides = ", or the path of a stretch is wrong"
        refusal = (
            f"only {100 * found.fitness:.0f} % of the surveyed points lie within three sigma of it, wherever {laid}: it is "
            f"another ship's, in other units, or far from where hull.pose says{besides}"
        )
    elif found.sigmas_off > MAX_SIGMAS_OFF:
        refusal = f"it fits only {found.sigmas_off:.0f} times farther from hull.pose than hull.pose_sigma says"
    return RegisteredModel(
        estimate=replace(solved, state=replace(state, hull=hull)),
        registration=found,
        stretches=stretches,
        refusal=refusal,
    )


def stretches_of_path(solved: RoundResult, options: AdjustOptions) -> Stretches | None:
    """Return the stretches into which outages cut a path that was solved without the CAD model;
    None where it holds together, or carries no ranges.
    """
    measured = solved.after.measured
    if measured.returns is None or options.as_published:
        return None
    node = measured.returns.node[~measured.returns.flagged]
    return find_stretches(solved.problem, native_settings(options), measured.odometry, node)


def _register_stretches(
    solved: Estimate, cad_model: CadModel, stretches: Stretches
) -> tuple[registration.Registration, State]:
    """Return the CAD model registered to the longest stretch, with the share of all points that
    then lie on it, and the state whose path has the other stretches laid onto it.
    """
    measured, state = solved.measured, solved.state
    assert measured.returns is not None
    sigma_range, node = (
        measured.rig.priors.range_sigma_m,
        measured.returns.node[~measured.returns.flagged],
    )
    points = _returns_in_global(measured.returns, measured, state)
    laid = lay_stretches(stretches, state.nodes, points, node, cad_model, sigma_range)
    found, state = laid.registration, replace(state, nodes=laid.nodes)
    fitness = registration.share_within(
        _returns_in_global(measured.returns, measured, state), found, sigma_range
    )
    return replace(found, fitness=fitness), state


def nothing_on_it(measured: Measurements, options: AdjustOptions) -> str | None:
    """Return why nothing of the measurements can lie on a CAD model, None where something may."""
    ranges = 0 if measured.returns is None else int((~measured.returns.flagged).sum())
    if options.method != "naive" or ranges:
        return None
    return "the method naive lays no landmark onto it, and there is no range of a DVL"


def reason_against(found: RoundResult, options: AdjustOptions) -> str | None:
    """Return why a solution with the CAD model is not to be believed, None where it may be: it
    misses the hull, or it explains images and navigation worse than the same measurements without
    the CAD model do.
    """
    ray_hit, label = found.result.ray_hit, found.result.label
    missed = float(np.mean(~ray_hit)) if len(ray_hit) else 0.0
    if missed > MAX_MISSED:
        return f"{100 * missed:.0f} % of the DVL's beams miss it"
    if options.method == "maxmix" and len(label) and float(np.mean(label == 1)) < MIN_ON_HULL:
        return f"only {100 * float(np.mean(label == 1)):.0f} % of the landmarks lie on its surface"
    if not len(found.problem.stereo.node) + len(found.problem.mono.node):
        # without images the path is navigation's own: its residuals are nil, and whatever bends it
        # makes them grow
        return None
    settings = native_settings(options)
    growth = residual_growth(found.problem, settings)
    worse = [name for name, ratio in growth.items() if ratio > MAX_GROWTH[name]]
    if "attitude" in worse and stated_attitude_rms(found, settings) <= 1:
        worse.remove("attitude")
    if not worse:
        return None
    parts = ", ".join(f"{name} by {100 * (growth[name] - 1):.0f} %" for name in worse)
    return f"laid onto it, the residuals grow: {parts}"


def stated_attitude_rms(found: RoundResult, settings: native.Options) -> float:
    """Return the root mean square of a round's residuals of depth, roll, pitch and the tray's
    angle, in the sigmas that the package states of roll, pitch and tray.

    One camera hardly tells the tray's angle from the pitch. The sigma of the tray is estimated from
    residuals that follow its noise, so it comes out too small, and grows with a right CAD model by
    more than the freed unknowns explain.
    """
    stated = replace(
        found.problem.tray,
        sigma=found.problem.tray.sigma
        * (found.after.measured.rig.priors.tray_sigma_rad / found.weights.tray),
    )
    cost = native.evaluate(
        replace(found.problem, tray=stated), replace(settings, method="naive"), jacobian=False
    ).cost_by_factor
    rows = len(stated.node) + 3 * len(found.problem.attitude.node)
    return float(np.sqrt(2 * (cost["attitude"] + cost["tray"]) / max(rows, 1)))


def residual_growth(problem: native.Problem, settings: native.Options) -> dict[str, float]:
    """Return by how much the CAD model makes what the path explains worse: the root mean square of
    the robust, whitened residuals of each group at the problem's values, over that of the same
    measurements solved without it. settings: of the solve that found the values.

    Unknowns that the CAD model determines follow navigation's noise no longer, and its residuals
    grow though all is right: one camera hardly tells the tray's angle from the pitch. Where a ratio
    is beyond MAX_GROWTH, the residuals without the CAD model are therefore counted with what they
    lost to such unknowns.
    """
    without = replace(problem, ranges=native.RangeTable(), surface=native.SurfaceTable()).hold(
        "T_g_M", "deviation"
    )
    naive = replace(settings, method="naive")
    free = without.started_from(native.solve(without, replace(naive, max_iterations=15)).unknowns)
    here, there = (_squares(p, naive) for p in (without, free))
    growth = {name: float(np.sqrt(here[name] / there[name])) for name in GROUPS if there[name] > 0}
    if all(ratio <= MAX_GROWTH[name] for name, ratio in growth.items()):
        return growth
    try:
        freed = _freed_squares(native.covariance(free, naive), native.covariance(problem, settings))
    except StageError:
        return growth  # something is not determined at all: nothing to count
    return {name: float(np.sqrt(here[name] / (there[name] + freed[name]))) for name in growth}


def _squares(problem: native.Problem, settings: native.Options) -> dict[str, float]:
    """Return the sum of the robust squares of each group's whitened residuals."""
    cost = native.evaluate(problem, settings, jacobian=False).cost_by_factor
    return {name: 2 * sum(cost[factor] for factor in factors) for name, factors in GROUPS.items()}


def _freed_squares(free: native.Covariance, tied: native.Covariance) -> dict[str, float]:
    """Return what the squares of each group may grow by because it determines fewer unknowns than
    before: a chi-square with as many degrees of freedom. Images determine all landmarks either way;
    nothing is allowed to them.
    """
    from scipy.special import chdtri  # not scipy.stats, which takes a quarter of a second to load

    def determined(marginals: native.Covariance, factors: tuple[str, ...]) -> float:
        return sum(marginals.leverage_by_factor[factor] for factor in factors)

    fewer = {
        name: determined(free, factors) - determined(tied, factors)
        for name, factors in GROUPS.items()
    }
    return {
        name: float(chdtri(count, 1 - FREED_QUANTILE)) if count > 0 else 0.0
        for name, count in fewer.items()
    }


def _hull_state(
    found: registration.Registration, points: Array, options: AdjustOptions
) -> HullState:
    hull = HullState(
        cad_model=found.cad_model,
        global_from_hull=found.global_from_hull,
        survey_center=found.center,
        grid=None,
        field=np.zeros(0),
    )
    if options.as_published:
        return hull
    at = hull.to_chart(points)
    grid = grid_over(at[np.isfinite(at).all(1)], found.cad_model.deviation_length)
    return replace(hull, grid=grid, field=np.zeros(grid.size))


def _points_to_register(measured: Measurements, state: State) -> Array:
    """Return what is laid onto the CAD model, in g: DVL returns, or stereo landmarks where no
    ranges were carried.
    """
    if measured.returns is not None and (~measured.returns.flagged).sum() >= MIN_POINTS:
        return _returns_in_global(measured.returns, measured, state)
    landmarks = selection.triangulate_landmarks(measured, state)
    landmarks = landmarks[np.isfinite(landmarks[:, 0])]
    if len(landmarks) < MIN_POINTS:
        raise StageError(
            f"nothing to lay onto the CAD model: fewer than {MIN_POINTS} DVL returns and landmarks",
            remedy="check topics.dvl and the cameras, or remove [hull] to run without a CAD model",
        )
    return landmarks


def _returns_in_global(returns: Returns, measured: Measurements, state: State) -> Array:
    """Return the DVL's returns that are not flagged, in g."""
    ends = state.mounted(measured.rig).dvl_points(returns, state.path)
    return ends.points[~returns.flagged]


@dataclass(frozen=True, kw_only=True)
class LaidModel:
    """The last estimate, its CAD model with the pose at the mean of its profile and with the error
    that it shows; evidence: what the pose was fitted to; form: whether that has the CAD model's
    form. Both None as published and without a CAD model.
    """

    ready: Estimate
    evidence: estimate.HullPoseEvidence | None = None
    form: Form | None = None


def estimate_hull_pose(last: RoundResult, options: AdjustOptions) -> LaidModel:
    """Return the CAD model where the points of a round lie on it. Where they leave it by more than
    the package says, the error that the package states is widened to what they show: a hull may be
    worse than its builder thinks, or another one.
    """
    ready = last.after
    hull = ready.state.hull
    if hull is None or options.as_published:
        return LaidModel(ready=ready)
    points = estimate.collect_hull_points(
        ready.measured, ready.state, last.chosen, last.result.label
    )
    evidence, best = estimate.fit_hull_pose(
        points.xyz, hull.global_from_hull, hull.cad_model, hull.survey_center, points.loose
    )
    form = compare_form(evidence, best)
    if form.contradicts:
        sigma = hull.cad_model.deviation_sigma * float(np.sqrt(form.deviation))
        wider = replace(hull.cad_model, deviation_sigma=sigma, contradicted=True)
        hull = replace(hull, cad_model=wider)
        evidence, best = estimate.fit_hull_pose(
            points.xyz, best, wider, hull.survey_center, points.loose
        )
    hull = replace(hull, global_from_hull=estimate.profile_mean_pose(evidence, best))
    return LaidModel(
        ready=replace(ready, state=replace(ready.state, hull=hull)), evidence=evidence, form=form
    )


def form_against(form: Form, sigmas_off: float) -> str | None:
    """Return why points that lie near the CAD model are not of its hull, None where they may be;
    sigmas_off: how far it was found from the package's guess.
    """
    if form.is_of_another_hull:
        return (
            f"the hull leaves it by {np.sqrt(form.deviation):.1f} times hull.deviation_sigma over metres: it is another "
            "ship's, or of another scale, or hull.deviation_sigma is too small"
        )
    if form.fits_better_stretched:
        return (
            f"its proportions or its scale are not the hull's: stretched along its axes it fits the surveyed part better, by a "
            f"chi-square of {form.stretch:.0f} with three degrees of freedom"
        )
    if sigmas_off <= registration.GUESS_SIGMAS:
        return None
    far = f"it fits {sigmas_off:.1f} times farther from hull.pose than hull.pose_sigma says"
    if not form.confirms:
        return f"{far}, and the surveyed part of the hull is too plain to tell that it is this one"
    if form.is_worse_than_stated:
        return (
            f"{far}, and there the hull leaves it by {np.sqrt(form.deviation):.1f} times hull.deviation_sigma over metres: a "
            "package may be mistaken in one of the two, but both point to another ship"
        )
    return None
