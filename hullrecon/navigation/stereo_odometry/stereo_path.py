# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The records of a dive that stereo visual odometry placed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses, identity, tray_poses
from hullrecon.geometry.rotations import roll_pitch_yaw
from hullrecon.navigation.dead_reckoning.dead_reckon import UNKNOWN_SIGMA_M, Navigated, finite_attitude
from hullrecon.navigation.dead_reckoning.error_propagation import trajectory_covariance
from hullrecon.navigation.dead_reckoning.nodes import pair_frames
from hullrecon.navigation.options import NavigateOptions
from hullrecon.navigation.sensors.attitude import AttitudeHistory, attitude_history
from hullrecon.navigation.sensors.clock import in_order, seconds
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.stereo_odometry.stereo_frame import StereoFrame, StereoRig
from hullrecon.navigation.stereo_odometry.visual_odometry import Chain, chain_errors, compose, follow, in_vehicle
from hullrecon.navigation.vehicle import Vehicle
from hullrecon.records.sensors import ImuSamples, JointSamples, PressureSamples
from hullrecon.records.trajectory import Attitude, Odometry, Returns, Trajectory
from hullrecon.typing import Array, Ints


@dataclass(frozen=True)
class Views:
    """Stamps and index rows of the usable frames of both cameras, in time order; `frame` makes a stereo frame of rows (top,
    bottom); T_s_ct, one pose."""

    top: tuple[Ints, Ints]
    bottom: tuple[Ints, Ints]
    frame: Callable[[int, int], StereoFrame]
    T_s_ct: Poses


@dataclass(frozen=True)
class Aids:
    """What else was logged; None where not."""

    imu: ImuSamples | None = None
    pressure: PressureSamples | None = None
    tray: JointSamples | None = None


def stereo_navigate(
    views: Views,
    aids: Aids,
    rig: StereoRig,
    vehicle: Vehicle,
    options: NavigateOptions,
    progress: Callable[[Sequence[int]], Any] = list,
) -> Navigated:
    """The vehicle's path in g by its stereo cameras. g starts at the first pair: x = y = 0; attitude by the IMU, else level
    with heading 0; depth by the pressure sensor, else 0. Raises StageError where fewer than half of the pairs can be joined."""
    pair = pair_frames(views.top[0], views.bottom[0])
    if len(pair) < 2:
        raise StageError("fewer than two stereo pairs", where="navigate", remedy="check the stamps of both cameras")
    t_ns, image = views.top[0][pair[:, 0]], np.stack([views.top[1][pair[:, 0]], views.bottom[1][pair[:, 1]]], axis=1)
    chain = follow(len(pair), lambda k: views.frame(*image[k]), rig, options.stereo_inliers, progress)
    if 2 * len(chain.lost) > len(chain.step):
        where = f"{len(chain.lost)} of {len(chain.step)} steps have fewer than {options.stereo_inliers} common features"
        remedy = "check the calibration and pose_in_top, or lower navigate.stereo_inliers"
        raise StageError("the stereo pairs do not join", where=where, remedy=remedy)
    hung = servo(aids.tray if aids.tray is None else in_order(aids.tray, "tray")[0], int(t_ns[0]))
    angle = hung.angle_at(t_ns)
    step, covariance = in_vehicle(chain, tray_poses(vehicle.tray_origin, angle) @ views.T_s_ct)
    history = _history(aids.imu, vehicle, options)
    depth = _depths(aids.pressure, t_ns)
    path = compose(_start(history, depth, t_ns, vehicle), step)
    errors = chain_errors(path, covariance)
    trajectory = Trajectory(
        t_ns=t_ns,
        quaternion=path.quaternion,
        translation=path.translation,
        covariance=trajectory_covariance(errors, path),
        tray=angle,
        image=image,
    )
    attitude = _attitude(history, depth, t_ns, vehicle, hung.direction_at(t_ns))
    lonely = len(views.top[0]) + len(views.bottom[0]) - 2 * len(pair)
    return Navigated(
        trajectory,
        errors,
        _edges(step, covariance),
        no_returns(),
        attitude,
        _remarks(chain, lonely, aids),
        _facts(chain, step, t_ns),
    )


