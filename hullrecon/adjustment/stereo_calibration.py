# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Test whether a dive contradicts the calibration of its stereo rig (docs/methods.md 6).

Where it does, the relative pose of the two cameras becomes an unknown. The images of a dive
determine the bottom camera's rotation and the direction of the baseline better than a calibration
does, but not the baseline's length. The length follows from DVL and depths, and the DVL may be as
wrong as the calibration.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon.adjustment.partition import join
from hullrecon.adjustment.problem import weighting
from hullrecon.adjustment.problem.state import Weights
from hullrecon.adjustment.rounds import Estimate, Phase, RoundSolver, Verdict
from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses
from hullrecon.rig import Rig
from hullrecon.typing import Array

TRIAL_ANCHORS = 5000  # landmarks of a trial: enough for six unknowns that all images share
# Prior sigmas of the stereo mount in a trial: of its rotation, and of its position as a share of
# the baseline's length
TRIAL_TURN_RAD = np.radians(1.0)
TRIAL_SHARE = 0.1
# Beyond these the calibration is contradicted: by rotation and direction of the baseline together,
# with five degrees of freedom (five sigmas in each), and by the baseline's length
MAX_CHI2 = 125.0
MAX_LENGTH_SIGMAS = 3.5
HELD = 1e-6  # prior sigma, m and rad, of what is held
# A turn, and a shift as a share of the baseline, that a good calibration may be off by: no warning
REPORTED_TURN_RAD = np.radians(0.03)
REPORTED_SHARE = 0.005
LEAST_SHOWN_MM, LEAST_SHOWN_DEG = 0.05, 0.005  # smaller ones round to zero in a sentence
DVL_SCALE = 0  # index of the DVL's scale among the errors of navigation


@dataclass(frozen=True, kw_only=True)
class StereoContradiction:
    """The difference between a dive's stereo rig and its calibration."""

    # True: by the images, the rotation or the direction of the baseline is not as calibrated.
    # False: only lengths by stereo and by the DVL disagree
    by_images: bool
    turn_rad: float  # of the bottom camera
    shift_m: float  # of the bottom camera
    direction_rad: float  # of the baseline
    length: float  # share by which the baseline is longer than calibrated


def free_contradicted_rig(path: Phase, solver: RoundSolver) -> Phase | None:
    """Make the stereo rig an unknown where the dive contradicts its calibration.

    A trial round solves the path with a wide prior of the stereo mount. None where the estimate
    agrees with the calibration (MAX_CHI2, MAX_LENGTH_SIGMAS), where it cannot be determined, or
    without a second camera.
    """
    solved = path.estimate
    rig = solved.measured.rig
    calibrated = rig.stereo_mount
    if calibrated is None:
        return None
    loose = np.r_[np.full(3, TRIAL_SHARE * rig.baseline_m), np.full(3, TRIAL_TURN_RAD)]
    quiet = replace(solver, anchors=TRIAL_ANCHORS, report=lambda _: None, history=[])
    trial = quiet.solve_round(
        _with_rig(solved, rig.with_priors(top_from_bottom=_sqrt_information(calibrated, loose)))
    )
    found = trial.after.state.mounts.top_from_bottom
    if found is None or not len(trial.problem.stereo.node):
        return None
    try:
        naive = replace(solver.settings, method="naive")
        marginals = join.covariance(trial.problem, trial.plan, naive, of_landmarks=False)
    except StageError:
        return None  # an unknown is not determined at all; the last round reports which
    contradiction = compare_rigs(calibrated, found, marginals.T_ct_cb + _prior_covariance(rig))
    if contradiction is None:
        return None
    solver.report(f"the stereo rig is an unknown: {describe_contradiction(contradiction)}")
    solver.history.append(trial.history)
    return Phase.of(
        (trial,), _free_contradicted(trial.after, rig, contradiction), Verdict(stereo=contradiction)
    )


