# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Translate messages of attitude and of depth to samples: one small function per type."""

from __future__ import annotations

import numpy as np

from hullrecon.dive.logs.messages.decode import LOST, Fields, vector
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.logs.samples import DepthSample, ImuSample, PressureSample, Sample

NO_DATA = -9999.0  # ds_sensor_msgs: DEPTH_PRESSURE_NO_DATA


def imu(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read sensor_msgs/Imu. A covariance of -1 marks a quantity that the IMU does not measure."""
    q = message.orientation
    quaternion = np.array([q.x, q.y, q.z, q.w], float)
    given = [
        np.asarray(c)[0] != -1
        for c in (
            message.orientation_covariance,
            message.angular_velocity_covariance,
            message.linear_acceleration_covariance,
        )
    ]
    return [
        ImuSample(
            t_ns,
            quaternion if given[0] else np.full(4, np.nan),
            vector(message.angular_velocity) if given[1] else LOST,
            vector(message.linear_acceleration) if given[2] else LOST,
        )
    ]


def fluid_pressure(message: Fields, t_ns: int, role: str) -> list[Sample]:
    return [PressureSample(t_ns, float(message.fluid_pressure))]


def attitude_of_pose(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the orientation of geometry_msgs/PoseStamped."""
    return [_attitude(message.pose.orientation, t_ns)]


def attitude_of_pose_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the orientation of geometry_msgs/PoseWithCovarianceStamped and of nav_msgs/Odometry."""
    return [_attitude(message.pose.pose.orientation, t_ns)]


def _attitude(q: Fields, t_ns: int) -> ImuSample:
    return ImuSample(t_ns, np.array([q.x, q.y, q.z, q.w], float), LOST, LOST)


def depth_of_pose(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read z of geometry_msgs/PoseStamped as the height over the water, up as in REP 103."""
    return [DepthSample(t_ns, float(message.pose.position.z), is_up=True)]


def depth_of_pose_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read z of PoseWithCovarianceStamped and nav_msgs/Odometry, up as in REP 103."""
    return [DepthSample(t_ns, float(message.pose.pose.position.z), is_up=True)]


def depth_of_number(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read std_msgs/Float64 and Float32 as a depth, positive down."""
    return [DepthSample(t_ns, float(message.data), is_up=False)]


def depth_of_head_up_display(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read mavros_msgs/VfrHud: its altitude is up, and negative under water (MAVLink, VFR_HUD)."""
    return [DepthSample(t_ns, float(message.altitude), is_up=True)]


def deep_submergence_depth(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the depth of ds_sensor_msgs/DepthPressure, which has the latitude in it already."""
    if message.depth <= NO_DATA:
        raise DamagedError("a DepthPressure without a depth")
    return [DepthSample(t_ns, float(message.depth), is_up=False)]
