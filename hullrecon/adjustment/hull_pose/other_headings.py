# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Test whether a CAD model lies turned about the vertical, or higher, than the package has it.

An IMU whose heading is off turns the whole path about where it began, and a wrong heading of the
package's guess looks the same. Nothing of a dive without positions tells the two apart. Nor does
anything tell depths that are all off from a wrong height of the guess.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.hull_pose.registration import (
    GOOD_FITNESS,
    GUESS_SIGMAS,
    Registration,
    prior_step,
    register_near,
    thin_points,
)
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

STEP_DEG = 30  # of headings that are tried, each of which the registration finds within its basin
CELL_M, POINTS = 0.1, 600
AIR_M, NEAR_AIR_M = 10.1, 0.7  # the air's pressure in metres of sea water, with the weather's


def stated_model(found: Registration) -> CadModel:
    """Give a CAD model the sigmas of its guess that the package states."""
    return replace(found.cad_model, guess_sigma=found.cad_model.guess_sigma / found.sigmas_off)


def turn_of(found: Registration) -> float | None:
    """Compute the turn of the hull from the guess, rad, where that alone contradicts the guess."""
    return None if found.sigmas_off <= GUESS_SIGMAS else _turn_from(stated_model(found), found)


def height_off(found: Registration) -> float | None:
    """Compute how far below the guess the hull lies, m, where that alone contradicts the guess."""
    if found.sigmas_off <= GUESS_SIGMAS:
        return None
    model = stated_model(found)
    step = prior_step(found.global_from_hull, model, found.center)
    down = model.guess.rotation.inv().apply([[0.0, 0.0, 1.0]])[0]  # of g, in M
    lower_m = float(down @ step[:3])
    rest = np.abs(np.r_[step[:3] - lower_m * down, step[3:]] / model.guess_sigma)
    return lower_m if rest.max() <= GUESS_SIGMAS else None


def _turn_from(cad_model: CadModel, found: Registration) -> float | None:
    """Compute the turn from a guess to where a hull was found, rad.

    None where the rest of the way is farther than the guess's sigmas allow, with a turn about where
    the path began and about the survey.
    """
    at, center = found.global_from_hull, found.center
    turn = float((at.rotation * cad_model.guess.rotation.inv()).as_euler("ZYX")[0, 0])
    began, there = (prior_step(pose, cad_model, center) for pose in (_turned(at, -turn), at))
    steps = np.stack([began, np.r_[there[:3], began[3:]]])
    sigmas = np.abs(steps / cad_model.guess_sigma).max(axis=1)
    return turn if sigmas.min() <= GUESS_SIGMAS else None


def find_fitting_heading(
    points: Array, cad_model: CadModel, range_sigma_m: float
) -> tuple[float, float] | None:
    """Register the CAD model to points (n, 3) in g with the guess turned by steps of a circle.

    Returns the turn, rad, at which it fits best, and the share of points that fit there. None if it
    fits at none where a guess so turned has it.
    """
    few = thin_points(points, CELL_M, POINTS)
    found: list[tuple[float, float]] = []
    for degrees in range(STEP_DEG, 360, STEP_DEG):
        other = replace(cad_model, guess=_turned(cad_model.guess, float(np.radians(degrees))))
        tried = register_near(few, other, range_sigma_m)
        turn = _turn_from(cad_model, tried)
        if tried.fitness >= GOOD_FITNESS and turn is not None:
            found.append((turn, tried.fitness))
    return max(found, key=lambda one: one[1], default=None)


def _turned(global_from_hull: Poses, turn: float) -> Poses:
    """Turn a hull about the vertical through where the path began, rad."""
    about = Rotation.from_euler("z", turn)
    return Poses(about.as_quat()[None], np.zeros((1, 3))) @ global_from_hull


def describe_height(lower_m: float) -> str:
    """Tell who may be wrong where a CAD model lies lower by so many metres than the package has it.

    Readings that hold the air's pressure and are taken for depths are too deep by that.
    """
    air = " (an absolute pressure that is read as a depth is too deep by 10.1 m: pressure.unit)"
    where = f"{abs(lower_m):.1f} m {'lower' if lower_m > 0 else 'higher'}"
    return (
        f"it fits where hull.pose says, but {where}: the depths, or the height of hull.pose, are "
        "off by as much"
        f"{air if abs(lower_m - AIR_M) < NEAR_AIR_M else ''}"
    )


def describe_turn(turn: float) -> str:
    """Tell who may be wrong where a CAD model lies turned, rad, from where the package has it."""
    return (
        f"turned by {np.degrees(turn):+.0f} degrees about the vertical it fits where hull.pose "
        "says: the heading of the IMU (imu.mount_deg) or that of hull.pose is off by as much"
    )
