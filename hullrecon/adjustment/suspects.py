# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the sensor whose error explains that measurements contradict each other (docs/methods.md 6).

Each sensor in turn is a suspect. The path is solved again without it, or with the error that it may
have as an unknown. The suspect without which chi-square falls most explains the contradiction best.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hullrecon import native
from hullrecon.adjustment.dvl_delay import VelocityChange
from hullrecon.adjustment.readout import RowMotion
from hullrecon.adjustment.suspected_errors import (
    DEPTH,
    FREE_DEPTH_M,
    Suspect,
    free_navigation,
    has_images,
    list_suspects,
    without_attitude,
)
from hullrecon.findings.adjustment import CORRECTED
from hullrecon.geometry.frames import Camera
from hullrecon.typing import Array

LEAST_SLOPE = 1e-3  # of measured depths by those of the path; below it the sensor is stuck
ITERATIONS = 50  # at most, of a trial, which starts at the solved path
TOLERANCE = 1e-5  # relative change of cost that ends a trial
READOUT_S = 0.01  # a trial has this readout time and its negative; cameras have 5 to 50 ms
SLOPE_S = 0.002  # step of the derivatives by the readout time
DELAY_S = 0.05  # a trial has this delay of the DVL and its negative
# navigation/clocks corrects delays beyond a quarter of a second, so none is twice that
MOST_DELAY_S = 0.5
# A suspect explains as much as the best one if its trial lowers chi-square by this share of it
EXPLAINS = 0.9
CERTAIN = 3.0  # sigmas of what chi-square loses where rows without error are left out
# True length over that by the DVL, beyond which its scale explains nothing: a metre is 3.28 feet
LEAST_SCALE, MOST_SCALE = 0.25, 4.0
# Readout times that cameras have. A shorter one moves features by less than calibrations are wrong
LEAST_READOUT_S, MOST_READOUT_S = 0.005, 0.2
# Suspects that stand for a whole sensor, and the suspects that are single errors of it
WHOLES = {
    "pressure": {"pressure-scale"},
    "dvl-velocities": {"dvl-scale", "dvl-mount", "dvl-clock"},
    "imu-turns": {"imu"},
    "focal-length": {"focal-length-top", "focal-length-bottom"},
    "principal-point": {"principal-point-bottom"},
}


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A suspect, and by how much chi-square falls without it or with its error estimated."""

    suspect: str  # a key of SUSPECTS of hullrecon/findings/adjustment.py
    gain: float  # fall of chi-square, less what is expected of the rows left out
    rows: int  # number of measurements that are left out, or of unknowns that are freed
    # Estimated error of the suspect, in the unit of its key (share, rad, px, s). None where it was
    # left out
    found: float | None

    @property
    def is_certain(self) -> bool:
        """Tell whether chi-square falls by more than noise explains."""
        return self.gain > self.spread

    @property
    def spread(self) -> float:
        """Compute the largest `gain` that noise explains where the rows have no error."""
        return float(CERTAIN * np.sqrt(2 * self.rows))

    @property
    def corrects(self) -> bool:
        """Tell whether the adjustment can estimate and correct this suspect's error."""
        return self.suspect in CORRECTED


def try_suspects(
    problem: native.Problem,
    settings: native.Options,
    by_row: RowMotion,
    by_delay: VelocityChange,
) -> tuple[Trial, ...]:
    """Solve a path again without each suspect, the best explanation first.

    Parameters
    ----------
    problem
        A round without the CAD model at its solution, its priors as the package states them.
    settings
        The options with which it was solved.
    by_row
        How its features move if images are read out row by row.
    by_delay
        How its odometry changes if the DVL's readings were stamped late.

    Returns
    -------
    tuple of Trial
        One for each suspect, in the order of falling `gain`.
    """
    before = _solved(problem, settings)[0]
    trials = [
        _try_without(suspect, problem, settings, before) for suspect in list_suspects(problem)
    ]
    trials += _try_depths(problem, settings, before)
    trials += [
        _try_readout(name, cameras, problem, settings, before, by_row)
        for name, cameras in _readouts(problem).items()
    ]
    if has_images(problem) and len(problem.odometry.first):
        trials.append(
            _try_time(
                "dvl-clock",
                lambda late_s: _solved(by_delay.punctual(problem, late_s), settings)[0],
                before,
                DELAY_S,
                (-MOST_DELAY_S, MOST_DELAY_S),
            )
        )
    return tuple(sorted(trials, key=lambda trial: -trial.gain))


