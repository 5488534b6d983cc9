# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Covariance of the motion between two views of a camera whose calibration is uncertain.

[Ozog2016 D.1.2, D.1.3]: what the features leave open, and what the nine intrinsics add to it, to
first order (D.8) or by the unscented transform (D.9, Algorithm 6). Both of a camera's views share
the errors of its calibration. Motions second_from_first are (4, 4) with |t| = 1. Their differences
are the five numbers of `vision.pairs.mono_motion`: the rotation perturbed on the right and the
direction of the translation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.problem.intrinsics import NAMES
from hullrecon.geometry.cameras import CameraModel
from hullrecon.typing import Array
from hullrecon.vision.pairs.mono_motion import fit, linearise, tangent_basis

KAPPA = 0.0  # of the transform: the centre has no weight, as in `gating.transfer`
STEP = 1e-3  # of a numeric derivative, in sigmas of the unknown


@dataclass(frozen=True, kw_only=True)
class TwoViews:
    """Matches of two images of one camera."""

    camera: CameraModel  # as it is calibrated
    first: Array  # (n, 2) px
    second: Array  # (n, 2) px, of the same points

    def ideal(self, error: Array) -> tuple[Array, Array]:
        """Compute ideal coordinates (n, 2) in both images, the intrinsics off by an error (9,)."""
        moved = dict(zip(NAMES, self.camera.parameters() + error, strict=True))
        camera = replace(self.camera, **moved)
        return camera.undistort(self.first), camera.undistort(self.second)

    def motion(self, start: Array, error: Array) -> Array:
        """Fit second_from_first (4, 4), |t| = 1, with the intrinsics off by an error (9,).

        start: (4, 4) from which the fit starts.
        """
        return fit(start, *self.ideal(error))


def first_order(views: TwoViews, motion: Array, covariance: Array) -> Array:
    """Propagate a calibration's covariance (9, 9) to a fitted motion: B S B' (5, 5) of (D.8).

    With r the Sampson distances, B = -(J'J)^-1 J' dr/dc. What (D.8) holds beside it, second
    derivatives times residuals, is of the noise's size.
    """
    root = _columns(covariance)
    by_motion = linearise(motion, *views.ideal(np.zeros(len(root))))[1]
    by_calibration = np.column_stack(
        [
            (_distances(views, motion, STEP * c) - _distances(views, motion, -STEP * c))
            / (2 * STEP)
            for c in root.T
        ]
    )
    moved = np.linalg.lstsq(by_motion, by_calibration, rcond=None)[0]
    return np.asarray(moved @ moved.T)


def unscented(views: TwoViews, motion: Array, covariance: Array) -> Array:
    """Propagate a calibration's covariance (9, 9) to a fitted motion: Sigma_UT (5, 5) of (D.9).

    Lines 5 to 10 of Algorithm 6: the motion is fitted anew with the calibration at each of nineteen
    sigma points. What the features leave open, Sigma_HZ, is added by the caller (line 11).
    """
    root = _columns(covariance)
    size = len(root)
    steps = np.sqrt(size + KAPPA) * root.T
    at = np.vstack([np.zeros(size), steps, -steps])
    weight = np.r_[KAPPA, np.full(2 * size, 0.5)] / (size + KAPPA)
    numbers = np.array([five_numbers(views.motion(motion, error), motion) for error in at])
    off = numbers - weight @ numbers
    return np.asarray((weight * off.T) @ off)


def sampled(
    views: TwoViews,
    motion: Array,
    covariance: Array,
    draws: int,
    rng: np.random.Generator,
    noise_px: float = 0.0,
) -> Array:
    """Fit the motion with calibrations drawn of a covariance (9, 9).

    Returns how each fit differs from `motion`, the fit with the calibration as it is: five numbers
    (draws, 5) as of `five_numbers`. motion: (4, 4) second_from_first, at which fits start.
    `noise_px`: sigma of the features, drawn as well.
    """
    errors = rng.standard_normal((draws, len(covariance))) @ _columns(covariance).T
    out = []
    for error in errors:
        noise = noise_px * rng.standard_normal((2, *views.first.shape))
        seen = replace(views, first=views.first + noise[0], second=views.second + noise[1])
        out.append(five_numbers(seen.motion(motion, error), motion))
    return np.array(out)


def five_numbers(motion: Array, about: Array) -> Array:
    """Compute a motion's five numbers about another motion, both (4, 4).

    They are the rotation vector between them, less than half a turn, and the direction of the
    translation across that of the other.
    """
    turn = Rotation.from_matrix(about[:3, :3].T @ motion[:3, :3]).as_rotvec()
    return np.concatenate([turn, tangent_basis(about[:3, 3]).T @ motion[:3, 3]])


def _distances(views: TwoViews, motion: Array, error: Array) -> Array:
    """Compute Sampson distances (n,) of the matches with the intrinsics off by an error (9,)."""
    return linearise(motion, *views.ideal(error))[0]


def _columns(covariance: Array) -> Array:
    """Compute a square root of a covariance, whose columns are sigmas along its axes."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0)))
