# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make the records of navigation for a dive whose path is stereo odometry, without a DVL."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.errors import StageError
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, identity, tray_poses
from hullrecon.geometry.rotations import roll_pitch_yaw
from hullrecon.navigation.dead_reckoning.dead_reckon import Navigated, finite_attitude
from hullrecon.navigation.dead_reckoning.error_propagation import trajectory_covariance
from hullrecon.navigation.dead_reckoning.nodes import pair_frames
from hullrecon.navigation.sensors.attitude import AttitudeHistory, attitude_history
from hullrecon.navigation.sensors.depth import depth_at_nodes_sigma, nodes_per_reading
from hullrecon.navigation.sensors.servo import Servo, servo
from hullrecon.navigation.sigmas import NavigationSigmas
from hullrecon.navigation.stereo_odometry.calibration_errors import calibration_moment
from hullrecon.navigation.stereo_odometry.pair_motion import Frame, PairMotion
from hullrecon.navigation.stereo_odometry.visual_odometry import (
    StepGuess,
    StereoChain,
    chain_errors,
    compose,
    in_vehicle,
    measure_steps,
)
from hullrecon.records.clock import describe_silence, seconds, unread_s
from hullrecon.records.sensors import ImuSamples, JointSamples, PressureSamples
from hullrecon.records.trajectory import Attitude, Odometry, Returns, Trajectory
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

FEATURES = 4000  # of an image whose motion is measured
INLIERS = 15  # features that must agree on a motion between two images


@dataclass(frozen=True, kw_only=True)
class Frames:
    """Usable frames of both cameras in time order, as stamps and rows of the camera's index."""

    top: tuple[Ints, Ints]
    bottom: tuple[Ints, Ints]


@dataclass(frozen=True, kw_only=True)
class Aids:
    """Sensors beside the cameras that support stereo odometry. None: not logged."""

    imu: ImuSamples | None = None
    pressure: PressureSamples | None = None
    tray: JointSamples | None = None


@dataclass(frozen=True, kw_only=True)
class MeasuredDepth:
    """Depth by the pressure sensor at the nodes (n)."""

    depth: Array  # (n,) m
    silence: str  # description of spans without a reading
    shared: Array  # (n,) nodes per reading, 0 without a reading nearby


def stereo_navigate(
    frames: Frames,
    aids: Aids,
    motion: PairMotion[Frame],
    rig: Rig,
    sigmas: NavigationSigmas,
    calibration_sigma: Array,
    progress: Callable[[Sequence[int]], Iterable[int]] = list,
) -> Navigated:
    """Compute the path of a dive by stereo odometry.

    The path starts at the first pair with x = y = 0. The attitude there is the IMU's, else level
    with heading 0. The depth is the pressure sensor's, else 0.

    Parameters
    ----------
    frames, aids
        The images, and what other sensors measured.
    motion
        Measures the motion between two stereo pairs.
    rig, sigmas
        Where sensors sit, and how well they are known.
    calibration_sigma
        Sigma (k,) of the calibration errors by which motions are differentiated, NaN where it is
        estimated from the dive.
    progress
        Shows how many pairs were read.

    Raises
    ------
    StageError
        Where there are fewer than two pairs, or where more than half of the steps cannot be
        measured.
    """
    t_ns, image = stereo_pairs(frames)

    # Motions between stereo pairs, in the camera's and then in the vehicle's axes.
    tray = servo(aids.tray, int(t_ns[0]))
    angle = tray.angle_at(t_ns)
    vehicle_from_camera = tray_poses(rig.tray_origin, angle) @ rig.tray_from(Camera.TOP)
    history = _smooth_attitude(aids.imu, sigmas.tilt_rad)
    guess = _prepare_guess(t_ns, history, vehicle_from_camera)
    chain = measure_steps([(int(a), int(b)) for a, b in image], motion, guess, progress)
    refuse_unjoined(len(chain.lost), len(chain.step))
    step, covariance, by_calibration = in_vehicle(chain, vehicle_from_camera)

    # The path that they give from the first pair on, with its errors.
    depth = _measured_depth(aids.pressure, t_ns)
    path = compose(_start_pose(history, depth, t_ns, rig), step)
    calibration = calibration_moment(chain.evidence, calibration_sigma)
    errors = chain_errors(path, covariance, by_calibration, calibration)
    trajectory = Trajectory(
        t_ns=t_ns,
        quaternion=path.quaternion,
        translation=path.translation,
        covariance=trajectory_covariance(errors, path),
        tray=angle,
        image=image,
    )
    unpaired = len(frames.top[0]) + len(frames.bottom[0]) - 2 * len(image)
    return Navigated(
        trajectory=trajectory,
        error_model=errors,
        odometry=_odometry_of_steps(
            step,
            covariance + by_calibration @ calibration @ np.swapaxes(by_calibration, 1, 2),
            chain.lost,
        ),
        returns=no_returns(),
        attitude=_record_attitude(history, depth, t_ns, sigmas, tray),
        remarks=_remarks(chain, t_ns, unpaired, aids, depth, tray),
        facts=_facts(chain, step, t_ns),
    )


