# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Dead reckoning from the logs to the records that later steps read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import roll_pitch_yaw
from hullrecon.navigation.dead_reckoning.error_propagation import (
    dead_reckoning_errors,
    trajectory_covariance,
)
from hullrecon.navigation.dead_reckoning.exposures import CameraTiming, exposures_of
from hullrecon.navigation.dead_reckoning.image_walk import ImageWalk
from hullrecon.navigation.dead_reckoning.nodes import NODE_SPACING_S, Nodes, choose_nodes
from hullrecon.navigation.dead_reckoning.odometry import (
    odometry,
    widen_for_delay,
    widen_for_tray,
)
from hullrecon.navigation.dead_reckoning.reckoning import Instant, Reckoning, reckon
from hullrecon.navigation.dead_reckoning.remarks import remarks_of
from hullrecon.navigation.dead_reckoning.returns import flag_ranges, returns
from hullrecon.navigation.dead_reckoning.unplaced import describe_unplaced
from hullrecon.navigation.sensors.attitude import AttitudeHistory, attitude_history
from hullrecon.navigation.sensors.depth import Depth, depth_at_nodes_sigma, hold_to_pressure
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.sensors.velocity import LONGEST_GAP_S, Velocities, usable_velocities
from hullrecon.navigation.sigmas import NavigationSigmas
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PressureSamples,
)
from hullrecon.records.trajectory import (
    Attitude,
    Odometry,
    Returns,
    Trajectory,
    TrajectoryErrorModel,
    VehiclePath,
)
from hullrecon.rig import Rig
from hullrecon.typing import Ints

# Before the first and after the last velocity each image within REACH_S gets a node. Farther images
# do only as long as each overlaps its neighbour
REACH_S = 1.0
# sigma of the motion across an outage above which images that overlap neither side get no pose
LOST_SIGMA_M = 0.5


@dataclass(frozen=True, kw_only=True)
class NavigationLogs:
    """The streams that navigation reads. None: not logged."""

    dvl: DvlPings
    imu: ImuSamples
    pressure: PressureSamples | None = None
    tray: JointSamples | None = None
    top: ImageIndex | None = None
    bottom: ImageIndex | None = None
    timing: CameraTiming = field(default_factory=CameraTiming)  # of the images


@dataclass(frozen=True, kw_only=True)
class Navigated:
    """Results of the step."""

    trajectory: Trajectory
    error_model: TrajectoryErrorModel
    odometry: Odometry
    returns: Returns
    attitude: Attitude
    remarks: list[str] = field(default_factory=list)  # sentences for the log
    facts: dict[str, object] = field(default_factory=dict)  # for navigation.json


def dead_reckon(
    logs: NavigationLogs,
    rig: Rig,
    sigmas: NavigationSigmas,
    walk: ImageWalk | None = None,
    readings: MotionReadings | None = None,
) -> Navigated:
    """Reckon the path of a dive from DVL, IMU, pressure and tray.

    x = y = 0 at the first ping with a velocity while the IMU runs. The heading is as logged. What
    was wrong with the sensors is put into words (`remarks`).

    Parameters
    ----------
    logs, rig, sigmas
        What the sensors measured, where they sit, and how well both are known.
    walk
        Follows the upper camera's images where DVL or IMU are silent. Images there get nodes as
        long as each overlaps its neighbour. Without it, images before and after the DVL get no
        node, and all images in an outage do.
    readings
        Velocities and attitude of these logs, where they were computed already.

    Raises
    ------
    StageError
        Where there are fewer than two usable velocities, attitudes or nodes.
    """
    # The path, and the nodes on it at which it is recorded.
    readings = usable_readings(logs, sigmas.tilt_rad) if readings is None else readings
    velocities, start_ns, span = _extend_velocities(logs, readings.velocities, walk)
    history = readings.attitude
    path = reckon(velocities, history, servo(logs.tray, int(velocities.t_ns[0])), rig, start_ns)
    nodes = _place_nodes(logs, path, span, walk)
    at = path.at(nodes.t_ns)
    depth = _correct_depth(logs.pressure, path, nodes)

    # The DVL's returns at the nodes, and what was wrong with the sensors.
    beams = returns(logs.dvl, path, at, flag_ranges(logs.dvl, sigmas.range_m))
    notes, facts = remarks_of(logs.dvl.t_ns, path, nodes, depth, beams)
    notes += describe_unplaced(logs.dvl, logs.imu, logs.pressure, velocities, nodes.t_ns, beams)

    # Poses with their errors, and the motions between neighbouring nodes.
    poses = _poses_at_nodes(path, at, depth)
    errors = dead_reckoning_errors(path, at, poses, depth, sigmas)
    covariance = trajectory_covariance(errors, poses)
    trajectory = Trajectory(
        t_ns=at.t_ns,
        quaternion=poses.quaternion,
        translation=poses.translation,
        covariance=covariance,
        tray=at.tray.copy(),
        image=nodes.image.copy(),
    )

    def path_at(t_ns: Ints) -> VehiclePath:
        """Interpolate vehicle and tray on the path at times (m,)."""
        instant = path.at(t_ns)
        return VehiclePath(poses=instant.poses(), tray=instant.tray)

    exposures = exposures_of(trajectory, beams, (logs.top, logs.bottom), logs.timing, path_at, rig)
    edges = widen_for_delay(odometry(path, at), path, at, sigmas.dvl_late_s)
    attitude = _record_attitude(path, at, depth, sigmas)
    return Navigated(
        trajectory=replace(trajectory, exposures=exposures),
        error_model=errors,
        odometry=widen_for_tray(edges, attitude.tray_sigma),
        returns=beams,
        attitude=attitude,
        remarks=notes,
        facts=facts,
    )


