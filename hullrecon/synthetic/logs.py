# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write a simulated dive's log: as MCAP, or as plain tables and images."""

from __future__ import annotations

import io
import zipfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.messages.definitions import DVL, PING_INFO, PROJECTED_SONAR_IMAGE
from hullrecon.synthetic import sonar
from hullrecon.synthetic.instruments import (
    ACCELERATION_SIGMA,
    GYRO_SIGMA,
    HEADING_SIGMA,
    RANGE_SIGMA,
    ROLL_PITCH_SIGMA,
    VELOCITY_SIGMA,
)
from hullrecon.synthetic.recorder import Streams, in_order, stamp_ns
from hullrecon.synthetic.vehicle import BEAMS, SONAR_ELEVATION_DEG
from hullrecon.typing import Array


def write_plain(folder: Path, streams: Streams) -> None:
    """Write dvl.csv, imu.csv, pressure.csv, joints.csv, camera_*.csv and sonar.csv, with images."""
    ranges = [f"range_{k + 1}" for k in range(4)]
    imu = ["qx", "qy", "qz", "qw", "wx", "wy", "wz", "ax", "ay", "az"]
    for name, columns, readings, values, form in (
        ("dvl", ["vx", "vy", "vz", *ranges], streams.dvl, ("velocity", "ranges"), "%.9f"),
        ("imu", imu, streams.imu, ("quaternion", "rates", "force"), "%.9f"),
        ("pressure", ["pascal"], streams.pressure, ("value",), "%.2f"),
        ("position", ["x", "y", "z"], streams.positions, ("value",), "%.4f"),
    ):
        if name != "position" or len(readings.t_s):
            table = np.column_stack([getattr(readings, value) for value in values])
            write_table(folder / f"{name}.csv", columns, readings.t_s, table, form)
    _write_joints(folder / "joints.csv", streams)
    _write_images(folder, streams)
    _write_pings(folder, streams)


def seconds(t_s: Array) -> list[str]:
    """Format seconds since 1970 with all nine digits, which a float64 would not hold."""
    return [f"{ns // 10**9}.{ns % 10**9:09d}" for ns in stamp_ns(t_s).tolist()]


def write_table(
    path: Path, names: list[str], t_s: Array, values: Array, form: str = "%.9f"
) -> None:
    """Write a CSV with a column t, the times (n,) in s, and columns of values (n, k) by name.

    NaN is left empty. form: format of a value.
    """
    lines = [",".join(["t", *names])]
    for stamp, row in zip(seconds(t_s), values.tolist(), strict=True):
        lines.append(",".join([stamp, *("" if v != v else form % v for v in row)]))
    path.write_text("\n".join(lines) + "\n")


def _write_joints(path: Path, streams: Streams) -> None:
    """Write the angles of both servos as one table, a row for each servo and time."""
    lines = ["t,name,rad"]
    for stamp, row in zip(seconds(streams.joints.t_s), streams.joints.value.tolist(), strict=True):
        lines += [
            f"{stamp},{name},{angle:.9f}"
            for name, angle in zip(("tray", "sonar_tray"), row, strict=True)
        ]
    path.write_text("\n".join(lines) + "\n")


def _write_images(folder: Path, streams: Streams) -> None:
    """Write the images of all cameras frame by frame, then a table for each camera.

    Frames are rendered when they are read. So all cameras' images of a frame are written before the
    next one.
    """
    for camera in streams.cameras:
        (folder / camera).mkdir(exist_ok=True)
    stamps = seconds(streams.frame_s) if streams.cameras else []
    for k in range(len(stamps)):
        for camera, jpeg in zip(streams.cameras, streams.frames[k], strict=True):
            (folder / camera / f"{k:06d}.jpg").write_bytes(jpeg)
    for camera in streams.cameras:
        rows = [f"{stamp},{camera}/{k:06d}.jpg" for k, stamp in enumerate(stamps)]
        (folder / f"{camera}.csv").write_text("\n".join(["t,file", *rows]) + "\n")


def _write_pings(folder: Path, streams: Streams) -> None:
    """Write a file for each ping of the sonar, and a table of them. Nothing without pings."""
    if not len(streams.ping_s):
        return
    (folder / "sonar").mkdir(exist_ok=True)
    lines = ["t,file"]
    for k, stamp in enumerate(seconds(streams.ping_s)):
        _write_npz(
            folder / "sonar" / f"{k:06d}.npz",
            {"image": streams.pings[k], "azimuth": sonar.AZIMUTH, "range": sonar.RANGE},
        )
        lines.append(f"{stamp},sonar/{k:06d}.npz")
    (folder / "sonar.csv").write_text("\n".join(lines) + "\n")


