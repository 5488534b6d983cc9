# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Assemble the tables of a native problem from measurements and state, and read a solution back.

The hull frame of the native problem has the axes of M and its origin in the middle of the survey.
So a small rotation of T_g_M moves the surveyed part by millimetres and not by metres
(docs/methods.md 6).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array

from hullrecon import native
from hullrecon.adjustment.hull_pose.pose_cost import frame_at
from hullrecon.adjustment.problem.deviation_field import as_rows, prior_rows
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.observations import (
    Block,
    landmark_count,
    read_blocks,
    read_tracks,
)
from hullrecon.adjustment.problem.state import POINTS, HullState, State, Weights
from hullrecon.estimation.navigation_tables import (
    attitude_table,
    gauge_prior,
    mount_prior_table,
    odometry_table,
    tray_table,
    velocity_table,
)
from hullrecon.estimation.plane_tables import with_planes
from hullrecon.estimation.position_tables import with_positions
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, pose_from_vector, pose_vector
from hullrecon.memory import empty_array, release_pages
from hullrecon.records.solution import Mounts
from hullrecon.records.trajectory import Odometry, Returns
from hullrecon.typing import Array, Ints, Ints32, Mask

MIN_SHARED = 12  # landmarks that two nodes share, from which these determine their relative pose


@dataclass(frozen=True)
class Selection:
    """Which measurements enter a round."""

    top: Mask  # (m,) rows of the tracks whose observation in the top camera enters
    bottom: Mask  # (m,) rows whose observation in the bottom camera enters
    returns: Mask  # (r,) DVL returns that enter
    landmarks: Ints  # (L_used,) landmarks that enter, in the tracks' numbering, ascending
    rays: Ints32  # (L,) number of observations of each landmark that enter, both cameras


def assemble(
    m: Measurements,
    state: State,
    weights: Weights,
    chosen: Selection,
    systematic_errors: bool,
    hold_hull_pose: bool = False,
) -> native.Problem:
    """Assemble the problem of one round, with the cameras' intrinsics held.

    Parameters
    ----------
    m
        Measurements, rig and CAD model.
    state
        Start values of the unknowns.
    weights
        Sigmas and weights of the measurements.
    chosen
        Which measurements enter.
    systematic_errors
        Errors of navigation and the DVL's mount are unknowns. Otherwise they are held.
    hold_hull_pose
        Hold the hull's pose.
    """
    priors = _priors(m, state)
    problem = native.Problem(
        unknowns=_unknowns(m, state, chosen),
        constant=_held_blocks(priors, state, systematic_errors, hold_hull_pose),
        lever_arms=native.LeverArms(tray=m.rig.tray_origin, pressure=m.rig.pressure_origin),
        priors=priors,
        attitude=attitude_table(m.attitude, weights.depth),
        tray=tray_table(
            m.trajectory.tray, weights.tray_direction, weights.tray, m.attitude.tray_sigma
        ),
        velocities=velocity_table(m.odometry, m.trajectory.t_ns),
        odometry=odometry_table(
            _without_tracked_motions(m, chosen), m.trajectory.tray, m.rig.tray_from_dvl, state.nodes
        ),
    )
    problem = with_positions(problem, m.positions)
    if m.tracks is not None:
        stereo, mono = _image_tables(m, weights, chosen)
        problem = replace(problem, stereo=stereo, mono=mono, sigma_px=weights.pixel)
    if state.hull is None:
        return with_planes(problem, m.planes)  # with a CAD model these returns are ranges to it
    mesh = _centred_mesh(state.hull)
    problem = replace(
        problem,
        cad_mesh=native.CadMesh(vertices=mesh.vertices, faces=mesh.faces),
        surface=_surface_table(state.hull, state, weights, chosen),
    )
    if m.returns is None:
        return problem
    return replace(problem, ranges=_range_table(m, m.returns, state.hull, state, weights, chosen))


