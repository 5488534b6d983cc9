# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One sigma of each kind of measurement: as the package states it at first, then from the residuals
of a round.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem import backlash, selection
from hullrecon.adjustment.problem.assembly import Selection, share_weight_by_cell
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.state import State, Weights
from hullrecon.adjustment.problem.triangulation import camera_poses, reprojection_errors
from hullrecon.geometry.robust import robust_sigma
from hullrecon.typing import Array, Ints

LEAST_LENGTHS = 100  # residuals from which a sigma is estimated
RESPONSE_GROUPS = 12


def initial_weights(m: Measurements, options: AdjustOptions) -> Weights:
    """Return the sigmas of the package."""
    return Weights(
        pixel=m.rig.priors.pixel_sigma_px,
        pixel_ratio=np.ones(0 if m.tracks is None else len(m.tracks.node)),
        depth=1.0,
        tray=m.rig.priors.tray_sigma_rad,
        range_sigma=m.rig.priors.range_sigma_m,
        surface=np.ones(selection.landmark_count(m)),
        tray_direction=np.zeros(len(m.trajectory.t_ns))
        if options.as_published
        else m.attitude.tray_direction,
    )


def surface_weights(state: State, chosen: Selection, options: AdjustOptions) -> Array:
    """Return the weight (L,) of each landmark's surface factor: full as published. With the field,
    landmarks of one cell a tenth of its length wide share one observation's weight: what the field
    does not follow within a cell (plate edges, weld seams) is common to them.
    """
    if state.hull is None or options.as_published or not len(chosen.landmarks):
        return np.ones(len(state.landmark))
    along, girth = state.hull.cad_model.deviation_length
    return share_weight_by_cell(
        state.hull, state.landmark, chosen.landmarks, (0.1 * along, 0.1 * girth)
    )


def estimate_weights(
    m: Measurements, state: State, chosen: Selection, weights: Weights, options: AdjustOptions
) -> Weights:
    """Return sigmas from the residuals, and sides of the tray's backlash from the adjusted angles."""
    if options.as_published or m.tracks is None:
        return weights
    pixel, pixel_ratio = estimate_pixel_sigmas(m, state, chosen, weights, options.min_sigma_px)
    side = backlash.estimate_sides(m.trajectory.tray - state.tray, weights.tray_direction)
    excess = (m.trajectory.tray - state.tray - state.navigation[5] * side)[
        m.attitude.tray_sigma == 0
    ]
    read = robust_sigma(excess) if len(excess) else m.rig.priors.tray_sigma_rad
    tray = float(np.clip(read, np.radians(0.02), m.rig.priors.tray_sigma_rad))
    return replace(
        weights,
        pixel=pixel,
        pixel_ratio=pixel_ratio,
        depth=_depth_weight(m, state),
        tray_direction=side,
        tray=tray,
    )


def estimate_pixel_sigmas(
    m: Measurements, state: State, chosen: Selection, weights: Weights, least: float
) -> tuple[float, Array]:
    """Return one sigma of a pixel coordinate, and the ratio (m,) of each observation's own to it,
    from the residuals of well-seen landmarks (at least six rays), freed of the three coordinates
    that each landmark takes from them.

    A feature is found the better the stronger the detector's response to it is: noise moves the
    extremum of a flat bump farther (docs/methods.md 6). Residuals in groups of like response tell
    how much, one group the corners, which have none.
    """
    if m.tracks is None or state.mounts.tray_from_top is None:
        return least, weights.pixel_ratio
    poses = camera_poses(m.rig, state)
    errors = reprojection_errors(m.tracks, state.landmark, *poses, m.rig)
    count, landmark = selection.landmark_count(m), m.tracks.landmark
    seen = chosen.top.astype(float) + chosen.bottom
    rays = np.bincount(landmark, seen, minlength=count)
    known = np.isin(landmark, chosen.landmarks)
    well = (rays[landmark] >= min(6, np.percentile(rays[chosen.landmarks], 75))) & known
    row = np.r_[np.flatnonzero(well & chosen.top), np.flatnonzero(well & chosen.bottom)]
    length = np.r_[errors[0][well & chosen.top], errors[1][well & chosen.bottom]]
    if len(length) < LEAST_LENGTHS:
        return max(least, m.rig.priors.pixel_sigma_px), np.ones_like(weights.pixel_ratio)
    weight = weights.pixel_ratio**-2
    whole = np.bincount(landmark, weight * seen, minlength=count)
    # of the two coordinates of a ray
    freedom = 1 - 1.5 * (weight / np.maximum(whole[landmark], weight))[row]
    pixel = max(least, _sigma_of_lengths(length, freedom))
    by_response = _sigma_by_response(m.tracks.response, row, length, freedom, pixel)
    return pixel, np.maximum(by_response, least) / pixel


