# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The suspects of a problem, and how it is solved without each or with its error as an unknown.

See docs/methods.md 6. suspects.py tries them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.typing import Array

LEFT_OUT = 1e3  # factor of the sigmas of a measurement that is left out
# Prior sigmas of errors that become unknowns: a share of a length, rad, m
FREE_SHARE, FREE_RAD, FREE_M = 1.0, 1.0, 1.0
FREE_DRIFT_RAD_S, FREE_DEPTH_M = 0.01, 10.0
LOOSE_TRAY_RAD = np.radians(10.0)  # sigma of a tray angle under suspicion, which is not left out
HELD, HELD_PX = 1e-6, 1e-3  # prior sigmas of intrinsics that are held
FOCAL, CENTER, RADIAL = slice(0, 2), slice(2, 4), slice(4, 6)  # of a camera's intrinsics
SCALE, DRIFT, ROLL, PITCH, DEPTH = range(5)  # indices of the errors of navigation


@dataclass(frozen=True)
class Suspect:
    """A sensor that may be wrong, or one error of it, and how to solve a path without it."""

    name: str  # a key of SUSPECTS of hullrecon/findings/adjustment.py
    doubt: Callable[[native.Problem], native.Problem]  # leave the sensor out, or free its error
    rows: int  # number of measurements that are left out, or of unknowns that are freed
    # Reads the estimated error from problem and solution. None where the sensor is left out
    found: Callable[[native.Problem, native.Unknowns], float] | None = None


def has_images(problem: native.Problem) -> bool:
    """Tell whether cameras observe landmarks of a problem."""
    return len(problem.stereo.node) + len(problem.mono.node) > 0


def list_suspects(problem: native.Problem) -> list[Suspect]:
    """List the suspects of a problem: sensors whose measurements it holds, and their errors.

    Depths and readout times are tried by functions of their own (`try_suspects`).
    """
    steps = len(problem.odometry.first)
    found = [
        Suspect("dvl-scale", free_navigation({SCALE: FREE_SHARE}), 1, _found_scale),
        Suspect("tray", _loosen_tray, len(problem.tray.node)),
    ]
    if problem.priors.T_s_d is not None:
        found.append(Suspect("dvl-mount", _free_mount("T_s_d"), 3, _turn("T_s_d")))
    biases = free_navigation({DRIFT: FREE_DRIFT_RAD_S, ROLL: FREE_RAD, PITCH: FREE_RAD})
    found.append(Suspect("imu", biases, 3, _found_tilt))
    if len(problem.plane_ranges.plane):
        found.append(Suspect("dvl-ranges", _without_planes, len(problem.plane_ranges.plane)))
    if len(problem.positions.node):
        found.append(Suspect("positions", _without_positions, 2 * len(problem.positions.node)))
    # Without images only velocities and turns give the path, and cannot be left out
    if not has_images(problem):
        return found
    found.append(Suspect("dvl-velocities", _without_velocities, 3 * steps))
    found.append(Suspect("imu-turns", _without_turns, 3 * steps))
    found += _lenses(problem)
    if problem.priors.T_s_ct is not None:
        found.append(Suspect("camera-mount", _free_mount("T_s_ct"), 6, _turn("T_s_ct")))
    if len(problem.stereo.node):
        found.append(Suspect("stereo-rig", _free_stereo_rig, 6, _baseline_change))
    return found


def _lenses(problem: native.Problem) -> list[Suspect]:
    """List the suspected errors of the lens calibrations, of both cameras or of one of the two."""
    cameras = ["intrinsics_top"]
    if len(problem.stereo.node) or (problem.mono.camera == 1).any():
        cameras.append("intrinsics_bottom")
    both = tuple(cameras)
    found = [
        Suspect("focal-length", _free_intrinsics(FOCAL, both), 2 * len(both), _focal_ratio(both)),
        Suspect(
            "principal-point", _free_intrinsics(CENTER, both), 2 * len(both), _center_shift(both)
        ),
        Suspect(
            "distortion",
            _free_intrinsics(RADIAL, both),
            2 * len(both),
            _distortion_change(both),
        ),
    ]
    if len(both) == 1:
        return found
    for name, key in (("top", "intrinsics_top"), ("bottom", "intrinsics_bottom")):
        own = _free_intrinsics(FOCAL, (key,))
        found.append(Suspect(f"focal-length-{name}", own, 2, _focal_ratio((key,))))
    # A wrong principal point of the top camera is left out: only the mount's prior would
    # distinguish it from one of the bottom camera.
    own = _free_intrinsics(CENTER, ("intrinsics_bottom",))
    shift = _center_shift(("intrinsics_bottom",))
    return [*found, Suspect("principal-point-bottom", own, 2, shift)]


