# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read an input as the program does, and boil it down to a digest of its data and to what was said
about it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile

import msgspec
import numpy as np

from benchmarks.fuzz.seed_files import HEIGHT, WIDTH
from benchmarks.fuzz.seed_messages import TOPICS
from hullrecon.dive.config import yaml_files
from hullrecon.dive.config.calibration import read_camera
from hullrecon.dive.config.load import load_config
from hullrecon.dive.hull.load import read_hull
from hullrecon.dive.images.encoded import check_image, decode
from hullrecon.dive.ingest.ingest import ingest
from hullrecon.dive.ingest.request import IngestRequest
from hullrecon.dive.init.log_summary import summarise_logs
from hullrecon.dive.init.template import fill_template
from hullrecon.dive.logs.ping_spool import PingStorage
from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.dive.logs.streams.pressure import PressureModel
from hullrecon.dive.logs.streams.sonar import keep_in_memory
from hullrecon.findings.finding import Finding, sentences
from hullrecon.records.serialisation import to_arrays
from hullrecon.steps.chain import stages

BEAMS = np.array(
    [[-0.5, 0, 0.75**0.5], [0.5, 0, 0.75**0.5], [0, 0.5, 0.75**0.5], [0, -0.5, 0.75**0.5]]
)
CALIBRATION = "camera_top.yaml"
AZIMUTH_DEG = np.linspace(-14, 14, 48)  # of the beams of a DIDSON


@dataclass(frozen=True)
class Reading:
    """digest: of the data that came out. said: sentences about what was lost or assumed."""

    digest: str
    said: frozenset[str]


Read = Callable[[Path, str], Reading]  # of a folder and the name of the input in it


def read_log(folder: Path, name: str) -> Reading:
    """Read a log of any form with all its sensors, images and pings, as `ingest` does."""
    kept: dict[str, BytesIO] = {}
    request = IngestRequest(
        logs=(name,),
        topics=TOPICS,
        joints={"tray": "tray"},
        imu_frame="ned",
        imu_mount_deg=(0.0, 0.0, 0.0),
        pressure=PressureModel(1025.0, 9.81, 101325.0),
        beams=BEAMS,
        sigma_velocity=0.003,
        calibration={"camera_top": CALIBRATION},
        added_ns={"camera_top": 0},
        mesh=None,
        units="m",
        sonar_azimuth_deg=AZIMUTH_DEG,
    )
    with TemporaryFile() as spool:
        storage = PingStorage(spool, keep_in_memory)
        found = ingest(
            folder, request, lambda camera: kept.setdefault(camera, BytesIO()), pings=storage
        )
    parts = [("", np.frombuffer(b"".join(f.getvalue() for f in kept.values()), np.uint8))]
    for key, record in {**found.records.by_name(), **found.images}.items():
        parts += [(f"{key}.{field}", array) for field, array in to_arrays(record).items()]
    return Reading(_digest(parts), frozenset(sentences([*found.lost, *found.notes])))


def look_into_log(folder: Path, name: str) -> Reading:
    """Write a dive.toml from a log as `init` does: it has to be one that `check` takes, whatever
    names the log holds.
    """
    logs = find_logs(folder / name)
    found = summarise_logs([open_log(path) for path in logs])
    text = fill_template(found, logs, folder)
    assert all(c.isprintable() or c == "\n" for c in text), f"control characters in {text!r}"
    with TemporaryDirectory(dir=folder) as place:
        (Path(place) / "dive.toml").write_text(text, encoding="utf-8")
        load_config(Path(place))
    lines = [*found.lines(), text]
    return Reading(
        hashlib.sha256("\n".join(lines).encode()).hexdigest(),
        frozenset(sentences([*found.lost, *found.notes])),
    )


def read_configuration(folder: Path, name: str) -> Reading:
    """Read a dive.toml with the sections of every step."""
    loaded = load_config(folder, {stage.name: stage.parameters for stage in stages()})
    sections = {key: msgspec.to_builtins(section) for key, section in loaded.sections.items()}
    return Reading(
        hashlib.sha256(repr(sections).encode(errors="surrogatepass")).hexdigest(), frozenset()
    )


def read_calibration(folder: Path, name: str) -> Reading:
    """Read a camera's YAML."""
    return Reading(repr(asdict(read_camera(folder / name))), frozenset())


def read_cad_model(folder: Path, name: str) -> Reading:
    """Read a CAD model: what is said of it beyond its size counts as said."""
    notes: list[Finding] = []
    mesh = read_hull(folder / name, "m", notes)
    return Reading(
        _digest([("vertices", mesh.vertices), ("faces", mesh.faces)]),
        frozenset(sentences(notes[1:])),
    )


def read_image(folder: Path, name: str) -> Reading:
    """Read an image: a damaged one is said to be damaged by the count of the images left out."""
    encoded = (folder / name).read_bytes()
    size = check_image(encoded, (WIDTH, HEIGHT)).size
    image = decode(encoded) if size == (WIDTH, HEIGHT) else None
    if image is None:
        return Reading("", frozenset(["the image is left out"]))
    assert image.shape[1::-1] == size
    return Reading(_digest([("image", image)]), frozenset())


def parse_each_yaml_once() -> None:
    """Keep what YAML holds by its text in this process: a damaged log comes with the same sound
    calibration each time.
    """
    yaml_files.parse_yaml = lru_cache(maxsize=32)(yaml_files.parse_yaml)


def _digest(parts: Iterable[tuple[str, np.ndarray]]) -> str:
    out = hashlib.sha256()
    for key, array in parts:
        out.update(f"{key} {array.dtype} {array.shape}".encode())
        out.update(np.ascontiguousarray(array).tobytes())
    return out.hexdigest()


READERS: Mapping[str, Read] = {
    "log": read_log,
    "configuration": read_configuration,
    "calibration": read_calibration,
    "cad": read_cad_model,
    "image": read_image,
    "init": look_into_log,
}
