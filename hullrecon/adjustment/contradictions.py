# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Corrections held within what a sensor can be wrong by, and contradictions refused.

The adjustment takes errors of sensors and mounts out. A correction that no sensor needs, or that
another sensor's error explains better, is no correction: the dive is contradictory
(docs/methods.md 6).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import chdtri  # not scipy.stats, which takes a quarter of a second to load

from hullrecon import native
from hullrecon.adjustment.exceeded_priors import MANY_SIGMAS, MOUNTS, ROTATION, displacement
from hullrecon.adjustment.hull_pose.other_beams import find_fitting_beams
from hullrecon.adjustment.hull_pose.other_tray import find_fitting_tray, find_tray_offset
from hullrecon.adjustment.readout import RowMotion, motion_by_row
from hullrecon.adjustment.rounds import Estimate, Phase, RoundResult, RoundSolver
from hullrecon.adjustment.suspects import Trial, best_explanations, least_gain, try_suspects
from hullrecon.errors import ContradictionError
from hullrecon.findings.finding import Finding
from hullrecon.records.trajectory import Returns
from hullrecon.rig import Rig
from hullrecon.typing import Array

# Largest believable errors of navigation, in the order of RigPriors.navigation_sigma:
LARGEST_ERRORS = np.array(
    [
        # Sound goes at 1402 m/s in fresh water of 0 degrees and at 1560 in salt water of 36
        # [ChenMillero1977]: a DVL that was set to the one in the other is off by a ninth.
        0.115,
        # Zero-rate offsets of MEMS gyros that nothing calibrates are a tenth of a degree a second
        # after their filter has settled.
        np.radians(0.1),
        # An attitude sensor is levelled by hand to a degree or two, as is its mount.
        np.radians(5.0),
        np.radians(5.0),
        # A gauge that was not zeroed: weather makes 0.4 m of water, trim and draught a metre
        2.0,
    ]
)
ERRORS = (
    "dvl.scale_sigma", "imu.heading_drift_deg_per_hour", "imu.bias_sigma_deg",
    "imu.bias_sigma_deg", "pressure.bias_sigma_m",
)  # fmt: skip
# Mounts are measured with a protractor to a degree or two; a bracket is made at 0, 45 or 90.
LARGEST_TURN_RAD = np.radians(5.0)
MOUNT_KEYS = {"tray_from_top": "camera.top.mount", "tray_from_dvl": "dvl.mount"}
# A bracket that was bent, or a baseline that was measured with a ruler. Air in place of water
# makes a third.
LARGEST_BASELINE_SHARE = 0.1
LARGEST_STEREO_TURN_RAD = np.radians(3.0)
# Of the focal length: a calibration in water knows focal lengths and principal point to half a per
# cent, another medium's is a third off
LARGEST_LENS_SHARE = 0.03
# What is left out contradicts the rest grossly: by so many squares of its sigma a row
GROSS = 4.0
# Chance that a suspect without error is named in place of the CAD model, of a path that agrees with
# itself: five sigmas, as in navigation/suspects. A distortion explained 12 squares on a faultless
# dive, 3,400 landmarks, whose CAD model had another unit.
CHANCE = 6e-7
LEAST_WEIGHT = 1e-3  # of depths, which a path without noise makes nil
# Squares that shearing the images explains at least, beyond which sensors are suspected: 0.3 at
# most where lenses are 0.3 px off, 4 and more with 20 px of principal point or 20 ms of readout
SHEARED = 2.0


def hold_within_belief(path: Phase, corrected: Phase, solver: RoundSolver) -> Phase:
    """Accept corrections that a sensor may need, with the suspects that were tried.

    Parameters
    ----------
    path, corrected
        The path with the package's priors, and with those that it contradicts widened.
    solver
        Of both.

    Raises
    ------
    ContradictionError
        Where a correction is larger than its sensor can be wrong by, or an error that cannot be
        taken out explains more.
    """
    beyond = list(_beyond_belief(path.estimate.measured.rig, corrected))
    trials = _try_all(path, solver)
    _refuse(trials, beyond, solver)
    return replace(corrected, verdict=replace(corrected.verdict, suspects=trials))