def stereo_pairs(frames: Frames) -> tuple[Ints, Ints]:
    """Pair the frames of both cameras: stamps (n,), and rows (n, 2) in the cameras' indices.

    Raises StageError where there are fewer than two pairs.
    """
    pair = pair_frames(frames.top[0], frames.bottom[0])
    if len(pair) < 2:
        where = (
            f"{len(frames.top[0])} images of the top camera, {len(frames.bottom[0])} of the other"
        )
        raise StageError("fewer than two stereo pairs by their stamps", where=where)
    top, bottom = pair.T
    return frames.top[0][top], np.stack([frames.top[1][top], frames.bottom[1][bottom]], axis=1)


def refuse_unjoined(lost: int, steps: int) -> None:
    """Raise StageError where more than half of the steps cannot be measured."""
    if 2 * lost > steps:
        where = f"{lost} of {steps} steps have fewer than {INLIERS} common features"
        raise StageError("the stereo pairs do not join", where=where)


def _smooth_attitude(imu: ImuSamples | None, sigma_tilt_rad: float) -> AttitudeHistory | None:
    """Smooth the attitude. None where no IMU was logged, or one without orientations."""
    if imu is None or np.isfinite(imu.quaternion).all(axis=1).sum() < 2:
        return None
    return attitude_history(finite_attitude(imu), sigma_tilt_rad)


def _prepare_guess(
    t_ns: Ints, history: AttitudeHistory | None, vehicle_from_camera: Poses
) -> StepGuess:
    """Collect what a motion between two stereo pairs is guessed from where their images fail.

    Its translation is guessed from the motion before it, and its turn from the IMU. Without an IMU
    both come from the motion before.

    Parameters
    ----------
    t_ns
        Times (n,) of the stereo pairs.
    history
        Attitude (global_from_vehicle) by the IMU, None without one.
    vehicle_from_camera
        Poses (n) of the top camera at these times, which follow the tray.
    """
    t_s = seconds(t_ns, int(t_ns[0]))
    if history is None:
        return StepGuess(t_s=t_s)
    camera = history.rotation(t_ns) * vehicle_from_camera.rotation
    return StepGuess(
        t_s=t_s, camera=camera, turn_variance=history.turn_variance(t_ns[:-1], t_ns[1:])
    )


def _start_pose(
    history: AttitudeHistory | None, depth: MeasuredDepth | None, t_ns: Ints, rig: Rig
) -> Poses:
    """Compute global_from_vehicle at the first pair, from the IMU's attitude and the depth.

    The vehicle is level without an IMU, and at depth 0 without a pressure sensor.
    """
    start = (
        identity()
        if history is None
        else Poses(history.rotation(t_ns[:1]).as_quat(), np.zeros((1, 3)))
    )
    if depth is None:
        return start
    sensor = start.apply(rig.pressure_origin)[0, 2]
    return Poses(start.quaternion, np.array([[0.0, 0.0, depth.depth[0] - sensor]]))


def _measured_depth(pressure: PressureSamples | None, t_ns: Ints) -> MeasuredDepth | None:
    """Interpolate the depth of the sensor at the nodes. None with fewer than two readings.

    Nodes far from any reading get an interpolated depth too, but share no reading: their depth then
    has a wide sigma.
    """
    if pressure is None or np.isfinite(pressure.depth).sum() < 2:
        return None
    known = np.isfinite(pressure.depth)
    start = int(t_ns[0])
    read_ns = pressure.t_ns[known]
    depth = np.interp(seconds(t_ns, start), seconds(read_ns, start), pressure.depth[known])
    shared = nodes_per_reading(read_ns, t_ns, unread_s(read_ns, t_ns) == 0)
    return MeasuredDepth(depth=depth, silence=describe_silence(read_ns, t_ns), shared=shared)


