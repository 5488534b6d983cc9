# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""ingest: the package's logs, calibration and CAD model, read once, checked, and kept as tables."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any, BinaryIO

import msgspec
import numpy as np
from numpy.typing import NDArray

from hullrecon.artifacts.graph.stage import Context, Stage
from hullrecon.dive.ingest import Ingested, Request, ingest, offset_ns
from hullrecon.dive.logs.dvl_beams import tilted_beams
from hullrecon.dive.logs.readers.open import open_log
from hullrecon.dive.logs.readers.plain import PlainLog
from hullrecon.dive.logs.readers.rosbag2 import METADATA, STORAGE
from hullrecon.dive.logs.streams import PressureModel
from hullrecon.records.serialisation import to_arrays

CAMERAS = {"camera_top": "camera.top", "camera_bottom": "camera.bottom"}
USES = (
    "logs", "topics", "tray.joint", "sonar.joint", "imu.frame", "pressure.density", "pressure.gravity", "pressure.atmosphere",
    "dvl.beams", "dvl.beam_angle_deg", "dvl.beam_azimuth_deg", "dvl.sigma_velocity",
    "camera.top.calibration", "camera.top.time_offset", "camera.bottom.calibration",
    "camera.bottom.time_offset", "hull.mesh", "hull.units",
)  # fmt: skip


class IngestOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """None: what is read is said by the other sections."""


def request_of(settings: Mapping[str, Any]) -> Request:
    """What ingest needs, from the dotted keys of `USES`."""
    topics = {name: getattr(settings["topics"], name) for name in settings["topics"].__struct_fields__}
    calibration = {name: settings[f"{section}.calibration"] for name, section in CAMERAS.items()}
    joints = {"tray": settings["tray.joint"], "sonar_tray": settings["sonar.joint"]}
    return Request(
        logs=settings["logs"].files,
        topics=_present(topics),
        joints=_present(joints),
        imu_frame=settings["imu.frame"],
        pressure=PressureModel(*(settings[f"pressure.{key}"] for key in ("density", "gravity", "atmosphere"))),
        beams=_beams(settings),
        sigma_velocity=settings["dvl.sigma_velocity"],
        calibration=_present(calibration),
        offset_ns={name: offset_ns(settings[f"{section}.time_offset"] or 0.0) for name, section in CAMERAS.items()},
        mesh=settings["hull.mesh"],
        units=settings["hull.units"] or "m",
    )


def _beams(settings: Mapping[str, Any]) -> NDArray[np.float64] | None:
    """Return (b, 3) unit vectors of the DVL's beams as dive.toml has them, either way; None where it has none."""
    if settings["dvl.beam_angle_deg"] is not None:
        return tilted_beams(settings["dvl.beam_angle_deg"], settings["dvl.beam_azimuth_deg"])
    beams = settings["dvl.beams"]
    return None if beams is None else np.array(beams, float)


def external(settings: Mapping[str, Any], package: Path) -> list[Path]:
    """Logs, with the files that their tables name; calibrations; CAD model."""
    request = request_of(settings)
    names = [*request.calibration.values(), *([request.mesh] if request.mesh else [])]
    logs = [file for name in request.logs for file in _log_files(package, name)]
    return [*logs, *(Path(name) for name in names)]


def _log_files(package: Path, name: str) -> list[Path]:
    """Return the files of one log, relative to the package where they lie in it. Of a folder only those that are read: a run
    may keep its own folder below it."""
    folder = package / name
    try:
        if not folder.is_dir():
            return [Path(name)]
    except OSError:  # a name that no file can have: the reader says so
        open_log(folder, package)
    log = open_log(folder, package)
    if isinstance(log, PlainLog):
        return [*(Path(name) / table for table in log.tables()), *log.named_files()]
    return [Path(name) / path.name for path in sorted(folder.iterdir()) if path.name == METADATA or path.suffix in STORAGE]


def run(context: Context) -> None:
    with ExitStack() as files:

        def open_file(camera: str) -> BinaryIO:
            path = files.enter_context(context.out.path(f"images_{camera}.bin"))
            return files.enter_context(path.open("wb"))

        found = ingest(
            context.source, request_of(context.settings), open_file, lambda messages: context.progress(messages, "messages")
        )
    _write(context, found)
    for sentence in [*found.lost, *found.remarks]:
        context.warn(sentence)


def _write(context: Context, found: Ingested) -> None:
    for name, record in found.records.items():
        if record is not None:
            context.out.arrays(f"{name}.npz", to_arrays(record))
    for name, index in found.images.items():
        context.out.arrays(f"images_{name}.npz", to_arrays(index))
    cameras = {name.removeprefix("camera_"): asdict(camera) for name, camera in found.cameras.items() if name in found.images}
    context.out.json("cameras.json", cameras)
    if found.hull is not None:
        context.out.arrays("hull.npz", {"vertices": found.hull.vertices, "faces": found.hull.faces})
    context.out.json("findings.json", found.findings())


def _present(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value not in (None, "")}


STAGE = Stage(
    name="ingest",
    summary="read the logs, the calibration and the CAD model",
    inputs=(),
    parameters=IngestOptions,
    version=2,
    run=run,
    uses=USES,
    external=external,
)
