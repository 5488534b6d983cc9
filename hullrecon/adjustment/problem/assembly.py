# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From records and the present state to the tables of a native problem, and back.

The native problem's hull frame is M moved to the middle of the survey, so that a small rotation of T_g_M moves the hull
by millimetres there and not by metres (docs/methods.md 6).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon.adjustment.hull_pose.registration import about
from hullrecon.adjustment.problem.deviation_field import prior_rows
from hullrecon.adjustment.problem.measurements import CadModel, Measurements, Mount
from hullrecon.adjustment.problem.state import State, Weights, from_seven, seven
from hullrecon.geometry.poses import Poses
from hullrecon.native import MeshIndex, Problem
from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True)
class Selection:
    """Which measurements enter: observation (m,) of the tracks' rows by camera, returns (r,), landmarks of the problem in
    the tracks' numbering (L_used,)."""

    top: Mask
    bottom: Mask
    returns: Mask
    landmarks: Ints


def assemble(
    m: Measurements,
    state: State,
    weights: Weights,
    chosen: Selection,
    center: Array,
    as_published: bool,
    hold_place: bool = False,
) -> Problem:
    """The problem of one round. hold_place: T_g_M stays."""
    problem = Problem(pose=np.hstack([state.nodes.translation, state.nodes.quaternion, state.tray[:, None]]))
    problem.navigation = state.navigation.copy()
    problem.tray_origin, problem.pressure_origin = m.rig.tray_origin, m.rig.pressure_origin
    problem.prior_navigation_sigma = m.rig.navigation_sigma
    held = ["intrinsics_top", "intrinsics_bottom"] + (["navigation", "T_s_d"] if as_published else [])
    _set_motion(problem, "T_s_d", state.T_s_d, m.rig.T_s_d, held)
    _navigation_tables(problem, m, weights)
    if m.tracks is not None:
        _camera_tables(problem, m, state, weights, chosen, held)
    else:
        held += ["T_s_ct", "T_ct_cb"]
    if m.cad_model is not None and state.T_g_M is not None:
        _cad_model_tables(problem, m, m.cad_model, state, weights, chosen, center)
    else:
        held += ["T_g_M", "deviation"]
    if hold_place:
        held.append("T_g_M")
    problem.constant = tuple(sorted(set(held)))
    return problem


def read_back(state: State, unknowns: dict[str, Array], chosen: Selection, center: Array) -> State:
    """The state after a solve; landmarks that did not enter stay NaN."""
    pose = unknowns["pose"]
    landmark = np.full_like(state.landmark, np.nan)
    landmark[chosen.landmarks] = unknowns["landmark"]
    moved = from_seven(unknowns["T_g_M"]) @ about(center).inverse() if state.T_g_M is not None else None
    return replace(
        state,
        nodes=Poses(pose[:, 3:7] / np.linalg.norm(pose[:, 3:7], axis=1, keepdims=True), pose[:, :3].copy()),
        tray=pose[:, 7].copy(),
        landmark=landmark,
        T_g_M=moved,
        T_s_ct=from_seven(unknowns["T_s_ct"]) if state.T_s_ct is not None else None,
        T_ct_cb=from_seven(unknowns["T_ct_cb"]) if state.T_ct_cb is not None else None,
        T_s_d=from_seven(unknowns["T_s_d"]),
        navigation=unknowns["navigation"].copy(),
        field=unknowns["deviation"].copy(),
    )


def _set_motion(problem: Problem, name: str, value: Poses, mount: Mount, held: list[str]) -> None:
    setattr(problem, name, seven(value))
    if mount.sqrt_information is None:
        held.append(name)
    else:
        setattr(problem, f"prior_{name}", seven(mount.nominal))
        setattr(problem, f"prior_{name}_sqrt", mount.sqrt_information)