def least_readout_gain(
    problem: native.Problem, settings: native.Options, by_row: RowMotion
) -> float:
    """Bound from below how far a readout time would lower chi-square, without a solve.

    The trials of all suspects take a solve each. The bound shows beforehand whether they are
    worthwhile on a path that contradicts no prior (`is_ill_timed` of contradictions).

    Chi-square is taken as a parabola of the readout time, with all other unknowns held. At the
    solution its slope is right. Its curvature is too large, since the other unknowns would follow:
    some twenty times too large on two legs. So chi-square falls at least to the parabola's minimum.
    Parameters are those of `try_suspects`. Zero without images.
    """
    return max(
        (
            _least_gain(partial(by_row.moved, problem, cameras=cameras), settings, SLOPE_S)
            for cameras in _readouts(problem).values()
        ),
        default=0.0,
    )


def least_delay_gain(
    problem: native.Problem, settings: native.Options, by_delay: VelocityChange
) -> float:
    """Bound from below how far a delay of the DVL would lower chi-square, without a solve.

    As `least_readout_gain` does. Zero without images, as nothing else determines the delay.
    """
    if not has_images(problem):
        return 0.0
    return _least_gain(partial(by_delay.punctual, problem), settings, DELAY_S)


def _least_gain(
    shifted: Callable[[float], native.Problem], settings: native.Options, step_s: float
) -> float:
    """Compute the fall of chi-square to the minimum of its parabola, with all unknowns held.

    shifted: makes the problem with a time, s. step_s: of the derivatives by that time.
    """
    naive = replace(settings, method="naive")
    less, here, more = (_chi2(shifted(time_s), naive) for time_s in (-step_s, 0.0, step_s))
    curvature = more + less - 2 * here
    # A parabola falls by slope^2 / (2 curvature). The slope is half the difference
    return float((more - less) ** 2 / (8 * curvature)) if curvature > 0 else 0.0


def _readouts(problem: native.Problem) -> dict[str, Sequence[Camera]]:
    """List the suspects with a readout time, and the cameras of each: both alike, or one of two."""
    if len(problem.stereo.node):
        return {
            "readout": tuple(Camera),
            "readout-top": (Camera.TOP,),
            "readout-bottom": (Camera.BOTTOM,),
        }
    return {"readout": tuple(Camera)} if len(problem.mono.node) else {}


def _try_readout(
    name: str,
    cameras: Sequence[Camera],
    problem: native.Problem,
    settings: native.Options,
    before: float,
    by_row: RowMotion,
) -> Trial:
    """Estimate a readout time (`_try_time`).

    Parameters
    ----------
    name, cameras
        The suspect, and the cameras whose features are moved.
    problem, settings
        The path at its solution, and the options with which it was solved.
    before
        Chi-square without a readout time.
    by_row
        How features move with the readout time.
    """

    def chi2(readout_s: float) -> float:
        return _solved(by_row.moved(problem, readout_s, cameras), settings)[0]

    return _try_time(name, chi2, before, READOUT_S, (LEAST_READOUT_S, MOST_READOUT_S))


def _try_time(
    name: str,
    chi2: Callable[[float], float],
    before: float,
    step_s: float,
    possible_s: tuple[float, float],
) -> Trial:
    """Estimate a time as the minimum of a parabola through three solves.

    Chi-square is about a parabola of the time. It is solved for none and for one on either side.
    Where the minimum lies outside of these, three solves around it follow.

    Parameters
    ----------
    name
        The suspect.
    chi2
        Solves with a time, s, and computes chi-square.
    before
        Chi-square without one.
    step_s
        The time on either side.
    possible_s
        Least and largest time that the suspect may have.
    """
    middle_s, here = 0.0, before
    while True:
        less, more = chi2(middle_s - step_s), chi2(middle_s + step_s)
        slope, curvature = (more - less) / 2, more + less - 2 * here
        step = -slope / curvature if curvature > 0 else 0.0  # to the minimum, in step_s
        found_s = middle_s + step_s * step
        if middle_s or abs(step) < 1 or not possible_s[0] < found_s < possible_s[1]:
            break
        middle_s, here = found_s, chi2(found_s)
    lowest = here + slope * step + curvature * step**2 / 2
    # One is subtracted: any free unknown lowers chi-square by about one
    return Trial(suspect=name, gain=before - lowest - 1, rows=1, found=found_s)


def _try_depths(problem: native.Problem, settings: native.Options, before: float) -> list[Trial]:
    """Solve without depths, then with depths multiplied by a factor and shifted by a constant.

    Depths that are left out are expected to lower chi-square by one for each row. A pressure sensor
    that is stuck may have less noise than stated. Then the chi-square of its readings about their
    mean is expected instead. Empty without depths. Depths that do not follow the path at all
    (LEAST_SLOPE) are not tried with a factor.

    Parameters
    ----------
    problem, settings
        The path at its solution, and the options with which it was solved.
    before
        Chi-square of it.
    """
    depth, sigma_m = problem.attitude.measured[:, 0], problem.attitude.sigma[:, 0]
    if not np.isfinite(sigma_m).any():
        return []
    chi2, unknowns = _solved(without_attitude(problem, [0]), settings)
    weight = 1 / sigma_m**2
    about_constant = float(weight @ (depth - np.average(depth, weights=weight)) ** 2) + 1
    left_out = Trial(
        suspect="pressure",
        gain=before - chi2 - min(about_constant, len(depth)),
        rows=len(depth),
        found=None,
    )
    # The path without depths gives the factor: depths = slope * true depths + constant
    path_m = _depths_of_path(problem.started_from(unknowns), settings)
    slope = _fit_slope(path_m, depth, weight)
    if abs(slope) < LEAST_SLOPE:
        return [left_out]
    scaled, _ = _solved(_with_depths(problem, 1 / slope), settings)
    own = Trial(suspect="pressure-scale", gain=before - scaled - 2, rows=2, found=1 / slope)
    return [left_out, own]