def compare_rigs(calibrated: Poses, found: Poses, covariance: Array) -> StereoContradiction | None:
    """Compare an estimated stereo mount with the calibrated mount. None where they agree.

    Parameters
    ----------
    calibrated, found
        Poses top_from_bottom, as calibrated and as estimated.
    covariance
        (6, 6) of their difference (translation in the top camera's axes, rotation perturbed on the
        right), from both the estimate and the calibration.
    """
    shift = (found.translation - calibrated.translation)[0]
    turn = (calibrated.rotation.inv() * found.rotation).as_rotvec()[0]
    axes, length_m = _baseline_axes(calibrated)
    # What images determine: the baseline's direction, as two shifts across it, and the rotation
    to_five = np.zeros((5, 6))
    to_five[:2, :3], to_five[2:, 3:] = axes[1:], np.eye(3)
    five = to_five @ np.r_[shift, turn]
    chi2 = float(five @ np.linalg.solve(to_five @ covariance @ to_five.T, five))
    longer_m, sigma_m = (
        float(axes[0] @ shift),
        float(np.sqrt(axes[0] @ covariance[:3, :3] @ axes[0])),
    )
    if chi2 < MAX_CHI2 and abs(longer_m) < MAX_LENGTH_SIGMAS * sigma_m:
        return None
    return StereoContradiction(
        by_images=chi2 >= MAX_CHI2,
        turn_rad=float(np.linalg.norm(turn)),
        shift_m=float(np.linalg.norm(shift)),
        direction_rad=float(np.linalg.norm(five[:2])) / length_m,
        length=longer_m / length_m,
    )


def describe_contradiction(found: StereoContradiction) -> str:
    """Describe the contradiction in words without a full stop."""
    if found.by_images:
        turned = f"{np.degrees(found.turn_rad):.2f} degrees"
        if 1e3 * found.shift_m < LEAST_SHOWN_MM:
            return f"the images fit with the bottom camera turned by {turned} from its calibration"
        moved = (
            f"the images fit with the bottom camera {1e3 * found.shift_m:.1f} mm from where its "
            "calibration has it"
        )
        return (
            moved
            if np.degrees(found.turn_rad) < LEAST_SHOWN_DEG
            else f"{moved}, and turned by {turned}"
        )
    off = f"{100 * abs(found.length):.1f} % {_longer(found.length)}"
    return f"for the DVL's velocities the baseline would have to be {off} than calibrated"


def stereo_warning(
    found: StereoContradiction, calibrated: Poses, adjusted: Poses, covariance: Array
) -> str | None:
    """Write the warning for the report. None where the contradiction is too small to matter.

    Parameters
    ----------
    found
        The contradiction, which the warning describes.
    calibrated, adjusted
        Poses top_from_bottom, as calibrated and at the solution.
    covariance
        (6, 6) of `adjusted`, translation in the top camera's axes first.
    """
    axes, length_m = _baseline_axes(calibrated)
    sigma = float(np.sqrt(axes[0] @ covariance[:3, :3] @ axes[0])) / length_m
    known = f"lengths are known to {100 * sigma:.2g} % (one sigma)"
    if not found.by_images:
        cause = _who_is_wrong(
            found, float(np.linalg.norm(adjusted.translation)) / length_m - 1, sigma
        )
        return (
            f"Stereo images and the DVL disagree about lengths: {describe_contradiction(found)}. "
            f"Both were doubted, and {known}; {cause}."
        )
    if found.turn_rad < REPORTED_TURN_RAD and found.shift_m < REPORTED_SHARE * length_m:
        return None
    return (
        f"The stereo calibration does not hold: {describe_contradiction(found)}. Where the two "
        f"cameras are to each other was estimated, and {known}."
    )


def _who_is_wrong(found: StereoContradiction, longer: float, sigma: float) -> str:
    """Say whether stereo or DVL is wrong about lengths, judged by all measurements together.

    The baseline's prior was widened, so that the other measurements (depths) decide its length.

    Parameters
    ----------
    found
        The contradiction, with the length at which the DVL alone would have the baseline.
    longer
        Share by which the adjusted baseline is longer than calibrated.
    sigma
        Sigma of `longer`.
    """
    by_stereo, by_dvl = abs(longer) / sigma, abs(longer - found.length) / sigma
    if by_stereo > MAX_LENGTH_SIGMAS and by_dvl < MAX_LENGTH_SIGMAS:
        off = f"{100 * abs(longer):.1f} % {_longer(longer)}"
        return f"by all else that was measured it is {off}"
    if by_dvl > MAX_LENGTH_SIGMAS and by_stereo < MAX_LENGTH_SIGMAS:
        return "by all else that was measured it is as calibrated, and the DVL is wrong"
    return "nothing else tells which is wrong"


def _longer(share: float) -> str:
    return "longer" if share > 0 else "shorter"


def _baseline_axes(rig: Poses) -> tuple[Array, float]:
    """Compute the axes of a baseline (3, 3) and its length, m.

    The rows are unit vectors in the top camera's axes: along the baseline, then two across it.
    """
    length_m = float(np.linalg.norm(rig.translation))
    along = rig.translation[0] / length_m
    across = np.linalg.svd(along[None])[2][1:]
    return np.vstack([along, across]), length_m