def _navigation_tables(problem: Problem, m: Measurements, weights: Weights) -> None:
    """Gauge prior on the first pose, attitude, tray and odometry."""
    problem.prior_pose_node = np.zeros(1, np.int32)
    problem.prior_pose = problem.pose[:1, :7].copy()
    problem.prior_pose_sqrt = _gauge_rows(m.trajectory.poses(), levelled=len(m.attitude.node) > 0)[None]
    attitude = m.attitude
    problem.attitude_node = attitude.node.astype(np.int32)
    problem.attitude_measured = np.stack([attitude.depth, attitude.roll, attitude.pitch], axis=1)
    problem.attitude_sigma = attitude.sigma * np.array([weights.depth, 1.0, 1.0])
    n = len(m.trajectory.t_ns)
    problem.tray_node = np.arange(n, dtype=np.int32)
    problem.tray_measured = m.trajectory.tray
    problem.tray_direction = weights.tray_direction
    problem.tray_sigma = np.full(n, weights.tray)
    o = m.odometry
    problem.odometry_first, problem.odometry_second = o.first.astype(np.int32), o.second.astype(np.int32)
    problem.odometry_measured = np.hstack([o.translation, o.quaternion])
    problem.odometry_sqrt = np.linalg.inv(np.linalg.cholesky(o.covariance))
    problem.odometry_by_navigation, problem.odometry_by_mount = o.by_navigation, o.by_mount
    problem.odometry_by_tray = o.by_tray
    problem.odometry_tray = 0.5 * (m.trajectory.tray[o.first] + m.trajectory.tray[o.second])
    problem.odometry_mount = seven(m.rig.T_s_d.nominal)


def _gauge_rows(nodes: Poses, levelled: bool) -> Array:
    """g is fixed by the first pose: x, y and heading are its own; depth, roll and pitch are left to their sensors where there
    are any."""
    tight_m, tight_rad = 1e-4, 1e-5
    free = (10.0, 1.0, 1.0) if levelled else (tight_m, tight_rad, tight_rad)  # m, rad, rad
    sigma_in_global = np.array([tight_m, tight_m, *free, tight_rad])
    to_global = nodes.rotation.as_matrix()[0]
    return np.asarray(np.kron(np.eye(2), to_global) / sigma_in_global[:, None])


def _camera_tables(
    problem: Problem, m: Measurements, state: State, weights: Weights, chosen: Selection, held: list[str]
) -> None:
    tracks, rig = m.tracks, m.rig
    if tracks is None or rig.top is None or rig.T_s_ct is None or state.T_s_ct is None:
        raise ValueError("tracks need a camera with a mount")
    _set_motion(problem, "T_s_ct", state.T_s_ct, rig.T_s_ct, held)
    if rig.T_ct_cb is not None and rig.bottom is not None and state.T_ct_cb is not None:
        _set_motion(problem, "T_ct_cb", state.T_ct_cb, rig.T_ct_cb, held)
        problem.intrinsics_bottom = rig.bottom.parameters()
    else:
        held.append("T_ct_cb")
    problem.intrinsics_top = rig.top.parameters()
    problem.sigma_px = weights.pixel
    problem.landmark = state.landmark[chosen.landmarks]
    number = np.full(len(state.landmark), -1)
    number[chosen.landmarks] = np.arange(len(chosen.landmarks))
    known = number[tracks.landmark] >= 0
    both, top, bottom = (
        known & k for k in (chosen.top & chosen.bottom, chosen.top & ~chosen.bottom, ~chosen.top & chosen.bottom)
    )
    problem.stereo_node, problem.stereo_landmark = (
        tracks.node[both].astype(np.int32),
        number[tracks.landmark[both]].astype(np.int32),
    )
    problem.stereo_pixel = np.hstack([tracks.top[both], tracks.bottom[both]])
    problem.mono_node = np.r_[tracks.node[top], tracks.node[bottom]].astype(np.int32)
    problem.mono_landmark = number[np.r_[tracks.landmark[top], tracks.landmark[bottom]]].astype(np.int32)
    problem.mono_camera = np.repeat(np.array([0, 1], np.int32), [top.sum(), bottom.sum()])
    problem.mono_pixel = np.vstack([tracks.top[top], tracks.bottom[bottom]])


