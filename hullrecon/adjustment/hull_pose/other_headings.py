# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Test whether a CAD model fits at another heading or height than the package's guess.

An IMU whose heading is off turns the whole path about its first pose, and a wrong heading of the
package's guess looks the same. Without position fixes (USBL, GNSS) nothing distinguishes the two.
Nor does anything distinguish a constant error of the depths from a wrong height of the guess.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.hull_pose.pose_cost import prior_step
from hullrecon.adjustment.hull_pose.registration import (
    GOOD_FITNESS,
    GUESS_SIGMAS,
    Registration,
    few_points,
    register_near,
)
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

STEP_DEG = 30  # between the headings that are tried: a registration converges from half of it
AIR_M, NEAR_AIR_M = 10.1, 0.7  # the air's pressure in metres of sea water, and how it varies


def stated_model(found: Registration) -> CadModel:
    """Return the registered CAD model with the guess's sigmas as the package states them.

    The registration has widened them by `sigmas_off`, where it contradicts the guess.
    """
    return replace(found.cad_model, guess_sigma=found.cad_model.guess_sigma / found.sigmas_off)


def turn_from_guess(found: Registration) -> float | None:
    """Compute the turn about g's z axis, rad, from the guess to the registered pose of the hull.

    Positive to starboard. None where the guess is not contradicted, or not in its heading alone.
    """
    return None if found.sigmas_off <= GUESS_SIGMAS else _turn_from(stated_model(found), found)


def height_below_guess(found: Registration) -> float | None:
    """Compute how far below the guess the hull lies, m.

    None where the guess is not contradicted, or not in its height alone.
    """
    if found.sigmas_off <= GUESS_SIGMAS:
        return None
    model = stated_model(found)
    step = prior_step(found.global_from_hull, model, found.center)
    down = model.guess.rotation.inv().apply([[0.0, 0.0, 1.0]])[0]  # of g, in M
    lower_m = float(down @ step[:3])
    rest = np.abs(np.r_[step[:3] - lower_m * down, step[3:]] / model.guess_sigma)
    return lower_m if rest.max() <= GUESS_SIGMAS else None


def _turn_from(cad_model: CadModel, found: Registration) -> float | None:
    """Compute the turn about g's z axis, rad, from a guess to a registered pose.

    The turn may be about the first pose of the path, as with a wrong IMU, or about the survey, as
    with a wrong guess. None where with neither the turned guess agrees with the registered pose to
    GUESS_SIGMAS.

    Parameters
    ----------
    cad_model
        The guess that is turned, and its stated sigmas, in which agreement is judged.
    found
        The registration, whose pose is compared with the turned guess.
    """
    at, center = found.global_from_hull, found.center
    turn = float((at.rotation * cad_model.guess.rotation.inv()).as_euler("ZYX")[0, 0])
    # Steps from the guess that the turn leaves: turned back about the first pose, about the survey
    turned_back, as_found = (
        prior_step(pose, cad_model, center) for pose in (_turned(at, -turn), at)
    )
    steps = np.stack([turned_back, np.r_[as_found[:3], turned_back[3:]]])
    sigmas = np.abs(steps / cad_model.guess_sigma).max(axis=1)
    return turn if sigmas.min() <= GUESS_SIGMAS else None


def find_fitting_heading(
    points: Array, cad_model: CadModel, range_sigma_m: float
) -> tuple[float, float] | None:
    """Register the CAD model to points (n, 3) in g with the guess turned by multiples of STEP_DEG.

    Returns the turn, rad, of the best fit, and the share of points that fit. None if the CAD model
    fits at no heading, or only far from the turned guess.
    """
    few = few_points(points)
    found: list[tuple[float, float]] = []
    for degrees in range(STEP_DEG, 360, STEP_DEG):
        other = replace(cad_model, guess=_turned(cad_model.guess, float(np.radians(degrees))))
        tried = register_near(few, other, range_sigma_m)
        turn = _turn_from(cad_model, tried)
        if tried.fitness >= GOOD_FITNESS and turn is not None:
            found.append((turn, tried.fitness))
    return max(found, key=lambda one: one[1], default=None)


def _turned(global_from_hull: Poses, turn: float) -> Poses:
    """Turn a hull by an angle, rad, about the vertical through the path's first pose."""
    about = Rotation.from_euler("z", turn)
    return Poses(about.as_quat()[None], np.zeros((1, 3))) @ global_from_hull


def describe_height(lower_m: float) -> str:
    """Describe what may be wrong where a CAD model fits lower than the guess by `lower_m`.

    A sensor that reads absolute pressure, taken for a depth, is too deep by the air's pressure.
    """
    air = " (an absolute pressure that is read as a depth is too deep by 10.1 m: pressure.unit)"
    where = f"{abs(lower_m):.1f} m {'lower' if lower_m > 0 else 'higher'}"
    return (
        f"it fits where hull.pose says, but {where}: the depths, or the height of hull.pose, are "
        "off by as much"
        f"{air if abs(lower_m - AIR_M) < NEAR_AIR_M else ''}"
    )


def describe_turn(turn: float) -> str:
    """Describe what may be wrong where a CAD model fits turned from the guess by `turn`, rad."""
    return (
        f"turned by {np.degrees(turn):+.0f} degrees about the vertical it fits where hull.pose "
        "says: the heading of the IMU (imu.mount_deg) or that of hull.pose is off by as much"
    )
