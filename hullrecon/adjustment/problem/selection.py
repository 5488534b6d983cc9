# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Select the observations, landmarks and returns of a round, and drop lost landmarks after it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from hullrecon.adjustment.problem.assembly import Selection
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.observations import (
    Block,
    first_nodes,
    landmark_count,
    map_blocks,
)
from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.problem.triangulation import (
    camera_poses,
    reprojection_errors,
    triangulate,
)
from hullrecon.geometry.poses import Poses
from hullrecon.native import MonoTable, Problem, Result, StereoTable, SurfaceTable
from hullrecon.typing import Array, Mask

Table = TypeVar("Table", StereoTable, MonoTable, SurfaceTable)
NEIGHBOURS_M = 0.15  # largest distance between landmarks off the hull that show one structure
# A landmark farther from the CAD model, or without one from the path, is a mismatch
NEAR_HULL_M, NEAR_PATH_M = 2.0, 30.0
# Largest reprojection error, px: of all observations, or of each by the detector's response (m,)
Limit = float | Callable[[Array], Array]


def triangulate_landmarks(m: Measurements, state: State) -> Array:
    """Triangulate landmarks (L, 3) m in g from the present poses. NaN with too few rays."""
    if m.tracks is None or state.mounts.tray_from_top is None:
        return np.zeros((0, 3))
    poses = camera_poses(m.rig, state)
    landmark = np.full((landmark_count(m), 3), np.nan)
    for own, found in map_blocks(m, lambda b: (b.landmarks, _triangulated(b, poses, m))):
        landmark[own] = found
    return landmark


def find_landmarks(m: Measurements, state: State, max_px: Limit) -> tuple[State, Selection]:
    """Triangulate landmarks from the present poses, and select measurements that agree with them.

    As `select_measurements`, but the landmarks of `state` are replaced by triangulated ones.
    """
    return _select(m, state, max_px, triangulate_first=True)


def select_measurements(m: Measurements, state: State, max_px: Limit) -> Selection:
    """Select observations with small reprojection errors, their landmarks, and DVL returns.

    Parameters
    ----------
    m, state
        Measurements, and the present poses and landmarks.
    max_px
        Largest reprojection error, of all observations or of each by the detector's response.

    Returns
    -------
    Selection
        Its landmarks have at least two observations and lie near the hull (NEAR_HULL_M,
        NEAR_PATH_M). Flagged returns are left out.
    """
    return _select(m, state, max_px, triangulate_first=False)[1]


def _select(
    m: Measurements, state: State, max_px: Limit, triangulate_first: bool
) -> tuple[State, Selection]:
    """Select measurements as `select_measurements` does, in blocks of landmarks.

    `triangulate_first`: triangulate the landmarks instead of taking those of `state`. The returned
    state holds them.
    """
    returns = ~m.returns.flagged if m.returns is not None else np.zeros(0, bool)
    if m.tracks is None or state.mounts.tray_from_top is None:
        empty = np.zeros(0, bool)
        nothing = Selection(empty, empty, returns, np.zeros(0, np.int64), np.zeros(0, np.int32))
        return replace(state, landmark=np.zeros((0, 3))), nothing
    poses, is_near = camera_poses(m.rig, state), _near_hull(state)
    count, rows = landmark_count(m), len(m.tracks.landmark)
    landmark = np.full((count, 3), np.nan) if triangulate_first else state.landmark
    top, bottom, used = np.zeros(rows, bool), np.zeros(rows, bool), np.zeros(count, bool)
    rays = np.zeros(count, np.int32)

    def select_in_block(block: Block) -> None:
        """Select the observations of a block of landmarks, and the landmarks. Fills the arrays."""
        own = block.landmarks
        if triangulate_first:
            landmark[own] = _triangulated(block, poses, m)
        errors = reprojection_errors(block.numbered_from_0, landmark[own], *poses, m.rig)
        limit = max_px(block.tracks.response) if callable(max_px) else max_px
        # An error is NaN without an observation, and does not agree
        agree = [np.nan_to_num(error, nan=np.inf) <= limit for error in errors]
        top[block.rows], bottom[block.rows] = agree
        of_block = np.add(*agree, dtype=np.int8)
        rays[own] = np.bincount(block.numbered_from_0.landmark, of_block)
        used[own] = (rays[own] >= 2) & np.isfinite(landmark[own, 0]) & is_near(landmark[own])

    for _ in map_blocks(m, select_in_block):
        pass
    chosen = Selection(top, bottom, returns, np.flatnonzero(used), rays)
    return replace(state, landmark=landmark), chosen