def _without_tracked_motions(m: Measurements, chosen: Selection) -> Odometry:
    """Drop odometry from images between nodes that share MIN_SHARED landmarks or more.

    The landmarks' observations come from the same images, which would count twice.
    """
    if m.tracks is None or not m.odometry.from_images.any():
        return m.odometry
    pairs = [np.zeros((2, 0), np.int64)]
    for block in read_tracks(m.tracks, _is_chosen(m, chosen)):
        rows = chosen.top[block.rows] | chosen.bottom[block.rows]
        pairs.append(np.stack([block.tracks.node[rows], block.tracks.landmark[rows]]))
    node, landmark = np.concatenate(pairs, axis=1)
    shape = (len(m.trajectory.t_ns), landmark_count(m))
    # Which landmarks (columns) each node (row) has observed
    seen = coo_array((np.ones(len(node)), (node, landmark)), shape=shape).tocsr()
    shared = seen[m.odometry.first].multiply(seen[m.odometry.second]).sum(axis=1)
    return m.odometry.take(~(m.odometry.from_images & (np.asarray(shared).ravel() >= MIN_SHARED)))


def _is_chosen(m: Measurements, chosen: Selection) -> Mask:
    """Tell which of the tracks' landmarks (L,) enter the problem."""
    out = np.zeros(landmark_count(m), bool)
    out[chosen.landmarks] = True
    return out


def state_from_unknowns(state: State, unknowns: native.Unknowns, chosen: Selection) -> State:
    """Update the state from the unknowns of a solve. Landmarks that did not enter become NaN.

    chosen: which landmarks entered, in the order of the unknowns.
    """
    pose, mounts = unknowns.pose, state.mounts
    landmark = np.full_like(state.landmark, np.nan)
    landmark[chosen.landmarks] = unknowns.landmark
    hull = state.hull
    if hull is not None:
        # The problem's hull frame has its origin in the middle of the survey
        found = pose_from_vector(unknowns.T_g_M) @ frame_at(hull.survey_center).inverse()
        hull = replace(hull, global_from_hull=found, field=unknowns.deviation.copy())
    return replace(
        state,
        nodes=Poses(
            pose[:, 3:7] / np.linalg.norm(pose[:, 3:7], axis=1, keepdims=True), pose[:, :3].copy()
        ),
        tray=pose[:, 7].copy(),
        landmark=landmark,
        mounts=Mounts(
            tray_from_dvl=pose_from_vector(unknowns.T_s_d),
            tray_from_top=pose_from_vector(unknowns.T_s_ct)
            if mounts.tray_from_top is not None
            else None,
            top_from_bottom=pose_from_vector(unknowns.T_ct_cb)
            if mounts.top_from_bottom is not None
            else None,
        ),
        navigation=unknowns.navigation.copy(),
        hull=hull,
    )


def _unknowns(m: Measurements, state: State, chosen: Selection) -> native.Unknowns:
    """Collect the start values of all unknowns from the state.

    Unknowns of sensors that the vehicle does not carry keep the defaults of `native.Unknowns`.
    Cameras start from their calibration in `m`, and only the landmarks `chosen` are unknowns.
    """
    unknowns = native.Unknowns(
        pose=np.hstack([state.nodes.vectors(), state.tray[:, None]]),
        T_s_d=pose_vector(state.mounts.tray_from_dvl),
        navigation=state.navigation.copy(),
    )
    if state.hull is not None:
        unknowns = replace(
            unknowns,
            T_g_M=pose_vector(_centred_pose(state.hull)),
            deviation=state.hull.field.copy(),
        )
    if m.tracks is not None and m.rig.top is not None and state.mounts.tray_from_top is not None:
        unknowns = replace(
            unknowns,
            landmark=state.landmark[chosen.landmarks],
            T_s_ct=pose_vector(state.mounts.tray_from_top),
            intrinsics_top=m.rig.top.parameters(),
        )
    if m.rig.bottom is not None and state.mounts.top_from_bottom is not None:
        unknowns = replace(
            unknowns,
            T_ct_cb=pose_vector(state.mounts.top_from_bottom),
            intrinsics_bottom=m.rig.bottom.parameters(),
        )
    return unknowns


def _held_blocks(
    priors: native.Priors, state: State, systematic_errors: bool, hold_hull_pose: bool
) -> tuple[str, ...]:
    """List the blocks of the problem that are held. Mounts without a prior are held too.

    systematic_errors, hold_hull_pose: as for `assemble`.
    """
    held = {"intrinsics_top", "intrinsics_bottom"}  # `free_intrinsics` may free them later
    if not systematic_errors:
        held |= {"navigation", "T_s_d"}
    mounts = {"T_s_d": priors.T_s_d, "T_s_ct": priors.T_s_ct, "T_ct_cb": priors.T_ct_cb}
    held |= {name for name, prior in mounts.items() if prior is None}
    if state.hull is None:
        held |= {"T_g_M", "deviation"}
    if hold_hull_pose:
        held.add("T_g_M")
    return tuple(sorted(held))


