# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A dive before an ellipsoid at the level of poses and beams, without logs and images.

The near pole of the ellipsoid is the origin, 3 m deep. Its near side faces -x, y runs along it.
Every error is drawn from the sigma that the rig states. One ping a pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, exp, from_matrix, from_rpy, identity
from hullrecon.records.trajectory import Attitude, Odometry, Returns, Trajectory
from hullrecon.rig import Rig, RigPriors
from hullrecon.typing import Array

STEP_M, STEP_S = 0.12, 0.4
STANDOFF_M = 1.2
POLE_DEPTH_M = 3.0
STEP_SIGMA = np.repeat([0.001, 0.0002], 3)  # m, rad
ATTITUDE_SIGMA = np.array([0.01, 1e-3, 1e-3])  # depth m, roll and pitch rad
MOUNT_SIGMA = np.radians(0.2)
RANGE_SIGMA_M = 0.01
TRAY_ORIGIN_M = np.array([0.4, 0.0, 0.1])
BEAMS = np.array(
    [[0.75**0.5, 0.5, 0], [0.75**0.5, -0.5, 0], [0.75**0.5, 0, 0.5], [0.75**0.5, 0, -0.5]]
)


@dataclass(frozen=True, kw_only=True)
class EllipsoidDive:
    """The true path, with the tray at zero, and the simulated navigation."""

    truth: Poses
    trajectory: Trajectory
    odometry: Odometry
    attitude: Attitude
    returns: Returns
    rig: Rig


def spiral_around_a_sphere(
    seed: int, *, radius_m: float, turns: float, drift_deg_per_hour: float
) -> EllipsoidDive:
    """Dive around a sphere [Ozog2016 C], half a metre deeper each turn, facing its middle.

    turns: number of rounds. drift_deg_per_hour: of the heading.
    """
    rng = np.random.default_rng(seed)
    reach = radius_m + STANDOFF_M
    turned = np.arange(0, 2 * np.pi * turns, STEP_M / reach)
    down = 0.5 * turned / (2 * np.pi) - 0.25 * turns  # m below the middle
    out = np.column_stack([-np.cos(turned), -np.sin(turned)]) * np.sqrt(reach**2 - down**2)[:, None]
    # roll, pitch and yaw swing by 0.6 degrees about facing the middle
    wobble = np.radians(0.6) * np.sin(np.outer(np.arange(len(turned)), [0.11, 0.17, 0.07]))
    rpy = wobble + np.c_[np.zeros((len(turned), 2)), turned]
    truth = from_rpy(np.column_stack([out + np.r_[radius_m, 0], down + POLE_DEPTH_M]), rpy)
    return measured_dive(rng, truth, drift_deg_per_hour, np.full(3, radius_m))


def measured_dive(
    rng: np.random.Generator,
    truth: Poses,
    drift_deg_per_hour: float,
    semi_axes_m: Array,
    nearer_m: Array | float = 0.0,
    bumps_m: float = 0.0,
) -> EllipsoidDive:
    """Simulate what is measured along a path before an ellipsoid.

    Parameters
    ----------
    rng
        Draws all errors.
    truth
        global_from_vehicle (n).
    drift_deg_per_hour
        Drift of the heading.
    semi_axes_m
        (3,) across, along and down.
    nearer_m
        By how much the surface lies nearer along x at each pose (n,).
    bumps_m
        Height of a rough surface, as of rock.
    """
    # Errors of navigation: scale, drift rad/s, roll and pitch rad, depth m, servo
    sigma = np.r_[0.003, np.radians(abs(drift_deg_per_hour)) / 3600, 1e-3, 1e-3, 0.02, 1e-9]
    navigation = sigma * rng.standard_normal(6)
    navigation[1] = np.radians(drift_deg_per_hour) / 3600
    turn = MOUNT_SIGMA * rng.standard_normal(3)
    matrices = truth.matrix()
    odometry = measured_steps(rng, matrices, navigation, turn, STEP_S, STEP_SIGMA)
    odometry = replace(odometry, by_tray=np.zeros((len(truth) - 1, 6)))
    attitude = _attitude(rng, truth, navigation)
    mount = exp(np.r_[np.zeros(3), turn])
    return EllipsoidDive(
        truth=truth,
        trajectory=reckoned(matrices[0], odometry, STEP_S),
        odometry=odometry,
        attitude=attitude,
        returns=_ranges(
            rng, truth, mount, semi_axes_m, np.broadcast_to(nearer_m, len(truth)), bumps_m
        ),
        rig=_rig(sigma),
    )


def _attitude(rng: np.random.Generator, truth: Poses, navigation: Array) -> Attitude:
    """Measure depth, roll and pitch at each pose, off by the biases and by white noise.

    navigation: (6,) errors, as of `measured_dive`.
    """
    n = len(truth)
    roll_pitch = truth.rotation.as_euler("xyz")[:, :2] - navigation[2:4]
    measured = np.column_stack([truth.translation[:, 2] + navigation[4], roll_pitch])
    measured += ATTITUDE_SIGMA * rng.standard_normal(measured.shape)
    return Attitude(
        node=np.arange(n),
        depth=measured[:, 0],
        roll=measured[:, 1],
        pitch=measured[:, 2],
        sigma=np.tile(ATTITUDE_SIGMA, (n, 1)),
        nodes_per_reading=np.ones(n),
        tray_direction=np.ones(n),
        tray_sigma=np.zeros(n),
    )


