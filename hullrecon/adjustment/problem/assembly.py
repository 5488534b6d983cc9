# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From records and the present state to the tables of a native problem, and back.

The native problem's hull frame is M moved to the middle of the survey, so that a small rotation of T_g_M moves the hull
by millimetres there and not by metres (docs/methods.md 6).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.hull_pose.registration import frame_at
from hullrecon.adjustment.problem.deviation_field import DeviationGrid, prior_rows
from hullrecon.adjustment.problem.measurements import CadModel, Measurements, Mount, return_points
from hullrecon.adjustment.problem.state import State, Weights, from_seven, seven
from hullrecon.geometry.poses import Poses
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import Returns
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
    hold_hull_pose: bool = False,
) -> native.Problem:
    """Return the problem of one round, its intrinsics held. hold_hull_pose: T_g_M is held too."""
    priors = _priors(m, state, center)
    problem = native.Problem(
        unknowns=_unknowns(m, state, chosen, center),
        constant=_held_blocks(priors, state, as_published, hold_hull_pose),
        lever_arms=native.LeverArms(tray=m.rig.tray_origin, pressure=m.rig.pressure_origin),
        priors=priors,
        attitude=_attitude_table(m, weights),
        tray=_tray_table(m, weights),
        odometry=_odometry_table(m),
    )
    if m.tracks is not None:
        stereo, mono = _image_tables(m.tracks, state, chosen)
        problem = replace(problem, stereo=stereo, mono=mono, sigma_px=weights.pixel)
    if m.cad_model is None or state.T_g_M is None:
        return problem
    mesh = native.CadMesh(vertices=m.cad_model.mesh.vertices - center, faces=m.cad_model.mesh.faces)
    surface = _surface_table(m.cad_model, state, weights, chosen)
    problem = replace(problem, cad_mesh=mesh, surface=surface)
    return problem if m.returns is None else replace(problem, ranges=_range_table(m, m.returns, state, weights, chosen, center))


def state_from_unknowns(state: State, unknowns: native.Unknowns, chosen: Selection, center: Array) -> State:
    """The state after a solve; landmarks that did not enter stay NaN."""
    pose = unknowns.pose
    landmark = np.full_like(state.landmark, np.nan)
    landmark[chosen.landmarks] = unknowns.landmark
    moved = pose_from_vector(unknowns.T_g_M) @ frame_at(center).inverse() if state.T_g_M is not None else None
    return replace(
        state,
        nodes=Poses(pose[:, 3:7] / np.linalg.norm(pose[:, 3:7], axis=1, keepdims=True), pose[:, :3].copy()),
        tray=pose[:, 7].copy(),
        landmark=landmark,
        T_g_M=moved,
        T_s_ct=pose_from_vector(unknowns.T_s_ct) if state.T_s_ct is not None else None,
        T_ct_cb=pose_from_vector(unknowns.T_ct_cb) if state.T_ct_cb is not None else None,
        T_s_d=pose_from_vector(unknowns.T_s_d),
        navigation=unknowns.navigation.copy(),
        field=unknowns.deviation.copy(),
    )


def _unknowns(m: Measurements, state: State, chosen: Selection, center: Array) -> native.Unknowns:
    unknowns = native.Unknowns(
        pose=np.hstack([state.nodes.translation, state.nodes.quaternion, state.tray[:, None]]),
        T_s_d=pose_vector(state.T_s_d),
        navigation=state.navigation.copy(),
        deviation=state.field.copy(),
    )
    if state.T_g_M is not None:
        unknowns = replace(unknowns, T_g_M=pose_vector(state.T_g_M @ frame_at(center)))
    if m.tracks is not None and m.rig.top is not None and state.T_s_ct is not None:
        unknowns = replace(
            unknowns,
            landmark=state.landmark[chosen.landmarks],
            T_s_ct=pose_vector(state.T_s_ct),
            intrinsics_top=m.rig.top.parameters(),
        )
    if m.rig.bottom is not None and state.T_ct_cb is not None:
        unknowns = replace(unknowns, T_ct_cb=pose_vector(state.T_ct_cb), intrinsics_bottom=m.rig.bottom.parameters())
    return unknowns


