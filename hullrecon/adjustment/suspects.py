# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whose error explains that the measurements of a dive contradict each other (docs/methods.md 6).

Each sensor in turn is left out of the solved path, or what it may be wrong in becomes unknown, and
the path is solved again: who, left out, makes the rest agree?
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.adjustment.readout import RowMotion
from hullrecon.findings.adjustment import CORRECTED
from hullrecon.geometry.frames import Camera
from hullrecon.typing import Array

LEFT_OUT = 1e3  # by which the sigmas of a measurement that is left out grow
FREE_SHARE, FREE_RAD, FREE_M = 1.0, 1.0, 1.0  # prior sigmas of what becomes unknown
FREE_DRIFT_RAD_S, FREE_DEPTH_M = 0.01, 10.0
LEAST_SLOPE = 1e-3  # of depths by the path's; less stand still
LOOSE_TRAY_RAD = np.radians(10.0)  # of each reading of the tray: its angles are not forgotten
ITERATIONS = 50  # of a trial, which starts at the solved path
TOLERANCE = 1e-5
HELD, HELD_PX = 1e-6, 1e-3  # prior sigmas of intrinsics that stay
READOUT_S = 0.01  # of a trial on either side of none; cameras have 5 to 50 ms
SLOPE_S = 0.002  # for derivatives by the readout time
# A suspect explains as much as the best if so large a share of the contradiction is gone without it
EXPLAINS = 0.9
CERTAIN = 3.0  # sigmas of the squares that rows without error take with them when they are left out
FOCAL, CENTER, RADIAL = slice(0, 2), slice(2, 4), slice(4, 6)  # of a camera's intrinsics
SCALE, DRIFT, ROLL, PITCH, DEPTH = range(5)  # places among the errors of navigation
# Truth over what a DVL measured, beyond which its scale explains nothing: feet are 3.28 to a metre
LEAST_SCALE, MOST_SCALE = 0.25, 4.0
# Readout times that cameras have [s]; less moves features by less than calibrations are wrong
LEAST_READOUT_S, MOST_READOUT_S = 0.005, 0.2
# Suspects as a whole, by their own errors
WHOLES = {
    "pressure": {"pressure-scale"},
    "dvl-velocities": {"dvl-scale", "dvl-mount"},
    "focal-length": {"focal-length-top", "focal-length-bottom"},
    "principal-point": {"principal-point-bottom"},
}


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A suspect, and what of a contradiction is gone without it."""

    suspect: str  # a key of SUSPECTS of hullrecon/findings/adjustment.py
    gain: float  # squares of residuals that are gone, beyond those of the rows left out
    rows: int  # measurements that are left out, or unknowns that are freed
    found: float | None  # its own error by the rest: share, rad; None where it was left out

    @property
    def is_certain(self) -> bool:
        """Tell whether more is gone than noise explains."""
        return self.gain > self.spread

    @property
    def spread(self) -> float:
        """Compute the spread of `gain` where the rows left out have no error."""
        return float(CERTAIN * np.sqrt(2 * self.rows))

    @property
    def corrects(self) -> bool:
        """Tell whether the adjustment can take this suspect's error out."""
        return self.suspect in CORRECTED


@dataclass(frozen=True)
class _Suspect:
    name: str
    doubt: Callable[[native.Problem], native.Problem]  # leaves it out, or frees its own unknowns
    rows: int  # of measurements that are left out, or unknowns that are freed
    # its own error (problem, solution), where that was freed
    found: Callable[[native.Problem, native.Unknowns], float] | None = None


def try_suspects(
    problem: native.Problem, settings: native.Options, by_row: RowMotion
) -> tuple[Trial, ...]:
    """Solve a path again without each suspect, the best explanation first.

    Parameters
    ----------
    problem
        A round without the CAD model at its solution, its priors as the package states them.
    settings
        Of its solve.
    by_row
        How its features move if images are read out row by row.
    """
    before = _solved(problem, settings)[0]
    trials = [_try(suspect, problem, settings, before) for suspect in _suspects(problem)]
    trials += _try_depths(problem, settings, before)
    trials += [
        _try_readout(name, cameras, problem, settings, before, by_row)
        for name, cameras in _readouts(problem).items()
    ]
    return tuple(sorted(trials, key=lambda trial: -trial.gain))


def least_gain(problem: native.Problem, settings: native.Options, by_row: RowMotion) -> float:
    """Bound from below how many squares a readout time explains, without a solve.

    The sum of squares is taken as a parabola of the readout time, with all other unknowns held. At
    the solution its slope is right. Its curvature is too large, since other unknowns would follow:
    some twenty times on two legs. So its minimum is not as low as the true one.
    """
    naive = replace(settings, method="naive")
    gains, here = [0.0], _squares(problem, naive)
    for cameras in _readouts(problem).values():
        less, more = (
            _squares(by_row.moved(problem, readout_s, cameras), naive)
            for readout_s in (-SLOPE_S, SLOPE_S)
        )
        curvature = more + less - 2 * here
        if curvature > 0:
            gains.append(float((more - less) ** 2 / (8 * curvature)))
    return max(gains)