def _rig(navigation_sigma: Array) -> Rig:
    """Describe the rig: the DVL's turn known to MOUNT_SIGMA, its place known, no camera.

    navigation_sigma: (6,) of the errors of navigation.
    """
    sqrt_information = np.diag(1 / np.r_[np.full(3, 1e-6), np.full(3, MOUNT_SIGMA)])
    return Rig(
        tray_origin=TRAY_ORIGIN_M,
        pressure_origin=np.zeros(3),
        tray_from_dvl=identity(1),
        priors=RigPriors(
            tray_from_dvl=sqrt_information,
            dvl_position_sigma_m=np.zeros(3),
            tray_sigma_rad=1e-4,
            navigation_sigma=navigation_sigma,
            density_sigma=0.002,
            range_sigma_m=RANGE_SIGMA_M,
        ),
    )


def _ranges(
    rng: np.random.Generator,
    truth: Poses,
    mount: Poses,
    axes: Array,
    nearer_m: Array,
    bumps_m: float,
) -> Returns:
    """Measure the range of each beam at each pose to the ellipsoid.

    mount: true tray_from_dvl. axes: half axes (3,) m. nearer_m, bumps_m: as of `measured_dive`.
    """
    n = len(truth)
    tray = Poses(np.array([[0, 0, 0, 1.0]]), TRAY_ORIGIN_M[None])
    dvl = truth @ tray @ mount
    node = np.repeat(np.arange(n), 4)
    beam = np.tile(BEAMS, (n, 1))
    along = dvl.rotation[node].apply(beam)
    middle = np.c_[axes[0] - nearer_m[node], np.zeros(4 * n), np.full(4 * n, POLE_DEPTH_M)]
    # In units of its half axes the ellipsoid is a unit sphere: the nearer root of a quadratic
    start = (dvl.translation[node] - middle) / axes
    a, b, c = (
        np.sum((along / axes) ** 2, 1),
        np.sum(along / axes * start, 1),
        np.sum(start**2, 1) - 1,
    )
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


def measured_steps(
    rng: np.random.Generator,
    truth: Array,
    navigation: Array,
    mount: Array,
    step_s: float,
    step_sigma: Array,
) -> Odometry:
    """Simulate the odometry of a path, one step every step_s.

    Parameters
    ----------
    rng
        Draws the white noise.
    truth
        global_from_vehicle (n, 4, 4).
    navigation
        Its first two: error of scale, and drift of the heading, rad/s.
    mount
        Turn (3,) of the DVL, rad.
    step_sigma
        White noise (6,) m, rad.
    """
    first, second = np.arange(len(truth) - 1), np.arange(1, len(truth))
    step = np.linalg.inv(truth[first]) @ truth[second]
    t, m = step[:, :3, 3], len(first)
    by_navigation, by_mount, by_tray = np.zeros((m, 6, 2)), np.zeros((m, 6, 3)), np.zeros((m, 6))
    by_navigation[:, :3, 0] = t
    by_navigation[:, :3, 1] = 0.5 * step_s * np.cross(truth[first, 2, :3], t)
    by_navigation[:, 3:, 1] = step_s * truth[second, 2, :3]
    # A small turn of the mount does turn x t.
    by_mount[:, :3] = np.cross(t[:, None], np.eye(3))
    by_tray[:, :3] = np.cross([0.0, 1.0, 0.0], t)
    error = (
        by_navigation @ navigation[:2] + by_mount @ mount + step_sigma * rng.standard_normal((m, 6))
    )
    turn = Rotation.from_matrix(step[:, :3, :3]) * Rotation.from_rotvec(-error[:, 3:])
    return Odometry(
        first=first,
        second=second,
        quaternion=turn.as_quat(),
        translation=t - error[:, :3],
        covariance=np.tile(np.diag(step_sigma**2), (m, 1, 1)),
        by_navigation=by_navigation,
        by_mount=by_mount,
        by_tray=by_tray,
        from_images=np.zeros(m, bool),
    )


def reckoned(start: Array, odometry: Odometry, step_s: float) -> Trajectory:
    """Chain odometry from a first pose global_from_vehicle (4, 4), one node every step_s.

    Its covariance is unity: a pose graph does not read it.
    """
    track = [start]
    for step in Poses(odometry.quaternion, odometry.translation).matrix():
        track.append(track[-1] @ step)
    found, n = from_matrix(np.array(track)), len(track)
    return Trajectory(
        t_ns=(step_s * 1e9 * np.arange(n)).astype(np.int64),
        quaternion=found.quaternion,
        translation=found.translation,
        covariance=np.tile(np.eye(6), (n, 1, 1)),
        tray=np.zeros(n),
        image=np.tile(np.arange(n)[:, None], (1, 2)),
    )