def _held_blocks(priors: native.Priors, state: State, as_published: bool, hold_hull_pose: bool) -> tuple[str, ...]:
    """Return the blocks that are not unknown: mounts without a prior among them."""
    held = {"intrinsics_top", "intrinsics_bottom"}
    if as_published:
        held |= {"navigation", "T_s_d"}
    mounts = {"T_s_d": priors.T_s_d, "T_s_ct": priors.T_s_ct, "T_ct_cb": priors.T_ct_cb}
    held |= {name for name, prior in mounts.items() if prior is None}
    if state.T_g_M is None:
        held |= {"T_g_M", "deviation"}
    if hold_hull_pose:
        held.add("T_g_M")
    return tuple(sorted(held))


def _mount_prior(mount: Mount | None, value: Poses | None) -> native.MotionPrior | None:
    """Return the prior of a mount; None where it is held or its sensor was not carried."""
    if mount is None or mount.sqrt_information is None or value is None:
        return None
    return native.MotionPrior(value=pose_vector(mount.nominal), sqrt_information=mount.sqrt_information)


def _priors(m: Measurements, state: State, center: Array) -> native.Priors:
    """Return the priors of mounts, navigation, hull pose and deviation field, and that which fixes g by the first pose."""
    first = np.hstack([state.nodes.translation, state.nodes.quaternion])[:1]
    rows = _gauge_rows(m.trajectory.poses(), levelled=len(m.attitude.node) > 0)[None]
    priors = native.Priors(
        T_s_d=_mount_prior(m.rig.T_s_d, state.T_s_d),
        T_s_ct=_mount_prior(m.rig.T_s_ct, state.T_s_ct),
        T_ct_cb=_mount_prior(m.rig.T_ct_cb, state.T_ct_cb if m.rig.bottom is not None else None),
        pose=native.PosePriors(node=np.zeros(1, np.int32), value=first, sqrt_information=rows),
        navigation_sigma=m.rig.navigation_sigma,
    )
    if m.cad_model is None:
        return priors
    guess = native.MotionPrior(
        value=pose_vector(m.cad_model.guess @ frame_at(center)), sqrt_information=np.diag(1.0 / m.cad_model.guess_sigma)
    )
    priors = replace(priors, T_g_M=guess)
    if state.grid is None:
        return priors
    field = prior_rows(state.grid, m.cad_model.deviation_sigma, m.cad_model.deviation_length)
    sparse = native.SparseRows(start=field.indptr.astype(np.int32), index=field.indices.astype(np.int32), value=field.data)
    return replace(priors, deviation=sparse)


def _gauge_rows(nodes: Poses, levelled: bool) -> Array:
    """Return the square root of the information (6, 6) that fixes g: x, y and heading are those of the first pose; depth, roll
    and pitch are left to their sensors where there are any."""
    tight_m, tight_rad = 1e-4, 1e-5
    free = (10.0, 1.0, 1.0) if levelled else (tight_m, tight_rad, tight_rad)  # m, rad, rad
    sigma_in_global = np.array([tight_m, tight_m, *free, tight_rad])
    to_global = nodes.rotation.as_matrix()[0]
    return np.asarray(np.kron(np.eye(2), to_global) / sigma_in_global[:, None])


def _attitude_table(m: Measurements, weights: Weights) -> native.AttitudeTable:
    attitude = m.attitude
    return native.AttitudeTable(
        node=attitude.node.astype(np.int32),
        measured=np.stack([attitude.depth, attitude.roll, attitude.pitch], axis=1),
        sigma=attitude.sigma * np.array([weights.depth, 1.0, 1.0]),
    )


def _tray_table(m: Measurements, weights: Weights) -> native.TrayTable:
    n = len(m.trajectory.t_ns)
    return native.TrayTable(
        node=np.arange(n, dtype=np.int32),
        measured=m.trajectory.tray,
        direction=weights.tray_direction,
        sigma=np.full(n, weights.tray),
    )


def _odometry_table(m: Measurements) -> native.OdometryTable:
    odometry, tray = m.odometry, m.trajectory.tray
    return native.OdometryTable(
        first=odometry.first.astype(np.int32),
        second=odometry.second.astype(np.int32),
        measured=np.hstack([odometry.translation, odometry.quaternion]),
        sqrt_information=np.linalg.inv(np.linalg.cholesky(odometry.covariance)),
        by_navigation=odometry.by_navigation,
        by_mount=odometry.by_mount,
        by_tray=odometry.by_tray,
        tray=0.5 * (tray[odometry.first] + tray[odometry.second]),
        mount=pose_vector(m.rig.T_s_d.nominal),
    )