def refuse_unreckonable(logs: NavigationLogs) -> None:
    """Raise StageError where DVL and IMU are too short for a path, without computing one."""
    logs = usable_logs(logs)
    velocities, _, span = _extend_velocities(logs, _placed_velocities(logs), None)
    _nodes_in(logs, velocities, span)


@dataclass(frozen=True, kw_only=True)
class MotionReadings:
    """Usable velocities of the DVL and smoothed attitude of the IMU, before integration."""

    velocities: Velocities  # those while the IMU was read
    attitude: AttitudeHistory


def usable_readings(logs: NavigationLogs, tilt_rad: float) -> MotionReadings:
    """Reject outliers of the DVL's velocities and smooth the IMU's attitude.

    Both are needed before there is a path, to compare the sensors' clocks. Velocities from before
    and after the IMU's record are left out.

    tilt_rad: white sigma of roll and pitch where the IMU's rates do not tell it.
    """
    return MotionReadings(
        velocities=_placed_velocities(logs), attitude=attitude_history(logs.imu, tilt_rad)
    )


def _placed_velocities(logs: NavigationLogs) -> Velocities:
    """Select the DVL's velocities while the IMU was read, without outliers."""
    slack = int(LONGEST_GAP_S * 1e9)
    read = int(logs.imu.t_ns[0]) - slack, int(logs.imu.t_ns[-1]) + slack
    return usable_velocities(logs.dvl, read)


def usable_logs(logs: NavigationLogs) -> NavigationLogs:
    """Keep the IMU's readings with an orientation, and the pressure if it has two readings.

    Raises StageError where the IMU gave fewer than two orientations.
    """
    pressure = logs.pressure
    if pressure is not None and np.isfinite(pressure.depth).sum() < 2:
        pressure = None
    return replace(logs, imu=finite_attitude(logs.imu), pressure=pressure)


def finite_attitude(imu: ImuSamples) -> ImuSamples:
    """Keep the readings with an orientation.

    Raises StageError where there are fewer than two.
    """
    known = np.isfinite(imu.quaternion).all(axis=1) & (np.linalg.norm(imu.quaternion, axis=1) > 0.5)
    if not known.any():
        raise StageError(
            "the IMU gave no orientation",
            where="imu",
            remedy="log sensor_msgs/Imu with its orientation filled in",
        )
    if known.sum() < 2:
        raise StageError(
            "the IMU gave a single orientation, and a path needs two",
            where="imu",
            remedy="see whether dive.from and dive.to leave the others out",
        )
    return ImuSamples(
        t_ns=imu.t_ns[known],
        quaternion=imu.quaternion[known],
        angular_velocity=imu.angular_velocity[known],
        acceleration=imu.acceleration[known],
    )


def _extend_velocities(
    logs: NavigationLogs, found: Velocities, walk: ImageWalk | None
) -> tuple[Velocities, int, tuple[int, int]]:
    """Take in velocities from before and after the IMU's record, as far as images go on there.

    There the attitude is held, with a sigma that grows, so the velocities give a rough path on
    which images get nodes. Each of these images overlaps its neighbour, so that links can hold it.
    Without a walk (no images) nothing is added. Raises StageError for fewer than two velocities.

    found: velocities while the IMU was read.

    Returns
    -------
    tuple
        The velocities, the stamp of the first one while the IMU was read, and the span in which
        images get a pose, ns.
    """
    reach = int(REACH_S * 1e9)
    if len(found.t_ns) < 2:
        where = (
            f"{len(logs.dvl.t_ns)} pings, {len(found.t_ns)} with a velocity "
            "while the IMU was running"
        )
        raise StageError("the DVL gave no velocity to reckon with", where=where)
    # images within REACH_S of the first and last velocity get a pose anyway; beyond, only those
    # that overlap
    measured_ns = int(found.t_ns[0]), int(found.t_ns[-1])
    reached = measured_ns[0] - reach, measured_ns[1] + reach
    span = reached if walk is None else walk.widened(reached)
    # velocities are taken in only at an end beyond which images go on
    if span != reached:
        first = span[0] if span[0] < reached[0] else measured_ns[0]
        last = span[1] if span[1] > reached[1] else measured_ns[1]
        found = usable_velocities(logs.dvl, (first, last))
    return found, measured_ns[0], span


