# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What sensors that fail do to the path: python -m benchmarks.disturbed PACKAGE FOLDER [--only NAME
...] [--free]

PACKAGE is a simulated dive with an MCAP log. Copies of it are made in FOLDER, each disturbed in one
way: no images for 50 s, no DVL for 60 s, neither DVL nor hull in the images for 60 s, an IMU whose
clock jumps by 2 s, a heading that steps by 3 degrees, each from the middle of the dive, a DVL whose
log ends half a minute after it; throughout, a DVL set to a speed of sound 3 % too high, and a
sensor whose clock is half a second late. Asked for by name, a stereo calibration that is off: the
bottom camera by a tenth of a degree, the baseline by 2 mm. Each is run to `adjust` and compared
with the truth: the vehicle's error in its own sigmas, and what was said of it.
"""

from __future__ import annotations

import json
import re
import shutil
import struct
import sys
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer
from scipy.spatial.transform import Rotation

from benchmarks.arguments import keep, parser_for
from benchmarks.legs import Figures, figures, hullrecon, without_cad_model
from hullrecon.synthetic.logs import store

NS = 1_000_000_000
HEADING_STEP_DEG, CLOCK_JUMP_S, NO_IMAGES_S = 3.0, 2.0, 50.0
NO_DVL_S, DVL_ENDS_S = 60.0, 30.0
LATE_S = 0.5
FAST_SOUND = 1.03  # times the speed of sound that is right
DVL_TYPE = "marine_acoustic_msgs/msg/Dvl"
ENCAPSULATION = 4  # bytes before a message in CDR
# From the topic, the time since the dive's middle in s and the message: the message as it is
# logged, or None where it is lost.
Disturbance = Callable[[str, float, bytes], bytes | None]


def stamp(data: bytes) -> int:
    """Return the stamp of a message's header, ns."""
    seconds, nanoseconds = struct.unpack_from("<iI", data, ENCAPSULATION)
    return int(seconds) * NS + int(nanoseconds)


def with_stamp(data: bytes, t_ns: int) -> bytes:
    """Return a message with another stamp."""
    return (
        data[:ENCAPSULATION] + struct.pack("<iI", t_ns // NS, t_ns % NS) + data[ENCAPSULATION + 8 :]
    )


def turned(data: bytes, angle_deg: float) -> bytes:
    """Return an Imu message whose attitude is turned about the vertical of its frame."""
    (length,) = struct.unpack_from("<I", data, ENCAPSULATION + 8)
    at = ENCAPSULATION + (8 + 4 + length + 7) // 8 * 8
    quaternion = np.array(struct.unpack_from("<4d", data, at))
    turn = Rotation.from_euler("z", angle_deg, degrees=True)
    return (
        data[:at]
        + struct.pack("<4d", *(turn * Rotation.from_quat(quaternion)).as_quat())
        + data[at + 32 :]
    )


def undisturbed(topic: str, since_s: float, data: bytes) -> bytes | None:
    return data


def no_images(topic: str, since_s: float, data: bytes) -> bytes | None:
    return None if "camera" in topic and 0 <= since_s < NO_IMAGES_S else data


def no_dvl(topic: str, since_s: float, data: bytes) -> bytes | None:
    return None if topic == "/dvl" and abs(since_s) < NO_DVL_S / 2 else data


def open_water(topic: str, since_s: float, data: bytes) -> bytes | None:
    """Lose the DVL, and show water with a little noise in place of the hull."""
    if "camera" in topic and abs(since_s) < NO_DVL_S / 2:
        return with_picture(data, water)
    return no_dvl(topic, since_s, data)


def water(width: int, height: int) -> bytes:
    """Return a JPEG that is darker from below to above, with noise."""
    grey = np.linspace(60, 100, height)[:, None] + np.random.default_rng(0).normal(
        0, 2, (height, width)
    )
    return bytes(cv2.imencode(".jpg", np.clip(grey, 0, 255).astype(np.uint8))[1])


def with_picture(data: bytes, size_to_picture: Callable[[int, int], bytes]) -> bytes:
    """Return a CompressedImage message with another picture of the same size."""
    at = ENCAPSULATION + 8
    for _ in range(2):  # frame_id and format
        (length,) = struct.unpack_from("<I", data, at)
        at = ENCAPSULATION + (at - ENCAPSULATION + 4 + length + 3) // 4 * 4
    height, width = cv2.imdecode(
        np.frombuffer(data, np.uint8, offset=at + 4), cv2.IMREAD_GRAYSCALE
    ).shape
    picture = size_to_picture(width, height)
    return data[:at] + struct.pack("<I", len(picture)) + picture


def dvl_ends(topic: str, since_s: float, data: bytes) -> bytes | None:
    return None if topic == "/dvl" and since_s >= DVL_ENDS_S else data


def fast_sound(topic: str, since_s: float, data: bytes) -> bytes | None:
    """Stretch what the DVL measures."""
    if topic != "/dvl":
        return data
    message = store().deserialize_cdr(data, DVL_TYPE)
    for axis in ("x", "y", "z"):
        setattr(message.velocity, axis, FAST_SOUND * getattr(message.velocity, axis))
    message.range = FAST_SOUND * message.range
    return bytes(store().serialize_cdr(message, DVL_TYPE))


def clock_jump(topic: str, since_s: float, data: bytes) -> bytes | None:
    return (
        with_stamp(data, stamp(data) + round(CLOCK_JUMP_S * NS))
        if topic == "/imu" and since_s >= 0
        else data
    )


def heading_step(topic: str, since_s: float, data: bytes) -> bytes | None:
    return turned(data, HEADING_STEP_DEG) if topic == "/imu" and since_s >= 0 else data


def late(part: str) -> Disturbance:
    """Stamp messages of topics whose name holds a word LATE_S late."""
    return lambda topic, since_s, data: (
        with_stamp(data, stamp(data) + round(LATE_S * NS)) if part in topic else data
    )


DISTURBANCES: dict[str, Disturbance] = {
    "undisturbed": undisturbed,
    "no-images": no_images,
    "no-dvl": no_dvl,
    "dvl-ends": dvl_ends,
    "open-water": open_water,
    "clock-jump": clock_jump,
    "heading-step": heading_step,
    "fast-sound": fast_sound,
    "dvl-late": late("/dvl"),
    "imu-late": late("/imu"),
    "images-late": late("camera"),
    "pressure-late": late("/pressure"),
}

# What is added to camera.bottom.pose_in_top, m and deg.
CALIBRATIONS: dict[str, tuple[float, ...]] = {
    "bottom-turned": (0.0, 0.0, 0.0, 0.1, 0.0, 0.0),
    "baseline-long": (0.0, 0.002, 0.0, 0.0, 0.0, 0.0),
}
NAMES = [*DISTURBANCES, *CALIBRATIONS]


def with_bottom_moved(text: str, by: tuple[float, ...]) -> str:
    """Return dive.toml with another pose of the bottom camera in the top one."""
    found = re.search(r"(?m)^pose_in_top = \[(.*)\]$", text)
    if found is None:
        raise SystemExit("the dive has no second camera")
    moved = [float(word) + more for word, more in zip(found[1].split(","), by, strict=True)]
    return f"{text[: found.start()]}pose_in_top = {moved}{text[found.end() :]}"


def miscalibrate(package: Path, copy: Path, by: tuple[float, ...]) -> None:
    """Write a copy of a package with another pose of the bottom camera in the top one."""
    disturb(package, copy, undisturbed)
    (copy / "dive.toml").write_text(with_bottom_moved((copy / "dive.toml").read_text(), by))


def disturb(package: Path, copy: Path, change: Disturbance, about_ns: int | None = None) -> None:
    """Write a copy of a package whose log is disturbed, about its middle or another time."""
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("*.mcap"))
    text = (copy / "dive.toml").read_text()
    (copy / "dive.toml").write_text(
        re.sub(r"(?m)^name = .*$", f'name = "{copy.name}"', text, count=1)
    )
    (log,) = (package / "logs").glob("*.mcap")
    with log.open("rb") as source, (copy / "logs" / log.name).open("wb") as target:
        reader, writer = make_reader(source), Writer(target)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        middle = (
            (summary.statistics.message_start_time + summary.statistics.message_end_time) // 2
            if about_ns is None
            else about_ns
        )
        writer.start(profile="ros2")
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if channel.id not in channels:
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, known
                )
            data = change(channel.topic, (message.log_time - middle) / NS, message.data)
            if data is not None:
                writer.add_message(
                    channels[channel.id], message.log_time, data, message.publish_time
                )
        writer.finish()


