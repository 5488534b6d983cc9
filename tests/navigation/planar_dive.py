# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Dives at the level of poses and beams: legs up and down before an ellipsoid, DVL, attitude,
depth, no camera.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.poses import Poses, from_rpy
from hullrecon.studies.scenes.ellipsoid_dive import (
    POLE_DEPTH_M,
    STANDOFF_M,
    STEP_M,
    EllipsoidDive,
    measured_dive,
)


def simulate(
    seed: int,
    *,
    drift_deg_per_hour: float,
    legs: int = 4,
    leg_m: float = 12.0,
    spacing_m: float = 0.5,
    semi_axes_m: tuple[float, float, float] = (5.0, 30.0, 6.0),
    off_m: float = 0.0,
    bumps_m: float = 0.0,
) -> EllipsoidDive:
    """The dive. semi_axes_m: of the ellipsoid across, along and down; off_m: by how much the odd
    legs truly see another, nearer surface, as where something hangs before the hull; bumps_m: of a
    surface that is rough, as rock is.
    """
    rng = np.random.default_rng(seed)
    axes = np.array(semi_axes_m)
    truth, leg = true_path(legs, leg_m, spacing_m, axes, rng)
    return measured_dive(rng, truth, drift_deg_per_hour, axes, off_m * (leg % 2), bumps_m)


def surface_x(axes: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """x of the ellipsoid's near side; its pole is the origin."""
    return np.asarray(axes[0] * (1 - np.sqrt(1 - (y / axes[1]) ** 2 - (z / axes[2]) ** 2)))


def true_path(
    legs: int, leg_m: float, spacing_m: float, axes: np.ndarray, rng: np.random.Generator
) -> tuple[Poses, np.ndarray]:
    """The vehicle faces the hull, +x, and goes sideways; legs (n,): number of each pose's leg."""
    per_leg = round(leg_m / STEP_M)
    k = np.tile(np.arange(per_leg), legs)
    leg = np.repeat(np.arange(legs), per_leg)
    y = leg_m * (np.where(leg % 2, per_leg - 1 - k, k) / per_leg - 0.5) + 0.25 * leg_m
    z = spacing_m * (leg - 0.5 * (legs - 1)) + 0.3
    turn = (
        np.sum(
            [
                np.sin(np.outer(np.arange(len(k)), rate) + rng.uniform(0, 6, 6))
                for rate in rng.uniform(0.05, 0.5, (5, 6))
            ],
            axis=0,
        )
        * np.r_[np.full(3, 0.008), np.radians([0.6, 0.6, 0.8])]
    )
    heading = np.arctan2(surface_x(axes, y + 1e-3, z) - surface_x(axes, y - 1e-3, z), 2e-3)
    place = np.column_stack([surface_x(axes, y, z) - STANDOFF_M, y, z + POLE_DEPTH_M]) + turn[:, :3]
    return from_rpy(place, turn[:, 3:] + np.c_[np.zeros((len(k), 2)), -heading]), leg


def aligned(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Errors (n, 3) after the best rigid motion."""
    a, b = found - found.mean(0), truth - truth.mean(0)
    u, _, vt = np.linalg.svd(b.T @ a)
    return np.asarray(a @ (u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt).T - b)