def free_navigation(
    sigma: Mapping[int, float],
) -> Callable[[native.Problem], native.Problem]:
    """Make a function that widens the prior sigmas of errors of navigation.

    sigma: the least sigma of an error, by its index.
    """

    def free(problem: native.Problem) -> native.Problem:
        """Widen the priors of the problem's navigation errors."""
        wide = problem.priors.navigation_sigma.copy()
        for index, value in sigma.items():
            wide[index] = max(wide[index], value)
        return replace(problem, priors=replace(problem.priors, navigation_sigma=wide))

    return free


def _free_mount(block: str) -> Callable[[native.Problem], native.Problem]:
    """Make a function that widens the prior of the mount in a block of the problem."""

    def free(problem: native.Problem) -> native.Problem:
        """Widen the prior of the mount to FREE_M and FREE_RAD."""
        prior = getattr(problem.priors, block)
        loose = np.diag(np.r_[np.full(3, 1 / FREE_M), np.full(3, 1 / FREE_RAD)])
        if block == "T_s_d":  # the DVL's position is held, as no measurement determines it
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
    entries: slice, cameras: Sequence[str]
) -> Callable[[native.Problem], native.Problem]:
    """Make a function that makes some intrinsics of cameras unknowns, and holds the others.

    Parameters
    ----------
    entries
        FOCAL, CENTER or RADIAL. The others are held by very small prior sigmas.
    cameras
        Blocks of the problem, as "intrinsics_top".
    """

    def free(problem: native.Problem) -> native.Problem:
        """Make the intrinsics unknowns, with wide priors of the entries and tight ones else."""
        # four in pixels (focal lengths, principal point), then five coefficients of distortion
        sigma = np.r_[np.full(4, HELD_PX), np.full(5, HELD)]
        in_pixels = entries != RADIAL
        sigma[entries] = FREE_SHARE * (problem.unknowns.intrinsics_top[FOCAL] if in_pixels else 1.0)
        priors = replace(problem.priors, intrinsics_sigma=sigma)
        return replace(problem, priors=priors).free(*cameras)

    return free


def without_attitude(problem: native.Problem, columns: Sequence[int]) -> native.Problem:
    """Leave out some angles of the attitude sensor, by sigmas so large that they do not count.

    columns: of the table's sigmas.
    """
    sigma = problem.attitude.sigma.copy()
    sigma[:, columns] *= LEFT_OUT
    return replace(problem, attitude=replace(problem.attitude, sigma=sigma))


def _loosen_tray(problem: native.Problem) -> native.Problem:
    """Let the tray's angle be off by LOOSE_TRAY_RAD at each node."""
    sigma = np.hypot(problem.tray.sigma, LOOSE_TRAY_RAD)
    return replace(problem, tray=replace(problem.tray, sigma=sigma))


def _without_planes(problem: native.Problem) -> native.Problem:
    """Leave out the planes that the DVL saw."""
    return replace(
        problem, plane_ranges=native.PlaneRangeTable(), plane_pairs=native.PlanePairTable()
    )


def _without_positions(problem: native.Problem) -> native.Problem:
    """Leave out positions from outside, by sigmas so large that they do not count."""
    sigma = LEFT_OUT * problem.positions.sigma
    return replace(problem, positions=replace(problem.positions, sigma=sigma))


def _without_velocities(problem: native.Problem) -> native.Problem:
    """Leave out the translations of the odometry, which the DVL's velocities tell."""
    rows = problem.odometry.sqrt_information.copy()
    rows[:, :3] /= LEFT_OUT
    return replace(problem, odometry=replace(problem.odometry, sqrt_information=rows))


def _without_turns(problem: native.Problem) -> native.Problem:
    """Leave out the odometry's rotations. Its upper rows hold what the velocities tell alone."""
    rows = problem.odometry.sqrt_information.copy()
    rows[:, 3:] /= LEFT_OUT
    return replace(problem, odometry=replace(problem.odometry, sqrt_information=rows))