def _sigma_by_response(
    response: Array, row: Ints, length: Array, freedom: Array, pixel: float
) -> Array:
    """Return one sigma (m,) of each observation: of its group of like response, linear in the
    logarithms between groups.
    """
    sigma = np.full(len(response), pixel)
    of_length = response[row]
    corner = np.isnan(of_length)
    if corner.sum() >= LEAST_LENGTHS:
        sigma[np.isnan(response)] = _sigma_of_lengths(length[corner], freedom[corner])
    responds = np.flatnonzero(of_length > 0)
    if not len(responds):
        return sigma
    edges = np.unique(
        np.quantile(of_length[responds], np.arange(1, RESPONSE_GROUPS) / RESPONSE_GROUPS)
    )
    group = np.searchsorted(edges, of_length[responds], side="right")
    groups = [responds[group == k] for k in range(len(edges) + 1)]
    groups = [rows for rows in groups if len(rows) >= LEAST_LENGTHS]
    if groups:
        found = [_sigma_of_lengths(length[rows], freedom[rows]) for rows in groups]
        center = [np.median(of_length[rows]) for rows in groups]
        known = np.flatnonzero(response > 0)
        sigma[known] = np.exp(np.interp(np.log(response[known]), np.log(center), np.log(found)))
    return sigma


def _sigma_of_lengths(length: Array, freedom: Array) -> float:
    """Return one sigma of a coordinate from lengths of residuals: the median length of a 2-D normal
    error is 1.177 sigma.
    """
    return float(np.median(length) / np.sqrt(2 * np.log(2)) / np.sqrt(max(freedom.mean(), 0.2)))


def depth_sigma(m: Measurements, weights: Weights) -> float:
    """Return the sigma of a depth with these weights (m), in the median; NaN without depths."""
    return (
        weights.depth * float(np.median(m.attitude.sigma[_measured_depths(m), 0]))
        if len(m.attitude.sigma)
        else float("nan")
    )


def _depth_weight(m: Measurements, state: State) -> float:
    """Return the sigma of the depths from their residuals, in the sigma that navigation gave them:
    that of a reading, which nodes that share it do not make smaller. The water's density scales all
    of them: n readings do not tell the dive's scale better than it is known.
    """
    rows = _measured_depths(m)
    if not m.attitude.has_depth.any():
        return 1.0
    z = state.nodes[m.attitude.node[rows]].apply(m.rig.pressure_origin)[:, 2]
    nodes = m.attitude.nodes_per_reading[rows]
    given = float(np.median(m.attitude.sigma[rows, 0] / np.sqrt(nodes)))
    white = robust_sigma(z - m.attitude.depth[rows])
    by_density = m.rig.priors.density_sigma * np.sqrt((1 / nodes).sum()) * float(np.std(z))
    return float(np.clip(max(white, by_density, 1e-3) / given, 0.0, 1.0))


def _measured_depths(m: Measurements) -> Ints:
    """Return the rows at which the pressure sensor was read; all where it was nowhere."""
    rows = np.flatnonzero(m.attitude.has_depth)
    return rows if len(rows) else np.arange(len(m.attitude.sigma))