def _image_tables(tracks: Tracks, state: State, chosen: Selection) -> tuple[native.StereoTable, native.MonoTable]:
    """Return the chosen observations: of landmarks that both cameras saw at a node, and of those that one saw."""
    number = np.full(len(state.landmark), -1)
    number[chosen.landmarks] = np.arange(len(chosen.landmarks))
    known = number[tracks.landmark] >= 0
    both, top, bottom = (
        known & k for k in (chosen.top & chosen.bottom, chosen.top & ~chosen.bottom, ~chosen.top & chosen.bottom)
    )
    stereo = native.StereoTable(
        node=tracks.node[both].astype(np.int32),
        landmark=number[tracks.landmark[both]].astype(np.int32),
        pixel=np.hstack([tracks.top[both], tracks.bottom[both]]),
    )
    mono = native.MonoTable(
        node=np.r_[tracks.node[top], tracks.node[bottom]].astype(np.int32),
        landmark=number[np.r_[tracks.landmark[top], tracks.landmark[bottom]]].astype(np.int32),
        camera=np.repeat(np.array([0, 1], np.int32), [top.sum(), bottom.sum()]),
        pixel=np.vstack([tracks.top[top], tracks.bottom[bottom]]),
    )
    return stereo, mono


def _surface_table(cad_model: CadModel, state: State, weights: Weights, chosen: Selection) -> native.SurfaceTable:
    landmark = np.arange(len(chosen.landmarks), dtype=np.int32)
    table = native.SurfaceTable(landmark=landmark, weight=weights.surface[chosen.landmarks])
    if state.grid is None or state.T_g_M is None:
        return table
    at = cad_model.chart.to_chart(state.T_g_M.inverse().apply(state.landmark[chosen.landmarks]))
    return replace(table, field=_field_nodes(state.grid, at[:, :2]))


def _range_table(
    m: Measurements, returns: Returns, state: State, weights: Weights, chosen: Selection, center: Array
) -> native.RangeTable:
    keep = chosen.returns
    table = native.RangeTable(
        node=returns.node[keep].astype(np.int32),
        offset=np.hstack([returns.translation[keep], returns.quaternion[keep]]),
        tray_offset=returns.tray_offset[keep],
        beam=returns.beam[keep],
        measured=returns.range_m[keep],
        sigma=np.full(int(keep.sum()), weights.range_sigma),
    )
    if state.grid is None or m.cad_model is None:
        return table
    at = m.cad_model.chart.to_chart(_hits(m, m.cad_model, returns, state, chosen, center) + center)
    return replace(table, field=_field_nodes(state.grid, at[:, :2]))


def _field_nodes(grid: DeviationGrid, along_girth: Array) -> native.FieldNodes:
    index, weight = grid.basis(along_girth)
    return native.FieldNodes(index=index, weight=weight)


def _hits(m: Measurements, cad_model: CadModel, returns: Returns, state: State, chosen: Selection, center: Array) -> Array:
    """Return where the beams meet the CAD model, (r, 3) in the problem's hull frame; the measured end where they miss."""
    if state.T_g_M is None:
        raise ValueError("beams meet a CAD model")
    used = from_arrays(Returns, {k: v[chosen.returns] for k, v in to_arrays(returns).items()})
    points, direction = return_points(used, state.nodes, state.tray, m.rig.tray_origin, state.T_s_d)
    hull = pose_from_vector(pose_vector(state.T_g_M @ frame_at(center)))
    points, direction = hull.inverse().apply(points), hull.inverse().rotation.apply(direction)
    origin = points - direction * used.range_m[:, None]
    cast = native.MeshIndex(cad_model.mesh.vertices - center, cad_model.mesh.faces).cast(origin, direction)
    length = np.where(np.isfinite(cast.range), cast.range, used.range_m)
    return np.asarray(origin + direction * length[:, None])


def share_weight_by_cell(m: Measurements, state: State, landmarks: Ints, cell: tuple[float, float]) -> Array:
    """Weight of each landmark's surface factor so that those of one cell of the chart (metres) weigh as one observation."""
    if m.cad_model is None or state.T_g_M is None:
        raise ValueError("cells need a CAD model")
    at = m.cad_model.chart.to_chart(state.T_g_M.inverse().apply(state.landmark[landmarks]))[:, :2]
    _, owner = np.unique(np.floor(np.nan_to_num(at) / np.array(cell)).astype(np.int64), axis=0, return_inverse=True)
    weight = np.ones(len(state.landmark))
    weight[landmarks] = 1.0 / np.bincount(owner)[owner]
    return weight