def _priors(m: Measurements, state: State) -> native.Priors:
    """Build the priors of mounts, navigation, first pose, hull pose and deviation field.

    The prior of the first pose fixes the frame g.
    """
    priors = native.Priors(
        T_s_d=mount_prior_table(
            m.rig.tray_from_dvl, m.rig.priors.tray_from_dvl, state.mounts.tray_from_dvl
        ),
        T_s_ct=mount_prior_table(
            m.rig.tray_from_top, m.rig.priors.tray_from_top, state.mounts.tray_from_top
        ),
        T_ct_cb=mount_prior_table(
            m.rig.stereo_mount, m.rig.priors.top_from_bottom, state.mounts.top_from_bottom
        ),
        pose=gauge_prior(state.nodes, m.attitude),
        navigation_sigma=m.rig.priors.navigation_sigma,
    )
    if state.hull is None:
        return priors
    cad_model, grid = state.hull.cad_model, state.hull.grid
    # Of the problem's hull frame, whose origin is the survey's middle
    guess = native.MotionPrior(
        value=pose_vector(cad_model.guess @ frame_at(state.hull.survey_center)),
        sqrt_information=np.diag(1.0 / cad_model.guess_sigma),
    )
    priors = replace(priors, T_g_M=guess)
    if grid is None:
        return priors
    field = prior_rows(grid, cad_model.deviation_sigma, cad_model.deviation_length)
    return replace(priors, deviation=as_rows(field))


def _image_tables(
    m: Measurements, weights: Weights, chosen: Selection
) -> tuple[native.StereoTable, native.MonoTable]:
    """Build the stereo table and the mono table from the chosen observations.

    An observation of a landmark by both cameras at a node is a stereo row, one by a single camera
    is a mono row. Observations are read in blocks twice: to count the rows, and to fill them in.

    weights: the sigma of each observation, by the detector's response. chosen: which ones enter.
    """
    known = _is_chosen(m, chosen)
    number = np.cumsum(known, dtype=np.int32) - 1  # of a landmark within the problem
    # Pixels of a row of both cameras, of the top one alone, of the bottom one alone
    sides = (slice(0, 4), slice(0, 2), slice(2, 4))

    def kinds_of(block: Block) -> tuple[Mask, Mask, Mask]:
        """Mark the block's rows seen by both cameras, by the top one alone, by the bottom one."""
        top, bottom = chosen.top[block.rows], chosen.bottom[block.rows]
        return top & bottom, top & ~bottom, ~top & bottom

    count = np.zeros(3, np.int64)  # rows of each of these kinds
    for block in read_tracks(m.tracks, known):
        count += [np.count_nonzero(rows) for rows in kinds_of(block)]
    tables = [_ImageRows(int(count[0]), 4), _ImageRows(int(count[1] + count[2]), 2)]
    # Next row of each kind. In the mono table the rows of the bottom camera follow the top one's.
    filled = np.array([0, 0, count[1]])
    for block in read_blocks(m, known):
        tracks = block.tracks
        pixel = np.hstack([tracks.top, tracks.bottom])
        ratio = weights.by_response.ratio(tracks.response)
        for kind, rows in enumerate(kinds_of(block)):
            own = np.flatnonzero(rows)
            to = slice(filled[kind], filled[kind] + len(own))
            table = tables[min(kind, 1)]
            table.node[to] = tracks.node[own]
            table.landmark[to] = number[tracks.landmark[own]]
            table.pixel[to] = pixel[own, sides[kind]]
            table.sigma_ratio[to] = ratio[own]
            filled[kind] = to.stop
        for table in tables:
            release_pages(*vars(table).values())
    both, one = tables
    return (
        native.StereoTable(**vars(both)),
        native.MonoTable(**vars(one), camera=np.repeat(np.array([0, 1], np.int32), count[1:])),
    )


class _ImageRows:
    """Columns of a table of observations, still to be filled. Large ones are backed by files."""

    def __init__(self, count: int, pixels: int) -> None:
        """Allocate `count` rows, each of an observation of `pixels` pixel coordinates."""
        self.node = empty_array((count,), np.int32)
        self.landmark = empty_array((count,), np.int32)
        self.pixel = empty_array((count, pixels), np.float64)
        self.sigma_ratio = empty_array((count,), np.float64)


def _centred_pose(hull: HullState) -> Poses:
    """Compute the pose in g of the problem's hull frame: M moved to the survey's centre."""
    return hull.global_from_hull @ frame_at(hull.survey_center)


