# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A dive at the level of poses and beams: legs up and down before an ellipsoid, DVL, attitude, depth, no camera."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from navigation.linked_dive import ATTITUDE_SIGMA, TRAY_ORIGIN_M, measured_steps, reckoned

from hullrecon.estimation.rig_priors import Mount, Rig
from hullrecon.geometry.poses import Poses, exp, from_rpy, identity
from hullrecon.records.trajectory import Attitude, Odometry, Returns, Trajectory

STEP_M, STEP_S = 0.12, 0.4
STANDOFF_M = 1.2
STEP_SIGMA = np.repeat([0.001, 0.0002], 3)  # m, rad
MOUNT_SIGMA = np.radians(0.2)
RANGE_SIGMA_M = 0.01
BEAMS = np.array([[0.75**0.5, 0.5, 0], [0.75**0.5, -0.5, 0], [0.75**0.5, 0, 0.5], [0.75**0.5, 0, -0.5]])


@dataclass(frozen=True, kw_only=True)
class PlanarDive:
    """The truth, T_g_v (n) with the tray at zero, and what navigation made of it."""

    truth: Poses
    trajectory: Trajectory
    odometry: Odometry
    attitude: Attitude
    returns: Returns
    rig: Rig


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
) -> PlanarDive:
    """The dive. semi_axes_m: of the ellipsoid across, along and down; off_m: by how much the odd legs truly see another, nearer
    surface, as where something hangs before the hull; bumps_m: of a surface that is rough, as rock is."""
    rng = np.random.default_rng(seed)
    axes = np.array(semi_axes_m)
    truth, leg = true_path(legs, leg_m, spacing_m, axes, rng)
    return measured(rng, truth, drift_deg_per_hour, axes, off_m * (leg % 2), bumps_m)


def spiral_around_a_sphere(seed: int, *, radius_m: float, turns: float, drift_deg_per_hour: float) -> PlanarDive:
    """Around a sphere, half a metre deeper each turn, facing its middle."""
    rng = np.random.default_rng(seed)
    reach = radius_m + STANDOFF_M
    turned = np.arange(0, 2 * np.pi * turns, STEP_M / reach)
    down = 0.5 * turned / (2 * np.pi) - 0.25 * turns
    out = np.column_stack([-np.cos(turned), -np.sin(turned)]) * np.sqrt(reach**2 - down**2)[:, None]
    wobble = np.radians(0.6) * np.sin(np.outer(np.arange(len(turned)), [0.11, 0.17, 0.07]))
    rpy = wobble + np.c_[np.zeros((len(turned), 2)), turned]
    truth = from_rpy(np.column_stack([out + np.r_[radius_m, 0], down + 3.0]), rpy)
    return measured(rng, truth, drift_deg_per_hour, np.full(3, radius_m), np.zeros(len(truth)), 0.0)


def measured(
    rng: np.random.Generator, truth: Poses, drift_deg_per_hour: float, axes: np.ndarray, off_m: np.ndarray, bumps_m: float
) -> PlanarDive:
    """What the instruments make of a path."""
    sigma = np.r_[0.003, np.radians(abs(drift_deg_per_hour)) / 3600, 1e-3, 1e-3, 0.02, 1e-9]
    navigation = sigma * rng.standard_normal(6)
    navigation[1] = np.radians(drift_deg_per_hour) / 3600
    turn = MOUNT_SIGMA * rng.standard_normal(3)
    mount = exp(np.r_[np.zeros(3), turn])
    odometry = measured_steps(rng, truth.matrix(), navigation, turn, STEP_S, STEP_SIGMA)
    odometry = replace(odometry, by_tray=np.zeros((len(truth) - 1, 6)))
    roll_pitch = truth.rotation.as_euler("xyz")[:, :2] - navigation[2:4]
    measured = np.column_stack([truth.translation[:, 2] + navigation[4], roll_pitch])
    measured += ATTITUDE_SIGMA * rng.standard_normal(measured.shape)
    n = len(truth)
    attitude = Attitude(
        node=np.arange(n),
        depth=measured[:, 0],
        roll=measured[:, 1],
        pitch=measured[:, 2],
        sigma=np.tile(ATTITUDE_SIGMA, (n, 1)),
        tray_direction=np.ones(n),
        tray_sigma=np.zeros(n),
    )
    return PlanarDive(
        truth=truth,
        trajectory=reckoned(truth.matrix(), odometry),
        odometry=odometry,
        attitude=attitude,
        returns=measured_ranges(rng, truth, mount, axes, off_m, bumps_m),
        rig=rig(sigma),
    )


