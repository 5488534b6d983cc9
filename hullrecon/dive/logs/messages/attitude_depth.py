# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Translate messages of attitude and of depth to samples: one small function per type.

Arguments are those of `Translate` in samples.py.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.dive.logs.messages.covariance import (
    DEEP_PA,
    FAR_M,
    FASTEST_TURN_RAD_S,
    LOST_SIGMA,
    NO_DIRECTION_RAD,
    sigma_of,
)
from hullrecon.dive.logs.messages.decode import Fields, vector
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.logs.samples import LOST, DepthSample, ImuSample, PressureSample, Sample

AXES = (0, 1, 2)  # of a covariance
NO_DATA = -9999.0  # ds_sensor_msgs: DEPTH_PRESSURE_NO_DATA


def imu(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read sensor_msgs/Imu, with NaN for quantities that their covariances mark as not measured.

    The attitude is lost where roll or pitch is unknown. The sigma of the heading does not count:
    it may be large, as north is unknown, while the changes of the heading are measured well.
    """
    q = message.orientation
    attitude_lost = sigma_of(message.orientation_covariance, (0, 1)) > NO_DIRECTION_RAD
    rates_lost = sigma_of(message.angular_velocity_covariance, AXES) > FASTEST_TURN_RAD_S
    acceleration_lost = sigma_of(message.linear_acceleration_covariance, AXES) == LOST_SIGMA
    return [
        ImuSample(
            t_ns,
            np.full(4, np.nan) if attitude_lost else np.array([q.x, q.y, q.z, q.w], float),
            LOST if rates_lost else vector(message.angular_velocity),
            LOST if acceleration_lost else vector(message.linear_acceleration),
        )
    ]


def fluid_pressure(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read sensor_msgs/FluidPressure without readings that their variance marks as lost."""
    lost = sigma_of([message.variance], (0,)) > DEEP_PA
    return [PressureSample(t_ns, np.nan if lost else float(message.fluid_pressure))]


def attitude_of_pose(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the orientation of geometry_msgs/PoseStamped."""
    return [_attitude(message.pose.orientation, t_ns)]


def attitude_of_pose_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the orientation of geometry_msgs/PoseWithCovarianceStamped and of nav_msgs/Odometry."""
    found = _attitude(message.pose.pose.orientation, t_ns)
    lost = sigma_of(message.pose.covariance, (3, 4)) > NO_DIRECTION_RAD
    return [replace(found, quaternion=np.full(4, np.nan)) if lost else found]


def _attitude(q: Fields, t_ns: int) -> ImuSample:
    """Convert a quaternion to an attitude without rates and acceleration."""
    return ImuSample(t_ns, np.array([q.x, q.y, q.z, q.w], float), LOST, LOST)


def depth_of_point(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read z of geometry_msgs/PointStamped as the height over the water, up as in REP 103."""
    return [DepthSample(t_ns, float(message.point.z), is_up=True)]


def depth_of_pose(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read z of geometry_msgs/PoseStamped as the height over the water, up as in REP 103."""
    return [DepthSample(t_ns, float(message.pose.position.z), is_up=True)]


def depth_of_pose_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read z of PoseWithCovarianceStamped and nav_msgs/Odometry, up as in REP 103."""
    lost = sigma_of(message.pose.covariance, (2,)) > FAR_M
    return [DepthSample(t_ns, np.nan if lost else float(message.pose.pose.position.z), is_up=True)]


def depth_of_number(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read std_msgs/Float64 and Float32 as a depth, positive down."""
    return [DepthSample(t_ns, float(message.data), is_up=False)]


def depth_of_head_up_display(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read mavros_msgs/VfrHud: its altitude is up, and negative under water (MAVLink, VFR_HUD)."""
    return [DepthSample(t_ns, float(message.altitude), is_up=True)]


def deep_submergence_depth(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the depth of ds_sensor_msgs/DepthPressure, computed with gravity at its latitude.

    Raises DamagedError where it has none.
    """
    if message.depth <= NO_DATA:
        raise DamagedError("a DepthPressure without a depth")
    return [DepthSample(t_ns, float(message.depth), is_up=False)]
