# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of wrong inputs: python -m benchmarks.faulty_inputs FOLDER [--dives N] [--seed S]
[--faultless N] [--only NAME ...] [--cameras KIND ...] [--json FILE]

Random dives (stereo, one camera, none) are simulated into FOLDER, and in each one input is made
wrong by a random size: a unit, an axis, a sign, a clock, a calibration, the CAD model. `check` and
`run --to adjust` see it, and the path is compared with the truth. An outcome is

  right    the path is as good as without the fault
  refused  check or run ends with an exit code, and names the sensor that is wrong
  named    the path is worse, and a warning names that sensor
  blamed   ended or warned, and only another sensor is named
  silent   the path is worse, and no warning is given

--faultless runs dives without a fault: every warning of theirs is an accusation.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import trimesh
import yaml
from mcap.reader import make_reader
from mcap.writer import Writer
from scipy.spatial.transform import Rotation

from benchmarks.disturbed import said
from benchmarks.legs import figures
from hullrecon.synthetic.logs import store

NS = 1_000_000_000
Message = Any  # of rosbags
# Changes a message of a topic, t seconds into the dive. None where the message is lost.
Edit = Callable[[Message, float], Message | None]
Files = Callable[[Path], None]  # changes files of a package other than its log

KINDS = {
    "none": "--cameras none --legs 3 --leg-length-m 4 --structures 0",
    "mono": "--cameras mono --legs 2 --leg-length-m 3 --structures 2 --marks 0 --barnacles 0",
    "stereo": "--cameras stereo --legs 2 --leg-length-m 3 --structures 2 --marks 0 --barnacles 0",
}
COMMON = "--no-sonar --image-width 400 --image-height 320 --leg-spacing-m 0.5"
AS_GOOD, AS_GOOD_MM = 1.5, 3.0  # times the error without the fault, or so much more
MANY_SIGMAS = 4.0
# words by which a sentence names the sensor that is wrong
NAMES = {
    "pressure": r"pressure|depth|atmospher",
    "dvl": r"\bdvl\b|speed of sound",
    "imu": r"\bimu\b|attitude|heading|angular|gyro|roll|pitch",
    "joints": r"tray|joint|servo",
    "camera": r"camera|calibrat|focal|lens|image|matrix|stereo",
    "clock": r"clock|stamp|time|late|early",
    "cad": r"\bcad\b|mesh|hull\.|model|unit",
}


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One wrong input of a random size."""

    sensor: str  # a key of NAMES: what has to be named
    edits: dict[str, Edit] = field(default_factory=dict)  # by topic
    files: Files | None = None
    size: str = ""  # of the fault, for the table


Random = np.random.Generator


def scale(*names: str) -> Callable[[Message, float], None]:
    """Make a function that multiplies fields, given as paths with dots."""

    def apply(message: Message, factor: float) -> None:
        for name in names:
            *path, last = name.split(".")
            of = message
            for step in path:
                of = getattr(of, step)
            setattr(of, last, getattr(of, last) * factor)

    return apply


def scaled(factor: float, *names: str) -> Edit:
    multiply = scale(*names)

    def edit(message: Message, t_s: float) -> Message:
        multiply(message, factor)
        return message

    return edit


def set_to(value: Callable[[float], float], name: str) -> Edit:
    def edit(message: Message, t_s: float) -> Message:
        setattr(message, name, value(t_s))
        return message

    return edit


def turned(matrix: np.ndarray, name: str) -> Edit:
    """Express a vector in other axes."""

    def edit(message: Message, t_s: float) -> Message:
        vector = getattr(message, name)
        vector.x, vector.y, vector.z = (matrix @ [vector.x, vector.y, vector.z]).tolist()
        return message

    return edit


def attitude(change: Callable[[Rotation], Rotation]) -> Edit:
    def edit(message: Message, t_s: float) -> Message:
        q = message.orientation
        q.x, q.y, q.z, q.w = change(Rotation.from_quat([q.x, q.y, q.z, q.w])).as_quat().tolist()
        return message

    return edit


def in_turn(*edits: Edit) -> Edit:
    def edit(message: Message, t_s: float) -> Message | None:
        for one in edits:
            message = one(message, t_s)
        return message

    return edit


def angle_negated(place: int) -> Edit:
    """Let yaw, pitch or roll (0, 1, 2) of an orientation grow the other way."""
    signs = np.where(np.arange(3) == place, -1.0, 1.0)
    return attitude(lambda r: Rotation.from_euler("ZYX", signs * r.as_euler("ZYX")))


def stamped(seconds: float) -> Edit:
    """Stamp a message late."""

    def edit(message: Message, t_s: float) -> Message:
        stamp = message.header.stamp
        t_ns = stamp.sec * NS + stamp.nanosec + round(seconds * NS)
        stamp.sec, stamp.nanosec = t_ns // NS, t_ns % NS
        return message

    return edit


def joint(change: Callable[[float], float]) -> Edit:
    def edit(message: Message, t_s: float) -> Message:
        message.position = np.array([change(x) for x in message.position])
        return message

    return edit


def picture(change: Callable[[np.ndarray], np.ndarray]) -> Edit:
    def edit(message: Message, t_s: float) -> Message:
        image = cv2.imdecode(np.asarray(message.data), cv2.IMREAD_COLOR)
        encoded = cv2.imencode(".jpg", change(image), [cv2.IMWRITE_JPEG_QUALITY, 92])[1]
        message.data = encoded.ravel()
        return message

    return edit


def lost_as_zero(start_s: float, seconds: float, covariance: float) -> Edit:
    """Write zeros for velocities while the bottom is lost, with a covariance."""

    def edit(message: Message, t_s: float) -> Message:
        if start_s <= t_s < start_s + seconds:
            v = message.velocity
            v.x = v.y = v.z = 0.0
            message.velocity_covar = np.diag(np.full(3, covariance)).ravel()
            message.range = np.zeros(4)
            message.num_good_beams = 0
        return message

    return edit


def calibration(*cameras: str, change: Callable[[dict[str, Any]], None]) -> Files:
    def files(package: Path) -> None:
        for camera in cameras:
            path = package / "calibration" / f"camera_{camera}.yaml"
            document = yaml.safe_load(path.read_text())
            change(document)
            path.write_text(yaml.safe_dump(document))

    return files


def focal(factor: float) -> Callable[[dict[str, Any]], None]:
    def change(document: dict[str, Any]) -> None:
        k = document["camera_matrix"]["data"]
        k[0], k[4] = k[0] * factor, k[4] * factor

    return change


def principal(dx: float, dy: float) -> Callable[[dict[str, Any]], None]:
    def change(document: dict[str, Any]) -> None:
        k = document["camera_matrix"]["data"]
        k[2], k[5] = k[2] + dx, k[5] + dy

    return change


def transpose(document: dict[str, Any]) -> None:
    document["camera_matrix"]["data"] = (
        np.reshape(document["camera_matrix"]["data"], (3, 3)).T.ravel().tolist()
    )


def distortion(document: dict[str, Any]) -> None:
    of = document["distortion_coefficients"]
    of["data"] = [-value for value in of["data"]]


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


def mesh(change: Callable[[trimesh.Trimesh], trimesh.Trimesh]) -> Files:
    def files(package: Path) -> None:
        change(trimesh.load(package / "hull.stl", process=False)).export(package / "hull.stl")

    return files


def swap_cameras(package: Path) -> None:
    path = package / "dive.toml"
    text = path.read_text()
    swapped = re.sub(
        r"(?m)^camera_(top|bottom) = ",
        lambda m: f"camera_{'bottom' if m[1] == 'top' else 'top'} = ",
        text,
    )
    path.write_text(swapped)


def sign(random: Random) -> float:
    return float(random.choice([-1.0, 1.0]))


def pick(random: Random, *values: float) -> float:
    return float(random.choice(values))


SWAPS = {
    "y negated": np.diag([1.0, -1.0, 1.0]),
    "z negated": np.diag([1.0, 1.0, -1.0]),
    "y and z negated": np.diag([1.0, -1.0, -1.0]),
    "x and y swapped": np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]]),
    "all negated": -np.eye(3),
    "x and y negated": np.diag([-1.0, -1.0, 1.0]),
    "turned by 90 degrees": np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]),
}
VECTORS = ("angular_velocity", "linear_acceleration")
CAMERAS = ("/camera/top/image_raw/compressed", "/camera/bottom/image_raw/compressed")


def _pressure(random: Random) -> dict[str, Fault]:
    unit, factor = [("hPa", 0.01), ("kPa", 0.001), ("bar", 1e-5), ("dbar", 1e-4)][
        random.integers(4)
    ]
    air = 101325.0 + random.normal(0, 2000)
    gain = float(random.choice([0.7, 0.85, 1.2, 1.5]))
    topic, name = "/pressure", "fluid_pressure"
    return {
        "pressure-unit": Fault(
            sensor="pressure", edits={topic: scaled(factor, name)}, size=f"in {unit}"
        ),
        "pressure-dead": Fault(
            sensor="pressure", edits={topic: set_to(lambda t: air, name)}, size=f"{air:.0f} Pa"
        ),
        "pressure-enclosure": Fault(
            sensor="pressure",
            edits={topic: set_to(lambda t: air + 30 * np.sin(t / 7) + random.normal(0, 8), name)},
            size="air in a housing",
        ),
        "pressure-scale": Fault(
            sensor="pressure",
            edits={
                topic: lambda m, t: set_to(
                    lambda _: 101325 + gain * (m.fluid_pressure - 101325), name
                )(m, t)
            },
            size=f"depth times {gain:g}",
        ),
    }


def _dvl(random: Random) -> dict[str, Fault]:
    factor = float(random.choice([0.001, 1000, 0.85, 1.15, 1.25]))
    axes = str(random.choice(list(SWAPS)))
    start, seconds = float(random.uniform(5, 15)), float(random.uniform(2, 6))
    return {
        "dvl-scale": Fault(
            sensor="dvl",
            edits={"/dvl": scaled(factor, "velocity.x", "velocity.y", "velocity.z")},
            size=f"velocity times {factor:g}",
        ),
        "dvl-axes": Fault(sensor="dvl", edits={"/dvl": turned(SWAPS[axes], "velocity")}, size=axes),
        "dvl-lost-zero": Fault(
            sensor="dvl",
            edits={"/dvl": lost_as_zero(start, seconds, pick(random, 1e-5, 1000.0, 0.0))},
            size=f"{seconds:.1f} s of zeros",
        ),
    }


def _imu(random: Random) -> dict[str, Fault]:
    axes = str(random.choice(list(SWAPS)))
    ned = Rotation.from_matrix([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
    flip = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))
    rates = ("angular_velocity.x", "angular_velocity.y", "angular_velocity.z")

    def order(message: Message, t_s: float) -> Message:
        q = message.orientation
        q.x, q.y, q.z, q.w = q.w, q.x, q.y, q.z
        return message

    angle = int(random.integers(3))
    in_body = [turned(np.diag([1.0, -1.0, -1.0]), of) for of in VECTORS]
    return {
        "imu-convention": Fault(
            sensor="imu",
            edits={"/imu": in_turn(attitude(lambda r: ned * r * flip), *in_body)},
            size="ENU and FLU, of all that it measures",
        ),
        "imu-angle": Fault(
            sensor="imu",
            edits={"/imu": angle_negated(angle)},
            size=f"{('yaw', 'pitch', 'roll')[angle]} grows the other way",
        ),
        "imu-rates-deg": Fault(
            sensor="imu", edits={"/imu": scaled(180 / np.pi, *rates)}, size="deg/s"
        ),
        "imu-rates-axes": Fault(
            sensor="imu", edits={"/imu": turned(SWAPS[axes], "angular_velocity")}, size=axes
        ),
        "imu-enu": Fault(sensor="imu", edits={"/imu": attitude(lambda r: ned * r * flip)}),
        "imu-body": Fault(sensor="imu", edits={"/imu": attitude(lambda r: r * flip)}),
        "imu-inverse": Fault(sensor="imu", edits={"/imu": attitude(lambda r: r.inv())}),
        "imu-order": Fault(sensor="imu", edits={"/imu": order}, size="w first"),
        "imu-dead": Fault(
            sensor="imu", edits={"/imu": attitude(lambda r: Rotation.identity())}, size="identity"
        ),
    }


def _joints(random: Random) -> dict[str, Fault]:
    off = float(np.radians(sign(random) * random.uniform(5, 20)))
    return {
        "joint-deg": Fault(sensor="joints", edits={"/joint_states": joint(np.degrees)}),
        "joint-sign": Fault(sensor="joints", edits={"/joint_states": joint(lambda x: -x)}),
        "joint-offset": Fault(
            sensor="joints",
            edits={"/joint_states": joint(lambda x: x + off)},
            size=f"{np.degrees(off):.1f} degrees",
        ),
    }


def _clocks(random: Random) -> dict[str, Fault]:
    topic = str(random.choice(["/dvl", "/imu", "/pressure"]))
    late = float(sign(random) * np.exp(random.uniform(np.log(0.1), np.log(5))))
    far = float(pick(random, 3600, 7200, -3600, -1_777_800_000, 18))
    return {
        "clock-late": Fault(
            sensor="clock", edits={topic: stamped(late)}, size=f"{topic} {late:+.2f} s"
        ),
        "clock-far": Fault(
            sensor="clock", edits={topic: stamped(far)}, size=f"{topic} {far:+.0f} s"
        ),
    }


def _cameras(random: Random, kind: str) -> dict[str, Fault]:
    both = ("top", "bottom") if kind == "stereo" else ("top",)
    topics = CAMERAS[: len(both)]
    late = float(sign(random) * random.uniform(0.08, 0.6))
    shift = float(sign(random) * random.uniform(15, 50))
    air = float(pick(random, 1 / 1.333, 1.333))
    out = {
        "camera-medium": Fault(
            sensor="camera", files=calibration(*both, change=focal(air)), size=f"f times {air:.3f}"
        ),
        "camera-focal": Fault(
            sensor="camera",
            files=calibration("top", change=focal(1.08)),
            size="f times 1.08, top alone",
        ),
        "camera-principal": Fault(
            sensor="camera",
            files=calibration(*both, change=principal(shift, shift / 2)),
            size=f"{shift:.0f} px",
        ),
        "camera-transposed": Fault(sensor="camera", files=calibration(*both, change=transpose)),
        "camera-distortion": Fault(sensor="camera", files=calibration(*both, change=distortion)),
        "camera-turned": Fault(
            sensor="camera",
            edits=dict.fromkeys(topics, picture(lambda i: np.ascontiguousarray(i[::-1, ::-1]))),
            size="pictures by 180 degrees",
        ),
        "camera-mirrored": Fault(
            sensor="camera",
            edits=dict.fromkeys(topics, picture(lambda i: np.ascontiguousarray(i[:, ::-1]))),
        ),
        "camera-late": Fault(
            sensor="clock", edits=dict.fromkeys(topics, stamped(late)), size=f"{late:+.2f} s"
        ),
    }
    if kind == "stereo":
        small = float(sign(random) * random.uniform(0.01, 0.06))
        out["camera-swapped"] = Fault(sensor="camera", files=swap_cameras)
        out["camera-apart"] = Fault(
            sensor="camera",
            files=toml("pose_in_top", lambda text: _longer(text, 1.1)),
            size="baseline 10 % too long",
        )
        out["camera-bottom-late"] = Fault(
            sensor="clock", edits={CAMERAS[1]: stamped(small)}, size=f"{1e3 * small:+.0f} ms"
        )
    return out


def _longer(text: str, factor: float) -> str:
    values = [float(word) for word in text.strip("[]").split(",")]
    return str([*(factor * value for value in values[:3]), *values[3:]])


def _cad(random: Random) -> dict[str, Fault]:
    unit = str(random.choice(["mm", "cm", "ft", "in"]))
    stretch = float(random.choice([0.9, 1.1, 1.3]))
    return {
        "cad-unit": Fault(sensor="cad", files=toml("units", lambda _: f'"{unit}"'), size=unit),
        "cad-scale": Fault(
            sensor="cad",
            files=mesh(lambda m: m.apply_scale(stretch)),
            size=f"times {stretch:g}",
        ),
        "cad-inverted": Fault(sensor="cad", files=mesh(_inverted), size="faces inwards"),
    }


def _inverted(of: trimesh.Trimesh) -> trimesh.Trimesh:
    of.invert()
    return of


def faults(kind: str, random: Random) -> dict[str, Fault]:
    """Draw the size of each fault that a dive of this kind may have."""
    found = (
        _pressure(random)
        | _dvl(random)
        | _imu(random)
        | _clocks(random)
        | _cad(random)
        | (_cameras(random, kind) | _joints(random) if kind != "none" else {})
    )
    return dict(found)


def corrupt(package: Path, copy: Path, fault: Fault) -> None:
    """Write a copy of a package with a fault."""
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("*.mcap"))
    rename(copy)
    (log,) = (package / "logs").glob("*.mcap")
    if fault.edits:
        rewrite(log, copy / "logs" / log.name, fault.edits)
    else:
        shutil.copy(log, copy / "logs")
    if fault.files is not None:
        fault.files(copy)


def rename(package: Path) -> None:
    path = package / "dive.toml"
    path.write_text(
        re.sub(r"(?m)^name = .*$", f'name = "{package.name}"', path.read_text(), count=1)
    )


def rewrite(log: Path, to: Path, edits: dict[str, Edit]) -> None:
    """Copy an MCAP log with messages of some topics changed."""
    with log.open("rb") as source, to.open("wb") as target:
        reader, writer = make_reader(source), Writer(target)
        writer.start(profile="ros2")
        channels: dict[int, int] = {}
        first_ns = None
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if channel.id not in channels:
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, known
                )
            first_ns = message.log_time if first_ns is None else first_ns
            data = message.data
            edit = edits.get(channel.topic)
            if edit is not None:
                read = store().deserialize_cdr(data, schema.name)
                changed = edit(read, (message.log_time - first_ns) / NS)
                if changed is None:
                    continue
                data = bytes(store().serialize_cdr(changed, schema.name))
            writer.add_message(channels[channel.id], message.log_time, data, message.publish_time)
        writer.finish()


@dataclass(frozen=True, kw_only=True)
class Seen:
    """What check and run made of a package."""

    check_code: int
    run_code: int
    sentences: list[str]  # warnings and errors of both
    error_mm: float  # of the path, NaN where none came out
    sigmas: float  # of the worst axis


def hullrecon(*words: str) -> tuple[int, str, str]:
    program = "import sys; from hullrecon_cli.main import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", program, *words], check=False, capture_output=True, text=True
    )
    return done.returncode, done.stdout, done.stderr


def look(package: Path, runs: Path, jobs: int) -> Seen:
    """Check and run a package, and compare the path with the truth."""
    check_code, out, err = hullrecon("check", str(package), "--json")
    try:
        found = json.loads(out)["findings"]
        sentences = [f["sentence"] for f in found if f["severity"] in ("warning", "error")]
    except (json.JSONDecodeError, KeyError):
        sentences = [err.strip()]
    words = ("run", "-q", str(package), "--runs", str(runs), "--to", "adjust", "--jobs", str(jobs))
    run_code, _, err = hullrecon(*words)
    run = runs / package.name
    sentences += [err.strip()] * (run_code != 0) + (said(run) if run.exists() else [])
    error_mm = sigmas = float("nan")
    if run_code == 0:
        row = figures(run, package)
        error_mm, sigmas = float(row["adjust_mm"]), max(row["errors_in_sigmas"])
        refused = row["cad_model_refused"]
        sentences += [str(refused)] if refused else []
    return Seen(
        check_code=check_code,
        run_code=run_code,
        sentences=sentences,
        error_mm=error_mm,
        sigmas=sigmas,
    )


def outcome(seen: Seen, without: Seen, sensor: str) -> str:
    """Judge what was made of a fault."""
    new = [sentence for sentence in seen.sentences if sentence not in without.sentences]
    named = any(re.search(NAMES[sensor], sentence, re.I) for sentence in new)
    if seen.check_code or seen.run_code:
        return "refused" if named else "blamed"
    as_good = seen.error_mm <= max(AS_GOOD * without.error_mm, without.error_mm + AS_GOOD_MM)
    if as_good and seen.sigmas <= max(MANY_SIGMAS, without.sigmas):
        return "right"
    if named:
        return "named"
    return "blamed" if new else "silent"


def simulate(kind: str, seed: int, folder: Path) -> Path:
    """Simulate a random dive of a kind, unless it exists."""
    random = np.random.default_rng([seed, list(KINDS).index(kind)])
    package = folder / f"{kind}-{seed}"
    if not (package / "truth").exists():
        words = [
            f"--speed-m-per-s={random.uniform(0.2, 0.4):.2f}",
            f"--standoff-m={random.uniform(1.0, 1.4):.2f}",
            f"--top-m={random.uniform(0.9, 1.5):.2f}",
            f"--length-m={random.choice([40, 60, 90])}",
            f"--heading-drift-deg-per-hour={random.choice([1, 10])}",
        ]
        code, _, err = hullrecon(
            *("simulate", "-q", str(package), "--name", package.name, "--seed", str(seed)),
            *(*COMMON.split(), *KINDS[kind].split(), *words),
        )
        if code:
            raise SystemExit(err)
    return package


def line(row: dict[str, Any]) -> str:
    told = " | ".join(" ".join(sentence.split())[:160] for sentence in row["sentences"][:4])
    return (
        f"{row['dive']:12s} {row['fault']:20s} {row['size']:24s} {row['outcome']:8s} check "
        f"{row['check_code']} run {row['run_code']} path {row['error_mm']:.1f} mm "
        f"({row['without_mm']:.1f}), {row['sigmas']:.1f} sigmas: {told}"
    )


def try_fault(
    package: Path, name: str, fault: Fault, without: Seen, folder: Path, jobs: int
) -> dict[str, Any]:
    """Make one fault, and judge what becomes of it."""
    copy = folder / "faulty" / f"{package.name}-{name}"
    if copy.exists():
        shutil.rmtree(copy)
    corrupt(package, copy, fault)
    seen = look(copy, folder / "runs", jobs)
    shutil.rmtree(folder / "runs" / copy.name, ignore_errors=True)
    return {
        "dive": package.name,
        "fault": name,
        "size": fault.size,
        "outcome": outcome(seen, without, fault.sensor),
        "without_mm": without.error_mm,
        **vars(seen),
    }


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--dives", type=int, default=20, help="faults to try")
    parser.add_argument("--per-dive", type=int, default=5, help="faults of one simulated dive")
    parser.add_argument("--faultless", type=int, default=0, help="dives without a fault")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", help="faults whose name begins so")
    parser.add_argument("--cameras", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    (args.folder / "faulty").mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(args.seed)
    rows: list[dict[str, Any]] = []

    for k in range(args.faultless):
        kind = args.cameras[k % len(args.cameras)]
        package = simulate(kind, args.seed * 1000 + k, args.folder)
        seen = look(package, args.folder / "runs", args.jobs)
        accused = "accused" if seen.sentences or seen.check_code or seen.run_code else "right"
        rows.append(
            {"dive": package.name, "fault": "none", "size": "", "outcome": accused}
            | {"without_mm": seen.error_mm, **vars(seen)}
        )
        print(line(rows[-1]), flush=True)

    done = k = 0
    while done < args.dives:
        kind = args.cameras[k % len(args.cameras)]
        package = simulate(kind, args.seed * 1000 + k, args.folder)
        without = look(package, args.folder / "runs", args.jobs)
        drawn = faults(kind, random)
        names = [n for n in drawn if not args.only or n.startswith(tuple(args.only))]
        for name in random.permutation(names)[: min(args.per_dive, args.dives - done)]:
            rows.append(try_fault(package, str(name), drawn[name], without, args.folder, args.jobs))
            print(line(rows[-1]), flush=True)
        done += min(args.per_dive, len(names))
        k += 1
    print(dict(Counter(row["outcome"] for row in rows)))
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1, default=float))
    return 0


if __name__ == "__main__":
    sys.exit(main())