def _triangulated(block: Block, poses: tuple[Poses, Poses | None], m: Measurements) -> Array:
    count = block.landmarks.stop - block.landmarks.start
    return triangulate(block.numbered_from_0, count, *poses, m.rig)[0]


def choose_anchors(m: Measurements, chosen: Selection, most: int) -> Selection:
    """Choose about `most` landmarks with many observations, spread evenly over the nodes.

    Landmarks are grouped by the node that observed them first, and each group keeps the same
    number, at least one. They are enough to find poses and sigmas in the rounds before the last, at
    a fraction of its cost.
    """
    if m.tracks is None or len(chosen.landmarks) <= most:
        return chosen
    node = first_nodes(m)[chosen.landmarks]
    # By node, and within it by the number of observations: the first of each node are kept
    order = np.lexsort((-chosen.rays[chosen.landmarks], node))
    rank = np.arange(len(order)) - np.searchsorted(node[order], node[order])
    kept = order[rank < max(1, most // max(1, len(np.unique(node))))]
    return replace(chosen, landmarks=np.sort(chosen.landmarks[kept]))


def drop_isolated_landmarks(state: State, chosen: Selection, off: Mask) -> Selection:
    """Drop landmarks off the hull that have few rays and few neighbours.

    A mismatch along the epipolar line looks like a landmark on a structure. But it has at most
    three rays, and fewer than two neighbours off the hull within NEIGHBOURS_M.

    Parameters
    ----------
    state, chosen
        Positions of the landmarks, and which landmarks enter.
    off
        (L_used,) whether a landmark that enters lies off the hull.
    """
    from scipy.spatial import cKDTree

    if not off.any():
        return chosen
    position = state.landmark[chosen.landmarks[off]]
    neighbours = cKDTree(position).query_ball_point(position, NEIGHBOURS_M, return_length=True) - 1
    isolated = np.zeros(len(off), bool)
    isolated[off] = (chosen.rays[chosen.landmarks[off]] <= 3) & (neighbours < 2)
    return replace(chosen, landmarks=chosen.landmarks[~isolated])


def label_boundary(sigma_on: float, sigma_off: float) -> float:
    """Compute the distance off the hull (m) at which both labels are equally likely.

    See [Ozog2016 4.2.3]. sigma_off must be larger than sigma_on.
    """
    return float(np.sqrt(2 * np.log(sigma_off / sigma_on) / (sigma_on**-2 - sigma_off**-2)))


def _near_hull(state: State) -> Callable[[Array], Mask]:
    """Make a function that tells which points (n, 3) in g are near the hull.

    Near means NEAR_HULL_M from the CAD model, or NEAR_PATH_M from the path without one.
    """
    from scipy.spatial import cKDTree

    hull = state.hull
    if hull is not None:
        return lambda points: np.abs(hull.cad_distance(_finite(points))) < NEAR_HULL_M
    path = cKDTree(state.nodes.translation)
    return lambda points: np.asarray(path.query(_finite(points))[0] < NEAR_PATH_M)


def _finite(points: Array) -> Array:
    """Move points with a NaN far away, as searches for the nearest refuse NaN."""
    return np.nan_to_num(points, nan=1e6)


def drop_landmarks(problem: Problem, keep: Mask) -> Problem:
    """Drop all landmarks but `keep` (L_used,) from a problem, with their rows, and renumber them.

    A solve may push a landmark behind its cameras or metres off the hull: a mismatch along an
    epipolar line, or any landmark where all are pulled to the hull (method "geva") or where a
    single solve starts from dead reckoning. No measurement determines it there, and then the
    covariances do not exist.
    """
    number = (np.cumsum(keep) - 1).astype(np.int32)

    def kept(table: Table) -> Table:
        rows = table.take(keep[table.landmark])
        return replace(rows, landmark=number[rows.landmark])

    return replace(
        problem,
        unknowns=replace(problem.unknowns, landmark=problem.unknowns.landmark[keep]),
        stereo=kept(problem.stereo),
        mono=kept(problem.mono),
        surface=kept(problem.surface),
    )


def drop_label_rows(result: Result, surface_rows: Mask) -> Result:
    """Drop labels and distances of landmarks that were dropped from the problem.

    surface_rows (m,): whether a row of the surface table stays. A result without labels is returned
    unchanged.
    """
    if len(result.label) != len(surface_rows):
        return result
    return replace(result, label=result.label[surface_rows], distance=result.distance[surface_rows])