def _centred_mesh(hull: HullState) -> Mesh:
    mesh = hull.cad_model.mesh
    return Mesh(mesh.vertices - hull.survey_center, mesh.faces)


def _surface_table(
    hull: HullState, state: State, weights: Weights, chosen: Selection
) -> native.SurfaceTable:
    """Build the surface table: one row for each landmark, its distance to the hull.

    Each row has the nodes of the deviation field around the landmark, and their weights.
    """
    landmark = np.arange(len(chosen.landmarks), dtype=np.int32)
    table = native.SurfaceTable(landmark=landmark, weight=weights.surface[chosen.landmarks])
    if hull.grid is None:
        return table
    count = len(landmark)
    field = native.FieldNodes(
        index=empty_array((count, 4), np.int32), weight=empty_array((count, 4), np.float64)
    )
    for first in range(0, count, POINTS):
        rows = slice(first, first + POINTS)
        points = hull.to_chart(state.landmark[chosen.landmarks[rows]])
        field.index[rows], field.weight[rows] = hull.grid.basis(points)
    release_pages(field.index, field.weight)
    return replace(table, field=field)


def _range_table(
    m: Measurements,
    returns: Returns,
    hull: HullState,
    state: State,
    weights: Weights,
    chosen: Selection,
) -> native.RangeTable:
    """Build the table of DVL ranges.

    Each row has the nodes of the deviation field around the point at which the beam meets the CAD
    model at the present state.

    Parameters
    ----------
    m, state
        The rig, and the poses from which the beams start.
    returns, chosen
        Returns of the DVL, and which of them enter.
    hull
        The CAD model, its pose, and the grid of the field. Without a grid rows have no nodes.
    weights
        The sigma of a range.
    """
    keep = chosen.returns
    table = native.RangeTable(
        node=returns.node[keep].astype(np.int32),
        offset=Poses(returns.quaternion[keep], returns.translation[keep]).vectors(),
        tray_offset=returns.tray_offset[keep],
        beam=returns.beam[keep],
        measured=returns.range_m[keep],
        sigma=np.full(int(keep.sum()), weights.range_sigma),
    )
    if hull.grid is None:
        return table
    # Hits are relative to the survey's middle, as the problem's hull frame is. The chart is in M
    at = hull.cad_model.chart.to_chart(
        _beam_hits(m, returns, hull, state, chosen) + hull.survey_center
    )
    index, weight = hull.grid.basis(at[:, :2])
    return replace(table, field=native.FieldNodes(index=index, weight=weight))


def _beam_hits(
    m: Measurements, returns: Returns, hull: HullState, state: State, chosen: Selection
) -> Array:
    """Find where the chosen beams meet the CAD model, (n, 3) m in the problem's hull frame.

    For a beam that misses, it is the end of the measured range. Arguments as of `_range_table`.
    """
    used = returns.take(chosen.returns)
    ends = state.mounted(m.rig).dvl_points(used, state.path)
    # the pose as the native problem has it, its quaternion normalised
    to_hull = pose_from_vector(pose_vector(_centred_pose(hull))).inverse()
    points, direction = to_hull.apply(ends.points), to_hull.rotation.apply(ends.directions)
    origin = points - direction * used.range_m[:, None]
    cast = _centred_mesh(hull).index.cast(origin, direction)
    length = np.where(np.isfinite(cast.range), cast.range, used.range_m)
    return np.asarray(origin + direction * length[:, None])


def share_weight_by_cell(
    hull: HullState, landmark: Array, chosen: Ints, cell: tuple[float, float]
) -> Array:
    """Compute weights (L,) of surface factors, so that those in one chart cell count as one.

    What the deviation field cannot follow within a cell moves all its landmarks alike.

    Parameters
    ----------
    hull
        On whose chart the cells are.
    landmark
        (L, 3) m in g.
    chosen
        Landmarks with a surface factor. The others have weight one.
    cell
        Size of a cell along and in girth, m.
    """
    at = hull.to_chart(landmark[chosen])
    along, girth = np.floor(np.nan_to_num(at) / np.array(cell)).astype(np.int64).T
    _, owner = np.unique(along * (np.ptp(girth) + 1) + girth - girth.min(), return_inverse=True)
    weight = np.ones(len(landmark))
    weight[chosen] = 1.0 / np.bincount(owner)[owner]
    return weight