def _write_npz(path: Path, arrays: dict[str, NDArray[Any]]) -> None:
    """Write as numpy.savez_compressed, with fixed dates: the same dive gives the same bytes."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            buffer = io.BytesIO()
            np.lib.format.write_array(buffer, np.ascontiguousarray(array), allow_pickle=False)
            archive.writestr(
                zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0)),
                buffer.getvalue(),
                zipfile.ZIP_DEFLATED,
            )


RosMessage = Any  # an instance of the class that rosbags makes for its type

# The published definition without the types that no simulated image has. Logs carry this text.
SONAR_IMAGE_DATA = """
uint32 DTYPE_UINT8=0
bool is_bigendian
uint32 dtype
uint32 beam_count
uint8[] data
"""

DEFINITIONS = {
    "marine_acoustic_msgs/msg/Dvl": DVL,
    "marine_acoustic_msgs/msg/PingInfo": PING_INFO,
    "marine_acoustic_msgs/msg/SonarImageData": SONAR_IMAGE_DATA,
    "marine_acoustic_msgs/msg/ProjectedSonarImage": PROJECTED_SONAR_IMAGE,
}
TOPICS = {
    "dvl": ("/dvl", "marine_acoustic_msgs/msg/Dvl"),
    "imu": ("/imu", "sensor_msgs/msg/Imu"),
    "pressure": ("/pressure", "sensor_msgs/msg/FluidPressure"),
    "joints": ("/joint_states", "sensor_msgs/msg/JointState"),
    "camera_top": ("/camera/top/image_raw/compressed", "sensor_msgs/msg/CompressedImage"),
    "camera_bottom": ("/camera/bottom/image_raw/compressed", "sensor_msgs/msg/CompressedImage"),
    "sonar": ("/sonar", "marine_acoustic_msgs/msg/ProjectedSonarImage"),
    "position": ("/usbl", "geometry_msgs/msg/PointStamped"),
}
# From a stamp to the moment at which it is logged.
LATENCY_NS = {
    "dvl": 33_000_000,
    "imu": 2_000_000,
    "pressure": 6_000_000,
    "joints": 7_000_000,
    "sonar": 130_000_000,
}
OTHER_LATENCY_NS = 60_000_000


def write_mcap(path: Path, streams: Streams) -> None:
    """Write all streams of a dive into one MCAP file, in the order in which they are logged.

    As on a vehicle, a message is logged a little after its stamp (LATENCY_NS).
    """
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as file:
        writer = Writer(file, chunk_size=1 << 20, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="hullrecon")
        channels = _channels(writer, {name for _, name, _ in in_order(streams)})
        by_logging = sorted(
            (stamp_ns + LATENCY_NS.get(name, OTHER_LATENCY_NS), name, row, stamp_ns)
            for stamp_ns, name, row in in_order(streams)
        )
        for logged_ns, name, row, stamp_ns in by_logging:
            _, message_type = TOPICS[name]
            message = MESSAGES[name](streams, row, stamp_ns)
            data = bytes(store().serialize_cdr(message, message_type))
            writer.add_message(channels[name], log_time=logged_ns, publish_time=stamp_ns, data=data)
        writer.finish()


@cache
def store() -> Any:
    """Make a rosbags type store that also knows the acoustic messages."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    known = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        known.register(get_types_from_msg(text, name))
    return known


def make(kind: str, **fields: Any) -> Any:
    """Make a message of that ROS type."""
    return store().types[kind](**fields)