def _found_scale(_: native.Problem, unknowns: native.Unknowns) -> float:
    """Read the DVL's scale error that a solve found."""
    return float(unknowns.navigation[SCALE])


def _found_tilt(_: native.Problem, unknowns: native.Unknowns) -> float:
    """Compute the size, rad, of the error in roll and pitch that a solve found."""
    return float(np.hypot(unknowns.navigation[ROLL], unknowns.navigation[PITCH]))


def _turn(block: str) -> Callable[[native.Problem, native.Unknowns], float]:
    """Make a function that computes by which angle, rad, a solve turned a mount from its prior.

    block: the mount's field in the priors and in the unknowns.
    """

    def turn(problem: native.Problem, unknowns: native.Unknowns) -> float:
        """Compute the angle, rad, between the mount's prior and the solution."""
        nominal = Rotation.from_quat(getattr(problem.priors, block).value[3:])
        found = Rotation.from_quat(getattr(unknowns, block)[3:])
        return float((nominal.inv() * found).magnitude())

    return turn


def _focal_ratio(cameras: Sequence[str]) -> Callable[[native.Problem, native.Unknowns], float]:
    """Make a function that computes the ratio of estimated to calibrated focal lengths.

    Of all cameras and both axes, it takes the ratio that is farthest from one.
    """

    def ratio(problem: native.Problem, unknowns: native.Unknowns) -> float:
        """Compute the ratio of solved to calibrated focal length that is farthest from one."""
        ratios = np.concatenate(
            [getattr(unknowns, c)[FOCAL] / getattr(problem.unknowns, c)[FOCAL] for c in cameras]
        )
        return float(ratios[np.abs(ratios - 1).argmax()])

    return ratio


def _center_shift(cameras: Sequence[str]) -> Callable[[native.Problem, native.Unknowns], float]:
    """Make a function that computes by how many pixels a solve moved a principal point at most."""

    def shift_px(problem: native.Problem, unknowns: native.Unknowns) -> float:
        """Compute the largest distance, px, between a solved and a calibrated principal point."""
        shifts = [
            getattr(unknowns, c)[CENTER] - getattr(problem.unknowns, c)[CENTER] for c in cameras
        ]
        return float(np.linalg.norm(shifts, axis=1).max())

    return shift_px


def _distortion_change(
    cameras: Sequence[str],
) -> Callable[[native.Problem, native.Unknowns], float]:
    """Make a function that computes by how many pixels, rms, another distortion moves features.

    A part that another focal length explains is left out, as every calibration finds that. Of
    several cameras, it takes the one that is moved most. cameras: blocks of the problem, as
    "intrinsics_top".
    """

    def change_px(problem: native.Problem, unknowns: native.Unknowns) -> float:
        """Compute the rms, px, by which distortions part, of the camera that is moved most."""
        return max(
            _nonlinear_rms(
                _pixels(problem, block), getattr(problem.unknowns, block), getattr(unknowns, block)
            )
            for block in cameras
        )

    return change_px


def _pixels(problem: native.Problem, block: str) -> Array:
    """Collect the pixels (n, 2) of the features of one camera."""
    column = ("intrinsics_top", "intrinsics_bottom").index(block)
    of_pairs = problem.stereo.pixel[:, 2 * column : 2 * column + 2]
    return np.concatenate([of_pairs, problem.mono.pixel[problem.mono.camera == column]])


def _nonlinear_rms(pixels: Array, before: Array, after: Array) -> float:
    """Compute the rms, px, by which two distortions part at pixels (n, 2), but for a scale.

    Zero without pixels. before, after: intrinsics (9,), of which the radial coefficients differ.
    """
    if not len(pixels):
        return 0.0
    from_center = pixels - before[CENTER]
    square = np.sum((from_center / before[FOCAL]) ** 2, axis=1, keepdims=True)
    first, second = after[RADIAL] - before[RADIAL]
    moved = from_center * (first * square + second * square**2)
    scale = np.sum(moved * from_center) / np.sum(from_center**2)
    return float(np.sqrt(np.mean(np.sum((moved - scale * from_center) ** 2, axis=1))))


def _baseline_change(problem: native.Problem, unknowns: native.Unknowns) -> float:
    """Compute the share by which a solve made the stereo baseline longer."""
    before, after = (np.linalg.norm(of.T_ct_cb[:3]) for of in (problem.unknowns, unknowns))
    return float(after / before - 1)
