# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The DVL's beams in the hull frame, as a solution or dead reckoning places them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses, tray_poses
from hullrecon.records.solution import DeviationField, Solution
from hullrecon.records.trajectory import Returns, Trajectory
from hullrecon.typing import Array

Field = Callable[[Array], Array]


@dataclass(frozen=True)
class Beams:
    """origin (n, 3) and unit direction (n, 3) in M, measured range (n,) m; flagged returns are left out."""

    origin: Array
    direction: Array
    range_m: Array

    def points(self) -> Array:
        return np.asarray(self.origin + self.range_m[:, None] * self.direction)


def place_beams(T_M_v: Poses, angle_rad: Array, T_s_d: Poses, returns: Returns, tray_origin_m: Array) -> Beams:
    """Beams of nodes T_M_v with tray angles (n,)."""
    good = ~returns.flagged & np.isfinite(returns.range_m)
    node = returns.node[good]
    at_ping = Poses(returns.quaternion[good], returns.translation[good])
    angle = angle_rad[node] + returns.tray_offset[good]
    T_M_d = T_M_v[node] @ at_ping @ tray_poses(tray_origin_m, angle) @ T_s_d
    direction = np.asarray(T_M_d.rotation.apply(returns.beam[good]))
    return Beams(T_M_d.translation, direction, returns.range_m[good])


def adjusted_beams(solution: Solution, T_g_M: Poses, returns: Returns, tray_origin_m: Array) -> Beams:
    hull_from_vehicle = T_g_M.inverse() @ solution.global_from_vehicle
    return place_beams(hull_from_vehicle, solution.tray, solution.mounts.tray_from_dvl, returns, tray_origin_m)


def reckoned_beams(trajectory: Trajectory, T_g_M: Poses, T_s_d: Poses, returns: Returns, tray_origin_m: Array) -> Beams:
    """Before the adjustment: dead-reckoned poses, the tray as logged, the mount as configured."""
    return place_beams(T_g_M.inverse() @ trajectory.poses(), trajectory.tray, T_s_d, returns, tray_origin_m)


def range_residuals(beams: Beams, cad_model: Scene, field: Field | None = None) -> Array:
    """Predicted minus measured range (m,) against the CAD model [Ozog2016 eq. 4.14], of the beams that meet it; with a field,
    against the CAD model moved outward by it: cast - field / cos(incidence), as in the adjustment."""
    predicted = cad_model.cast(beams.origin, beams.direction)
    met = np.isfinite(predicted)
    if field is not None:
        at = beams.origin[met] + predicted[met, None] * beams.direction[met]
        facing = -np.einsum("ni,ni->n", beams.direction[met], cad_model.closest(at).normal)
        predicted[met] -= field(at) / np.maximum(np.abs(facing), 0.2)
    return np.asarray((predicted - beams.range_m)[met])


def field_at(field: DeviationField, chart: Chart) -> Field:
    """The solution's field of normal offsets at points (n, 3) in M, m."""
    from scipy.interpolate import RegularGridInterpolator

    axes = [o + s * np.arange(n) for o, s, n in zip(
        field.origin, field.step, field.value.shape, strict=True)]  # fmt: skip
    look_up = RegularGridInterpolator(axes, field.value, bounds_error=False, fill_value=None)
    low, high = (np.array([a[k] for a in axes]) for k in (0, -1))
    return lambda points: np.asarray(look_up(np.clip(np.nan_to_num(chart.to_chart(points)[:, :2]), low, high)))
