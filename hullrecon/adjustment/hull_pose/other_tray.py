# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Test whether a CAD model that does not fit the survey would fit tray angles read otherwise.

Without a camera nothing else tells a wrong sign, unit or zero of them: the hull that the beams
meet is as bent as the angles say, and depths change by their cosine alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.adjustment.hull_pose.other_headings import stated_model
from hullrecon.adjustment.hull_pose.registration import (
    GOOD_FITNESS,
    GUESS_SIGMAS,
    Registration,
    fits_far_better,
    prior_step,
    register_near,
    rms_m,
    thin_points,
)
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import Odometry, Returns, VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array

# by what the angles have to be multiplied where they are read wrongly
READINGS = {"sign": -1.0, "rad": float(np.degrees(1)), "deg": float(np.radians(1))}
CELL_M, POINTS = 0.1, 600  # of the ends that are registered


def find_fitting_tray(
    rig: Rig, path: VehiclePath, odometry: Odometry, returns: Returns, cad_model: CadModel
) -> tuple[str, float, float] | None:
    """Register the CAD model to the ends of a DVL's beams with the tray's angles read otherwise.

    Parameters
    ----------
    rig, path, odometry
        As solved, in g, and what the DVL measured between the nodes.
    returns
        Of the DVL.
    cad_model
        What they are registered to.

    Returns
    -------
    reading, rms before, rms after
        A key of READINGS, and the distances from the CAD model, m. None where no other reading
        fits far better.
    """
    if not np.ptp(path.tray):
        return None  # it stands still: any reading but turns the hull
    as_is = _register(rig, path, returns, cad_model)
    found: dict[str, Registration] = {}
    for reading, factor in READINGS.items():
        if np.abs(factor * path.tray).max() < np.pi:
            other = replace(returns, tray_offset=factor * returns.tray_offset)
            found[reading] = _register(
                rig, with_tray(path, odometry, factor * path.tray), other, cad_model
            )
    best = fits_far_better(as_is, found)
    return None if best is None else (best, rms_m(as_is), rms_m(found[best]))


def find_tray_offset(
    rig: Rig, path: VehiclePath, odometry: Odometry, returns: Returns, found: Registration
) -> tuple[float, float] | None:
    """Compute by how much the tray's angles are off where the CAD model lies turned about its axis.

    Ends of beams from a tray that is off turn with it, and a path that its odometry made does too.
    The hull's pose was guessed apart from both.

    Parameters
    ----------
    rig, path, odometry, returns
        As for `find_fitting_tray`.
    found
        The CAD model registered to the ends as they are, farther from its guess than that allows.

    Returns
    -------
    offset, rms after
        rad, and the distances from the CAD model with the angles put right by it, m. None where it
        does not lie as guessed then.
    """
    if found.sigmas_off <= GUESS_SIGMAS:
        return None
    stated = stated_model(found)
    axis = path.poses.rotation.apply([0.0, 1.0, 0.0]).mean(axis=0)
    turn = (found.global_from_hull.rotation * stated.guess.rotation.inv()).as_rotvec()[0]
    offset = float(turn @ axis / np.linalg.norm(axis))
    again = _register(rig, with_tray(path, odometry, path.tray - offset), returns, stated)
    step = prior_step(again.global_from_hull, stated, again.center) / stated.guess_sigma
    fits = again.fitness >= GOOD_FITNESS and np.abs(step).max() <= GUESS_SIGMAS
    return (offset, rms_m(again)) if fits else None


def with_tray(path: VehiclePath, odometry: Odometry, tray: Array) -> VehiclePath:
    """Reckon a path anew by its orientations and odometry, with the tray at other angles.

    tray: (n,) rad.
    """
    turn = 0.5 * (tray - path.tray)[np.stack([odometry.first, odometry.second])].sum(axis=0)
    way = turned_odometry(odometry, turn).translation
    moved = path.poses.rotation[odometry.first].apply(way)
    start = path.poses.translation[:1]
    translation = np.vstack([start, start + np.cumsum(moved, axis=0)])
    return VehiclePath(poses=Poses(path.poses.quaternion, translation), tray=tray)


def turned_odometry(odometry: Odometry, turn: Array) -> Odometry:
    """Turn the ways that a DVL measured by angles (m,) of its tray.

    Of a way across the tray's axis, the vehicle's y, `by_tray` is the cross product with it.
    """
    sine, versine = np.sin(turn)[:, None], (1 - np.cos(turn))[:, None]
    by_tray = odometry.by_tray.copy()
    across = by_tray[:, :3]
    back = np.cross([0.0, 1.0, 0.0], across)
    translation = odometry.translation + sine * across + versine * back
    by_tray[:, :3] = across - versine * across + sine * back
    return replace(odometry, translation=translation, by_tray=by_tray)


def _register(rig: Rig, path: VehiclePath, returns: Returns, cad_model: CadModel) -> Registration:
    ends = rig.dvl_points(returns, path).points[~returns.flagged]
    points = thin_points(ends, CELL_M, POINTS)
    return register_near(points, cad_model, rig.priors.range_sigma_m)