def said(run: Path) -> list[str]:
    """Return the warnings of a run's steps."""
    steps = [
        run / name / "manifest.json"
        for name in ("ingest", "navigate", "links", "matches", "adjust")
    ]
    return [
        sentence
        for step in steps
        if step.exists()
        for sentence in json.loads(step.read_text())["warnings"]
    ]


def line(name: str, row: Figures) -> str:
    """Format one disturbance's figures as a line."""
    sigmas = " ".join(f"{x:.2f}" for x in row["errors_in_sigmas"])
    return (
        f"{name}: rigid rms {row['adjust_mm']:.1f} mm (dead reckoning "
        f"{row['dead_reckoning_mm']:.1f}), errors in sigmas"
        f" {sigmas}; CAD refused: {row['cad_model_refused']}; {' | '.join(row['said'])}"
    )


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("package", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="+", choices=NAMES, default=list(DISTURBANCES))
    parser.add_argument("--free", action="store_true", help="run also without the CAD model")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows: dict[str, Figures] = {}

    def measure(name: str, package: Path, runs: Path, run: Path) -> None:
        code = hullrecon("run", "-q", str(package), "--runs", str(runs), "--to", "adjust")
        rows[name] = {"exit_code": code} | (
            {} if code else figures(run, package) | {"said": said(run)}
        )
        print(f"{name}: ended with {code}" if code else line(name, rows[name]), flush=True)

    for name in args.only:
        copy, runs = args.folder / name, args.folder / "runs"
        if not copy.exists() and name in CALIBRATIONS:
            miscalibrate(args.package, copy, CALIBRATIONS[name])
        elif not copy.exists():
            disturb(args.package, copy, DISTURBANCES[name])
        measure(name, copy, runs, runs / name)
        if args.free:
            free, free_runs = without_cad_model(copy, runs / name)
            measure(f"{name}, no CAD model", free, free_runs, free_runs / name)
    keep(rows, args.json)
    return 0


if __name__ == "__main__":
    sys.exit(main())