def header(stamp_ns: int, frame: str) -> Any:
    """Make a std_msgs/Header."""
    stamp = make("builtin_interfaces/msg/Time", sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def vector(xyz: Any, kind: str = "geometry_msgs/msg/Vector3") -> Any:
    """Make a geometry_msgs/Vector3, or a Point."""
    return make(kind, x=float(xyz[0]), y=float(xyz[1]), z=float(xyz[2]))


def _channels(writer: Any, names: set[str]) -> dict[str, int]:
    """Register a schema for each type, and a channel for each stream. Returns these by stream."""
    schemas, channels = dict[str, int](), dict[str, int]()
    for name in sorted(names):
        topic, kind = TOPICS[name]
        if kind not in schemas:
            text, _ = store().generate_msgdef(kind, ros_version=2)
            schemas[kind] = writer.register_schema(
                name=kind, encoding="ros2msg", data=text.encode()
            )
        channels[name] = writer.register_channel(
            topic=topic, message_encoding="cdr", schema_id=schemas[kind]
        )
    return channels


def _dvl(streams: Streams, k: int, ns: int) -> RosMessage:
    """Make the message of DVL ping k. A lost range is 0, with a covariance of -1."""
    ranges, velocity = streams.dvl.ranges[k], streams.dvl.velocity[k]
    good = np.isfinite(ranges)
    return make(
        "marine_acoustic_msgs/msg/Dvl",
        header=header(ns, "dvl"),
        velocity_mode=1,
        dvl_type=0,
        velocity=vector(velocity),
        velocity_covar=np.diag(np.full(3, VELOCITY_SIGMA**2)).ravel(),
        altitude=float(np.mean(ranges[good]) * BEAMS[0, 2]) if good.any() else -1.0,
        course_gnd=float(np.arctan2(velocity[1], velocity[0])),
        speed_gnd=float(np.hypot(velocity[0], velocity[1])),
        num_good_beams=int(good.sum()),
        sound_speed=1500.0,
        beam_ranges_valid=True,
        beam_velocities_valid=False,
        beam_unit_vec=[vector(beam) for beam in BEAMS],
        range=np.where(good, ranges, 0.0),
        range_covar=np.where(good, RANGE_SIGMA**2, -1.0).astype(np.float32),
        beam_quality=good.astype(np.float32),
        beam_velocity=np.zeros(4, np.float32),
        beam_velocity_covar=np.full(4, -1.0, np.float32),
    )


def _imu(streams: Streams, k: int, ns: int) -> RosMessage:
    """Make the message of IMU reading k."""
    x, y, z, w = streams.imu.quaternion[k].tolist()
    return make(
        "sensor_msgs/msg/Imu",
        header=header(ns, "vehicle"),
        orientation=make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w),
        orientation_covariance=np.diag(
            [ROLL_PITCH_SIGMA**2, ROLL_PITCH_SIGMA**2, (10 * HEADING_SIGMA) ** 2]
        ).ravel(),
        angular_velocity=vector(streams.imu.rates[k]),
        angular_velocity_covariance=np.diag(np.full(3, GYRO_SIGMA**2)).ravel(),
        linear_acceleration=vector(streams.imu.force[k]),
        linear_acceleration_covariance=np.diag(np.full(3, ACCELERATION_SIGMA**2)).ravel(),
    )


def _pressure(streams: Streams, k: int, ns: int) -> RosMessage:
    """Make the message of pressure reading k."""
    pascal = float(streams.pressure.value[k])
    return make(
        "sensor_msgs/msg/FluidPressure",
        header=header(ns, "vehicle"),
        fluid_pressure=pascal,
        variance=0.0,
    )


def _joints(streams: Streams, k: int, ns: int) -> RosMessage:
    """Make the message of reading k of both servos."""
    none = np.zeros(0)
    names, angle = ["tray", "sonar_tray"], streams.joints.value[k]
    return make(
        "sensor_msgs/msg/JointState",
        header=header(ns, ""),
        name=names,
        position=angle,
        velocity=none,
        effort=none,
    )


def _position(streams: Streams, k: int, ns: int) -> RosMessage:
    """Make the message of position k."""
    place = vector(streams.positions.value[k], "geometry_msgs/msg/Point")
    return make("geometry_msgs/msg/PointStamped", header=header(ns, "usbl"), point=place)


def _camera(name: str, jpeg: bytes, ns: int) -> RosMessage:
    """Make the message of an image of the camera `name`."""
    data = np.frombuffer(jpeg, np.uint8)
    return make(
        "sensor_msgs/msg/CompressedImage", header=header(ns, name), format="jpeg", data=data
    )


def _sonar(streams: Streams, k: int, ns: int) -> RosMessage:
    """Make the message of sonar ping k."""
    width = np.full(sonar.BEAM_COUNT, np.radians(SONAR_ELEVATION_DEG), np.float32)
    beam = np.full(sonar.BEAM_COUNT, abs(sonar.AZIMUTH[1] - sonar.AZIMUTH[0]), np.float32)
    info = make(
        "marine_acoustic_msgs/msg/PingInfo",
        frequency=1.8e6,
        sound_speed=1500.0,
        tx_beamwidths=width,
        rx_beamwidths=beam,
    )
    pixels = np.ascontiguousarray(streams.pings[k].T).ravel()  # range bin by range bin
    image = make(
        "marine_acoustic_msgs/msg/SonarImageData",
        is_bigendian=False,
        dtype=0,
        beam_count=sonar.BEAM_COUNT,
        data=pixels,
    )
    return make(
        "marine_acoustic_msgs/msg/ProjectedSonarImage",
        header=header(ns, "sonar"),
        ping_info=info,
        beam_directions=[vector(d) for d in sonar.beam_directions()],
        ranges=sonar.RANGE.astype(np.float32),
        image=image,
    )


# Makes the message of row k of a stream, with the stamp ns
MESSAGES = {
    "dvl": _dvl,
    "imu": _imu,
    "pressure": _pressure,
    "joints": _joints,
    "camera_top": lambda s, k, ns: _camera("camera_top", s.frames[k][0], ns),
    "camera_bottom": lambda s, k, ns: _camera("camera_bottom", s.frames[k][1], ns),
    "sonar": _sonar,
    "position": _position,
}