def _sqrt_information(calibrated: Poses, sigma: Array) -> Array:
    """Compute the square root of information (6, 6) of a prior of the stereo mount.

    It is applied to a motion in the bottom camera's axes (`RigPriors`), and divides it by sigmas
    that are known along and across the baseline.

    sigma (6,): along the baseline and twice across it, m, and of the rotation, rad.
    """
    rows = np.zeros((6, 6))
    # From the bottom camera's axes to the top camera's, then to those of the baseline
    rows[:3, :3] = _baseline_axes(calibrated)[0] @ calibrated.rotation.as_matrix()[0]
    rows[3:, 3:] = np.eye(3)
    return np.asarray(rows / sigma[:, None])


def _prior_covariance(rig: Rig) -> Array:
    """Compute the prior covariance (6, 6) of the stereo mount, top_from_bottom, m and rad.

    Zeros where the mount is held. The package's prior is on a motion in the bottom camera's axes
    (`RigPriors`). Here its translation is turned into the top camera's, the order and sense of
    every covariance of docs/conventions.md.
    """
    sqrt_information = rig.priors.top_from_bottom
    if sqrt_information is None or rig.top_from_bottom is None:
        return np.zeros((6, 6))
    top_from_bottom_axes = np.eye(6)
    top_from_bottom_axes[:3, :3] = rig.top_from_bottom.rotation.as_matrix()[0]
    return np.asarray(
        top_from_bottom_axes
        @ np.linalg.inv(sqrt_information.T @ sqrt_information)
        @ top_from_bottom_axes.T
    )


def _with_rig(estimate: Estimate, rig: Rig) -> Estimate:
    return replace(estimate, measured=replace(estimate.measured, rig=rig))


def _free_contradicted(after: Estimate, calibrated: Rig, found: StereoContradiction) -> Estimate:
    """Widen the priors of what the dive contradicts.

    Where the images contradict the calibration, the whole stereo mount is freed: direction and
    rotation, which images determine, as wide as in the trial (`free_contradicted_rig`), the length
    by the size of the contradiction, as a baseline whose direction is wrong may be as wrong in
    length. Where only lengths disagree, the DVL may be as wrong as the rig. Then the baseline's
    length, the DVL's scale and the ranges are freed by the size of the contradiction.

    Parameters
    ----------
    after
        The estimate after the trial, the round with a wide prior of the stereo mount.
    calibrated
        The rig with the priors of the package.
    found
        The contradiction, whose size becomes the sigma of lengths.
    """
    mount, length_m = calibrated.top_from_bottom, calibrated.baseline_m
    assert mount is not None
    covariance, axes = _prior_covariance(calibrated), _baseline_axes(mount)[0]
    # The package's sigmas along and across the baseline and of the rotation, below which none goes
    along = np.diag(axes @ covariance[:3, :3] @ axes.T)
    least = np.maximum(np.sqrt(np.r_[along, np.diag(covariance[3:, 3:])]), HELD)
    if found.by_images:
        # Both are shares of the baseline: turned by a small angle, its end moves by that share
        length_sigma = max(abs(found.length), found.direction_rad)
        loose = np.r_[  # m along the baseline, m along two axes across it, rad of rotation
            length_sigma * length_m, np.full(2, TRIAL_SHARE * length_m), np.full(3, TRIAL_TURN_RAD)
        ]
        rows = _sqrt_information(mount, np.maximum(loose, least))
        return _with_rig(after, calibrated.with_priors(top_from_bottom=rows))
    length_sigma = abs(found.length)
    navigation_sigma = calibrated.priors.navigation_sigma.copy()
    navigation_sigma[DVL_SCALE] = max(navigation_sigma[DVL_SCALE], length_sigma)
    only_length = _sqrt_information(
        mount, np.maximum(np.r_[length_sigma * length_m, np.zeros(5)], least)
    )
    widened = _with_rig(
        after,
        calibrated.with_priors(top_from_bottom=only_length, navigation_sigma=navigation_sigma),
    )
    return replace(widened, weights=widen_ranges(after, length_sigma))


def widen_ranges(after: Estimate, share: float) -> Weights:
    """Widen the sigma of DVL ranges so that together they determine lengths no better than `share`.

    A wrong speed of sound scales all ranges alike, as it does the velocities, so that n ranges do
    not determine a length better than one.
    """
    returns = after.measured.returns
    if returns is None:
        return after.weights
    together_m = weighting.sigma_of_common_scale(returns.range_m, share)
    return replace(after.weights, range_sigma=max(after.weights.range_sigma, together_m))
