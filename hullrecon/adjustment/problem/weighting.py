# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sigmas of the measurements: first as the package states them, then from a round's residuals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.adjustment.options import Strategy
from hullrecon.adjustment.problem.assembly import Selection, share_weight_by_cell
from hullrecon.adjustment.problem.lens import estimate_lens_sigma
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.observations import Block, landmark_count, map_blocks
from hullrecon.adjustment.problem.state import ResponseSigmas, State, Weights
from hullrecon.adjustment.problem.triangulation import camera_poses, reprojection_errors
from hullrecon.geometry.robust import robust_sigma
from hullrecon.typing import Array, Ints

MIN_RESIDUALS = 100  # with fewer, no sigma is estimated
RESPONSE_GROUPS = 12  # of features, by the detector's response
MIN_SIGMA_PX = 0.03  # lower limit of an estimated pixel sigma: no feature is located better
MIN_TRAY_SIGMA_DEG = 0.02  # lower limit of the estimated sigma of a tray angle
MIN_RAYS = 6  # observations of a landmark whose residuals are used
FLIP_COST = 4.0  # of a change of the tray's side, as a cost (half a squared whitened residual)
CELL_SHARE = 0.1  # side of a cell whose landmarks share a weight, in the field's correlation length


def initial_weights(m: Measurements, strategy: Strategy) -> Weights:
    """Make the weights of the first round, from the sigmas that the package states.

    Without systematic errors in the strategy, tray and lenses have none.
    """
    return Weights(
        pixel=m.rig.priors.pixel_sigma_px,
        by_response=ResponseSigmas(pixel=m.rig.priors.pixel_sigma_px, least=0.0),
        depth=1.0,
        tray=m.rig.priors.tray_sigma_rad,
        range_sigma=m.rig.priors.range_sigma_m,
        surface=np.ones(landmark_count(m)),
        tray_direction=m.attitude.tray_direction
        if strategy.systematic_errors
        else np.zeros(len(m.trajectory.t_ns)),
        lens=np.array(m.rig.priors.calibration_sigma_px) * float(strategy.systematic_errors),
    )


def surface_weights(state: State, chosen: Selection, strategy: Strategy) -> Array:
    """Compute the weight (L,) of each landmark's surface factor.

    With the deviation field, the landmarks in a cell of a tenth of its correlation length have
    together the weight of one observation. What the field cannot follow within a cell (plate edges,
    weld seams) moves them all alike. Without the field all have weight one.

    state, chosen: landmarks and hull, and which landmarks enter. Those that do not have weight one.
    """
    if state.hull is None or not strategy.deviation_field or not len(chosen.landmarks):
        return np.ones(len(state.landmark))
    along, girth = state.hull.cad_model.deviation_length
    return share_weight_by_cell(
        state.hull, state.landmark, chosen.landmarks, (CELL_SHARE * along, CELL_SHARE * girth)
    )


def estimate_weights(
    m: Measurements, state: State, chosen: Selection, weights: Weights, strategy: Strategy
) -> Weights:
    """Estimate the sigmas of the next round from residuals, and the sides of the tray's backlash.

    Parameters
    ----------
    m, state, chosen
        Measurements, solution of the round, and which measurements entered.
    weights
        Sigmas and weights that the round used. Returned unchanged without images, or where the
        strategy estimates no sigmas.
    strategy
        Says whether sigmas are estimated.
    """
    if not strategy.estimate_sigmas or m.tracks is None:
        return weights
    by_response = estimate_pixel_sigmas(m, state, chosen, weights)
    side = estimate_sides(m.trajectory.tray - state.tray, weights.tray_direction)
    # What the backlash (`navigation[5]`) leaves of the tray's residuals, at nodes at which the
    # servo was read
    excess = (m.trajectory.tray - state.tray - state.navigation[5] * side)[
        m.attitude.tray_sigma == 0
    ]
    read = robust_sigma(excess) if len(excess) else m.rig.priors.tray_sigma_rad
    tray = float(np.clip(read, np.radians(MIN_TRAY_SIGMA_DEG), m.rig.priors.tray_sigma_rad))
    return replace(
        weights,
        pixel=by_response.pixel,
        by_response=by_response,
        depth=_depth_sigma_ratio(m, state),
        tray_direction=side,
        tray=tray,
        lens=estimate_lens_sigma(m.lenses, np.array(m.rig.priors.calibration_sigma_px)),
    )


