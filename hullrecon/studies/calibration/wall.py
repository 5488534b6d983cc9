# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sigma of the motion between two views of a wall, by features and by calibration."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem.intrinsics import prior_sigma
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import exp
from hullrecon.studies.calibration.two_views import TwoViews, first_order, sampled, unscented
from hullrecon.studies.study import StudyResult
from hullrecon.typing import Array
from hullrecon.vision.pairs.mono_motion import linearise

CAMERA = CameraModel(1360, 1024, 1200.0, 1200.0, 679.5, 511.5, k1=-0.13, k2=0.05)
# baseline 1; a wall five baselines ahead with a relief of a third of one
SECOND_FROM_FIRST = exp([[-1.0, 0.0, 0.0, *np.radians([1.0, 5.0, 0.5])]]).matrix()[0]
DISTANCE, RELIEF, POINTS, DRAWS = 5.0, 0.33, 150, 200
FEATURES_PX = {"fiducials, 0.05 px": 0.05, "SIFT, 0.5 px": 0.5}
CALIBRATIONS = {"a fifth": 0.2, "as adjust allows": 1.0, "four times": 4.0}
HEADS = ("features", "calibration", "alone, mrad", "first order", "sigma points", "drawn")


def study() -> StudyResult:
    """Tabulate the sigmas."""
    values = sigmas_of_wall()
    return StudyResult(values=dict(values), heads=HEADS, rows=wall_rows(values))


def sigmas_of_wall() -> dict[str, dict[str, float]]:
    """Compute sigmas of the rotation, rad, by features and calibration, in four ways.

    By the features alone, with the part of the calibration to first order, with that part by sigma
    points, and as the scatter of fits to drawn features with drawn calibrations.
    """
    rng = np.random.default_rng(0)
    views, found = views_of_wall(rng), {}
    by_motion = linearise(SECOND_FROM_FIRST, *views.ideal(np.zeros(9)))[1]
    for features, noise_px in FEATURES_PX.items():
        alone = np.asarray((noise_px / CAMERA.fx) ** 2 * np.linalg.inv(by_motion.T @ by_motion))
        for calibration, factor in CALIBRATIONS.items():
            covariance = np.diag((factor * prior_sigma(CAMERA, AdjustOptions())) ** 2)
            given = views, SECOND_FROM_FIRST, covariance
            drawn = sampled(*given, DRAWS, rng, noise_px=noise_px)
            found[f"{features}; {calibration}"] = {
                "features_rad": _rotation(alone),
                "first_order_rad": _rotation(alone + first_order(*given)),
                "sigma_points_rad": _rotation(alone + unscented(*given)),
                "drawn_rad": float(np.sqrt(drawn[:, :3].var(axis=0).sum())),
            }
    return found


def wall_rows(found: Mapping[str, Mapping[str, float]]) -> tuple[tuple[str, ...], ...]:
    """Tabulate the sigmas of `sigmas_of_wall` in mrad."""
    return tuple(
        (*name.split("; "), *(f"{1e3 * sigma:.3g}" for sigma in row.values()))
        for name, row in found.items()
    )


def views_of_wall(rng: np.random.Generator, points: int = POINTS) -> TwoViews:
    """Simulate matches of two views of a wall, without noise. points: their number."""
    first = rng.uniform(0, [CAMERA.width, CAMERA.height], (points, 2))
    depth = DISTANCE + RELIEF * rng.standard_normal((points, 1))
    there = np.hstack([CAMERA.undistort(first), np.ones((points, 1))]) * depth
    moved = there @ SECOND_FROM_FIRST[:3, :3].T + SECOND_FROM_FIRST[:3, 3]
    return TwoViews(camera=CAMERA, first=first, second=CAMERA.project(moved))


def _rotation(covariance: Array) -> float:
    """Compute the sigma of the whole rotation from a motion's covariance (5, 5)."""
    return float(np.sqrt(np.trace(covariance[:3, :3])))
