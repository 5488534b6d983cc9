# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Limit corrections to what a sensor can be wrong by, and refuse dives that contradict themselves.

The adjustment estimates errors of sensors and mounts, and corrects them. A correction larger than
any sensor needs, or one that another sensor's error explains better, is no correction: the
measurements contradict each other, and the dive is refused (docs/methods.md 6).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import chdtri  # not scipy.stats, which takes a quarter of a second to load

from hullrecon import native
from hullrecon.adjustment.dvl_delay import VelocityChange, velocity_change
from hullrecon.adjustment.exceeded_priors import MANY_SIGMAS, MOUNTS, ROTATION, displacement
from hullrecon.adjustment.hull_pose.other_beams import find_fitting_beams
from hullrecon.adjustment.hull_pose.other_tray import find_fitting_tray, find_tray_offset
from hullrecon.adjustment.hull_pose.registration import Registration
from hullrecon.adjustment.problem.lens import MOST_CALIBRATIONS
from hullrecon.adjustment.readout import RowMotion, motion_by_row
from hullrecon.adjustment.rounds import Estimate, Phase, RoundResult, RoundSolver
from hullrecon.adjustment.suspects import (
    MOST_DELAY_S,
    Trial,
    best_explanations,
    least_delay_gain,
    least_readout_gain,
    try_suspects,
)
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
        # rad/s. Zero-rate offsets of MEMS gyros that nothing calibrates are a tenth of a degree a
        # second after their filter has settled.
        np.radians(0.1),
        # rad, roll and pitch. An attitude sensor is levelled by hand to a degree or two, as is its
        # mount.
        np.radians(5.0),
        np.radians(5.0),
        # m. A gauge that was not zeroed: weather makes 0.4 m of water, trim and draught a metre.
        2.0,
    ]
)
# Key of dive.toml that states each one's sigma
ERRORS = (
    "dvl.scale_sigma", "imu.heading_drift_deg_per_hour", "imu.bias_sigma_deg",
    "imu.bias_sigma_deg", "pressure.bias_sigma_m",
)  # fmt: skip
# Mounts are measured with a protractor to a degree or two; a bracket is made at 0, 45 or 90.
LARGEST_TURN_RAD = np.radians(5.0)
MOUNT_KEYS = {"tray_from_top": "camera.top.mount", "tray_from_dvl": "dvl.mount"}
# Largest believable error of a stereo rig, as a share of the baseline's length and as a turn: a
# bracket that was bent, or a baseline that was measured with a ruler. A calibration in air instead
# of water is off by a third.
LARGEST_BASELINE_SHARE = 0.1
LARGEST_STEREO_TURN_RAD = np.radians(3.0)
# Largest believable error of focal length and principal point, as a share of the focal length: a
# calibration in water finds both to half a per cent, one in another medium is a third off
LARGEST_LENS_SHARE = 0.03
# A measurement that is left out contradicts the rest grossly if chi-square falls by more than this
# for each of its rows
GROSS = 4.0
# Chance that a suspect without error is named in place of the CAD model, on a path that does not
# contradict itself: five sigmas, as in navigation/suspects. On a faultless dive with 3,400
# landmarks, whose CAD model had another unit, a distortion lowered chi-square by 12.
CHANCE = 6e-7
LEAST_WEIGHT = 1e-3  # of depths, whose estimated weight is zero on a path without noise
# Chi-square that a shear of the images explains at least, beyond which sensors are suspected: 0.3
# at most where lenses are 0.3 px off, 4 and more with 20 px of principal point or 20 ms of readout
SHEARED = 2.0
# Chi-square that a delay of the DVL explains at least, beyond which sensors are suspected: five
# sigmas, as in navigation/clocks. 0.2 on a dive with right clocks, 757 with 0.14 s
DELAYED = 25.0


