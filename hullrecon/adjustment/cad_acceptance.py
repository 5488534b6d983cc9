# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Accept the CAD model, or refuse it with a reason: its registration, a round with it, its shape.

It is accepted only if the measurements that the path explained without it are explained as well
with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hullrecon.adjustment.hull_pose import registration
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
from hullrecon.adjustment.hull_pose.segments import Segments
from hullrecon.adjustment.hull_pose.shape_comparison import ShapeComparison
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.adjustment.residual_growth import MAX_GROWTH, residual_growth, stated_attitude_rms
from hullrecon.adjustment.rounds import ACCEPTED, Estimate, RoundResult, RoundSolver, Verdict
from hullrecon.dive.hull.afloat import find_sunk
from hullrecon.dive.hull.symmetry import find_lying_side
from hullrecon.findings.finding import Finding
from hullrecon.geometry.meshes.units import UNIT_NAMES
from hullrecon.typing import Array

MAX_SIGMAS_OFF = 8.0  # largest distance from the package's guess of the hull pose, in its sigmas
MAX_MISSED = 0.2  # share of the beams that miss the CAD model
MIN_ON_HULL = 0.2  # share of the landmarks on its surface
# An explanation of a refusal is named too if the points that fit with it are at least this share of
# those that fit with the best explanation
AS_WELL = 0.9
# Possible causes, where the CAD model fits with no explanation that is tried. The tray's angles are
# a part of the path, logged or taken to be constant.
ANYBODY = (
    ": the model, its unit, hull.pose, the path, the tray's angles or the ranges from it are wrong"
)


def lying_side(cad_model: CadModel) -> Finding | None:
    """Say which side a CAD model lies on at the package's guess. None where it is upright."""
    return find_lying_side(cad_model.mesh, cad_model.chart.ship_axes, cad_model.guess)


def sunk(cad_model: CadModel) -> Finding | None:
    """Say how deep a ship lies under water at the package's guess. None where it floats."""
    axes, sigma_m = cad_model.chart.ship_axes, cad_model.guess_sigma[:3]
    return find_sunk(cad_model.mesh, axes, cad_model.guess, sigma_m)


def accept_registration(found: registration.Registration, segments: Segments | None) -> Verdict:
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


def add_fitting_unit_and_heading(
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


def accept_round(found: RoundResult, solver: RoundSolver) -> Verdict:
    """Judge a round that was solved with the CAD model.

    The CAD model is refused where beams or landmarks miss it, or where images and navigation are
    explained worse with it than without it.
    """
    return _verdict(_reasons_to_refuse(found, solver))


def _reasons_to_refuse(found: RoundResult, solver: RoundSolver) -> Iterator[str]:
    """Yield the reasons to refuse the CAD model after a round with it, most important first.

    The DVL's beams miss it, few landmarks lie on it, or residuals of images and navigation grow.
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
    growth = residual_growth(found.problem, found.plan, settings)
    worse = [name for name, ratio in growth.items() if ratio > MAX_GROWTH[name]]
    if "attitude" in worse and stated_attitude_rms(found, settings) <= 1:
        # in the sigmas that dive.toml states they are small enough (`stated_attitude_rms`)
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


def accept_shape(shape: ShapeComparison, sigmas_off: float) -> Verdict:
    """Judge by its shape whether the surveyed hull is that of the CAD model.

    Parameters
    ----------
    shape
        The surveyed shape, compared with the CAD model's.
    sigmas_off
        How far the hull was found from the package's guess of its pose, in the guess's sigmas.
    """
    return _verdict(_reasons_against_shape(shape, sigmas_off))


def _reasons_against_shape(shape: ShapeComparison, sigmas_off: float) -> Iterator[str]:
    """Yield reasons why the surveyed hull is not that of the CAD model, most important first.

    A hull that was found far from the package's guess has to pass more: its shape must confirm the
    CAD model, and deviate by no more than stated.

    shape: the comparison of both shapes. sigmas_off: distance of the registered pose from the
    guess, in sigmas of hull.pose.
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
            "hull.pose, the path, the tray's angles or the DVL's ranges are wrong"
        )
    if sigmas_off <= registration.GUESS_SIGMAS:
        return
    far = f"it fits {sigmas_off:.1f} times farther from hull.pose than hull.pose_sigma says"
    if not shape.fits_better_than_plane:
        yield f"{far}, and the surveyed part of the hull is too plain to tell that it is this one"
    if shape.exceeds_stated_error:
        yield f"{far}, and there the hull leaves it by {times}"


def _verdict(reasons: Iterator[str]) -> Verdict:
    """Refuse by the first reason, and accept where there is none. Further ones are not computed."""
    reason = next(reasons, None)
    return ACCEPTED if reason is None else Verdict(accepted=False, reason=reason)
