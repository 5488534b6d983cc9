# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Translate messages to samples, one small function a type; the tables at the end say which topics take which types."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hullrecon.dive.logs.dvl_beams import A50, a50_beams
from hullrecon.dive.logs.messages.decode import Fields
from hullrecon.dive.logs.messages.pictures import encode_raw
from hullrecon.dive.logs.readers.unpack import DamagedError, printable
from hullrecon.dive.logs.samples import DvlSample, ImageSample, ImuSample, JointSample, PressureSample, Sample, SonarSample
from hullrecon.typing import Array

LOST = np.full(3, np.nan)
NO_RANGES = np.zeros(0)
DTYPES = {0: "u1", 1: "i1", 2: "u2", 3: "i2", 4: "u4", 5: "i4", 6: "u8", 7: "i8", 8: "f4", 9: "f8"}  # of SonarImageData
FIGURE_OF_MERIT_LIMIT = 0.4  # m/s; Water Linked: velocities with a larger figure of merit are not valid
NORTEK_LOST, NORTEK_BAD_MERIT = -32.0, 10.0  # m/s; Nortek: velocities of -32.768 and figures of merit of 10 are invalid


def stamp_ns(header: Fields) -> int:
    return int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)


def vector(v: Fields) -> Array:
    return np.array([v.x, v.y, v.z], float)