def is_sheared(path: Phase, solver: RoundSolver) -> bool:
    """Tell whether a solved path would fit better if its images were sheared by the motion.

    Legs beside each other show that before any prior is exceeded.
    """
    if path.first is None:
        return False
    problem, by_row = _suspected(path.first)
    return least_gain(problem, solver.settings, by_row) > SHEARED


def explain_refusal(path: Phase, placed: Phase, solver: RoundSolver) -> Phase:
    """Ask whether a sensor is wrong before the CAD model is blamed.

    Raises
    ------
    ContradictionError
        Where the path contradicts itself without the CAD model, or the CAD model fits the DVL's
        ranges with its beams in another order, or with the tray's angles read otherwise.
    """
    if path.first is None or not solver.strategy.systematic_errors:
        return placed
    trials = path.verdict.suspects
    if not trials:
        trials = _try_all(path, solver)
        if not any(_is_beyond_chance(trial) for trial in trials):
            trials = ()
    _refuse(trials, [], solver)
    _refuse_other_readings(path.estimate, placed)
    return replace(placed, verdict=replace(placed.verdict, suspects=trials))


def _is_beyond_chance(trial: Trial) -> bool:
    """Tell whether a suspect explains more squares than rows without error take with them."""
    return bool(trial.gain + trial.rows > chdtri(trial.rows, CHANCE))


def _refuse_other_readings(solved: Estimate, placed: Phase) -> None:
    """Raise ContradictionError where the CAD model fits the DVL's ranges read otherwise.

    With its beams in another order, or, without images, which show how the tray turns, with the
    tray's angles of the other sign, unit or zero.
    """
    measured, state = solved.measured, solved.state
    returns, cad_model, hull = measured.returns, measured.cad_model, placed.estimate.state.hull
    if returns is None or cad_model is None or (hull is not None and hull.segments is not None):
        return  # the parts of a path that outages cut fit anything
    rig = state.mounted(measured.rig)

    def ends(of: Returns) -> Array:
        return rig.dvl_points(of, state.path).points[~of.flagged]

    beams = find_fitting_beams(returns, ends, cad_model, measured.rig.priors.range_sigma_m)
    if beams is not None:
        order, before_m, after_m = beams
        values = {"beams": list(order), "before_mm": 1e3 * before_m, "after_mm": 1e3 * after_m}
        raise ContradictionError(Finding("other-beams", values).sentence)
    if measured.tracks is not None:
        return
    tray = find_fitting_tray(rig, state.path, measured.odometry, returns, cad_model)
    off = None
    if placed.placement is not None:
        lies = placed.placement.registration
        off = find_tray_offset(rig, state.path, measured.odometry, returns, lies)
    if off is not None and (tray is None or off[1] < tray[2]):
        values = {"offset_deg": float(np.degrees(off[0])), "after_mm": 1e3 * off[1]}
        raise ContradictionError(Finding("tray-offset", values).sentence)
    if tray is not None:
        reading, before_m, after_m = tray
        values = {"reading": reading, "before_mm": 1e3 * before_m, "after_mm": 1e3 * after_m}
        raise ContradictionError(Finding("other-tray", values).sentence)


def _try_all(path: Phase, solver: RoundSolver) -> tuple[Trial, ...]:
    assert path.first is not None
    problem, by_row = _suspected(path.first)
    return try_suspects(problem, solver.settings, by_row)


def _suspected(first: RoundResult) -> tuple[native.Problem, RowMotion]:
    measured, state = first.after.measured, first.after.state
    return _as_stated(first), motion_by_row(first.problem, measured, state)


def _as_stated(solved: RoundResult) -> native.Problem:
    """Return a round's problem with the sigmas of depths and of the tray that the package states.

    Those estimated from residuals are too small where the solution follows a sensor's noise, and
    whatever is left out then seems to explain much. Lenses have no displacement: theirs would take
    a part of any other error.
    """
    problem, weights = solved.problem, solved.weights
    stated = solved.after.measured.rig.priors.tray_sigma_rad / weights.tray
    depths = np.array([1 / max(weights.depth, LEAST_WEIGHT), 1.0, 1.0])
    unknowns = problem.unknowns
    return replace(
        problem,
        unknowns=replace(
            unknowns,
            lens_top=np.zeros_like(unknowns.lens_top),
            lens_bottom=np.zeros_like(unknowns.lens_bottom),
        ),
        lenses=native.LensTable(),
        tray=replace(problem.tray, sigma=problem.tray.sigma * stated),
        attitude=replace(problem.attitude, sigma=problem.attitude.sigma * depths),
    )


