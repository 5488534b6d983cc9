# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The whole package to records: what the ingest step keeps, and what `check` tells."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.check import messages
from hullrecon.dive.config.calibration import read_camera
from hullrecon.dive.hull.load import read_hull
from hullrecon.dive.images.sink import ImageSink
from hullrecon.dive.logs import streams
from hullrecon.dive.logs.read_streams import Gathered, Watch, gather
from hullrecon.dive.logs.readers.open import open_log
from hullrecon.dive.logs.samples import ImageSample
from hullrecon.dive.logs.timeline import NS, put_in_order
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.sensors import ImageIndex

JOINT_KEYS = {"tray": "tray.joint", "sonar_tray": "sonar.joint"}
OpenFile = Callable[[str], BinaryIO]  # a file for the images of that camera


@dataclass(frozen=True)
class Request:
    """What ingest needs of dive.toml. topics: topic by sensor; joints: servo by record ("tray", "sonar_tray"); calibration
    and offset_ns by camera ("camera_top", "camera_bottom"); beams (b, 3) or None."""

    logs: tuple[str, ...]
    topics: Mapping[str, str]
    joints: Mapping[str, str]
    imu_frame: str
    pressure: streams.PressureModel
    beams: NDArray[np.float64] | None
    sigma_velocity: float
    calibration: Mapping[str, str]
    offset_ns: Mapping[str, int]
    mesh: str | None
    units: str


@dataclass
class Ingested:
    """records by name ("dvl", "imu", "pressure", "tray", "sonar_tray", "sonar"), images and cameras by camera, hull or None."""

    records: dict[str, Any] = field(default_factory=dict)
    images: dict[str, ImageIndex] = field(default_factory=dict)
    cameras: dict[str, CameraModel] = field(default_factory=dict)
    hull: Mesh | None = None
    counts: dict[str, int] = field(default_factory=dict)
    lost: list[str] = field(default_factory=list)
    hull_words: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def findings(self) -> dict[str, Any]:
        """findings.json: sentences."""
        spans = messages.spans(self.records, self.images)
        return {"spans": spans, "lost": self.lost, "hull": self.hull_words, "remarks": self.remarks}


def ingest(package: Path, request: Request, open_file: OpenFile, watch: Watch = iter) -> Ingested:
    """Reads everything once. Raises InputError for what cannot be used, with the file, topic or size that is wrong."""
    out = Ingested()
    logs = [open_log(package / name, package) for name in request.logs]
    out.cameras = {name: read_camera(package / path) for name, path in request.calibration.items()}
    if request.mesh is not None:
        out.hull = read_hull(package / request.mesh, request.units, out.hull_words)
    sinks = {
        name: ImageSink(name, (c.width, c.height), request.offset_ns[name], package, lambda name=name: open_file(name))  # type: ignore[misc]
        for name, c in out.cameras.items()
    }

    def take_image(sample: ImageSample, logged_ns: int) -> None:
        if sample.camera in sinks:
            sinks[sample.camera].take(sample, logged_ns)

    topics = {} if all(log.gives_samples for log in logs) else request.topics
    found = gather(logs, {topic: sensor for sensor, topic in topics.items()}, take_image, watch)
    _check_topics(topics, found)
    out.remarks += found.remarks
    out.lost = messages.losses(found.losses)
    out.counts = {channel.topic: count for channel, count in sorted(found.counts.items(), key=lambda c: c[0].topic)}
    _records(out, request, found)
    for name, sink in sinks.items():
        index = sink.finish(out.remarks)
        if index is not None:
            out.images[name] = index
    if not out.records and not out.images:
        raise InputError("no sensor could be read from the logs", where=", ".join(request.logs), remedy="see `hullrecon check`")
    return out


def _check_topics(topics: Mapping[str, str], found: Gathered) -> None:
    """A topic that is named but absent is an error, unless the log is damaged: then its messages may be what was lost."""
    held = {channel.topic for channel in found.counts}
    for sensor, topic in sorted(topics.items()):
        if topic in held:
            continue
        if not found.losses:
            raise InputError(
                f"topic {topic} is not in the log, which holds {', '.join(sorted(held)) or 'nothing'}",
                where=f"topics.{sensor}", remedy="name the topic that the log has, or leave the key away",
            )  # fmt: skip
        found.remarks.append(f"{sensor}: nothing of {topic} is left in the damaged log")


def _records(out: Ingested, request: Request, found: Gathered) -> None:
    make: dict[str, Callable[[list[Any]], Any]] = {
        "dvl": lambda s: streams.dvl_pings(s, request.beams, request.sigma_velocity, out.remarks),
        "imu": lambda s: streams.imu_samples(s, request.imu_frame, out.remarks),
        "pressure": lambda s: streams.pressure_samples(s, request.pressure, out.remarks),
        "sonar": lambda s: streams.sonar_pings(s, out.remarks),
    }
    for name, build in make.items():
        samples = _ordered(name, found.samples[name], found.logged_ns[name], out.remarks)
        if samples:
            out.records[name] = build(samples)
    joints = list(zip(found.samples["joints"], found.logged_ns["joints"], strict=True))
    _check_joints(request, found, {str(s.name) for s, _ in joints}, out.remarks)  # type: ignore[union-attr]
    for record, joint in request.joints.items():
        mine = [(s, t) for s, t in joints if s.name == joint]  # type: ignore[union-attr]
        samples = _ordered(f"joint {joint}", [s for s, _ in mine], [t for _, t in mine], out.remarks)
        if samples:
            out.records[record] = streams.joint_samples(samples, joint, out.remarks)


def _check_joints(request: Request, found: Gathered, held: set[str], remarks: list[str]) -> None:
    """InputError for a servo that is named but that no joint message holds, unless the log is damaged. Without any joint
    message the tray is known to be taken as fixed; of the sonar's servo that is remarked."""
    for record, joint in request.joints.items():
        where = JOINT_KEYS[record]
        if joint in held:
            continue
        if not held or found.losses:
            if held or record != "tray":
                remarks.append(f"{where}: no reading of {joint} is in the log; it is taken as fixed at 0 degrees")
            continue
        near = difflib.get_close_matches(joint, held, 1, 0.5)
        raise InputError(
            f"joint {joint} is not in the log, which holds {', '.join(sorted(held))}", where=where,
            remedy=f'did you mean "{near[0]}"?' if near else f'name one of them, or set {where} = "" if nothing turns there',
        )  # fmt: skip


def _ordered(name: str, samples: list[Any], logged_ns: list[int], remarks: list[str]) -> list[Any]:
    line = put_in_order(name, [s.t_ns for s in samples], logged_ns)
    remarks += line.remarks
    return [samples[i] for i in line.keep]


def offset_ns(seconds: float) -> int:
    return round(seconds * NS)