def _depths_of_path(problem: native.Problem, settings: native.Options) -> Array:
    """Compute the depths (n,) m of a path at the readings of the pressure sensor."""
    rows = problem.attitude
    at = native.evaluate(problem, replace(settings, method="naive"), jacobian=False)
    whitened = at.residual[at.factor == native.FACTORS.index("attitude")].reshape(-1, 3)[:, 0]
    # A whitened residual is (depth of the path - measured depth) / sigma
    return np.asarray(whitened * rows.sigma[:, 0] + rows.measured[:, 0])


def _fit_slope(x: Array, y: Array, weight: Array) -> float:
    """Fit y (n,) = slope * x + constant by weighted least squares. Zero where x is constant."""
    from_mean = x - np.average(x, weights=weight)
    spread = weight @ from_mean**2
    return float((weight * from_mean) @ y / spread) if spread > 0 else 0.0


def _with_depths(problem: native.Problem, factor: float) -> native.Problem:
    """Multiply the depths and their sigmas by a factor, and make their bias an unknown."""
    measured, sigma = problem.attitude.measured.copy(), problem.attitude.sigma.copy()
    measured[:, 0] *= factor
    sigma[:, 0] *= abs(factor)
    rows = replace(problem.attitude, measured=measured, sigma=sigma)
    return free_navigation({DEPTH: FREE_DEPTH_M})(replace(problem, attitude=rows))


def _try_without(
    suspect: Suspect, problem: native.Problem, settings: native.Options, before: float
) -> Trial:
    """Solve without a suspect, or with its error as an unknown, to see how far chi-square falls.

    By noise alone it falls by about one for each row left out and each unknown, which is taken off.

    before: chi-square with the suspect as it is.
    """
    chi2, unknowns = _solved(suspect.doubt(problem), settings)
    return Trial(
        suspect=suspect.name,
        gain=before - chi2 - suspect.rows,
        rows=suspect.rows,
        found=None if suspect.found is None else suspect.found(problem, unknowns),
    )


def best_explanations(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """Choose the trial that explains most, and those that explain nearly as much.

    Nearly: a share EXPLAINS of the best one's gain, less what noise may add to it (`spread`).
    Trials whose gain noise explains, or whose estimated error no such sensor has, are not
    considered. Empty if none is left. A whole sensor is not named where one of its own errors
    (WHOLES) explains as much.

    trials: in the order of falling gain, as of `try_suspects`.
    """
    certain = [trial for trial in trials if trial.is_certain and not _is_impossible(trial)]
    if not certain:
        return ()
    enough = EXPLAINS * certain[0].gain - certain[0].spread
    best = [trial for trial in certain if trial.gain >= enough]
    named = {trial.suspect for trial in best}
    wholes = {whole for whole, parts in WHOLES.items() if named & parts}
    return tuple(trial for trial in best if trial.suspect not in wholes)


def _is_impossible(trial: Trial) -> bool:
    """Tell whether the estimated error is of a size that no such sensor has."""
    if trial.suspect == "dvl-scale" and trial.found is not None:
        return not LEAST_SCALE < 1 + trial.found < MOST_SCALE
    if trial.suspect == "dvl-clock" and trial.found is not None:
        return abs(trial.found) > MOST_DELAY_S
    if trial.suspect.startswith("readout") and trial.found is not None:
        return not LEAST_READOUT_S < trial.found < MOST_READOUT_S
    return False


def _solved(problem: native.Problem, settings: native.Options) -> tuple[float, native.Unknowns]:
    """Solve without labels, and return the robust chi-square at the solution with the solution."""
    naive = replace(settings, method="naive")
    result = native.solve(
        problem, replace(naive, max_iterations=ITERATIONS, function_tolerance=TOLERANCE)
    )
    return _chi2(problem.started_from(result.unknowns), naive), result.unknowns


def _chi2(problem: native.Problem, settings: native.Options) -> float:
    """Compute the robust chi-square of a problem at its start values: twice the cost."""
    return 2 * sum(native.evaluate(problem, settings, jacobian=False).cost_by_factor.values())
