# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Test whether a CAD model that does not fit the survey would fit tray angles read otherwise.

Without a camera nothing else tells a wrong sign or unit of them: the hull that the beams meet is as
bent as the angles say, and depths change by their cosine alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.adjustment.hull_pose.registration import (
    Registration,
    fits_far_better,
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