def estimate_pixel_sigmas(
    m: Measurements, state: State, chosen: Selection, weights: Weights
) -> ResponseSigmas:
    """Estimate the pixel sigma of all observations, and its dependence on the detector's response.

    A feature with a stronger response is located better, as noise moves the extremum of a flat
    response farther (docs/methods.md 6). So residuals are grouped by response. Corners, which have
    no response, are one group. Residuals of landmarks with many observations are used. Each
    landmark absorbs three coordinates of its residuals, which their redundancy takes into account.

    Parameters
    ----------
    m, state, chosen
        Measurements, solution of a round, and which measurements entered.
    weights
        That the round used.
    """
    if m.tracks is None or state.mounts.tray_from_top is None:
        return replace(weights.by_response, pixel=MIN_SIGMA_PX)
    rays = chosen.rays[chosen.landmarks]
    well_seen = np.zeros(len(state.landmark), bool)
    well_seen[chosen.landmarks] = rays >= min(MIN_RAYS, np.percentile(rays, 75))
    poses = camera_poses(m.rig, state)

    def residuals(block: Block) -> dict[str, list[Array]]:
        errors = reprojection_errors(block.tracks, state.landmark, *poses, m.rig)
        return _residuals_of_block(block, errors, chosen, weights)

    blocks = list(map_blocks(m, residuals, well_seen))
    # Of the top camera, then of the bottom one
    length, redundancy, response = (
        np.concatenate([of_block[name][k] for k in range(2) for of_block in blocks])
        if blocks
        else np.zeros(0)
        for name in ("length", "redundancy", "response")
    )
    if len(length) < MIN_RESIDUALS:
        stated = max(MIN_SIGMA_PX, m.rig.priors.pixel_sigma_px)
        return ResponseSigmas(pixel=stated, least=MIN_SIGMA_PX)
    pixel = max(MIN_SIGMA_PX, _sigma_of_lengths(length, redundancy))
    return _sigma_by_response(response, length, redundancy, pixel)


def _residuals_of_block(
    block: Block, errors: tuple[Array, Array], chosen: Selection, weights: Weights
) -> dict[str, list[Array]]:
    """Collect the residuals of a block that entered, with their redundancies and responses.

    Parameters
    ----------
    block
        Observations (m,) of some landmarks.
    errors
        Lengths (m,) px of the reprojection errors in the top and the bottom camera.
    chosen
        Which observations entered.
    weights
        That the round used.

    Returns
    -------
    dict
        "length" px, "redundancy" of a coordinate, and "response" of the detector: each a list with
        an array (k,) for the top camera and one for the bottom camera.
    """
    tracks, sides = block.tracks, (chosen.top[block.rows], chosen.bottom[block.rows])
    weight = weights.by_response.ratio(tracks.response) ** -2
    owner = block.numbered_from_0.landmark
    # Summed weight of all observations of a landmark, by both cameras
    whole = np.bincount(owner, weight * np.add(*sides, dtype=np.int8))[owner]
    # A landmark's three coordinates take up 3 of the 2 n coordinates of its n observations, from
    # each by the share of its weight: a redundancy of 1 - (3 / 2) share for each coordinate.
    redundancy = 1 - 1.5 * (weight / np.maximum(whole, weight))
    return {
        name: [values[k][side] for k, side in enumerate(sides)]
        for name, values in (
            ("length", errors),
            ("redundancy", (redundancy, redundancy)),
            ("response", (tracks.response, tracks.response)),
        )
    }


def _sigma_by_response(
    response: Array, length: Array, redundancy: Array, pixel: float
) -> ResponseSigmas:
    """Estimate the sigma of each of RESPONSE_GROUPS groups of features with similar responses.

    Groups with fewer than MIN_RESIDUALS residuals are left out, between which sigmas are
    interpolated later.

    Parameters
    ----------
    response
        (n,) of the detector, NaN for corners, which are a group of their own.
    length, redundancy
        (n,) of each residual, as of `_residuals_of_block`.
    pixel
        Sigma of all observations, px.
    """
    corner = np.isnan(response)
    of_corners = None
    if corner.sum() >= MIN_RESIDUALS:
        of_corners = _sigma_of_lengths(length[corner], redundancy[corner])
    # Groups of equal size, between quantiles of the response
    responds = np.flatnonzero(response > 0)
    edges = np.unique(
        np.quantile(response[responds], np.arange(1, RESPONSE_GROUPS) / RESPONSE_GROUPS)
        if len(responds)
        else np.zeros(0)
    )
    group = np.searchsorted(edges, response[responds], side="right").astype(np.int8)
    center, found = [], []
    for k in range(len(edges) + 1):
        rows = responds[group == k]
        if len(rows) >= MIN_RESIDUALS:
            center.append(float(np.median(response[rows])))
            found.append(_sigma_of_lengths(length[rows], redundancy[rows]))
    return ResponseSigmas(
        pixel=pixel,
        least=MIN_SIGMA_PX,
        corner=of_corners,
        response=np.array(center),
        sigma=np.array(found),
    )


def _sigma_of_lengths(length: Array, redundancy: Array) -> float:
    """Estimate the sigma of an image coordinate, px, from the median length of residuals.

    The median length of a 2-D normal error is sqrt(2 ln 2) = 1.177 sigma. A residual's variance is
    that of the observation times its redundancy.
    """
    mean_redundancy = max(redundancy.mean(), 0.2)
    return float(np.median(length) / np.sqrt(2 * np.log(2)) / np.sqrt(mean_redundancy))