def _readouts(problem: native.Problem) -> dict[str, Sequence[Camera]]:
    """List whose rows may have been exposed one after another: all cameras', or one's of two."""
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
    """Solve with features moved for some readout times; the squares are a parabola of it.

    Where its minimum lies beyond the times that are tried, these are laid around it once more.
    """

    def squares(readout_s: float) -> float:
        return _solved(by_row.moved(problem, readout_s, cameras), settings)[0]

    middle_s, here = 0.0, before
    while True:
        less, more = squares(middle_s - READOUT_S), squares(middle_s + READOUT_S)
        slope, curvature = (more - less) / 2, more + less - 2 * here
        step = -slope / curvature if curvature > 0 else 0.0
        found_s = middle_s + READOUT_S * step
        if middle_s or abs(step) < 1 or not LEAST_READOUT_S < found_s < MOST_READOUT_S:
            break
        middle_s, here = found_s, squares(found_s)
    left = here + slope * step + curvature * step**2 / 2
    return Trial(suspect=name, gain=before - left - 1, rows=1, found=found_s)


def _try_depths(problem: native.Problem, settings: native.Options, before: float) -> list[Trial]:
    """Solve without depths, and with depths that a line makes of them. Nothing without any.

    Readings that follow no depth stand still but for their noise, which costs them as much.
    """
    depth, sigma_m = problem.attitude.measured[:, 0], problem.attitude.sigma[:, 0]
    if not np.isfinite(sigma_m).any():
        return []
    squares, unknowns = _solved(_without_attitude(problem, [0]), settings)
    weight = 1 / sigma_m**2
    still = float(weight @ (depth - np.average(depth, weights=weight)) ** 2) + 1
    left_out = Trial(
        suspect="pressure",
        gain=before - squares - min(still, len(depth)),
        rows=len(depth),
        found=None,
    )
    path_m = _depths_of_path(problem.started_from(unknowns), settings)
    slope = _slope(path_m, depth, weight)
    if abs(slope) < LEAST_SLOPE:
        return [left_out]
    scaled, _ = _solved(_with_depths(problem, 1 / slope), settings)
    own = Trial(suspect="pressure-scale", gain=before - scaled - 2, rows=2, found=1 / slope)
    return [left_out, own]


def _depths_of_path(problem: native.Problem, settings: native.Options) -> Array:
    """Compute the depths (m,) that a path has where the pressure sensor was read."""
    rows = problem.attitude
    at = native.evaluate(problem, replace(settings, method="naive"), jacobian=False)
    whitened = at.residual[at.factor == native.FACTORS.index("attitude")].reshape(-1, 3)[:, 0]
    return np.asarray(whitened * rows.sigma[:, 0] + rows.measured[:, 0])


def _slope(x: Array, y: Array, weight: Array) -> float:
    """Fit y (n,) = slope * x + constant by weighted least squares; 0 where x stands still."""
    from_mean = x - np.average(x, weights=weight)
    spread = weight @ from_mean**2
    return float((weight * from_mean) @ y / spread) if spread > 0 else 0.0


def _with_depths(problem: native.Problem, factor: float) -> native.Problem:
    """Multiply the depths and their sigmas, with a constant that is unknown."""
    measured, sigma = problem.attitude.measured.copy(), problem.attitude.sigma.copy()
    measured[:, 0] *= factor
    sigma[:, 0] *= abs(factor)
    rows = replace(problem.attitude, measured=measured, sigma=sigma)
    return _free_navigation({DEPTH: FREE_DEPTH_M})(replace(problem, attitude=rows))


def _try(
    suspect: _Suspect, problem: native.Problem, settings: native.Options, before: float
) -> Trial:
    """Solve without a suspect. before: squares of the residuals with it."""
    squares, unknowns = _solved(suspect.doubt(problem), settings)
    return Trial(
        suspect=suspect.name,
        gain=before - squares - suspect.rows,
        rows=suspect.rows,
        found=None if suspect.found is None else suspect.found(problem, unknowns),
    )


