# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The DVL's beams in the hull frame, and their residuals against the CAD model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, Trajectory, VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class HullBeams:
    """The beams that came back and were not flagged, in M."""

    points: Array  # (n, 3) their ends
    directions: Array  # (n, 3) unit vectors
    range_m: Array  # (n,) measured

    @property
    def origins(self) -> Array:
        """Compute the points (n, 3) in M at which the beams left the instrument."""
        return np.asarray(self.points - self.range_m[:, None] * self.directions)


def beams_of(path: VehiclePath, rig: Rig, returns: Returns) -> HullBeams:
    """Place the beams of a vehicle path in M."""
    good = ~returns.flagged & np.isfinite(returns.range_m)
    ends = rig.dvl_points(returns, path)
    return HullBeams(
        points=ends.points[good], directions=ends.directions[good], range_m=returns.range_m[good]
    )


def adjusted_beams(
    solution: Solution, global_from_hull: Poses, returns: Returns, rig: Rig
) -> HullBeams:
    """Place the beams by the solution's poses, tray and mounts."""
    path = VehiclePath(
        poses=global_from_hull.inverse() @ solution.global_from_vehicle, tray=solution.tray
    )
    return beams_of(path, rig.with_mounts(solution.mounts), returns)


def dead_reckoned_beams(
    trajectory: Trajectory, global_from_hull: Poses, returns: Returns, rig: Rig
) -> HullBeams:
    """Place the beams by dead reckoning, the tray as logged, the mount as configured."""
    path = VehiclePath(poses=global_from_hull.inverse() @ trajectory.poses(), tray=trajectory.tray)
    return beams_of(path, rig, returns)


def range_residuals(
    beams: HullBeams, cad_model: Scene, deviation_at: Callable[[Array], Array] | None = None
) -> Array:
    """Compute predicted minus measured ranges (m,) m of beams that meet the CAD model.

    This is [Ozog2016 eq. 4.14]. `deviation_at`: the hull's normal offset (n,) m at points (n, 3) in
    M. The CAD model is moved outward by it, as in the adjustment: cast - offset / cos(incidence).
    """
    origins = beams.origins
    predicted = cad_model.cast(origins, beams.directions)
    met = np.isfinite(predicted)
    if deviation_at is not None:
        at = origins[met] + predicted[met, None] * beams.directions[met]
        facing = -np.einsum("ni,ni->n", beams.directions[met], cad_model.closest(at).normal)
        predicted[met] -= deviation_at(at) / np.maximum(np.abs(facing), 0.2)
    return np.asarray((predicted - beams.range_m)[met])
