# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimate how long after the top camera the bottom one is exposed, from the motion in between.

Between two exposures the rig moves on. That moves the bottom camera's image across its epipolar
lines one way on one leg and the other way on the way back, which no calibration does
(docs/methods.md 4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, exp
from hullrecon.geometry.robust import SIGNIFICANT, huber_weight, robust_sigma
from hullrecon.rig import Rig
from hullrecon.typing import Array
from hullrecon.vision.pairs.two_view import essential_of, sampson_squared
from hullrecon.vision.stereo.matching import rectify, triangulate

# Sigma of the rig's rotation and of the baseline's direction, rad. As good as unknown: what a wrong
# calibration explains must not count as a delay.
RIG_SIGMA_RAD = 0.05
# A shorter delay moves features at usual speeds by less than calibrations are wrong
LEAST_S = 0.002
# Sigma of a delay that remains however many features agree, s: from changes of speed within an
# exposure, and from lenses
FLOOR_S = 0.0003
# Delays are searched within +-FARTHEST_S: less than half the period of a camera with two images a
# second.
FARTHEST_S, STEP_S = 0.24, 0.02
STEPS, SETTLED = 8, 1e-5  # Gauss-Newton steps at most, and the step (rad or s) that ends them
FEW = 60  # matches of a pair that are used to find the starting value
DIFFERENCE = 1e-4  # rad or s, for numeric derivatives


@dataclass(frozen=True, kw_only=True)
class MatchedRays:
    """The matches of a pair of images of the two cameras, and how the tray moved."""

    top: Array  # (n, 2) ideal coordinates
    bottom: Array  # (n, 2) of the same features
    twist: Array  # (6,) of the tray in its own axes, m/s and rad/s; NaN where not measured
    stamped_s: float  # the bottom image's stamp minus the top image's

    def every(self, step: int) -> MatchedRays:
        """Select every `step`-th match."""
        return replace(self, top=self.top[::step], bottom=self.bottom[::step])


@dataclass(frozen=True, kw_only=True)
class Delay:
    """How much the bottom camera's stamps are before its exposure, and the sigma."""

    early_s: float  # to be added to the stamps; negative where they are late
    sigma_s: float

    @property
    def is_significant(self) -> bool:
        """Whether the delay is believed and worth a correction."""
        return abs(self.early_s) > max(SIGNIFICANT * self.sigma_s, LEAST_S)


def estimate_delay(rig: Rig, pairs: Sequence[MatchedRays]) -> Delay | None:
    """Estimate the bottom camera's delay together with errors of the rig's calibration.

    Both move features off their epipolar lines, so that a wrong calibration would otherwise pass as
    a delay. It starts at the delay of least epipolar error on a grid of delays, then takes
    Gauss-Newton steps on delay, rotation and direction of the baseline. The variance of the delay
    is that of the matches plus the cluster-robust one, which holds differences between pairs of
    images beyond their noise. None where fewer than three pairs have a known motion, or where
    nothing moved.
    """
    pairs = [pair for pair in pairs if np.isfinite(pair.twist).all()]
    if len(pairs) < 3:
        return None
    starts = np.arange(-FARTHEST_S, FARTHEST_S + STEP_S, STEP_S)
    # The shortest first: of equally good delays the shortest is taken.
    starts = starts[np.argsort(np.abs(starts), kind="stable")]
    unknowns = np.zeros(6)
    # At most FEW matches of each pair are enough to choose the start.
    few = [pair.every(-(-len(pair.top) // FEW)) for pair in pairs]
    unknowns[5] = min(starts, key=lambda delay_s: _cost(rig, few, np.r_[np.zeros(5), delay_s]))
    information, scatter = np.eye(6), np.eye(6)
    for _ in range(STEPS):
        information, gradient, scatter = _normal_equations(rig, pairs, unknowns)
        if np.linalg.cond(information) > 1e14:  # nothing moved
            return None
        step = np.linalg.solve(information, gradient)
        unknowns = unknowns - step
        if np.abs(step).max() < SETTLED:
            break
    inverse = np.linalg.inv(information)
    variance = (inverse @ scatter @ inverse)[5, 5] + inverse[5, 5]
    return Delay(early_s=float(unknowns[5]), sigma_s=float(np.hypot(np.sqrt(variance), FLOOR_S)))


def move_to_top(rig: Rig, pair: MatchedRays, delay_s: float) -> Array:
    """Predict a pair's bottom features as if both cameras had been exposed at the same time.

    Then the calibrated rig applies to them. Each match is triangulated with the bottom camera where
    it was when exposed, and the point is projected into the bottom camera where it was when the top
    one was exposed. Features without a valid point are left unchanged. delay_s: to be added to the
    bottom camera's stamps.

    Returns
    -------
    bottom
        (n, 2) ideal coordinates.
    """
    moved = _bottom_moved(rig, pair, delay_s)
    if rig.stereo_mount is None:
        return pair.bottom
    turned = rectify(rig.stereo_mount @ moved)
    point = triangulate(turned, turned.rectify_top(pair.top), turned.rectify_bottom(pair.bottom))
    in_bottom = rig.stereo_mount.inverse().apply(point)
    depth = in_bottom[:, 2:]
    out = np.where(depth > 0, in_bottom[:, :2] / np.where(depth > 0, depth, 1.0), np.nan)
    return np.where(np.isfinite(out), out, pair.bottom)


def _bottom_moved(rig: Rig, pair: MatchedRays, delay_s: float) -> Poses:
    """Compute the bottom camera's motion from the top camera's exposure to its own.

    Returns the pose of the bottom camera when it was exposed, in the axes of the bottom camera when
    the top one was exposed, a batch of one. delay_s: to be added to the
    bottom image's stamp.
    """
    # The twist is of the tray, in its own axes. The mount takes it to the camera's.
    mount = rig.tray_from(Camera.BOTTOM)
    moved = exp((pair.stamped_s + delay_s) * pair.twist[None])
    return mount.inverse() @ moved @ mount


def _residuals(rig: Rig, pair: MatchedRays, unknowns: Array) -> Array:
    """Compute signed Sampson distances (n,) of matches from their epipolar lines.

    They are in ideal coordinates. unknowns: (6,) error of the bottom camera's rotation (3) and of
    the baseline's direction (2), rad, and the delay, s.
    """
    assert rig.stereo_mount is not None
    # Rectified cameras have the baseline along y: rows 0 and 2 are the axes across it
    turned = rectify(rig.stereo_mount).rotation_top
    across = unknowns[3] * turned[0] + unknowns[4] * turned[2]
    error = exp(np.r_[0.0, 0.0, 0.0, unknowns[:3]][None])
    corrected = Poses(
        (rig.stereo_mount @ error).quaternion,
        rig.stereo_mount.translation + rig.baseline_m * across,
    )
    top_from_bottom = corrected @ _bottom_moved(rig, pair, float(unknowns[5]))
    essential = essential_of(top_from_bottom.inverse().matrix()[0])
    bottom, top = (np.hstack([xy, np.ones((len(xy), 1))]) for xy in (pair.bottom, pair.top))
    # The Sampson distance is taken as a magnitude. The epipolar constraint gives its sign.
    sign = np.sign(np.einsum("ni,ij,nj->n", bottom, essential, top))
    return np.asarray(sign * np.sqrt(sampson_squared(essential, pair.top, pair.bottom)))


def _cost(rig: Rig, pairs: Sequence[MatchedRays], unknowns: Array) -> float:
    """Sum the mean distances of the pairs' matches from their epipolar lines.

    Each distance is capped at 3 px: beyond, it is that of a wrong match. unknowns: (6,) as of
    `_residuals`.
    """
    cap = 3 / rig.focal_px(Camera.TOP)
    return float(
        sum(np.minimum(np.abs(_residuals(rig, pair, unknowns)), cap).mean() for pair in pairs)
    )


def _normal_equations(
    rig: Rig, pairs: Sequence[MatchedRays], unknowns: Array
) -> tuple[Array, Array, Array]:
    """Sum the normal equations of all pairs, with Huber weights and numeric derivatives.

    Returns
    -------
    information, gradient
        (6, 6) and (6,) of the unknowns of `_residuals`, with the prior of the calibration.
    scatter
        (6, 6) sum of the outer products of each pair's gradient, for the cluster-robust variance.
    """
    residual = [_residuals(rig, pair, unknowns) for pair in pairs]
    sigma = robust_sigma(np.concatenate(residual), about=0.0)
    prior = np.diag(np.r_[np.full(5, RIG_SIGMA_RAD**-2), 0.0])
    information, gradient, scatter = prior, prior @ unknowns, np.zeros((6, 6))
    for pair, r in zip(pairs, residual, strict=True):
        jacobian = np.stack(
            [
                (_residuals(rig, pair, unknowns + step) - _residuals(rig, pair, unknowns - step))
                / (2 * DIFFERENCE)
                for step in DIFFERENCE * np.eye(6)
            ],
            axis=1,
        )
        weight = huber_weight(r, sigma)
        weighted = jacobian * weight[:, None]
        own = weighted.T @ r
        information, gradient = information + weighted.T @ jacobian, gradient + own
        scatter += np.outer(own, own)
    return information, gradient, scatter