def _odometry_of_steps(step: Poses, covariance: Array, lost: Ints) -> Odometry:
    """Write the steps as odometry, which the adjustment takes as measured.

    Derivatives by errors of DVL, mount and tray are zero: cameras alone measured the steps.

    covariance: of the steps, the calibration's errors included. lost: rows of steps that were
    guessed, so that they do not count as measured by images.
    """
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
        from_images=~np.isin(np.arange(m), lost),
    )


def no_returns() -> Returns:
    """Make the empty record of a dive without a DVL."""
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


def _record_attitude(
    history: AttitudeHistory | None,
    depth: MeasuredDepth | None,
    t_ns: Ints,
    sigmas: NavigationSigmas,
    tray: Servo,
) -> Attitude:
    """Record depth, roll and pitch of the nodes, with a wide sigma for what was not measured.

    Where neither depth nor attitude was measured, only the tray is recorded.
    """
    direction = tray.direction_at(t_ns)
    tray_sigma = np.hypot(tray.unread_sigma(t_ns), sigmas.tray_unknown_rad)
    if history is None and depth is None:
        none = np.zeros(0)
        return Attitude(
            node=np.zeros(0, np.int64),
            depth=none,
            roll=none,
            pitch=none,
            sigma=np.zeros((0, 3)),
            nodes_per_reading=none,
            tray_direction=direction,
            tray_sigma=tray_sigma,
        )
    n = len(t_ns)
    roll, pitch = (
        np.zeros((2, n)) if history is None else roll_pitch_yaw(history.rotation(t_ns)).T[:2]
    )
    tilt = (
        np.full(n, np.pi)
        if history is None
        else np.hypot(sigmas.tilt_rad, history.unread_sigma(t_ns))
    )
    shared = np.zeros(n) if depth is None else depth.shared
    return Attitude(
        node=np.arange(n),
        depth=np.zeros(n) if depth is None else depth.depth,
        roll=roll,
        pitch=pitch,
        sigma=np.stack([depth_at_nodes_sigma(sigmas.depth_m, shared), tilt, tilt], axis=1),
        nodes_per_reading=shared,
        tray_direction=direction,
        tray_sigma=tray_sigma,
    )


def _remarks(
    chain: StereoChain,
    t_ns: Ints,
    unpaired: int,
    aids: Aids,
    depth: MeasuredDepth | None,
    tray: Servo,
) -> list[str]:
    """Describe what the path lacks: sensors that were not logged or were silent, guessed steps.

    Nothing is said where nothing is lacking.

    unpaired: images without a partner in the other camera.
    """
    no_depth, no_angle = "" if depth is None else depth.silence, tray.silence(t_ns)
    longest_s = 1e-9 * float(np.diff(t_ns)[chain.lost].max(initial=0))
    sentences = [
        (aids.imu is None, "no IMU: the vehicle is taken to be level at the first pair"),
        (aids.pressure is None, "no pressure: the depth is counted from the first pair"),
        (no_depth, f"pressure: {no_depth}; there the depth is counted on by the cameras"),
        (
            no_angle,
            (
                f"tray: {no_angle}; there it is taken to stand as last read, or to turn "
                "evenly between two readings"
            ),
        ),
        (unpaired, f"images without a partner in the other camera, and without a pose: {unpaired}"),
        (
            len(chain.lost),
            f"{len(chain.lost)} of {len(chain.step)} steps could not be seen and were "
            "guessed from the step before, the"
            f" longest {longest_s:.1f} s",
        ),
    ]
    return [sentence for holds, sentence in sentences if holds]


def _facts(chain: StereoChain, step: Poses, t_ns: Ints) -> dict[str, object]:
    """Collect numbers for navigation.json: inliers, guessed steps, and the path's length.

    step: motions of the vehicle. t_ns (n,): stamps of the pairs.
    """
    return {
        "start_ns": int(t_ns[0]),
        "inliers": chain.inliers.tolist(),
        "lost_steps": chain.lost.tolist(),
        "lost_s": np.round(1e-9 * np.diff(t_ns)[chain.lost], 3).tolist(),
        "path_length_m": round(float(np.linalg.norm(step.translation, axis=1).sum()), 3),
    }