def _refuse(trials: Sequence[Trial], beyond: Sequence[str], solver: RoundSolver) -> None:
    """Raise ContradictionError unless a correction explains what the trials show."""
    best = best_explanations(trials)
    top = solver.calibrated.top
    focal_px = 1.0 if top is None else top.fx
    for trial in trials:
        solver.report(f"left out or freed: {trial.suspect}: {trial.gain:.0f} squares are gone")
    corrected = any(trial.corrects and _is_believable(trial, focal_px) for trial in best)
    if not beyond and (not best or corrected or not _is_gross(best[0], focal_px)):
        return
    explanations = [[trial.suspect, trial.found] for trial in best]
    found = Finding("contradiction", {"beyond": ", ".join(beyond), "explanations": explanations})
    raise ContradictionError(found.sentence)


def _is_believable(trial: Trial, focal_px: float) -> bool:
    """Tell whether a suspect's own error is of a size that it may have."""
    largest = {
        "dvl-scale": LARGEST_ERRORS[0],
        "dvl-mount": LARGEST_TURN_RAD,
        "camera-mount": LARGEST_TURN_RAD,
        "imu": LARGEST_ERRORS[2],
        "stereo-rig": LARGEST_BASELINE_SHARE,
    }
    if trial.suspect.startswith("principal-point"):
        largest[trial.suspect] = LARGEST_LENS_SHARE * focal_px
    if trial.suspect.startswith("focal-length"):
        return trial.found is not None and abs(trial.found - 1) <= LARGEST_LENS_SHARE
    if trial.suspect not in largest or trial.found is None:
        return False
    return bool(abs(trial.found) <= largest[trial.suspect])


def _is_gross(trial: Trial, focal_px: float) -> bool:
    """Tell whether a suspect contradicts the rest by more than small errors do."""
    return not _is_believable(trial, focal_px) and trial.gain > GROSS * trial.rows


def _beyond_belief(stated: Rig, corrected: Phase) -> Iterator[str]:
    """Describe each correction that is larger than its sensor can be wrong by.

    A package that allows more than that itself is believed.
    """
    state, stereo = corrected.estimate.state, corrected.verdict.stereo
    found = np.abs(state.navigation[: len(LARGEST_ERRORS)])
    allowed = MANY_SIGMAS * stated.priors.navigation_sigma[: len(LARGEST_ERRORS)]
    for place in np.flatnonzero(found > np.maximum(LARGEST_ERRORS, allowed)):
        yield f"{found[place] / allowed[place] * MANY_SIGMAS:.0f} times {ERRORS[place]}"
    for name in MOUNTS:
        nominal, rows, mount = (getattr(of, name) for of in (stated, stated.priors, state.mounts))
        if nominal is None or rows is None or mount is None:
            continue
        turn = float(np.linalg.norm(displacement(nominal, mount)[0][ROTATION]))
        if turn > max(LARGEST_TURN_RAD, MANY_SIGMAS * _largest_sigma(rows)):
            yield f"{MOUNT_KEYS[name]} turned by {np.degrees(turn):.1f} degrees"
    if stereo is None:
        return
    if stereo.turn_rad > LARGEST_STEREO_TURN_RAD:
        yield f"the bottom camera turned by {np.degrees(stereo.turn_rad):.1f} degrees"
    if abs(stereo.length) > LARGEST_BASELINE_SHARE:
        yield f"the baseline off by {100 * abs(stereo.length):.0f} %"


def _largest_sigma(rows: Array) -> float:
    """Compute the largest sigma of a mount's rotation, rad, from its square root of information."""
    return float(np.linalg.norm(np.linalg.inv(rows), axis=1)[ROTATION].max())