def _history(imu: ImuSamples | None, vehicle: Vehicle, options: NavigateOptions) -> AttitudeHistory | None:
    """None where no IMU, or one without orientations, was logged."""
    if imu is None or np.isfinite(imu.quaternion).all(axis=1).sum() < 2:
        return None
    return attitude_history(in_order(finite_attitude(imu), "imu")[0], vehicle.sigma_tilt, options.longest_gap_s)


def _start(history: AttitudeHistory | None, depth: Array | None, t_ns: Ints, vehicle: Vehicle) -> Poses:
    start = identity() if history is None else Poses(history.rotation(t_ns[:1]).as_quat(), np.zeros((1, 3)))
    if depth is None:
        return start
    sensor = start.apply(vehicle.pressure_origin)[0, 2]
    return Poses(start.quaternion, np.array([[0.0, 0.0, depth[0] - sensor]]))


def _depths(pressure: PressureSamples | None, t_ns: Ints) -> Array | None:
    """Depth of the sensor at the nodes, linear between readings."""
    if pressure is None or np.isfinite(pressure.depth).sum() < 2:
        return None
    record = in_order(pressure, "pressure")[0]
    known = np.isfinite(record.depth)
    start = int(t_ns[0])
    return np.asarray(np.interp(seconds(t_ns, start), seconds(record.t_ns[known], start), record.depth[known]))


def _edges(step: Poses, covariance: Array) -> Odometry:
    m = len(step)
    return Odometry(
        first=np.arange(m),
        second=np.arange(1, m + 1),
        quaternion=step.quaternion,
        translation=step.translation,
        covariance=covariance,
        by_navigation=np.zeros((m, 6, 2)),
        by_mount=np.zeros((m, 6, 3)),
        by_tray=np.zeros((m, 6)),
    )


def no_returns() -> Returns:
    """The record of a dive without a DVL."""
    ints, floats = np.zeros(0, np.int64), np.zeros(0)
    return Returns(
        t_ns=ints,
        node=ints,
        quaternion=np.zeros((0, 4)),
        translation=np.zeros((0, 3)),
        tray_offset=floats,
        beam=np.zeros((0, 3)),
        range_m=floats,
        flagged=np.zeros(0, bool),
    )


def _attitude(history: AttitudeHistory | None, depth: Array | None, t_ns: Ints, vehicle: Vehicle, direction: Array) -> Attitude:
    """Empty, but for the tray, where neither attitude nor depth was measured; what was not measured has a wide sigma."""
    if history is None and depth is None:
        none = np.zeros(0)
        return Attitude(
            node=np.zeros(0, np.int64), depth=none, roll=none, pitch=none, sigma=np.zeros((0, 3)), tray_direction=direction
        )
    n = len(t_ns)
    roll, pitch = np.zeros((2, n)) if history is None else roll_pitch_yaw(history.rotation(t_ns)).T[:2]
    tilt = np.pi if history is None else vehicle.sigma_tilt
    sigma = np.tile([UNKNOWN_SIGMA_M if depth is None else vehicle.sigma_depth, tilt, tilt], (n, 1))
    return Attitude(
        node=np.arange(n),
        depth=np.zeros(n) if depth is None else depth,
        roll=roll,
        pitch=pitch,
        sigma=sigma,
        tray_direction=direction,
    )


def _remarks(chain: Chain, lonely: int, aids: Aids) -> list[str]:
    said = [
        (True, "no DVL: the path is stereo visual odometry; its scale is that of the rig's baseline"),
        (aids.imu is None, "no IMU: the vehicle is taken to be level at the first pair"),
        (aids.pressure is None, "no pressure: the depth is counted from the first pair"),
        (lonely, f"{lonely} images have no partner in the other camera and no pose"),
        (
            len(chain.lost),
            f"{len(chain.lost)} of {len(chain.step)} steps could not be seen and were guessed from the step before",
        ),
    ]
    return [words for holds, words in said if holds]


def _facts(chain: Chain, step: Poses, t_ns: Ints) -> dict[str, object]:
    return {
        "start_ns": int(t_ns[0]),
        "inliers": chain.inliers.tolist(),
        "lost_steps": chain.lost.tolist(),
        "path_length_m": round(float(np.linalg.norm(step.translation, axis=1).sum()), 3),
    }