def best_explanations(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """Choose the trial that explains most, and those that explain as much.

    A sensor as a whole is not named where one of its own errors explains as much.
    """
    certain = [trial for trial in trials if trial.is_certain and not _is_absurd(trial)]
    if not certain:
        return ()
    enough = EXPLAINS * certain[0].gain - certain[0].spread
    best = [trial for trial in certain if trial.gain >= enough]
    named = {trial.suspect for trial in best}
    wholes = {whole for whole, parts in WHOLES.items() if named & parts}
    return tuple(trial for trial in best if trial.suspect not in wholes)


def _is_absurd(trial: Trial) -> bool:
    """Tell whether a suspect's own error is one that no sensor has."""
    if trial.suspect == "dvl-scale" and trial.found is not None:
        return not LEAST_SCALE < 1 + trial.found < MOST_SCALE
    if trial.suspect.startswith("readout") and trial.found is not None:
        return not LEAST_READOUT_S < trial.found < MOST_READOUT_S
    return False


def _solved(problem: native.Problem, settings: native.Options) -> tuple[float, native.Unknowns]:
    """Solve, and sum the robust squares of all whitened residuals."""
    naive = replace(settings, method="naive")
    result = native.solve(
        problem, replace(naive, max_iterations=ITERATIONS, function_tolerance=TOLERANCE)
    )
    return _squares(problem.started_from(result.unknowns), naive), result.unknowns


def _squares(problem: native.Problem, settings: native.Options) -> float:
    return 2 * sum(native.evaluate(problem, settings, jacobian=False).cost_by_factor.values())


def _suspects(problem: native.Problem) -> list[_Suspect]:
    """List the suspects that a problem has."""
    has_images = len(problem.stereo.node) + len(problem.mono.node) > 0
    steps = len(problem.odometry.first)
    found = [
        _Suspect("dvl-scale", _free_navigation({SCALE: FREE_SHARE}), 1, _scale),
        _Suspect("tray", _loosen_tray, len(problem.tray.node)),
    ]
    if problem.priors.T_s_d is not None:
        found.append(_Suspect("dvl-mount", _free_mount("T_s_d"), 3, _turn("T_s_d")))
    biases = _free_navigation({DRIFT: FREE_DRIFT_RAD_S, ROLL: FREE_RAD, PITCH: FREE_RAD})
    found.append(_Suspect("imu", biases, 3, _tilt))
    if len(problem.plane_ranges.plane):
        found.append(_Suspect("dvl-ranges", _without_planes, len(problem.plane_ranges.plane)))
    if len(problem.positions.node):
        found.append(_Suspect("positions", _without_positions, 2 * len(problem.positions.node)))
    if not has_images:
        return found
    found.append(_Suspect("dvl-velocities", _without_velocities, 3 * steps))
    found += _lenses(problem)
    if problem.priors.T_s_ct is not None:
        found.append(_Suspect("camera-mount", _free_mount("T_s_ct"), 6, _turn("T_s_ct")))
    if len(problem.stereo.node):
        found.append(_Suspect("stereo-rig", _free_stereo_rig, 6, _baseline))
    return found


def _lenses(problem: native.Problem) -> list[_Suspect]:
    """List what may be wrong in both calibrations, or in one of the two."""
    cameras = ["intrinsics_top"]
    if len(problem.stereo.node) or (problem.mono.camera == 1).any():
        cameras.append("intrinsics_bottom")
    both = tuple(cameras)
    found = [
        _Suspect("focal-length", _free_intrinsics(FOCAL, both), 2 * len(both), _focal_ratio(both)),
        _Suspect(
            "principal-point", _free_intrinsics(CENTER, both), 2 * len(both), _center_shift(both)
        ),
        _Suspect("distortion", _free_intrinsics(RADIAL, both), 2 * len(both)),
    ]
    if len(both) == 1:
        return found
    for name, key in (("top", "intrinsics_top"), ("bottom", "intrinsics_bottom")):
        own = _free_intrinsics(FOCAL, (key,))
        found.append(_Suspect(f"focal-length-{name}", own, 2, _focal_ratio((key,))))
    # That of the top camera is told from the bottom one's by the mount alone.
    own = _free_intrinsics(CENTER, ("intrinsics_bottom",))
    shift = _center_shift(("intrinsics_bottom",))
    return [*found, _Suspect("principal-point-bottom", own, 2, shift)]


def _free_navigation(
    sigma: Mapping[int, float],
) -> Callable[[native.Problem], native.Problem]:
    """Prepare to widen the sigmas of some errors of navigation to these, by place."""

    def free(problem: native.Problem) -> native.Problem:
        wide = problem.priors.navigation_sigma.copy()
        for place, value in sigma.items():
            wide[place] = max(wide[place], value)
        return replace(problem, priors=replace(problem.priors, navigation_sigma=wide))

    return free


def _free_mount(block: str) -> Callable[[native.Problem], native.Problem]:
    """Prepare to widen the prior of a mount, by its block of the problem."""

    def free(problem: native.Problem) -> native.Problem:
        prior = getattr(problem.priors, block)
        loose = np.diag(np.r_[np.full(3, 1 / FREE_M), np.full(3, 1 / FREE_RAD)])
        if block == "T_s_d":  # its position is held: nothing sees it
            loose[:3] = prior.sqrt_information[:3]
        wide = replace(prior, sqrt_information=loose)
        return replace(problem, priors=replace(problem.priors, **{block: wide}))

    return free


def _free_stereo_rig(problem: native.Problem) -> native.Problem:
    """Make the stereo rig an unknown with a wide prior."""
    value = problem.unknowns.T_ct_cb
    if problem.priors.T_ct_cb is not None:
        value = problem.priors.T_ct_cb.value
    length_m = max(float(np.linalg.norm(value[:3])), 1e-6)
    loose = np.diag(np.r_[np.full(3, 1 / (FREE_SHARE * length_m)), np.full(3, 1 / FREE_RAD)])
    wide = native.MotionPrior(value=value, sqrt_information=loose)
    return replace(problem, priors=replace(problem.priors, T_ct_cb=wide)).free("T_ct_cb")


def _free_intrinsics(
    places: slice, cameras: Sequence[str]
) -> Callable[[native.Problem], native.Problem]:
    """Prepare to make some intrinsics of cameras unknown (focal lengths, centre or distortion).

    The others are held, by very small sigmas.
    """

    def free(problem: native.Problem) -> native.Problem:
        sigma = np.r_[np.full(4, HELD_PX), np.full(5, HELD)]
        pixels = places != RADIAL
        sigma[places] = FREE_SHARE * (problem.unknowns.intrinsics_top[FOCAL] if pixels else 1.0)
        priors = replace(problem.priors, intrinsics_sigma=sigma)
        return replace(problem, priors=priors).free(*cameras)

    return free


def _without_attitude(problem: native.Problem, columns: Sequence[int]) -> native.Problem:
    sigma = problem.attitude.sigma.copy()
    sigma[:, columns] *= LEFT_OUT
    return replace(problem, attitude=replace(problem.attitude, sigma=sigma))


def _loosen_tray(problem: native.Problem) -> native.Problem:
    sigma = np.hypot(problem.tray.sigma, LOOSE_TRAY_RAD)
    return replace(problem, tray=replace(problem.tray, sigma=sigma))


def _without_planes(problem: native.Problem) -> native.Problem:
    return replace(
        problem, plane_ranges=native.PlaneRangeTable(), plane_pairs=native.PlanePairTable()
    )


def _without_positions(problem: native.Problem) -> native.Problem:
    sigma = LEFT_OUT * problem.positions.sigma
    return replace(problem, positions=replace(problem.positions, sigma=sigma))


def _without_velocities(problem: native.Problem) -> native.Problem:
    rows = problem.odometry.sqrt_information.copy()
    rows[:, :3] /= LEFT_OUT
    return replace(problem, odometry=replace(problem.odometry, sqrt_information=rows))


def _scale(_: native.Problem, unknowns: native.Unknowns) -> float:
    return float(unknowns.navigation[SCALE])


def _tilt(_: native.Problem, unknowns: native.Unknowns) -> float:
    return float(np.hypot(unknowns.navigation[ROLL], unknowns.navigation[PITCH]))


def _turn(block: str) -> Callable[[native.Problem, native.Unknowns], float]:
    """Prepare to tell by which angle, rad, a solve turned a mount from its prior."""

    def turn(problem: native.Problem, unknowns: native.Unknowns) -> float:
        nominal = Rotation.from_quat(getattr(problem.priors, block).value[3:])
        found = Rotation.from_quat(getattr(unknowns, block)[3:])
        return float((nominal.inv() * found).magnitude())

    return turn


def _focal_ratio(cameras: Sequence[str]) -> Callable[[native.Problem, native.Unknowns], float]:
    """Take the ratio of focal lengths, of cameras and axes, that is farthest from one."""

    def ratio(problem: native.Problem, unknowns: native.Unknowns) -> float:
        ratios = np.concatenate(
            [getattr(unknowns, c)[FOCAL] / getattr(problem.unknowns, c)[FOCAL] for c in cameras]
        )
        return float(ratios[np.abs(ratios - 1).argmax()])

    return ratio


def _center_shift(cameras: Sequence[str]) -> Callable[[native.Problem, native.Unknowns], float]:
    """Prepare to tell by how many pixels a solve moved the principal points of cameras."""

    def shift_px(problem: native.Problem, unknowns: native.Unknowns) -> float:
        shifts = [
            getattr(unknowns, c)[CENTER] - getattr(problem.unknowns, c)[CENTER] for c in cameras
        ]
        return float(np.linalg.norm(shifts, axis=1).max())

    return shift_px


def _baseline(problem: native.Problem, unknowns: native.Unknowns) -> float:
    before, after = (np.linalg.norm(of.T_ct_cb[:3]) for of in (problem.unknowns, unknowns))
    return float(after / before - 1)
