# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Test whether a CAD model that does not fit would fit with other tray angles.

The angles may have another sign, unit or zero than dive.toml says. The surveyed hull is bent then.
Without a camera only the CAD model shows it, as depths change with the cosine of the angle alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.adjustment.hull_pose.other_headings import stated_model
from hullrecon.adjustment.hull_pose.pose_cost import prior_step
from hullrecon.adjustment.hull_pose.registration import (
    GOOD_FITNESS,
    GUESS_SIGMAS,
    Registration,
    few_points,
    fits_far_better,
    register_near,
    rms_m,
)
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import Odometry, Returns, VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array

# Other conventions of the angles, and the factor that corrects each: the opposite sign, and rad or
# deg where the other unit was taken
READINGS = {"sign": -1.0, "rad": float(np.degrees(1)), "deg": float(np.radians(1))}


def find_fitting_tray(
    rig: Rig, path: VehiclePath, odometry: Odometry, returns: Returns, cad_model: CadModel
) -> tuple[str, float, float] | None:
    """Register the CAD model to the ends of the DVL's beams for each other convention of the tray.

    Parameters
    ----------
    rig, path
        As solved, the path in g.
    odometry
        Motion between nodes by the DVL, from which the path is computed anew.
    returns
        Ranges of the DVL, whose ends are computed with each convention.
    cad_model
        To which the ends are registered.

    Returns
    -------
    convention, rms before, rms after
        A key of READINGS, and the RMS distance from the CAD model, m, with the angles as read and
        with that convention. None where no other convention fits far better, or where the tray does
        not move.
    """
    if not np.ptp(path.tray):
        return None  # the tray does not move: every convention turns the hull as a whole
    as_is = _register(rig, path, returns, cad_model)
    found: dict[str, Registration] = {}
    for reading, factor in READINGS.items():
        if np.abs(factor * path.tray).max() < np.pi:
            other = replace(returns, tray_offset=factor * returns.tray_offset)
            found[reading] = _register(
                rig, with_tray(path, odometry, factor * path.tray), other, cad_model
            )
    best = fits_far_better(as_is, found, rig.priors.range_sigma_m)
    return None if best is None else (best, rms_m(as_is), rms_m(found[best]))


def find_tray_offset(
    rig: Rig, path: VehiclePath, odometry: Odometry, returns: Returns, found: Registration
) -> tuple[float, float] | None:
    """Compute an offset of the tray's angles from a hull that is turned about the tray's axis.

    An offset turns the ends of the beams, and the path by DVL odometry, about the tray's axis. The
    package's guess of the hull's pose does not depend on the tray, so the registered hull lies
    turned from it by the offset.

    Parameters
    ----------
    rig, path, odometry, returns
        As for `find_fitting_tray`.
    found
        Registration of the CAD model to the ends with the angles as read.

    Returns
    -------
    offset, rms after
        rad, to be subtracted from the angles, and the RMS distance from the CAD model, m, after
        that. None where the registration agrees with the guess, or does not after the correction.
    """
    if found.sigmas_off <= GUESS_SIGMAS:
        return None
    stated = stated_model(found)
    axis = path.poses.rotation.apply([0.0, 1.0, 0.0]).mean(axis=0)
    turn = (found.global_from_hull.rotation * stated.guess.rotation.inv()).as_rotvec()[0]
    offset = float(turn @ axis / np.linalg.norm(axis))
    # A return's angle is relative to that of its node, so the returns stay as they are
    again = _register(rig, with_tray(path, odometry, path.tray - offset), returns, stated)
    step = prior_step(again.global_from_hull, stated, again.center) / stated.guess_sigma
    fits = again.fitness >= GOOD_FITNESS and np.abs(step).max() <= GUESS_SIGMAS
    return (offset, rms_m(again)) if fits else None


def with_tray(path: VehiclePath, odometry: Odometry, tray: Array) -> VehiclePath:
    """Compute a path again from its orientations and odometry, with the tray at other angles.

    Parameters
    ----------
    path
        The path with the tray's angles as they were.
    odometry
        Motion between consecutive nodes, measured by a DVL on the tray.
    tray
        (n,) rad, the other angles.
    """
    # By how much each motion's tray angle differs, as the mean over its two nodes
    turn = 0.5 * (tray - path.tray)[np.stack([odometry.first, odometry.second])].sum(axis=0)
    measured = turned_odometry(odometry, turn).translation
    moved = path.poses.rotation[odometry.first].apply(measured)
    start = path.poses.translation[:1]
    translation = np.vstack([start, start + np.cumsum(moved, axis=0)])
    return VehiclePath(poses=Poses(path.poses.quaternion, translation), tray=tray)


def turned_odometry(odometry: Odometry, turn: Array) -> Odometry:
    """Turn the translations that a DVL measured by angles (m,) rad of its tray.

    The tray's axis is the vehicle's y. The derivative of a translation by the tray's angle,
    `by_tray`, is the cross product of that axis with it, and Rodrigues' formula follows from it.
    """
    # t + sin (y x t) + (1 - cos) y x (y x t), and its cross product with y, as y x back = -across
    sine, versine = np.sin(turn)[:, None], (1 - np.cos(turn))[:, None]
    by_tray = odometry.by_tray.copy()
    across = by_tray[:, :3]
    back = np.cross([0.0, 1.0, 0.0], across)
    translation = odometry.translation + sine * across + versine * back
    by_tray[:, :3] = across - versine * across + sine * back
    return replace(odometry, translation=translation, by_tray=by_tray)


def _register(rig: Rig, path: VehiclePath, returns: Returns, cad_model: CadModel) -> Registration:
    ends = rig.dvl_points(returns, path).points[~returns.flagged]
    points = few_points(ends)
    return register_near(points, cad_model, rig.priors.range_sigma_m)
