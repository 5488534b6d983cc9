# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make one input of a simulated dive wrong by a random size, for benchmarks.faulty_inputs."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import trimesh
from mcap.reader import make_reader
from mcap.writer import Writer
from scipy.spatial.transform import Rotation

from hullrecon.dive.config.yaml_files import read_yaml
from hullrecon.synthetic.logs import store

NS = 1_000_000_000
Message = Any  # of rosbags
Edit = Callable[[Message, float], None]  # changes a message of a topic, t seconds into the dive
Files = Callable[[Path], None]  # changes files of a package other than its log
Random = np.random.Generator
ANGLES = ("roll", "pitch", "yaw")
CAMERAS = ("/camera/top/image_raw/compressed", "/camera/bottom/image_raw/compressed")
VELOCITY = ("velocity.x", "velocity.y", "velocity.z")
RATES = ("angular_velocity.x", "angular_velocity.y", "angular_velocity.z")
SWAPS = {
    "y negated": np.diag([1.0, -1.0, 1.0]),
    "z negated": np.diag([1.0, 1.0, -1.0]),
    "y and z negated": np.diag([1.0, -1.0, -1.0]),
    "x and y swapped": np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]]),
    "all negated": -np.eye(3),
    "x and y negated": np.diag([-1.0, -1.0, 1.0]),
    "turned by 90 degrees": np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]),
}
NED = Rotation.from_matrix([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
FLIP = Rotation.from_matrix(SWAPS["y and z negated"])


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One wrong input of a random size."""

    sensor: str  # what has to be named, a key of NAMES of benchmarks.faulty_inputs
    edits: Mapping[str, Edit] = field(default_factory=dict)  # by topic
    files: Files | None = None
    size: str = ""  # of the fault, for the table


def faults(kind: str, random: Random) -> dict[str, Fault]:
    """Draw the size of each fault that a dive of this kind may have."""
    found = _pressure(random) | _dvl(random) | _imu(random) | _clocks(random) | _cad(random)
    return (found if kind == "none" else found | _cameras(random, kind)) | _joints(random)


def corrupt(package: Path, copy: Path, fault: Fault) -> None:
    """Write a copy of a package with a fault."""
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("*.mcap"))
    toml("name", lambda _: f'"{copy.name}"')(copy)
    (log,) = (package / "logs").glob("*.mcap")
    rewrite(log, copy / "logs" / log.name, fault.edits)
    if fault.files is not None:
        fault.files(copy)


def rewrite(log: Path, to: Path, edits: Mapping[str, Edit]) -> None:
    """Copy an MCAP log with messages of some topics changed."""
    with log.open("rb") as source, to.open("wb") as target:
        reader, writer = make_reader(source), Writer(target)
        writer.start(profile="ros2")
        channels: dict[int, int] = {}
        first_ns = None
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            first_ns = message.log_time if first_ns is None else first_ns
            if channel.id not in channels:
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, known
                )
            data = message.data
            if channel.topic in edits:
                read = store().deserialize_cdr(data, schema.name)
                edits[channel.topic](read, (message.log_time - first_ns) / NS)
                data = bytes(store().serialize_cdr(read, schema.name))
            writer.add_message(channels[channel.id], message.log_time, data, message.publish_time)
        writer.finish()


def changed(change: Callable[[Any], Any], *names: str) -> Edit:
    """Make an edit that changes fields, given as paths with dots."""

    def edit(message: Message, t_s: float) -> None:
        for name in names:
            *path, last = name.split(".")
            of = reduce(getattr, path, message)
            setattr(of, last, change(getattr(of, last)))

    return edit


def scaled(factor: float, *names: str) -> Edit:
    return changed(lambda value: value * factor, *names)


def of_sound(factor: float) -> Edit:
    """Measure velocities, ranges and altitude with a speed of sound that is wrong by a factor."""
    velocity = scaled(factor, *VELOCITY, "altitude")

    def edit(message: Message, t_s: float) -> None:
        velocity(message, t_s)
        message.range = np.asarray(message.range) * np.float32(factor)

    return edit


def turned(matrix: np.ndarray, *names: str) -> Edit:
    """Express vectors in other axes."""

    def edit(message: Message, t_s: float) -> None:
        for name in names:
            vector = getattr(message, name)
            vector.x, vector.y, vector.z = (matrix @ [vector.x, vector.y, vector.z]).tolist()

    return edit


def attitude(change: Callable[[Rotation], Rotation]) -> Edit:
    def edit(message: Message, t_s: float) -> None:
        q = message.orientation
        q.x, q.y, q.z, q.w = change(Rotation.from_quat([q.x, q.y, q.z, q.w])).as_quat().tolist()

    return edit


def with_body(message: Message, t_s: float) -> None:
    """Write all that an IMU measures in ENU and FLU."""
    attitude(lambda r: NED * r * FLIP)(message, t_s)
    turned(SWAPS["y and z negated"], "angular_velocity", "linear_acceleration")(message, t_s)


def w_first(message: Message, t_s: float) -> None:
    q = message.orientation
    q.x, q.y, q.z, q.w = q.w, q.x, q.y, q.z


def stamped(seconds: float, rate: float = 0.0) -> Edit:
    """Stamp a message late, by a clock that is fast by a rate."""

    def edit(message: Message, t_s: float) -> None:
        stamp = message.header.stamp
        t_ns = stamp.sec * NS + stamp.nanosec + round((seconds + rate * t_s) * NS)
        stamp.sec, stamp.nanosec = t_ns // NS, t_ns % NS

    return edit


def picture(change: Callable[[np.ndarray], np.ndarray]) -> Edit:
    def edit(message: Message, t_s: float) -> None:
        image = cv2.imdecode(np.asarray(message.data), cv2.IMREAD_COLOR)
        assert image is not None
        quality = [cv2.IMWRITE_JPEG_QUALITY, 92]
        message.data = cv2.imencode(".jpg", np.ascontiguousarray(change(image)), quality)[1].ravel()

    return edit


def lost_as_zero(start_s: float, seconds: float, covariance: float) -> Edit:
    """Write zeros for velocities while the bottom is lost, with a covariance."""

    def edit(message: Message, t_s: float) -> None:
        if start_s <= t_s < start_s + seconds:
            message.velocity.x = message.velocity.y = message.velocity.z = 0.0
            message.velocity_covar = np.diag(np.full(3, covariance)).ravel()
            message.range, message.num_good_beams = np.zeros(4), 0

    return edit


def jumping(at_s: float, by: float, name: str) -> Edit:
    """Add a constant to a field from some time on."""

    def edit(message: Message, t_s: float) -> None:
        setattr(message, name, getattr(message, name) + (by if t_s >= at_s else 0.0))

    return edit


def stuck(at_s: float) -> Edit:
    """Repeat the positions of joints from some time on."""
    kept: list[np.ndarray] = []

    def edit(message: Message, t_s: float) -> None:
        if t_s >= at_s or not kept:
            kept[:] = kept or [message.position]
            message.position = kept[0] if t_s >= at_s else message.position
        else:
            kept[:] = [message.position]

    return edit


def along_axis(message: Message, t_s: float) -> None:
    """Write distances along the DVL's axis for ranges along its beams."""
    message.range = message.range * np.array([beam.z for beam in message.beam_unit_vec])


def calibration(
    cameras: Sequence[str], change: Callable[[list[float], list[float]], None]
) -> Files:
    """Change camera matrix and distortion of some cameras."""

    def files(package: Path) -> None:
        for camera in cameras:
            path = package / "calibration" / f"camera_{camera}.yaml"
            document: Any = read_yaml(path)
            change(document["camera_matrix"]["data"], document["distortion_coefficients"]["data"])
            path.write_text(json.dumps(document))

    return files


def halved(k: list[float], d: list[float]) -> None:
    """Make a calibration one of pictures half as large."""
    k[:6] = [value / 2 for value in k[:6]]


def mounted(begins: str, angle: int, degrees: float) -> Files:
    """Turn a mount or pose in dive.toml by an angle of its three. begins: of its line."""

    def files(package: Path) -> None:
        path = package / "dive.toml"

        def turn(line: re.Match[str]) -> str:
            six = json.loads(line[2])
            six[3 + angle] += degrees
            return line[1] + json.dumps(six)

        text, count = re.subn(rf"(?m)^(?={begins})(\w+ = )(\[.*\])$", turn, path.read_text())
        if count != 1:
            raise SystemExit(f"dive.toml has {count} lines {begins}")
        path.write_text(text)

    return files


def toml(key: str, change: Callable[[str], str]) -> Files:
    def files(package: Path) -> None:
        path = package / "dive.toml"
        text, count = re.subn(
            rf"(?m)^({key} = )(.*)$", lambda m: m[1] + change(m[2]), path.read_text(), count=1
        )
        if not count:
            raise SystemExit(f"dive.toml has no {key}")
        path.write_text(text)

    return files


def mesh(change: Callable[[trimesh.Trimesh], object]) -> Files:
    def files(package: Path) -> None:
        of = trimesh.load(package / "hull.stl", process=False)
        change(of)
        of.export(package / "hull.stl")

    return files


def without(key: str) -> Files:
    """Take a key out of dive.toml, where it is given."""

    def files(package: Path) -> None:
        path = package / "dive.toml"
        path.write_text(re.sub(rf"(?m)^{key} = .*\n", "", path.read_text()))

    return files


def all_of(*some: Files) -> Files:
    def files(package: Path) -> None:
        for one in some:
            one(package)

    return files


def swap_cameras(package: Path) -> None:
    path = package / "dive.toml"
    other = {"top": "bottom", "bottom": "top"}
    path.write_text(
        re.sub(
            r"(?m)^camera_(top|bottom) = ", lambda m: f"camera_{other[m[1]]} = ", path.read_text()
        )
    )


def about_z(degrees: float) -> np.ndarray:
    return Rotation.from_euler("z", degrees, degrees=True).as_matrix()


def sign(random: Random) -> float:
    return float(random.choice([-1.0, 1.0]))


def pick(random: Random, *values: float) -> float:
    return float(random.choice(values))


def _pressure(random: Random) -> dict[str, Fault]:
    units = [("hPa", 0.01), ("kPa", 0.001), ("bar", 1e-5), ("dbar", 1e-4)]
    unit, factor = units[random.integers(4)]
    air = 101325.0 + random.normal(0, 2000)
    gain = pick(random, 0.7, 0.85, 1.2, 1.5)
    jump_m, at_s = sign(random) * random.uniform(0.4, 1.0), random.uniform(6, 18)

    def housing(message: Message, t_s: float) -> None:
        message.fluid_pressure = air + 30 * np.sin(t_s / 7) + random.normal(0, 8)

    def fault(edit: Edit, size: str) -> Fault:
        return Fault(sensor="pressure", edits={"/pressure": edit}, size=size)

    name = "fluid_pressure"
    gauge = changed(lambda p: p - 101325, name)
    return {
        "pressure-unit": fault(scaled(factor, name), f"in {unit}"),
        "pressure-dead": fault(changed(lambda _: air, name), f"{air:.0f} Pa"),
        "pressure-enclosure": fault(housing, "air in a housing"),
        "pressure-gauge": fault(gauge, "above the air's"),
        "pressure-jump": fault(
            jumping(at_s, 1025 * 9.81 * jump_m, name), f"{jump_m:+.2f} m at {at_s:.0f} s"
        ),
        "pressure-scale": fault(
            changed(lambda p: 101325 + gain * (p - 101325), name), f"depth times {gain:g}"
        ),
    }


def _dvl(random: Random) -> dict[str, Fault]:
    factor = pick(random, 0.001, 1000, 0.85, 1.1, 1.15, 1.25)
    axes = str(random.choice(list(SWAPS)))
    start, seconds = float(random.uniform(5, 15)), float(random.uniform(2, 6))
    lost = lost_as_zero(start, seconds, pick(random, 1e-5, 1000.0, 0.0))
    nearer = pick(random, 0.85, 0.92, 1.08)
    angle = sign(random) * float(random.uniform(10, 170))
    mount = int(random.integers(3))
    mount_deg = pick(random, -90, -45, 45, 90, 180)
    order = random.permutation(4)
    while (order == np.arange(4)).all():
        order = random.permutation(4)

    sound, axis = pick(random, 0.94, 0.97, 1.03, 1.06), int(random.integers(3))
    offset_m_s = sign(random) * float(random.uniform(0.05, 0.3))
    offset = changed(lambda value: value + offset_m_s, VELOCITY[axis])

    def fault(edit: Edit, size: str) -> Fault:
        return Fault(sensor="dvl", edits={"/dvl": edit}, size=size)

    return {
        "dvl-scale": fault(scaled(factor, *VELOCITY), f"velocity times {factor:g}"),
        "dvl-sound": fault(of_sound(sound), f"velocity and ranges times {sound:g}"),
        "dvl-offset": fault(offset, f"velocity {offset_m_s:+.2f} m/s along {'xyz'[axis]}"),
        "dvl-axes": fault(turned(SWAPS[axes], "velocity"), axes),
        "dvl-turned": fault(turned(about_z(angle), "velocity"), f"{angle:.0f} degrees about z"),
        "dvl-mount": Fault(
            sensor="dvl",
            files=mounted(r"mount = \[0.0, 0.0, 0.08", mount, mount_deg),
            size=f"{ANGLES[mount]} off by {mount_deg:.0f} degrees",
        ),
        "dvl-beams": fault(
            changed(lambda ranges: np.asarray(ranges)[order], "range"),
            f"beams in the order {' '.join(str(beam + 1) for beam in order)}",
        ),
        "dvl-lost-zero": fault(lost, f"{seconds:.1f} s of zeros"),
        "dvl-range-mm": fault(scaled(1000.0, "range"), "ranges in mm"),
        "dvl-range-scale": fault(scaled(nearer, "range"), f"ranges times {nearer:g}"),
        "dvl-range-axis": fault(along_axis, "along the axis"),
    }


def _imu(random: Random) -> dict[str, Fault]:
    axes, angle = str(random.choice(list(SWAPS))), int(random.integers(3))
    signs = np.where(np.arange(3) == angle, -1.0, 1.0)
    mount_deg = sign(random) * float(random.uniform(10, 170))
    felt = str(random.choice(list(SWAPS)))

    swing_deg, slow_s = float(random.uniform(3, 12)), float(random.uniform(15, 60))

    def swinging(message: Message, t_s: float) -> None:
        """Write a heading that steel bends."""
        by = swing_deg * np.sin(2 * np.pi * t_s / slow_s)
        attitude(lambda r: Rotation.from_euler("z", by, degrees=True) * r)(message, t_s)

    def sits_turned(message: Message, t_s: float) -> None:
        """Write what an IMU measures that is turned about the vehicle's z axis."""
        mount = about_z(mount_deg)
        attitude(lambda r: r * Rotation.from_matrix(mount))(message, t_s)
        turned(mount.T, "angular_velocity", "linear_acceleration")(message, t_s)

    mirrored = attitude(lambda r: Rotation.from_euler("ZYX", signs * r.as_euler("ZYX")))

    def fault(edit: Edit, size: str = "") -> Fault:
        return Fault(sensor="imu", edits={"/imu": edit}, size=size)

    return {
        "imu-convention": fault(with_body, "ENU and FLU, of all that it measures"),
        "imu-turned": fault(sits_turned, f"{mount_deg:.0f} degrees about z"),
        "imu-swing": fault(swinging, f"{swing_deg:.0f} degrees in {slow_s:.0f} s"),
        "imu-felt-axes": fault(turned(SWAPS[felt], "linear_acceleration"), felt),
        "imu-angle": fault(mirrored, f"{ANGLES[::-1][angle]} grows the other way"),
        "imu-rates-deg": fault(scaled(180 / np.pi, *RATES), "deg/s"),
        "imu-rates-axes": fault(turned(SWAPS[axes], "angular_velocity"), axes),
        "imu-enu": fault(attitude(lambda r: NED * r * FLIP)),
        "imu-body": fault(attitude(lambda r: r * FLIP)),
        "imu-inverse": fault(attitude(lambda r: r.inv())),
        "imu-order": fault(w_first, "w first"),
        "imu-dead": fault(attitude(lambda r: Rotation.identity()), "identity"),
    }


def _joints(random: Random) -> dict[str, Fault]:
    off, lag = sign(random) * random.uniform(5, 20), sign(random) * random.uniform(0.2, 2.0)
    quarter, at_s = pick(random, -90, 90, 180), max(0.0, random.uniform(-10, 15))

    def fault(change: Callable[[np.ndarray], np.ndarray], size: str = "") -> Fault:
        return Fault(
            sensor="joints", edits={"/joint_states": changed(change, "position")}, size=size
        )

    return {
        "joint-deg": fault(np.degrees),
        "joint-rad": Fault(
            sensor="joints",
            files=toml("joint", lambda name: f'{name}\njoint_unit = "deg"'),
            size="read as degrees",
        ),
        "joint-sign": fault(np.negative),
        "joint-dead": fault(np.zeros_like, "zero"),
        "joint-offset": fault(lambda x: x + np.radians(off), f"{off:.1f} degrees"),
        "joint-quarter": fault(lambda x: x + np.radians(quarter), f"{quarter:.0f} degrees"),
        "joint-stuck": Fault(
            sensor="joints", edits={"/joint_states": stuck(at_s)}, size=f"from {at_s:.0f} s on"
        ),
        "joint-late": Fault(
            sensor="joints", edits={"/joint_states": stamped(lag)}, size=f"{lag:+.2f} s"
        ),
    }


def _clocks(random: Random) -> dict[str, Fault]:
    topic = str(random.choice(["/dvl", "/imu", "/pressure"]))
    late = sign(random) * float(np.exp(random.uniform(np.log(0.1), np.log(5))))
    far = pick(random, 3600, 7200, -3600, -1_777_800_000, 18)
    rate = sign(random) * random.uniform(0.003, 0.02)

    def fault(edit: Edit, size: str) -> Fault:
        return Fault(sensor="clock", edits={topic: edit}, size=f"{topic} {size}")

    return {
        "clock-late": fault(stamped(late), f"{late:+.2f} s"),
        "clock-far": fault(stamped(far), f"{far:+.2f} s"),
        "clock-rate": fault(stamped(0.0, rate), f"{100 * rate:+.1f} % fast"),
    }


def _cameras(random: Random, kind: str) -> dict[str, Fault]:
    both = ("top", "bottom") if kind == "stereo" else ("top",)
    topics = CAMERAS[: len(both)]
    late, shift = sign(random) * random.uniform(0.08, 0.6), sign(random) * random.uniform(15, 50)
    air, small = pick(random, 1 / 1.333, 1.333), sign(random) * random.uniform(0.01, 0.06)
    few, rolled = sign(random) * random.uniform(2, 8), pick(random, -90, 90, 180)

    def lens(
        change: Callable[[list[float], list[float]], None], size: str = "", of: Sequence[str] = both
    ) -> Fault:
        return Fault(sensor="camera", files=calibration(of, change), size=size)

    def longer_focus(factor: float) -> Callable[[list[float], list[float]], None]:
        return lambda k, d: k.__setitem__(slice(0, 5, 4), [factor * k[0], factor * k[4]])

    def shifted(k: list[float], d: list[float]) -> None:
        k[2], k[5] = k[2] + shift, k[5] + shift / 2

    def nearby(k: list[float], d: list[float]) -> None:
        k[5] += few

    def transposed(k: list[float], d: list[float]) -> None:
        k[:] = np.reshape(k, (3, 3)).T.ravel().tolist()

    def bent(k: list[float], d: list[float]) -> None:
        d[:] = [-value for value in d]

    def shown(change: Callable[[np.ndarray], np.ndarray], size: str) -> Fault:
        return Fault(sensor="camera", edits=dict.fromkeys(topics, picture(change)), size=size)

    def longer(text: str) -> str:
        values = json.loads(text)
        return str([*(1.1 * value for value in values[:3]), *values[3:]])

    def clock(of: Sequence[str], by: float) -> Fault:
        return Fault(
            sensor="clock", edits=dict.fromkeys(of, stamped(by)), size=f"{1e3 * by:+.0f} ms"
        )

    def exchanged(k: list[float], d: list[float]) -> None:
        k[0], k[4] = k[4], k[0]

    found = {
        "camera-size": lens(halved, "of pictures half as large"),
        "camera-axes": lens(exchanged, "fx and fy exchanged"),
        "camera-few-pixels": lens(nearby, f"principal point by {few:.1f} px"),
        "camera-medium": lens(longer_focus(air), f"f times {air:.3f}"),
        "camera-focal": lens(longer_focus(1.08), "f times 1.08, top alone", ("top",)),
        "camera-principal": lens(shifted, f"{shift:.0f} px"),
        "camera-transposed": lens(transposed),
        "camera-distortion": lens(bent, "other sign"),
        "camera-turned": shown(lambda i: i[::-1, ::-1], "pictures by 180 degrees"),
        "camera-mirrored": shown(lambda i: i[:, ::-1], "pictures"),
        "camera-late": clock(topics, late),
        "camera-mount": Fault(
            sensor="camera",
            files=mounted(r"mount = \[0.0, 0.0, -0.05", 0, rolled),
            size=f"roll off by {rolled:.0f} degrees",
        ),
    }
    if kind == "stereo":
        found["camera-swapped"] = Fault(sensor="camera", files=swap_cameras)
        found["camera-apart"] = Fault(
            sensor="camera", files=toml("pose_in_top", longer), size="baseline 10 % too long"
        )
        found["camera-bottom-late"] = clock(CAMERAS[1:], small)
    return found


def _cad(random: Random) -> dict[str, Fault]:
    unit = str(random.choice(["mm", "cm", "ft", "in"]))
    stretch = pick(random, 0.9, 1.1, 1.3)

    scale = mesh(lambda m: m.apply_scale(stretch))
    skew_deg = sign(random) * float(random.uniform(10, 40))

    def skewed(of: trimesh.Trimesh) -> None:
        turn = trimesh.transformations.rotation_matrix(np.radians(skew_deg), [0, 0, 1])
        of.apply_transform(turn)

    def fault(files: Files, size: str) -> Fault:
        return Fault(sensor="cad", files=files, size=size)

    def in_map(of: trimesh.Trimesh) -> None:
        of.apply_translation([4.5e5, 5.5e6, 0.0])

    def y_up(of: trimesh.Trimesh) -> None:
        of.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))

    def turned_over(of: trimesh.Trimesh) -> None:
        of.apply_transform(trimesh.transformations.rotation_matrix(np.pi, [1, 0, 0]))

    def on_end(of: trimesh.Trimesh) -> None:
        of.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))

    def in_radians(numbers: str) -> str:
        six = json.loads(numbers)
        return json.dumps([*six[:3], *np.radians(six[3:]).round(6).tolist()])

    def plated(of: trimesh.Trimesh) -> None:
        """Give the plates a thickness, with the inner faces as a yard exports them."""
        inner = of.vertices - 0.015 * of.vertex_normals
        faces = np.vstack([of.faces, of.faces[:, ::-1] + len(of.vertices)])
        both = trimesh.Trimesh(np.vstack([of.vertices, inner]), faces, process=False)
        of.vertices, of.faces = both.vertices, both.faces

    return {
        "cad-precision": fault(mesh(in_map), "in map coordinates"),
        "cad-axes": fault(mesh(y_up), "y upwards"),
        "cad-over": fault(mesh(turned_over), "upside down"),
        "cad-turned": fault(mesh(skewed), f"by {skew_deg:.0f} degrees in plan"),
        "cad-end": fault(mesh(on_end), "on its end"),
        "cad-pose": fault(toml("pose", in_radians), "hull.pose in radians"),
        "cad-plates": fault(mesh(plated), "inner faces of its plates"),
        "cad-unit": fault(toml("units", lambda _: f'"{unit}"'), unit),
        "cad-scale": fault(scale, f"times {stretch:g}"),
        "cad-scale-unstated": fault(
            all_of(scale, without("length_overall")), f"times {stretch:g}, no length stated"
        ),
        "cad-inverted": fault(mesh(lambda m: m.invert()), "faces inwards"),
    }