def rig(navigation_sigma: np.ndarray) -> Rig:
    turn = np.diag(1 / np.r_[np.full(3, 1e-6), np.full(3, MOUNT_SIGMA)])
    return Rig(
        tray_origin=TRAY_ORIGIN_M,
        tray_sigma=1e-4,
        pressure_origin=np.zeros(3),
        T_s_d=Mount(identity(1), turn),
        dvl_position_sigma=np.zeros(3),
        T_s_ct=None,
        T_ct_cb=None,
        top=None,
        bottom=None,
        sigma_px=1.0,
        sigma_range=RANGE_SIGMA_M,
        density_sigma=0.002,
        navigation_sigma=navigation_sigma,
    )


def surface_x(axes: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """x of the ellipsoid's near side; its pole is the origin."""
    return np.asarray(axes[0] * (1 - np.sqrt(1 - (y / axes[1]) ** 2 - (z / axes[2]) ** 2)))


def true_path(
    legs: int, leg_m: float, spacing_m: float, axes: np.ndarray, rng: np.random.Generator
) -> tuple[Poses, np.ndarray]:
    """The vehicle faces the hull, +x, and goes sideways; legs (n,): the number of each pose's leg."""
    per_leg = round(leg_m / STEP_M)
    k = np.tile(np.arange(per_leg), legs)
    leg = np.repeat(np.arange(legs), per_leg)
    y = leg_m * (np.where(leg % 2, per_leg - 1 - k, k) / per_leg - 0.5) + 0.25 * leg_m
    z = spacing_m * (leg - 0.5 * (legs - 1)) + 0.3
    turn = (
        np.sum(
            [np.sin(np.outer(np.arange(len(k)), rate) + rng.uniform(0, 6, 6)) for rate in rng.uniform(0.05, 0.5, (5, 6))],
            axis=0,
        )
        * np.r_[np.full(3, 0.008), np.radians([0.6, 0.6, 0.8])]
    )
    heading = np.arctan2(surface_x(axes, y + 1e-3, z) - surface_x(axes, y - 1e-3, z), 2e-3)
    place = np.column_stack([surface_x(axes, y, z) - STANDOFF_M, y, z + 3.0]) + turn[:, :3]
    return from_rpy(place, turn[:, 3:] + np.c_[np.zeros((len(k), 2)), -heading]), leg


def measured_ranges(
    rng: np.random.Generator, truth: Poses, mount: Poses, axes: np.ndarray, off_m: np.ndarray, bumps_m: float
) -> Returns:
    """One ping a pose: where each beam meets the ellipsoid, whose pole lies at a depth of 3 m; nearer by off_m (n,) along x."""
    n = len(truth)
    tray = Poses(np.array([[0, 0, 0, 1.0]]), TRAY_ORIGIN_M[None])
    dvl = truth @ tray @ mount
    node = np.repeat(np.arange(n), 4)
    beam = np.tile(BEAMS, (n, 1))
    along = dvl.rotation[node].apply(beam)
    start = (dvl.translation[node] - np.c_[axes[0] - off_m[node], np.zeros(4 * n), np.full(4 * n, 3.0)]) / axes
    a, b, c = np.sum((along / axes) ** 2, 1), np.sum(along / axes * start, 1), np.sum(start**2, 1) - 1
    range_m = (-b - np.sqrt(b**2 - a * c)) / a
    end = dvl.translation[node] + range_m[:, None] * along
    range_m += bumps_m * np.sin(4 * end[:, 1] + 1) * np.sin(5 * end[:, 2])
    return Returns(
        t_ns=(STEP_S * 1e9 * node).astype(np.int64),
        node=node,
        quaternion=np.tile([0, 0, 0, 1.0], (4 * n, 1)),
        translation=np.zeros((4 * n, 3)),
        tray_offset=np.zeros(4 * n),
        beam=beam,
        range_m=range_m + RANGE_SIGMA_M * rng.standard_normal(4 * n),
        flagged=np.zeros(4 * n, bool),
    )


def aligned(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Errors (n, 3) after the best rigid motion."""
    a, b = found - found.mean(0), truth - truth.mean(0)
    u, _, vt = np.linalg.svd(b.T @ a)
    return np.asarray(a @ (u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt).T - b)
