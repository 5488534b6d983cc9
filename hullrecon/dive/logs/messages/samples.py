# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Translate messages to samples. The tables at the end say which topics take which types."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hullrecon.dive.logs.messages import attitude_depth, position, sonar, velocity
from hullrecon.dive.logs.messages.decode import Fields
from hullrecon.dive.logs.messages.pictures import decoded_mosaic, encode_raw
from hullrecon.dive.logs.readers.unpack import DamagedError, printable
from hullrecon.dive.logs.samples import ImageSample, JointSample, Sample


def stamp_ns(header: Fields) -> int:
    """Read the stamp of a message's header, ns."""
    return int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)


def joint_state(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Translate a joint message to an angle for each joint that it names.

    It is NaN for one without a position, as in the messages of a driver that gives speeds. Raises
    DamagedError for positions without names, which may be of any joint.
    """
    if len(message.position) and not len(message.name):
        raise DamagedError("they name no joint; have the driver fill in JointState.name")
    missing = [np.nan] * (len(message.name) - len(message.position))
    return [
        JointSample(t_ns, printable(str(name)), float(angle))
        for name, angle in zip(message.name, [*message.position, *missing], strict=False)
    ]


def compressed_image(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read sensor_msgs/CompressedImage, whose format says what the compressed pixels are."""
    return [ImageSample(t_ns, role, decoded_mosaic(message.format, bytes(message.data)))]


def raw_image(message: Fields, t_ns: int, role: str) -> list[Sample]:
    return [ImageSample(t_ns, role, encode_raw(message))]


# of a decoded message, its stamp, ns, and the sensor's name ("camera_top", ...)
Translate = Callable[[Fields, int, str], Sequence[Sample]]
DVL_TYPES: dict[str, Translate] = {
    "marine_acoustic_msgs/msg/Dvl": velocity.marine_dvl,
    "ds_sensor_msgs/msg/Dvl": velocity.deep_submergence_dvl,
    "waterlinked_a50_ros_driver/msg/DVL": velocity.water_linked,
    "dvl_msgs/msg/DVL": velocity.water_linked,
    "waterlinked_a50/msg/TransducerReportStamped": velocity.transducer_report,
    "waterlinked_dvl/msg/TransducerReportStamped": velocity.unnamed_transducer_report,
    "cola2_msgs/msg/DVL": velocity.simulator_dvl,
    "uuv_sensor_ros_plugins_msgs/msg/DVL": velocity.simulator_dvl,
    "stonefish_ros/msg/DVL": velocity.simulator_dvl,
    "nortek_dvl/msg/Dvl": velocity.nortek_dvl,
    "geometry_msgs/msg/TwistWithCovarianceStamped": velocity.twist_with_covariance,
    "geometry_msgs/msg/TwistStamped": velocity.twist,
    "nav_msgs/msg/Odometry": velocity.twist_with_covariance,
}
IMU_TYPES: dict[str, Translate] = {
    "sensor_msgs/msg/Imu": attitude_depth.imu,
    "geometry_msgs/msg/PoseStamped": attitude_depth.attitude_of_pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": attitude_depth.attitude_of_pose_with_covariance,
    "nav_msgs/msg/Odometry": attitude_depth.attitude_of_pose_with_covariance,
}
PRESSURE_TYPES: dict[str, Translate] = {
    "sensor_msgs/msg/FluidPressure": attitude_depth.fluid_pressure,
    "ds_sensor_msgs/msg/DepthPressure": attitude_depth.deep_submergence_depth,
    "geometry_msgs/msg/PointStamped": attitude_depth.depth_of_point,
    "geometry_msgs/msg/PoseStamped": attitude_depth.depth_of_pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": attitude_depth.depth_of_pose_with_covariance,
    "nav_msgs/msg/Odometry": attitude_depth.depth_of_pose_with_covariance,
    "mavros_msgs/msg/VfrHud": attitude_depth.depth_of_head_up_display,
    "mavros_msgs/msg/VFR_HUD": attitude_depth.depth_of_head_up_display,
    "std_msgs/msg/Float64": attitude_depth.depth_of_number,
    "std_msgs/msg/Float32": attitude_depth.depth_of_number,
}
SONAR_TYPES: dict[str, Translate] = {
    "marine_acoustic_msgs/msg/ProjectedSonarImage": sonar.projected_sonar,
    "acoustic_msgs/msg/SonarImage": sonar.sonar_image,
    "oculus_interfaces/msg/Ping": sonar.oculus_ping,
    "oculus_sonar_driver/msg/OculusSonarRawMsg": sonar.oculus_raw,
}
POSITION_TYPES: dict[str, Translate] = {
    "sensor_msgs/msg/NavSatFix": position.satellite_fix,
    "geographic_msgs/msg/GeoPointStamped": position.geographic_point,
    "geographic_msgs/msg/GeoPoseStamped": position.geographic_pose,
    "geographic_msgs/msg/GeoPoseWithCovarianceStamped": position.geographic_pose_with_covariance,
    "geometry_msgs/msg/PointStamped": position.point,
    "geometry_msgs/msg/PoseStamped": position.pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": position.pose_with_covariance,
}
IMAGE_TYPES: dict[str, Translate] = {
    "sensor_msgs/msg/CompressedImage": compressed_image,
    "sensor_msgs/msg/Image": raw_image,
}
TYPES: dict[str, dict[str, Translate]] = {
    "dvl": DVL_TYPES,
    "imu": IMU_TYPES,
    "pressure": PRESSURE_TYPES,
    "joints": {"sensor_msgs/msg/JointState": joint_state},
    "camera_top": IMAGE_TYPES,
    "camera_bottom": IMAGE_TYPES,
    "sonar": SONAR_TYPES,
    "position": POSITION_TYPES,
}
WITHOUT_HEADER = frozenset(  # they take the time of logging
    {"std_msgs/msg/Float64", "std_msgs/msg/Float32", "waterlinked_a50/msg/TransducerReportStamped"}
)
COMMON_TYPES = frozenset(  # that many kinds of sensors use, so that only the topic's name tells
    {
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "nav_msgs/msg/Odometry",
        "geometry_msgs/msg/TwistWithCovarianceStamped",
        "geometry_msgs/msg/TwistStamped",
        "geometry_msgs/msg/PointStamped",
        "mavros_msgs/msg/VfrHud",
        "mavros_msgs/msg/VFR_HUD",
        "std_msgs/msg/Float64",
        "std_msgs/msg/Float32",
    }
)