def _place_nodes(
    logs: NavigationLogs,
    path: Reckoning,
    span_ns: tuple[int, int],
    walk: ImageWalk | None,
) -> Nodes:
    """Place the nodes of the path at images, and at pings where there are no images.

    In a long outage of the DVL the vehicle may have gone anywhere. Where its displacement is known
    worse than LOST_SIGMA_M, frames that no chain of overlapping frames joins to either side of the
    outage get no node. Raises StageError for fewer than two nodes.

    Parameters
    ----------
    logs
        Stamps of images and pings, at which nodes are placed.
    path
        Its velocities say where the outages are, and how well they are bridged.
    span_ns
        First and last instant at which frames get a node.
    walk
        Finds the frames that overlap neither side of an outage. Without it each frame gets a node.
    """
    # frames in badly bridged outages that are joined to neither side, as spans
    outages = path.velocities.outages
    unsure = outages[path.velocities.bridged_variance(*outages.T) > LOST_SIGMA_M**2]
    lost = [] if walk is None else [walk.lost_in((begin, end)) for begin, end in unsure.tolist()]
    return _nodes_in(logs, path.velocities, span_ns, [span for span in lost if span is not None])


def _nodes_in(
    logs: NavigationLogs,
    velocities: Velocities,
    span_ns: tuple[int, int],
    lost_ns: Sequence[tuple[int, int]] = (),
) -> Nodes:
    """Choose the nodes of a span, but for frames in `lost_ns`.

    Raises StageError for fewer than two nodes.
    """
    measured_ns, reach = velocities.t_ns, int(REACH_S * 1e9)
    pings = logs.dvl.t_ns[
        (logs.dvl.t_ns >= measured_ns[0] - reach) & (logs.dvl.t_ns <= measured_ns[-1] + reach)
    ]
    top, bottom = usable_frames(logs.top), usable_frames(logs.bottom)
    nodes = choose_nodes(top, bottom, pings, span_ns, lost_ns)
    if len(nodes.t_ns) < 2:
        raise StageError("fewer than two images and pings lie where the motion is known")
    return nodes


def _correct_depth(pressure: PressureSamples | None, path: Reckoning, nodes: Nodes) -> Depth | None:
    """Correct the path's depth by the pressure sensor.

    None without a pressure sensor, or where it was not read near any node.
    """
    if pressure is None:
        return None
    found = hold_to_pressure(pressure, path, nodes.t_ns, 0.5 * NODE_SPACING_S)
    return None if found.unread_s.all() else found


def usable_frames(index: ImageIndex | None) -> tuple[Ints, Ints]:
    """List stamps and rows of the frames that decode, in time order. Empty without an index.

    Rows are those in the index, by which images are read.
    """
    if index is None:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    rows = np.flatnonzero(index.usable)
    rows = rows[np.argsort(index.t_ns[rows], kind="stable")]
    return index.t_ns[rows], rows


def _poses_at_nodes(path: Reckoning, at: Instant, depth: Depth | None) -> Poses:
    """Compute global_from_vehicle (n) at the nodes, with x = y = 0 at the start.

    z is that of the path, corrected by the pressure sensor. Without one it is 0 at the start too.
    """
    start = path.at(np.array([path.start_ns])).poses().translation[0]
    position = at.poses().translation - start
    if depth is not None:
        position[:, 2] = at.poses().translation[:, 2] + depth.shift
    return Poses(at.rotation.as_quat(), position)


def _record_attitude(
    path: Reckoning, at: Instant, depth: Depth | None, sigmas: NavigationSigmas
) -> Attitude:
    """Record depth, roll and pitch of the nodes with their sigmas, as the adjustment uses them.

    Values without a reading nearby get a wide sigma. Sigmas of nodes that share a pressure reading
    are inflated, so that it counts once. That of a late pressure sensor grows with the rate of the
    depth.
    """
    n = len(at.t_ns)
    roll, pitch, _ = roll_pitch_yaw(at.rotation).T
    measured = np.zeros(n) if depth is None else depth.measured
    shared = np.zeros(n) if depth is None else depth.shared
    tilt = np.hypot(sigmas.tilt_rad, path.attitude.unread_sigma(at.t_ns))
    late_m = sigmas.pressure_late_s * np.abs(np.gradient(measured, at.t_s))
    depth_m = np.hypot(depth_at_nodes_sigma(sigmas.depth_m, shared), late_m)
    return Attitude(
        node=np.arange(n),
        depth=measured,
        roll=roll,
        pitch=pitch,
        sigma=np.stack([depth_m, tilt, tilt], axis=1),
        nodes_per_reading=shared,
        tray_direction=at.direction.copy(),
        tray_sigma=np.hypot(path.servo.unread_sigma(at.t_ns), sigmas.tray_unknown_rad),
    )
