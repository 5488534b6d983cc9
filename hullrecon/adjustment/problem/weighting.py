# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One sigma of each kind of measurement: as the package states it at first, then from the residuals of a round."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem import backlash, selection
from hullrecon.adjustment.problem.assembly import Selection, share_weight_by_cell
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.state import State, Weights
from hullrecon.geometry.robust import robust_sigma
from hullrecon.typing import Array, Ints

DENSITY_SIGMA = 0.002  # relative, of sea water where it was not measured
UNKNOWN_DEPTH_M = 1.0  # sigma beyond which no pressure was logged


def initial_weights(m: Measurements, options: AdjustOptions) -> Weights:
    """Return the sigmas of the package."""
    return Weights(
        pixel=m.rig.sigma_px,
        depth=1.0,
        tray=m.rig.tray_sigma,
        range_sigma=m.rig.sigma_range,
        surface=np.ones(selection.landmark_count(m)),
        tray_direction=np.zeros(len(m.trajectory.t_ns)) if options.as_published else m.attitude.tray_direction,
    )


def surface_weights(state: State, chosen: Selection, options: AdjustOptions) -> Array:
    """Return the weight (L,) of each landmark's surface factor: full as published. With the field, landmarks of one cell a
    tenth of its length wide share one observation's weight: what the field does not follow within a cell (plate edges, weld
    seams) is common to them."""
    if state.hull is None or options.as_published or not len(chosen.landmarks):
        return np.ones(len(state.landmark))
    along, girth = state.hull.cad_model.deviation_length
    return share_weight_by_cell(state.hull, state.landmark, chosen.landmarks, (0.1 * along, 0.1 * girth))


def estimate_weights(m: Measurements, state: State, chosen: Selection, weights: Weights, options: AdjustOptions) -> Weights:
    """Return sigmas from the residuals, and sides of the tray's backlash from the adjusted angles."""
    if options.as_published or m.tracks is None:
        return weights
    pixel = selection.estimate_pixel_sigma(m, state, chosen, options.least_pixel_sigma)
    side = backlash.estimate_sides(m.trajectory.tray - state.tray, weights.tray_direction)
    excess = (m.trajectory.tray - state.tray - state.navigation[5] * side)[m.attitude.tray_sigma == 0]
    read = robust_sigma(excess) if len(excess) else m.rig.tray_sigma
    tray = float(np.clip(read, np.radians(0.02), m.rig.tray_sigma))
    return replace(weights, pixel=pixel, depth=_depth_weight(m, state), tray_direction=side, tray=tray)


def depth_sigma(m: Measurements, weights: Weights) -> float:
    """Return the sigma of a depth with these weights (m), in the median; NaN without depths."""
    return weights.depth * float(np.median(m.attitude.sigma[_measured_depths(m), 0])) if len(m.attitude.sigma) else float("nan")


def _depth_weight(m: Measurements, state: State) -> float:
    """Return the sigma of the depths from their residuals, in the sigma that navigation gave them. The water's density scales
    all of them: n readings do not tell the dive's scale better than it is known."""
    rows = _measured_depths(m)
    if not len(rows) or np.median(m.attitude.sigma[rows, 0]) > UNKNOWN_DEPTH_M:
        return 1.0
    z = state.nodes[m.attitude.node[rows]].apply(m.rig.pressure_origin)[:, 2]
    given = float(np.median(m.attitude.sigma[rows, 0]))
    white = robust_sigma(z - m.attitude.depth[rows])
    shared = DENSITY_SIGMA * np.sqrt(len(z)) * float(np.std(z))
    return float(np.clip(max(white, shared, 1e-3) / given, 0.0, 1.0))


def _measured_depths(m: Measurements) -> Ints:
    """Return the rows at which the pressure sensor was read; all where it was nowhere."""
    rows = np.flatnonzero(m.attitude.sigma[:, 0] <= UNKNOWN_DEPTH_M)
    return rows if len(rows) else np.arange(len(m.attitude.sigma))
