# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A dive of one second as ROS messages, and as MCAP, ROS 1 bag and ROS 2 folder; written by the
writers of mcap and rosbags.
"""

from __future__ import annotations

import io
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

START_NS = 1_777_887_000_000_000_000
NS = 1_000_000_000
DVL, SONAR = "marine_acoustic_msgs/msg/Dvl", "marine_acoustic_msgs/msg/ProjectedSonarImage"
TOPICS = {
    "dvl": "/dvl",
    "imu": "/imu",
    "pressure": "/pressure",
    "joints": "/joints",
    "camera_top": "/cam",
    "sonar": "/sonar",
}


@dataclass(frozen=True)
class LoggedMessage:
    """A message as it lies in a log: data in CDR for ROS 2, in ROS 1's own form else."""

    topic: str
    kind: str
    t_ns: int
    data: bytes


@cache
def store(ros: int) -> Any:
    """Return the message types of ROS 1 or 2, those of the DVL and the sonar with them."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    from hullrecon.dive.logs.messages.definitions import BUNDLED

    types = get_typestore(Stores.ROS2_JAZZY if ros == 2 else Stores.ROS1_NOETIC)
    for name, text in BUNDLED.items():
        types.register(get_types_from_msg(text, name))
    return types


class MessageWriter:
    """Messages of one reading each, in the types of ROS 1 or 2."""

    def __init__(self, ros: int, jpeg: bytes) -> None:
        self.ros, self.jpeg, self.types = ros, jpeg, store(ros)

    def make(self, kind: str, **given: Any) -> Any:
        return self.types.types[kind](**given)

    def vector(self, x: float, y: float, z: float) -> Any:
        return self.make("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=float(z))

    def header(self, t: int) -> Any:
        stamp = self.make("builtin_interfaces/msg/Time", sec=t // NS, nanosec=t % NS)
        return self.make(
            "std_msgs/msg/Header",
            stamp=stamp,
            frame_id="x",
            **({"seq": 0} if self.ros == 1 else {}),
        )

    def imu(self, t: int) -> Any:
        return self.make(
            "sensor_msgs/msg/Imu",
            header=self.header(t),
            orientation=self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
            angular_velocity=self.vector(0.1, 0.2, 0.3),
            linear_acceleration=self.vector(0, 0, -9.81),
            **{
                f"{name}_covariance": np.zeros(9)
                for name in ("orientation", "angular_velocity", "linear_acceleration")
            },
        )

    def dvl(self, t: int) -> Any:
        s, c = 0.5, 0.75**0.5
        beams = [self.vector(*b) for b in ((-s, 0, c), (s, 0, c), (0, s, c), (0, -s, c))]
        return self.make(
            DVL,
            header=self.header(t),
            velocity_mode=1,
            dvl_type=0,
            velocity=self.vector(0.1, 0.2, 0.3),
            velocity_covar=np.diag([4e-6, 4e-6, 4e-6]).ravel(),
            altitude=1.0,
            course_gnd=0.0,
            speed_gnd=0.0,
            num_good_beams=4,
            sound_speed=1500.0,
            beam_ranges_valid=True,
            beam_velocities_valid=False,
            beam_unit_vec=beams,
            range=np.array([1.0, 2.0, 3.0, 4.0]),
            range_covar=np.zeros(4, np.float32),
            beam_quality=np.zeros(4, np.float32),
            beam_velocity=np.zeros(4, np.float32),
            beam_velocity_covar=np.zeros(4, np.float32),
        )

    def sonar(self, t: int) -> Any:
        info = self.make(
            "marine_acoustic_msgs/msg/PingInfo",
            frequency=1e6,
            sound_speed=1500.0,
            tx_beamwidths=np.zeros(0, np.float32),
            rx_beamwidths=np.zeros(0, np.float32),
        )
        pixels = self.make(
            "marine_acoustic_msgs/msg/SonarImageData",
            is_bigendian=False,
            dtype=0,
            beam_count=4,
            data=np.arange(12, dtype=np.uint8),
        )
        directions = [self.vector(0, np.sin(a), np.cos(a)) for a in np.linspace(0.25, -0.25, 4)]
        ranges = np.array([1, 2, 3], np.float32)
        return self.make(
            SONAR,
            header=self.header(t),
            ping_info=info,
            beam_directions=directions,
            ranges=ranges,
            image=pixels,
        )

    def joints(self, t: int) -> Any:
        none, angle = np.zeros(0), np.array([0.1, 9.0])
        return self.make(
            "sensor_msgs/msg/JointState",
            header=self.header(t),
            name=["tray", "other"],
            position=angle,
            velocity=none,
            effort=none,
        )

    def pressure(self, t: int) -> Any:
        return self.make(
            "sensor_msgs/msg/FluidPressure",
            header=self.header(t),
            fluid_pressure=111380.0,
            variance=0.0,
        )

    def image(self, t: int) -> Any:
        data = np.frombuffer(self.jpeg, np.uint8)
        return self.make(
            "sensor_msgs/msg/CompressedImage", header=self.header(t), format="jpeg", data=data
        )

    def entry(self, topic: str, kind: str, t: int, message: Any) -> LoggedMessage:
        serialised = (
            self.types.serialize_cdr(message, kind)
            if self.ros == 2
            else self.types.serialize_ros1(message, kind)
        )
        return LoggedMessage(topic, kind, t, bytes(serialised))


def tiny_dive(ros: int, jpeg: bytes) -> list[LoggedMessage]:
    """Write one second of a dive.

    Ten readings of the IMU, four of pressure and joints, two DVL pings and images, one sonar ping.
    """
    write = MessageWriter(ros, jpeg)
    out = []
    for i in range(10):
        t = START_NS + i * NS // 10
        out.append(write.entry("/imu", "sensor_msgs/msg/Imu", t, write.imu(t)))
        if i % 3 == 0:
            out.append(
                write.entry("/pressure", "sensor_msgs/msg/FluidPressure", t, write.pressure(t))
            )
            out.append(write.entry("/joints", "sensor_msgs/msg/JointState", t, write.joints(t)))
        if i % 5 == 0:
            out.append(write.entry("/dvl", DVL, t, write.dvl(t)))
            out.append(write.entry("/cam", "sensor_msgs/msg/CompressedImage", t, write.image(t)))
        if i == 4:
            out.append(write.entry("/sonar", SONAR, t, write.sonar(t)))
    return out


def as_mcap(entries: list[LoggedMessage], compression: str, **more: Any) -> bytes:
    """Return an MCAP of some six chunks. compression: "none", "lz4" or "zstd"; more: options of
    mcap's writer.
    """
    from mcap.writer import CompressionType, Writer

    file = io.BytesIO()
    writer = Writer(file, chunk_size=1000, compression=CompressionType[compression.upper()], **more)
    writer.start("ros2", "hullrecon")
    channels: dict[str, int] = {}
    for n, e in enumerate(entries):
        if e.topic not in channels:
            text, _ = store(2).generate_msgdef(e.kind, ros_version=2)
            channels[e.topic] = writer.register_channel(
                e.topic, "cdr", writer.register_schema(e.kind, "ros2msg", text.encode())
            )
        writer.add_message(channels[e.topic], e.t_ns, e.data, e.t_ns, n)
    writer.finish()
    return file.getvalue()


def as_bag(entries: list[LoggedMessage], compression: str) -> bytes:
    """Return a ROS 1 bag of some four chunks. compression: "none", "lz4" or "bz2"."""
    from rosbags.rosbag1 import Writer

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "dive.bag"
        writer = Writer(path)
        writer.chunk_threshold = 1000
        if compression != "none":
            writer.set_compression(Writer.CompressionFormat[compression.upper()])
        with writer:
            _fill(writer, entries, 1)
        return path.read_bytes()


def as_ros2_folder(entries: list[LoggedMessage], storage: str) -> dict[str, bytes]:
    """Return the files of a ROS 2 recording by name. storage: "MCAP" or "SQLITE3"."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "dive"
        with Writer(path, version=9, storage_plugin=StoragePlugin[storage]) as writer:
            _fill(writer, entries, 2)
        return {file.name: file.read_bytes() for file in sorted(path.iterdir())}


def _fill(writer: Any, entries: list[LoggedMessage], ros: int) -> None:
    connections: dict[str, Any] = {}
    for e in entries:
        if e.topic not in connections:
            connections[e.topic] = writer.add_connection(e.topic, e.kind, typestore=store(ros))
        writer.write(connections[e.topic], e.t_ns, e.data)