def sigma_of_common_scale(range_m: Array, share: float) -> float:
    """Compute the sigma, m, with which ranges (n,) tell the scale they share to `share` together.

    An error that all ranges share does not average out, however many there are. 0 without ranges.
    """
    if not len(range_m):
        return 0.0
    return share * float(np.median(range_m)) * float(np.sqrt(len(range_m)))


def depth_sigma(m: Measurements, weights: Weights) -> float:
    """Compute the median sigma of a depth with these weights, m. NaN without depths."""
    return (
        weights.depth * float(np.median(m.attitude.sigma[_measured_depths(m), 0]))
        if len(m.attitude.sigma)
        else float("nan")
    )


def _depth_sigma_ratio(m: Measurements, state: State) -> float:
    """Estimate the sigma of a pressure reading, as a share of the sigma that navigation gave it.

    Several nodes may share one reading, which does not make it more certain. The sigma is at least
    so large that all depths together do not determine a length better than the water's density is
    known, as an error of the density scales them all.
    """
    rows = _measured_depths(m)
    if not m.attitude.has_depth.any():
        return 1.0
    z = state.nodes[m.attitude.node[rows]].apply(m.rig.pressure_origin)[:, 2]
    # Navigation inflated the sigmas of nodes that share a reading, so that it counts once
    nodes = m.attitude.nodes_per_reading[rows]
    given_m = float(np.median(m.attitude.sigma[rows, 0] / np.sqrt(nodes)))
    white_m = robust_sigma(z - m.attitude.depth[rows])
    # An error of the density scales all depths. Readings of this sigma determine a scale no better
    by_density_m = m.rig.priors.density_sigma * np.sqrt((1 / nodes).sum()) * float(np.std(z))
    return float(np.clip(max(white_m, by_density_m, 1e-3) / given_m, 0.0, 1.0))


def _measured_depths(m: Measurements) -> Ints:
    """List rows at which the pressure sensor was read, or all rows where it never was."""
    rows = np.flatnonzero(m.attitude.has_depth)
    return rows if len(rows) else np.arange(len(m.attitude.sigma))


def estimate_sides(excess: Array, prior_direction: Array) -> Array:
    """Estimate on which side of its backlash the tray hangs at each node, +1 or -1 (n,).

    Backlash is a bias of the angle that flips with the direction of motion [Ozog2016 4.2.6]:
    measured - adjusted = backlash * side. After a solve with a wide prior of the tray's angles,
    this difference has two levels. A two-state Viterbi path over time assigns nodes to them more
    reliably than the noisy direction of the logged motion does.

    Parameters
    ----------
    excess
        Measured minus adjusted angle (n,), rad, in the order of time.
    prior_direction
        Sides (n,) by the logged motion. Returned where the two levels are closer than three times
        their spread, or with fewer than ten nodes.
    """
    low, high = _two_levels(excess)
    sigma = max(
        robust_sigma(np.minimum(np.abs(excess - low), np.abs(excess - high)), about=0.0), 1e-5
    )
    if high - low < 3 * sigma or len(excess) < 10:
        return prior_direction
    fit = np.stack([(excess - low) ** 2, (excess - high) ** 2], axis=1) / (2 * sigma**2)
    # A node's cost is bounded, so that a single outlier costs less than the two flips around it
    path = _viterbi(np.minimum(fit, 1.5 * FLIP_COST), FLIP_COST)
    return np.where(path == 1, 1.0, -1.0)


def _two_levels(values: Array) -> tuple[float, float]:
    """Find the medians of two clusters of values (n,), by k-medians started at the quartiles.

    They are the tray's mean errors on the two sides of its backlash.
    """
    low, high = (float(q) for q in np.percentile(values, [25, 75]))
    for _ in range(20):
        upper = np.abs(values - high) < np.abs(values - low)
        if upper.all() or not upper.any():
            break
        low, high = float(np.median(values[~upper])), float(np.median(values[upper]))
    return low, high


def _viterbi(cost: Array, flip_cost: float) -> Ints:
    """Find the sequence of two states (n,) of least cost, by the Viterbi algorithm.

    Parameters
    ----------
    cost
        (n, 2) of each state at each time.
    flip_cost
        Cost of each change of state.
    """
    n = len(cost)
    best, back = cost[0].copy(), np.zeros((n, 2), np.int64)
    for i in range(1, n):
        stay, change = best, best[::-1] + flip_cost
        back[i] = np.where(change < stay, [1, 0], [0, 1])
        best = np.minimum(stay, change) + cost[i]
    path = np.zeros(n, np.int64)
    path[-1] = int(np.argmin(best))
    for i in range(n - 1, 0, -1):
        path[i - 1] = back[i, path[i]]
    return path
