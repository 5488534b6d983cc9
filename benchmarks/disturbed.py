# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What sensors that fail do to the path: python -m benchmarks.disturbed PACKAGE FOLDER [--only NAME ...] [--json FILE]

PACKAGE is a simulated dive with an MCAP log. Copies of it are made in FOLDER, each disturbed in one way: no images for 50 s, no
DVL for 60 s, an IMU whose clock jumps by 2 s, a heading that steps by 3 degrees, each from the middle of the dive. Each is run
to `adjust` and compared with the truth: the vehicle's error in its own sigmas, and what was said of it.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import struct
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer
from scipy.spatial.transform import Rotation

from benchmarks.legs import figures, hullrecon

NS = 1_000_000_000
HEADING_STEP_DEG, CLOCK_JUMP_S, NO_IMAGES_S, NO_DVL_S = 3.0, 2.0, 50.0, 60.0
ENCAPSULATION = 4  # bytes before a message in CDR
# From the topic, the time since the dive's middle in s and the message: the message as it is logged, or None where it is lost.
Disturbance = Callable[[str, float, bytes], bytes | None]


def stamp(data: bytes) -> int:
    """Return the stamp of a message's header, ns."""
    seconds, nanoseconds = struct.unpack_from("<iI", data, ENCAPSULATION)
    return int(seconds) * NS + int(nanoseconds)


def with_stamp(data: bytes, t_ns: int) -> bytes:
    """Return a message with another stamp."""
    return data[:ENCAPSULATION] + struct.pack("<iI", t_ns // NS, t_ns % NS) + data[ENCAPSULATION + 8 :]


def turned(data: bytes, angle_deg: float) -> bytes:
    """Return an Imu message whose attitude is turned about the vertical of its frame."""
    (length,) = struct.unpack_from("<I", data, ENCAPSULATION + 8)
    at = ENCAPSULATION + (8 + 4 + length + 7) // 8 * 8
    quaternion = np.array(struct.unpack_from("<4d", data, at))
    turn = Rotation.from_euler("z", angle_deg, degrees=True)
    return data[:at] + struct.pack("<4d", *(turn * Rotation.from_quat(quaternion)).as_quat()) + data[at + 32 :]


def undisturbed(topic: str, since_s: float, data: bytes) -> bytes | None:
    return data


def no_images(topic: str, since_s: float, data: bytes) -> bytes | None:
    return None if "camera" in topic and 0 <= since_s < NO_IMAGES_S else data


def no_dvl(topic: str, since_s: float, data: bytes) -> bytes | None:
    return None if topic == "/dvl" and abs(since_s) < NO_DVL_S / 2 else data


def clock_jump(topic: str, since_s: float, data: bytes) -> bytes | None:
    return with_stamp(data, stamp(data) + round(CLOCK_JUMP_S * NS)) if topic == "/imu" and since_s >= 0 else data


def heading_step(topic: str, since_s: float, data: bytes) -> bytes | None:
    return turned(data, HEADING_STEP_DEG) if topic == "/imu" and since_s >= 0 else data


DISTURBANCES: dict[str, Disturbance] = {
    "undisturbed": undisturbed,
    "no-images": no_images,
    "no-dvl": no_dvl,
    "clock-jump": clock_jump,
    "heading-step": heading_step,
}


def disturb(package: Path, copy: Path, change: Disturbance) -> None:
    """Write a copy of a package whose log is disturbed."""
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("*.mcap"))
    text = (copy / "dive.toml").read_text()
    (copy / "dive.toml").write_text(re.sub(r"(?m)^name = .*$", f'name = "{copy.name}"', text, count=1))
    (log,) = (package / "logs").glob("*.mcap")
    with log.open("rb") as source, (copy / "logs" / log.name).open("wb") as target:
        reader, writer = make_reader(source), Writer(target)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        middle = (summary.statistics.message_start_time + summary.statistics.message_end_time) // 2
        writer.start(profile="ros2")
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if channel.id not in channels:
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, known)
            data = change(channel.topic, (message.log_time - middle) / NS, message.data)
            if data is not None:
                writer.add_message(channels[channel.id], message.log_time, data, message.publish_time)
        writer.finish()


def said(run: Path) -> list[str]:
    """Return what the steps remarked."""
    sentences = json.loads((run / "ingest" / "findings.json").read_text())["remarks"]
    return [*sentences, *json.loads((run / "navigate" / "navigation.json").read_text())["remarks"]]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="+", choices=DISTURBANCES, default=list(DISTURBANCES))
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows: dict[str, object] = {}
    for name in args.only:
        copy = args.folder / name
        if not copy.exists():
            disturb(args.package, copy, DISTURBANCES[name])
        code = hullrecon("run", "-q", str(copy), "--runs", str(args.folder / "runs"), "--to", "adjust")
        run = args.folder / "runs" / name
        row = {"exit_code": code} | ({} if code else figures(run, copy) | {"said": said(run)})
        rows[name] = row
        print(f"{name}: {json.dumps(row)}", flush=True)
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
