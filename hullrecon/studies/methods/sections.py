# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sections through structures and the DVL's residuals, for the figures of the methods."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.evaluation.truth import TrueStructure, Truth
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, Trajectory, VehiclePath
from hullrecon.rig import Rig
from hullrecon.studies.methods.plots import CrossSection, WholeSection
from hullrecon.typing import Array, Mask

HALF_M = 0.08  # to either side of a section, along the hull
REACH_M = 0.55  # of a section across a structure, from its middle


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


def cut_section(
    solve: tuple[str, str],
    structure: TrueStructure,
    landmarks: Array,
    on_surface: Mask,
    dvl: Array,
    truth: Truth,
) -> CrossSection:
    """Slice the hull through a structure, HALF_M to either side along the hull.

    The DVL's few returns are taken from a slice five times as thick.

    Parameters
    ----------
    solve
        Names of the solve's method and of its weighting.
    structure
        Through the middle of which the hull is cut.
    landmarks, on_surface
        (l, 3) m in M, aligned with the truth, and which of them (l,) the solve put on the hull.
    dvl
        (n, 3) m, ends of the beams, likewise.
    truth
        Gives the profiles of the steel and of the CAD model.
    """
    axes = _axes(structure)
    foot = np.array(structure.center) - structure.height * axes[2]
    local, beams = (landmarks - foot) @ axes.T, (dvl - foot) @ axes.T
    seen, hit = _inside(local, HALF_M, REACH_M), _inside(beams, 5 * HALF_M, REACH_M)
    line = np.linspace(-REACH_M, REACH_M, 200)
    return CrossSection(
        method=solve[0],
        weighting=solve[1],
        dvl=beams[hit, 1:],
        on=local[seen & on_surface, 1:],
        off=local[seen & ~on_surface, 1:],
        steel=_profile(truth.built, foot, axes, line),
        cad_model=_profile(truth.cad_model, foot, axes, line)
        if truth.cad_model is not None
        else np.zeros((0, 2)),
    )


def cut_whole_hull(
    structure: TrueStructure,
    landmarks: Array,
    on_surface: Mask,
    dvl: Array,
    truth: Truth,
) -> WholeSection:
    """Slice across the whole hull at the structure, in M's y and z (x forward).

    Parameters are those of `cut_section`.
    """
    at = np.array(structure.center)
    near, hit = np.abs(landmarks[:, 0] - at[0]) < HALF_M, np.abs(dvl[:, 0] - at[0]) < 5 * HALF_M
    cad_model = np.zeros((0, 2))
    if truth.cad_model is not None and near.any():
        # Rays from 5 m outside of the structure's side to 3 m inside, over the landmarks' heights
        low, high = landmarks[near, 2].min() - 0.8, landmarks[near, 2].max() + 0.8
        side = np.sign(structure.normal[1]) or 1.0
        start = np.stack(
            [np.full(200, at[0]), np.full(200, at[1] + 5 * side), np.linspace(low, high, 200)], 1
        )
        way = truth.cad_model.cast(start, np.tile([0.0, -side, 0.0], (200, 1)))
        met = np.isfinite(way) & (way < 5 + 3.0)
        cad_model = np.stack([start[met, 1] - side * way[met], start[met, 2]], 1)
    return WholeSection(
        on=landmarks[near & on_surface, 1:],
        off=landmarks[near & ~on_surface, 1:],
        dvl=dvl[hit, 1:],
        cad_model=cad_model,
        at=at[1:],
    )


def _axes(structure: TrueStructure) -> Array:
    """Span rows along the hull, over its girth and outward."""
    normal = np.array(structure.normal)
    along = np.array([1.0, 0.0, 0.0]) - normal * normal[0]
    along /= np.linalg.norm(along)
    return np.stack([along, np.cross(normal, along), normal])


def _inside(local: Array, half_m: float, reach_m: float) -> Mask:
    """Mark points (n, 3) m in axes of `_axes`, within 0.4 m of the hull, that a slice holds."""
    return (
        (np.abs(local[:, 0]) < half_m)
        & (np.abs(local[:, 1]) < reach_m)
        & (np.abs(local[:, 2]) < 0.4)
    )


def _profile(surface: Scene, foot: Array, axes: Array, line: Array) -> Array:
    """Cast rays from outside onto the surface: profile (m, 2), m over the girth and outward.

    foot, axes: origin (3,) and rows (3, 3), as of `_axes`. line: (k,) m over the girth from foot.
    """
    start = foot + line[:, None] * axes[1] + 0.5 * axes[2]
    way = surface.cast(start, np.tile(-axes[2], (len(line), 1)))
    met = np.isfinite(way) & (way < 1.2)
    return np.stack([line[met], 0.5 - way[met]], axis=1)