def accept_corrections(path: Phase, corrected: Phase, solver: RoundSolver) -> Phase:
    """Accept the corrections of a path unless they are unbelievable or explained better otherwise.

    Parameters
    ----------
    path, corrected
        The path solved with the package's priors, and the path solved with the contradicted priors
        widened.
    solver
        Its options are those of the trials' solves, and it reports each trial.

    Returns
    -------
    Phase
        `corrected`, with the trials of all suspects in its verdict.

    Raises
    ------
    ContradictionError
        Where a correction is larger than its sensor can be wrong by, or where an error that the
        adjustment cannot correct explains more.
    """
    beyond = list(_beyond_belief(path.estimate.measured.rig, corrected))
    trials = _try_all(path, solver)
    _refuse(trials, beyond, solver)
    return replace(corrected, verdict=replace(corrected.verdict, suspects=trials))


def believe_place(path: Phase, placed: Phase, stated: Rig, solver: RoundSolver) -> None:
    """Check corrections that were found with the CAD model, as `accept_corrections` does.

    Parameters
    ----------
    path, placed
        The path, solved without the CAD model, and the phase of the accepted CAD model.
    stated
        The rig with the priors of the package.
    solver
        Its options are those of the trials' solves, and it reports each trial.

    Raises
    ------
    ContradictionError
        Where a correction is larger than its sensor can be wrong by.
    """
    beyond = list(_beyond_belief(stated, placed))
    if beyond and path.first is not None and solver.strategy.systematic_errors:
        _refuse(path.verdict.suspects or _try_all(path, solver), beyond, solver)


def is_ill_timed(path: Phase, solver: RoundSolver) -> bool:
    """Tell whether a readout time or a delay of the DVL would make a solved path fit better.

    Neither has a prior that the path could contradict. With a readout time, image rows are exposed
    one after another: each leg's motion shears its images (`readout`), and adjacent legs contradict
    each other. With a delay, the DVL is stamped late relative to the images (`dvl_delay`).
    """
    if path.first is None:
        return False
    problem, by_row, by_delay = _prepare_trials(path.first)
    return (
        least_readout_gain(problem, solver.settings, by_row) > SHEARED
        or least_delay_gain(problem, solver.settings, by_delay) > DELAYED
    )


