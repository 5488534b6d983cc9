# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A tiny dive as ROS messages, and writers of every log format for it. The writers are those of
mcap and rosbags.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from datasets import dataset

START_NS = 1_777_887_000_000_000_000
NS = 1_000_000_000
DVL = "marine_acoustic_msgs/msg/Dvl"


@dataclass(frozen=True)
class Entry:
    topic: str
    kind: str
    t_ns: int
    message: Any


class Kit:
    """Messages of ROS 2 types and files of them."""

    start_ns = START_NS

    def __init__(self) -> None:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore

        from hullrecon.dive.logs.messages.definitions import BUNDLED

        self.stores = {2: get_typestore(Stores.ROS2_JAZZY), 1: get_typestore(Stores.ROS1_NOETIC)}
        for store in self.stores.values():
            for name, text in BUNDLED.items():
                store.register(get_types_from_msg(text, name))

    def make(self, kind: str, ros: int = 2, **given: Any) -> Any:
        return self.stores[ros].types[kind](**given)

    def header(self, t_ns: int, ros: int = 2) -> Any:
        stamp = self.make("builtin_interfaces/msg/Time", ros, sec=t_ns // NS, nanosec=t_ns % NS)
        more = {"seq": 0} if ros == 1 else {}
        return self.make("std_msgs/msg/Header", ros, stamp=stamp, frame_id="x", **more)

    def vector(self, x: float, y: float, z: float, ros: int = 2) -> Any:
        return self.make("geometry_msgs/msg/Vector3", ros, x=float(x), y=float(y), z=float(z))

    def imu(
        self, t_ns: int, ros: int = 2, quaternion: Any = (0.0, 0.0, 0.0, 1.0), **more: Any
    ) -> Any:
        covariance = np.zeros(9)
        x, y, z, w = map(float, quaternion)
        return self.make(
            "sensor_msgs/msg/Imu",
            ros,
            header=self.header(t_ns, ros),
            orientation=self.make("geometry_msgs/msg/Quaternion", ros, x=x, y=y, z=z, w=w),
            angular_velocity=self.vector(0.1, 0.2, 0.3, ros),
            linear_acceleration=self.vector(0, 0, -9.81, ros),
            **{
                "orientation_covariance": covariance,
                "angular_velocity_covariance": covariance,
                "linear_acceleration_covariance": covariance,
                **more,
            },
        )

    def pressure(self, t_ns: int, pascal: float, ros: int = 2) -> Any:
        return self.make(
            "sensor_msgs/msg/FluidPressure",
            ros,
            header=self.header(t_ns, ros),
            fluid_pressure=float(pascal),
            variance=0.0,
        )

    def joints(self, t_ns: int, names: list[str], angles: list[float], ros: int = 2) -> Any:
        return self.make(
            "sensor_msgs/msg/JointState",
            ros,
            header=self.header(t_ns, ros),
            name=names,
            position=np.array(angles, float),
            velocity=np.zeros(0),
            effort=np.zeros(0),
        )

    def dvl(self, t_ns: int, ros: int = 2, **more: Any) -> Any:
        s, c = 0.5, 0.75**0.5
        beams = [self.vector(*b, ros) for b in ((-s, 0, c), (s, 0, c), (0, s, c), (0, -s, c))]
        given: dict[str, Any] = {
            "header": self.header(t_ns, ros),
            "velocity_mode": 1,
            "dvl_type": 0,
            "velocity": self.vector(0.1, 0.2, 0.3, ros),
            "velocity_covar": np.diag([4e-6, 4e-6, 4e-6]).ravel(),
            "altitude": 2.5 * c,
            "course_gnd": 0.0,
            "speed_gnd": 0.0,
            "num_good_beams": 4,
            "sound_speed": 1500.0,
            "beam_ranges_valid": True,
            "beam_velocities_valid": False,
            "beam_unit_vec": beams,
            "range": np.array([1.0, 2.0, 3.0, 4.0]),
            "range_covar": np.zeros(4, np.float32),
            "beam_quality": np.zeros(4, np.float32),
            "beam_velocity": np.zeros(4, np.float32),
            "beam_velocity_covar": np.zeros(4, np.float32),
        }
        return self.make(DVL, ros, **{**given, **more})

    def sonar(
        self, t_ns: int, pixels: np.ndarray, range_m: Any = (1.0, 2.0, 3.0), dtype: int = 0
    ) -> Any:
        """pixels [ranges, beams]."""
        beams = pixels.shape[1]
        directions = [self.vector(0, np.sin(a), np.cos(a)) for a in np.linspace(0.25, -0.25, beams)]
        image = self.make(
            "marine_acoustic_msgs/msg/SonarImageData",
            is_bigendian=False,
            dtype=dtype,
            beam_count=beams,
            data=np.frombuffer(pixels.tobytes(), np.uint8),
        )
        info = self.make(
            "marine_acoustic_msgs/msg/PingInfo",
            frequency=1e6,
            sound_speed=1500.0,
            tx_beamwidths=np.zeros(0, np.float32),
            rx_beamwidths=np.zeros(0, np.float32),
        )
        return self.make(
            "marine_acoustic_msgs/msg/ProjectedSonarImage",
            header=self.header(t_ns),
            ping_info=info,
            beam_directions=directions,
            ranges=np.array(range_m, np.float32),
            image=image,
        )

    def image(self, t_ns: int, encoded: bytes, ros: int = 2) -> Any:
        return self.make(
            "sensor_msgs/msg/CompressedImage", ros, header=self.header(t_ns, ros), format="jpeg",
            data=np.frombuffer(encoded, np.uint8),
        )  # fmt: skip

    @staticmethod
    def jpeg(shade: int, width: int = 64, height: int = 48) -> bytes:
        rng = np.random.default_rng(shade)
        ok, data = cv2.imencode(
            ".jpg",
            rng.integers(0, 255, (height, width, 3), np.uint8),
            [cv2.IMWRITE_JPEG_QUALITY, 40],
        )
        assert ok
        return data.tobytes()

    def dive(self, ros: int = 2, seconds: int = 4) -> list[Entry]:
        """Ten IMU readings, five pressures and joints, two pings and two images a second."""
        out = []
        for i in range(seconds * 10):
            t = START_NS + i * NS // 10
            # an orientation that never changes is one that nobody has measured
            turned = (0.0, 0.0, 1e-6 * i, 1.0)
            out.append(Entry("/imu", "sensor_msgs/msg/Imu", t, self.imu(t, ros, turned)))
            if i % 2 == 0:
                out.append(
                    Entry(
                        "/pressure",
                        "sensor_msgs/msg/FluidPressure",
                        t,
                        self.pressure(t, 101325 + 10055.25 * i, ros),
                    )
                )
                out.append(
                    Entry(
                        "/joints",
                        "sensor_msgs/msg/JointState",
                        t,
                        self.joints(t, ["tray", "other"], [0.1 * i % 6, 9.0], ros),
                    )
                )
            if i % 5 == 0:
                out.append(Entry("/dvl", DVL, t, self.dvl(t, ros)))
                out.append(
                    Entry(
                        "/cam",
                        "sensor_msgs/msg/CompressedImage",
                        t,
                        self.image(t, self.jpeg(i), ros),
                    )
                )
        return out

    def mcap(
        self,
        path: Path,
        entries: list[Entry],
        chunk_size: int = 4000,
        compression: str = "zstd",
        **more: Any,
    ) -> Path:
        from mcap.writer import CompressionType, Writer

        from hullrecon.dive.logs.messages.definitions import BUNDLED

        assert BUNDLED
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as stream:
            writer = Writer(
                stream,
                chunk_size=chunk_size,
                compression=CompressionType[compression.upper()],
                **more,
            )
            writer.start("ros2", "kit")
            channels: dict[str, int] = {}
            for n, e in enumerate(entries):
                if e.topic not in channels:
                    text, _ = self.stores[2].generate_msgdef(e.kind, ros_version=2)
                    schema = writer.register_schema(e.kind, "ros2msg", text.encode())
                    channels[e.topic] = writer.register_channel(e.topic, "cdr", schema)
                data = bytes(self.stores[2].serialize_cdr(e.message, e.kind))
                writer.add_message(channels[e.topic], e.t_ns, data, e.t_ns, n)
            writer.finish()
        return path

    def bag1(
        self, path: Path, entries: list[Entry], chunk_size: int = 4000, compression: Any = None
    ) -> Path:
        from rosbags.rosbag1 import Writer

        path.parent.mkdir(parents=True, exist_ok=True)
        writer = Writer(path)
        writer.chunk_threshold = chunk_size
        if compression is not None:
            writer.set_compression(Writer.CompressionFormat[compression])
        with writer:
            connections: dict[str, Any] = {}
            for e in entries:
                if e.topic not in connections:
                    connections[e.topic] = writer.add_connection(
                        e.topic, e.kind, typestore=self.stores[1]
                    )
                writer.write(
                    connections[e.topic], e.t_ns, self.stores[1].serialize_ros1(e.message, e.kind)
                )
        return path

    def ros2(self, path: Path, entries: list[Entry], storage: str = "SQLITE3") -> Path:
        from rosbags.rosbag2 import StoragePlugin, Writer

        with Writer(path, version=9, storage_plugin=StoragePlugin[storage]) as writer:
            connections: dict[str, Any] = {}
            for e in entries:
                if e.topic not in connections:
                    connections[e.topic] = writer.add_connection(
                        e.topic, e.kind, typestore=self.stores[2]
                    )
                writer.write(
                    connections[e.topic], e.t_ns, self.stores[2].serialize_cdr(e.message, e.kind)
                )
        return path


@pytest.fixture(scope="session")
def kit() -> Kit:
    return Kit()


@pytest.fixture(scope="session")
def data() -> Path:
    return dataset()


def write_calibration(path: Path, width: int = 64, height: int = 48, **more: Any) -> Path:
    """A camera_info YAML; `more` replaces whole lines by key."""
    lines = {
        "image_width": f"{width}",
        "image_height": f"{height}",
        "camera_name": "x",
        "camera_matrix": "\n  rows: 3\n  cols: 3\n  data: [50.0, 0, 31.5, 0, 51.0, 23.5, 0, 0, 1]",
        "distortion_model": "plumb_bob",
        "distortion_coefficients": "\n  rows: 1\n  cols: 5\n  data: [-0.1, 0.02, 0.001, -0.002, "
        "0.003]",
        **more,
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{key}: {value}\n" for key, value in lines.items()))
    return path


@pytest.fixture(scope="session")
def calibration() -> Any:
    return write_calibration


TOML = """
[dive]
name = "tiny"
[logs]
files = ["{log}"]
[topics]
dvl = "/dvl"
imu = "/imu"
pressure = "/pressure"
joints = "/joints"
camera_top = "/cam"
[camera.top]
calibration = "calibration/camera_top.yaml"
"""


@pytest.fixture
def package(kit: Kit, tmp_path: Path) -> Path:
    """A package whose log is logs/dive.mcap."""
    kit.mcap(tmp_path / "logs" / "dive.mcap", kit.dive())
    write_calibration(tmp_path / "calibration" / "camera_top.yaml")
    (tmp_path / "dive.toml").write_text(TOML.format(log="logs/dive.mcap"))
    return tmp_path