def marine_dvl(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read marine_acoustic_msgs/Dvl.

    A lost velocity has a covariance of -1, or comes from the water; a lost beam a range of 0, negative or NaN, or a covariance
    of -1.
    """
    covariance = np.asarray(message.velocity_covar, float)
    ranges = np.asarray(message.range, float).copy()
    bad = np.asarray(message.range_covar, float) == -1
    ranges[bad | ~(ranges > 0)] = np.nan
    if not message.beam_ranges_valid:
        ranges[:] = np.nan
    beams = np.array([vector(b) for b in message.beam_unit_vec])
    of_the_water = message.velocity_mode == 2
    velocity = LOST if covariance[0] == -1 or of_the_water else vector(message.velocity)
    return [DvlSample(t_ns, velocity, _sigma(covariance[[0, 4, 8]]), ranges, beams if _are_unit(beams) else None)]


def twist_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geometry_msgs/TwistWithCovarianceStamped and nav_msgs/Odometry: no ranges."""
    covariance = np.asarray(message.twist.covariance, float)
    velocity = LOST if covariance[0] == -1 else vector(message.twist.twist.linear)
    return [DvlSample(t_ns, velocity, _sigma(covariance[[0, 7, 14]]), NO_RANGES, None)]


def twist(message: Fields, t_ns: int, role: str) -> list[Sample]:
    return [DvlSample(t_ns, vector(message.twist.linear), np.nan, NO_RANGES, None)]


def water_linked(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the A50's report: figure of merit as sigma, one entry a beam with its own validity.

    Its beams are those of the A50: the message has none.
    """
    valid = bool(message.velocity_valid)
    ranges = [b.distance if b.valid and b.distance > 0 else np.nan for b in sorted(message.beams, key=lambda b: int(b.id))]
    sigma = float(message.fom) if 0 < message.fom < FIGURE_OF_MERIT_LIMIT else np.nan
    beams = a50_beams() if len(ranges) == 4 else None
    velocity = vector(message.velocity) if valid else LOST
    return [DvlSample(t_ns, velocity, sigma, np.array(ranges, float), beams, A50 if beams is not None else "")]


def girona_dvl(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read cola2_msgs/DVL: velocity with covariance, one altitude, no beams."""
    covariance = np.asarray(message.velocity_covariance, float)
    velocity = LOST if covariance[0] == -1 else vector(message.velocity)
    return [DvlSample(t_ns, velocity, _sigma(covariance[[0, 4, 8]]), NO_RANGES, None)]


def simulator_dvl(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read DVLs of UUV Simulator and Stonefish: as Girona's, with one message a beam; a covariance of -1 marks a lost one."""
    covariance = np.asarray(message.velocity_covariance, float)
    velocity = LOST if covariance[0] == -1 else vector(message.velocity)
    ranges = [b.range if b.range > 0 and b.range_covariance != -1 else np.nan for b in message.beams]
    return [DvlSample(t_ns, velocity, _sigma(covariance[[0, 4, 8]]), np.array(ranges, float), None)]


def nortek_dvl(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read nortek_dvl/Dvl: figure of merit as sigma; a lost velocity is -32.768, a lost distance 0."""
    velocity, merit = vector(message.velocity), float(message.figureOfMerit)
    lost = bool(np.any(velocity <= NORTEK_LOST)) or merit >= NORTEK_BAD_MERIT
    ranges = np.asarray(message.beamDistance, float)
    sigma = merit if 0 < merit < FIGURE_OF_MERIT_LIMIT else np.nan
    return [DvlSample(t_ns, LOST if lost else velocity, sigma, np.where(ranges > 0, ranges, np.nan), None)]


def imu(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read sensor_msgs/Imu. A covariance of -1 says that the IMU does not measure that quantity."""
    q = message.orientation
    quaternion = np.array([q.x, q.y, q.z, q.w], float)
    given = [np.asarray(c)[0] != -1 for c in (
        message.orientation_covariance, message.angular_velocity_covariance, message.linear_acceleration_covariance
    )]  # fmt: skip
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


def joint_state(message: Fields, t_ns: int, role: str) -> list[Sample]:
    return [
        JointSample(t_ns, printable(str(name)), float(angle))
        for name, angle in zip(message.name, message.position, strict=False)
    ]


def compressed_image(message: Fields, t_ns: int, role: str) -> list[Sample]:
    return [ImageSample(t_ns, role, bytes(message.data))]


def raw_image(message: Fields, t_ns: int, role: str) -> list[Sample]:
    return [ImageSample(t_ns, role, encode_raw(message))]


def projected_sonar(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read ProjectedSonarImage. The pixel of range bin r and beam b lies at r * beam_count + b."""
    if int(message.image.dtype) not in DTYPES:
        raise DamagedError(f"a sonar image of data type {message.image.dtype}")
    order = ">" if message.image.is_bigendian else "<"
    directions = np.array([vector(b) for b in message.beam_directions]).reshape(-1, 3)
    range_m = np.asarray(message.ranges, float)
    pixels = np.frombuffer(bytes(message.image.data), order + DTYPES[int(message.image.dtype)])
    beams = int(message.image.beam_count)
    if beams != len(directions) or pixels.size != beams * len(range_m) or not pixels.size:
        raise DamagedError(f"a sonar image of {pixels.size} pixels for {beams} beams and {len(range_m)} ranges")
    return [SonarSample(t_ns, np.ascontiguousarray(pixels.reshape(len(range_m), beams).T), directions, range_m)]


def _sigma(variances: Array) -> float:
    """One sigma of a velocity from the diagonal of its covariance; NaN where that is zero or senseless."""
    mean = float(np.mean(variances))
    return float(np.sqrt(mean)) if np.isfinite(mean) and mean > 0 else float("nan")


def _are_unit(beams: Array) -> bool:
    return bool(np.all(np.abs(np.linalg.norm(beams, axis=1) - 1) < 0.02))


Translate = Callable[[Fields, int, str], Sequence[Sample]]
DVL_TYPES: dict[str, Translate] = {
    "marine_acoustic_msgs/msg/Dvl": marine_dvl,
    "geometry_msgs/msg/TwistWithCovarianceStamped": twist_with_covariance,
    "geometry_msgs/msg/TwistStamped": twist,
    "nav_msgs/msg/Odometry": twist_with_covariance,
    "waterlinked_a50_ros_driver/msg/DVL": water_linked,
    "dvl_msgs/msg/DVL": water_linked,
    "cola2_msgs/msg/DVL": girona_dvl,
    "uuv_sensor_ros_plugins_msgs/msg/DVL": simulator_dvl,
    "stonefish_ros/msg/DVL": simulator_dvl,
    "nortek_dvl/msg/Dvl": nortek_dvl,
}
IMAGE_TYPES: dict[str, Translate] = {"sensor_msgs/msg/CompressedImage": compressed_image, "sensor_msgs/msg/Image": raw_image}
TYPES: dict[str, dict[str, Translate]] = {
    "dvl": DVL_TYPES,
    "imu": {"sensor_msgs/msg/Imu": imu},
    "pressure": {"sensor_msgs/msg/FluidPressure": fluid_pressure},
    "joints": {"sensor_msgs/msg/JointState": joint_state},
    "camera_top": IMAGE_TYPES,
    "camera_bottom": IMAGE_TYPES,
    "sonar": {"marine_acoustic_msgs/msg/ProjectedSonarImage": projected_sonar},
}