def explain_refusal(path: Phase, placed: Phase, solver: RoundSolver) -> Phase:
    """Look for a sensor whose error explains why the CAD model was refused.

    Returns the phase of the refused CAD model, with the suspects that were tried in its verdict.
    Where no suspect explains more than chance, none is in it. Nothing is tried where the path was
    solved without rounds, or without errors of sensors as unknowns.

    Parameters
    ----------
    path
        The path, solved without the CAD model.
    placed
        The phase of the refused CAD model.
    solver
        Its options are those of the trials' solves, and it reports each trial.

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
    _refuse_misread_ranges(path.estimate, placed)
    return replace(placed, verdict=replace(placed.verdict, suspects=trials))


def doubt_tray(path: Phase, placed: Phase) -> Phase:
    """Look for wrong angles of the tray where an accepted CAD model contradicts the package.

    An offset of the angles is noted in the placement, for a warning, where the CAD model lies far
    from its guess and would lie at it with the angles corrected. Otherwise the phase `placed` is
    returned unchanged, as it is without DVL ranges and on a path that outages cut.

    Raises
    ------
    ContradictionError
        Where the hull deviates from the CAD model by more than the package states, and does not
        with the tray's angles read otherwise. Images would show how the tray turns, so with them
        nothing is tried.
    """
    measured, state, placement = path.estimate.measured, path.estimate.state, placed.placement
    if measured.returns is None or placement is None or placement.segments is not None:
        return placed
    shape = placement.shape
    if measured.tracks is None and shape is not None and shape.needs_wider_sigma:
        _refuse_misread_tray(path.estimate, None)
    rig, found = state.mounted(measured.rig), placement.registration
    offset = find_tray_offset(rig, state.path, measured.odometry, measured.returns, found)
    if offset is None:
        return placed
    return replace(placed, placement=replace(placement, tray_offset=offset[0]))


def _is_beyond_chance(trial: Trial) -> bool:
    """Tell whether chi-square falls by more than leaving out rows without error explains.

    `gain` is the fall less the number of rows. Their sum is compared with the chi-square limit.
    """
    return bool(trial.gain + trial.rows > chdtri(trial.rows, CHANCE))


def _refuse_misread_ranges(solved: Estimate, placed: Phase) -> None:
    """Raise ContradictionError where the CAD model fits the DVL's ranges interpreted otherwise.

    Tried are the beams in another order, and without images, which would show how the tray turns,
    other readings of its angles.

    Parameters
    ----------
    solved
        The path, solved without the CAD model.
    placed
        The phase of the CAD model, which was refused.
    """
    measured, state = solved.measured, solved.state
    returns, cad_model, hull = measured.returns, measured.cad_model, placed.estimate.state.hull
    if returns is None or cad_model is None or (hull is not None and hull.segments is not None):
        return  # the segments of a path that outages cut move freely, and fit any interpretation
    rig = state.mounted(measured.rig)

    def ends(of: Returns) -> Array:
        return rig.dvl_points(of, state.path).points[~of.flagged]

    beams = find_fitting_beams(returns, ends, cad_model, measured.rig.priors.range_sigma_m)
    if beams is not None:
        order, before_m, after_m = beams
        values = {"beams": list(order), "before_mm": 1e3 * before_m, "after_mm": 1e3 * after_m}
        raise ContradictionError(Finding("other-beams", values).sentence)
    if measured.tracks is None:
        found = None if placed.placement is None else placed.placement.registration
        _refuse_misread_tray(solved, found)


def _refuse_misread_tray(solved: Estimate, found: Registration | None) -> None:
    """Raise ContradictionError where the CAD model fits with the tray's angles read otherwise.

    They are tried with the other sign, in another unit, and with another zero.

    Parameters
    ----------
    solved
        A path with DVL ranges, solved without the CAD model.
    found
        The registration of the CAD model, from which an offset of the angles follows. None: no
        offset is tried.
    """
    measured, state = solved.measured, solved.state
    returns, cad_model = measured.returns, measured.cad_model
    assert returns is not None
    assert cad_model is not None
    rig = state.mounted(measured.rig)
    tray = find_fitting_tray(rig, state.path, measured.odometry, returns, cad_model)
    offset = None
    if found is not None:
        offset = find_tray_offset(rig, state.path, measured.odometry, returns, found)
    # Of the two explanations, that which leaves the smaller RMS distance from the CAD model
    if offset is not None and (tray is None or offset[1] < tray[2]):
        offset_deg = float(np.degrees(offset[0]))
        named = Finding(
            "tray-offset",
            {"offset_deg": offset_deg, "add_deg": -offset_deg, "after_mm": 1e3 * offset[1]},
        )
        raise ContradictionError(named.sentence)
    if tray is not None:
        reading, before_m, after_m = tray
        named = Finding(
            "other-tray",
            {"reading": reading, "before_mm": 1e3 * before_m, "after_mm": 1e3 * after_m},
        )
        raise ContradictionError(named.sentence)


def _try_all(path: Phase, solver: RoundSolver) -> tuple[Trial, ...]:
    """Solve the first round of a path without each suspect in turn."""
    assert path.first is not None
    problem, by_row, by_delay = _prepare_trials(path.first)
    return try_suspects(problem, solver.settings, by_row, by_delay)


def _prepare_trials(first: RoundResult) -> tuple[native.Problem, RowMotion, VelocityChange]:
    """Prepare the trials of suspects.

    Returns
    -------
    tuple
        The round's problem, how its features move with a readout time, and how its odometry
        changes with a delay of the DVL.
    """
    measured, state = first.after.measured, first.after.state
    by_row = motion_by_row(first.problem, measured, state)
    by_delay = velocity_change(first.problem, measured.trajectory.t_ns)
    return _with_stated_sigmas(first), by_row, by_delay


def _with_stated_sigmas(solved: RoundResult) -> native.Problem:
    """Give a round's problem the sigmas of depths and tray that the package states.

    Estimated from residuals, a sigma is too small where the solution follows the sensor's
    noise, and then any sensor that is left out seems to explain much. The displacements of the
    lenses stay unknowns. On a long dive, what a calibration leaves would look like another sensor's
    error without them.
    """
    problem, weights = solved.problem, solved.weights
    # Ratios of the stated sigmas to those of the round: of the tray, and of depth, roll and pitch
    tray_ratio = solved.after.measured.rig.priors.tray_sigma_rad / weights.tray
    attitude_ratio = np.array([1 / max(weights.depth, LEAST_WEIGHT), 1.0, 1.0])
    return replace(
        problem,
        tray=replace(problem.tray, sigma=problem.tray.sigma * tray_ratio),
        attitude=replace(problem.attitude, sigma=problem.attitude.sigma * attitude_ratio),
    )


def _refuse(trials: Sequence[Trial], beyond: Sequence[str], solver: RoundSolver) -> None:
    """Raise ContradictionError where a correction is beyond belief, or a fault explains more.

    A fault explains more where chi-square falls grossly in the best trial, and none of the trials
    that explain as much is a correction of believable size.

    Parameters
    ----------
    trials
        What each suspect explains, the best first.
    beyond
        Descriptions of corrections that are too large to be believed. Empty: none is.
    solver
        Reports each trial. Its calibration gives how far lenses may be off.
    """
    best = best_explanations(trials)
    for trial in trials:
        solver.report(f"left out or freed: {trial.suspect}: {trial.gain:.0f} squares are gone")
    corrected = any(trial.corrects and _is_believable(trial, solver.calibrated) for trial in best)
    if not beyond and (not best or corrected or not _is_gross(best[0], solver.calibrated)):
        return
    explanations = [[trial.suspect, trial.found] for trial in best]
    found = Finding("contradiction", {"beyond": ", ".join(beyond), "explanations": explanations})
    raise ContradictionError(found.sentence)


def _is_believable(trial: Trial, calibrated: Rig) -> bool:
    """Tell whether the error that a trial found is of a size that the suspect may have.

    A distortion may be as far off as the lenses' displacements, which correct it.
    """
    focal_px = 1.0 if calibrated.top is None else calibrated.top.fx
    largest = {
        "dvl-scale": LARGEST_ERRORS[0],
        "dvl-mount": LARGEST_TURN_RAD,
        "camera-mount": LARGEST_TURN_RAD,
        "imu": LARGEST_ERRORS[2],
        "stereo-rig": LARGEST_BASELINE_SHARE,
        "dvl-clock": MOST_DELAY_S,
        "distortion": MOST_CALIBRATIONS * max(calibrated.priors.calibration_sigma_px),
    }
    if trial.suspect.startswith("principal-point"):
        largest[trial.suspect] = LARGEST_LENS_SHARE * focal_px
    if trial.suspect.startswith("focal-length"):
        return trial.found is not None and abs(trial.found - 1) <= LARGEST_LENS_SHARE
    if trial.suspect not in largest or trial.found is None:
        return False
    return bool(abs(trial.found) <= largest[trial.suspect])


def _is_gross(trial: Trial, calibrated: Rig) -> bool:
    """Tell whether a suspect contradicts the rest by more than an error of believable size does."""
    return not _is_believable(trial, calibrated) and trial.gain > GROSS * trial.rows


def _beyond_belief(stated: Rig, corrected: Phase) -> Iterator[str]:
    """Describe each correction that is larger than its sensor can be wrong by.

    Where the package itself allows more, that is the limit. The tray's backlash has none.

    Parameters
    ----------
    stated
        The rig with the priors of the package.
    corrected
        The path with the contradicted priors widened.
    """
    state, stereo = corrected.estimate.state, corrected.verdict.stereo
    found = np.abs(state.navigation[: len(LARGEST_ERRORS)])
    allowed = MANY_SIGMAS * stated.priors.navigation_sigma[: len(LARGEST_ERRORS)]
    for row in np.flatnonzero(found > np.maximum(LARGEST_ERRORS, allowed)):
        yield f"{found[row] / allowed[row] * MANY_SIGMAS:.0f} times {ERRORS[row]}"
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
    """Compute the largest sigma of a mount's rotation, rad.

    rows (6, 6): square root of the mount's information.
    """
    # The covariance is inverse @ inverse.T, so a sigma is the length of a row of the inverse
    return float(np.linalg.norm(np.linalg.inv(rows), axis=1)[ROTATION].max())