def _cad_model_tables(
    problem: Problem, m: Measurements, cad_model: CadModel, state: State, weights: Weights, chosen: Selection, center: Array
) -> None:
    """The hull, its prior, ranges and surface factors, the deviation field."""
    assert state.T_g_M is not None
    problem.vertices, problem.faces = cad_model.mesh.vertices - center, cad_model.mesh.faces
    problem.T_g_M = seven(state.T_g_M @ about(center))
    problem.prior_T_g_M = seven(cad_model.guess @ about(center))
    problem.prior_T_g_M_sqrt = np.diag(1.0 / cad_model.guess_sigma)
    n = len(chosen.landmarks)
    problem.surface_landmark = np.arange(n, dtype=np.int32)
    problem.surface_weight = weights.surface[chosen.landmarks]
    if m.returns is not None:
        _range_tables(problem, m, weights, chosen)
    if state.grid is None:
        return
    rows = prior_rows(state.grid, cad_model.deviation_sigma, cad_model.deviation_length)
    problem.deviation = state.field.copy()
    problem.field_prior_start = rows.indptr.astype(np.int32)
    problem.field_prior_index, problem.field_prior_value = rows.indices.astype(np.int32), rows.data
    at = cad_model.chart.to_chart(state.T_g_M.inverse().apply(state.landmark[chosen.landmarks]))
    problem.surface_field_index, problem.surface_field_weight = state.grid.basis(at[:, :2])
    if m.returns is not None:
        at = cad_model.chart.to_chart(_hits(problem, m, state, chosen) + center)
        problem.range_field_index, problem.range_field_weight = state.grid.basis(at[:, :2])


def _range_tables(problem: Problem, m: Measurements, weights: Weights, chosen: Selection) -> None:
    returns = m.returns
    assert returns is not None
    keep = chosen.returns
    problem.range_node = returns.node[keep].astype(np.int32)
    problem.range_offset = np.hstack([returns.translation[keep], returns.quaternion[keep]])
    problem.range_tray_offset = returns.tray_offset[keep]
    problem.range_beam = returns.beam[keep]
    problem.range_measured = returns.range_m[keep]
    problem.range_sigma = np.full(int(keep.sum()), weights.range_sigma)


def _hits(problem: Problem, m: Measurements, state: State, chosen: Selection) -> Array:
    """Where the beams meet the CAD model, (r, 3) in the problem's hull frame; the measured end where they miss."""
    from hullrecon.adjustment.problem.measurements import return_points
    from hullrecon.records.serialisation import from_arrays, to_arrays

    assert m.returns is not None
    used = from_arrays(type(m.returns), {k: v[chosen.returns] for k, v in to_arrays(m.returns).items()})
    points, direction = return_points(used, state.nodes, state.tray, m.rig.tray_origin, state.T_s_d)
    hull = from_seven(problem.T_g_M)
    points, direction = hull.inverse().apply(points), hull.inverse().rotation.apply(direction)
    origin = points - direction * used.range_m[:, None]
    cast = MeshIndex(problem.vertices, problem.faces).cast(origin, direction)
    length = np.where(np.isfinite(cast.range), cast.range, used.range_m)
    return np.asarray(origin + direction * length[:, None])


def cell_share(m: Measurements, state: State, landmarks: Ints, cell: tuple[float, float]) -> Array:
    """Weight of each landmark's surface factor so that those of one cell of the chart (metres) weigh as one observation."""
    if m.cad_model is None or state.T_g_M is None:
        raise ValueError("cells need a CAD model")
    at = m.cad_model.chart.to_chart(state.T_g_M.inverse().apply(state.landmark[landmarks]))[:, :2]
    _, owner = np.unique(np.floor(np.nan_to_num(at) / np.array(cell)).astype(np.int64), axis=0, return_inverse=True)
    weight = np.ones(len(state.landmark))
    weight[landmarks] = 1.0 / np.bincount(owner)[owner]
    return weight
