# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Selection of observations, landmarks and returns for a round, and of landmarks after it."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from hullrecon.adjustment.problem.assembly import Selection
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.problem.triangulation import (
    camera_poses,
    reprojection_errors,
    triangulate,
)
from hullrecon.native import MonoTable, Problem, Result, StereoTable, SurfaceTable
from hullrecon.typing import Array, Mask

Table = TypeVar("Table", StereoTable, MonoTable, SurfaceTable)


def landmark_count(m: Measurements) -> int:
    """Count the landmarks of the tracks."""
    return 0 if m.tracks is None else len(m.tracks.color)


def triangulate_landmarks(m: Measurements, state: State) -> Array:
    """Triangulate landmarks (L, 3) in g from the present poses. NaN where it cannot be done."""
    if m.tracks is None or state.mounts.tray_from_top is None:
        return np.zeros((0, 3))
    top, bottom = camera_poses(m.rig, state)
    position, _ = triangulate(m.tracks, landmark_count(m), top, bottom, m.rig)
    return position


def select_measurements(m: Measurements, state: State, max_px: Array | float) -> Selection:
    """Select observations that agree with the present poses, their landmarks, and returns.

    Parameters
    ----------
    m, state
        What was measured, and the present poses and landmarks.
    max_px
        Largest reprojection error, of all observations or of each (m,).

    Returns
    -------
    Selection
        Landmarks keep at least two rays and lie near the hull. Flagged returns are left out.
    """
    returns = ~m.returns.flagged if m.returns is not None else np.zeros(0, bool)
    if m.tracks is None or state.mounts.tray_from_top is None:
        empty = np.zeros(0, bool)
        return Selection(empty, empty, returns, np.zeros(0, np.int64))
    poses = camera_poses(m.rig, state)
    top_error, bottom_error = reprojection_errors(m.tracks, state.landmark, *poses, m.rig)
    top, bottom = (
        np.nan_to_num(top_error, nan=np.inf) <= max_px,
        np.nan_to_num(bottom_error, nan=np.inf) <= max_px,
    )
    rays = np.bincount(m.tracks.landmark, top.astype(float) + bottom, minlength=landmark_count(m))
    used = (rays >= 2) & np.isfinite(state.landmark[:, 0]) & _near_hull(state)
    return Selection(top, bottom, returns, np.flatnonzero(used))


def choose_anchors(m: Measurements, chosen: Selection, most: int) -> Selection:
    """Choose about `most` of the landmarks seen best, spread evenly over nodes.

    At least one of each node that first saw some: enough to find poses and sigmas in the rounds
    before the last, at a fraction of its cost.
    """
    if m.tracks is None or len(chosen.landmarks) <= most:
        return chosen
    rays = np.bincount(
        m.tracks.landmark, chosen.top.astype(float) + chosen.bottom, minlength=landmark_count(m)
    )
    first = np.full(landmark_count(m), np.iinfo(np.int64).max)
    np.minimum.at(first, m.tracks.landmark, m.tracks.node)
    node = first[chosen.landmarks]
    order = np.lexsort((-rays[chosen.landmarks], node))
    rank = np.arange(len(order)) - np.searchsorted(node[order], node[order])
    kept = order[rank < max(1, most // max(1, len(np.unique(node))))]
    return Selection(chosen.top, chosen.bottom, chosen.returns, np.sort(chosen.landmarks[kept]))


def drop_isolated_landmarks(
    m: Measurements, state: State, chosen: Selection, off: Mask, reach_m: float = 0.15
) -> Selection:
    """Drop landmarks off the hull that stand alone.

    A mismatch along the epipolar line looks like structure, but has no two neighbours off the hull
    within reach, and at most three rays.

    Parameters
    ----------
    m, state, chosen
        The measurements, and those chosen.
    off
        Which chosen landmarks lie off the hull.
    reach_m
        Within which neighbours count.
    """
    from scipy.spatial import cKDTree

    if m.tracks is None or not off.any():
        return chosen
    rays = np.bincount(
        m.tracks.landmark, chosen.top.astype(float) + chosen.bottom, minlength=landmark_count(m)
    )[chosen.landmarks]
    position = state.landmark[chosen.landmarks]
    neighbours = (
        cKDTree(position[off]).query_ball_point(position[off], reach_m, return_length=True) - 1
    )
    isolated = np.zeros(len(off), bool)
    isolated[off] = (rays[off] <= 3) & (neighbours < 2)
    return Selection(chosen.top, chosen.bottom, chosen.returns, chosen.landmarks[~isolated])


def label_boundary(sigma_on: float, sigma_off: float) -> float:
    """Compute the distance off the hull (m) at which both labels are equally likely.

    See [Ozog2016 4.2.3]. sigma_off must be larger than sigma_on.
    """
    return float(np.sqrt(2 * np.log(sigma_off / sigma_on) / (sigma_on**-2 - sigma_off**-2)))


def _near_hull(state: State, reach_m: float = 2.0) -> Mask:
    """Tell which landmarks (L,) lie within reach of the CAD model, or of the path without one.

    Metres off is a mismatch.
    """
    from scipy.spatial import cKDTree

    finite = np.nan_to_num(state.landmark, nan=1e6)
    if state.hull is None:
        gap, _ = cKDTree(state.nodes.translation).query(finite)
        return np.asarray(gap < 30.0)
    return np.asarray(np.abs(state.hull.cad_distance(finite)) < reach_m)


def drop_landmarks(problem: Problem, keep: Mask) -> Problem:
    """Keep landmarks `keep` (L,) of a problem alone, and renumber their factors.

    A solve may push a landmark behind its cameras or metres off the hull: a mismatch along an
    epipolar line, when every landmark is pulled to the hull, or when one solve starts from dead
    reckoning. Nothing determines it there, and one of them is enough for the covariances not to
    exist.
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
    """Keep rows (m,) of the surface table in the result of a problem with fewer landmarks."""
    if len(result.label) != len(surface_rows):
        return result
    return replace(result, label=result.label[surface_rows], distance=result.distance[surface_rows])
