# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""ingest: read the package's logs, calibrations and CAD model once, and keep them as tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import BinaryIO

import numpy as np

from hullrecon.artifacts.stage import Context, StageSettings
from hullrecon.artifacts.writer import write_blocks
from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.schema import Logs, Topics
from hullrecon.dive.ingest.ingest import ingest
from hullrecon.dive.ingest.request import IngestRequest, LogUnits, whole_ns
from hullrecon.dive.ingest.result import IngestResult
from hullrecon.dive.logs.dvl_beams import tilted_beams
from hullrecon.dive.logs.formats.stamps import LoggerClock, zone_of
from hullrecon.dive.logs.ping_spool import Images, PingStorage
from hullrecon.dive.logs.streams.pressure import PressureModel
from hullrecon.dive.logs.time_window import Instant
from hullrecon.geometry.frames import Camera
from hullrecon.records.sensors import SonarPings
from hullrecon.records.serialisation import to_arrays
from hullrecon.steps.artifacts import MOUNTS, SONAR_IMAGES
from hullrecon.steps.chain import NoOptions
from hullrecon.steps.keys import CARRIED, INGEST_KEYS, TIME_OFFSETS
from hullrecon.typing import Array


def ingest_settings(loaded: LoadedConfig) -> StageSettings:
    """Select the settings of a dive.toml that ingest reads."""
    return StageSettings("ingest", {name: loaded.value(name) for name in INGEST_KEYS})


def request_of(settings: StageSettings) -> IngestRequest:
    """Build the request for ingest, which knows nothing of dive.toml, from `INGEST_KEYS`.

    Topics, joints and calibrations that dive.toml does not name are left out.
    """
    topics = settings.read("topics", Topics)
    named: dict[str, str | None] = {
        name: getattr(topics, name) for name in topics.__struct_fields__
    }
    keys = ("density", "gravity", "atmosphere")
    azimuth = settings.read_optional("sonar.beam_azimuth_deg", tuple)
    logs = settings.read("logs", Logs)
    return IngestRequest(
        logs=logs.files,
        clock=_clock(logs.time_zone, settings.read_optional("dive.date", datetime)),
        topics=_drop_empty(named),
        joints=_drop_empty(
            {
                "tray": settings.read("tray.joint", str),
                "sonar_tray": settings.read_optional("sonar.joint", str),
            }
        ),
        imu_frame=settings.read("imu.frame", str),
        log_units=LogUnits(
            rates=settings.read("imu.rates_unit", str),
            velocity=settings.read("dvl.velocity_unit", str),
            joints={
                "tray": settings.read("tray.joint_unit", str),
                "sonar_tray": settings.read_optional("sonar.joint_unit", str) or "rad",
            },
        ),
        tray_positive=settings.read("tray.positive", str),
        tray_offset_deg=settings.read("tray.offset_deg", float),
        imu_heading=settings.read("imu.heading", str),
        imu_mount_deg=settings.read_optional("imu.mount_deg", tuple),
        pressure=PressureModel(
            **{key: settings.read(f"pressure.{key}", float) for key in keys},
            z_axis=settings.read_optional("pressure.z_axis", str),
            unit=settings.read_optional("pressure.unit", str),
        ),
        beams=_beams(settings),
        sigma_velocity=settings.read("dvl.sigma_velocity", float),
        calibration=_drop_empty(
            {c.key: settings.read_optional(f"{c.section}.calibration", str) for c in Camera}
        ),
        added_ns={
            sensor: whole_ns(settings.read_optional(f"{section}.time_offset", float) or 0.0)
            for sensor, section in TIME_OFFSETS.items()
        },
        uncalibrated=tuple(c.key for c in Camera if _needs_logged_calibration(settings, c)),
        mesh=settings.read_optional("hull.mesh", str),
        units=settings.read_optional("hull.units", str) or "m",
        start=_instant(settings, "dive.from"),
        end=_instant(settings, "dive.to"),
        position_source=settings.read_optional("position.source", str),
        position_frame=settings.read("position.frame", str),
        sigma_position=settings.read("position.sigma_m", float),
        sonar_azimuth_deg=None if azimuth is None else np.array(azimuth, float),
    )


def _needs_logged_calibration(settings: StageSettings, camera: Camera) -> bool:
    """Test whether a camera was carried of which dive.toml names no calibration.

    The log's camera_info then has to give it.
    """
    return (
        settings[f"{camera.section}.{CARRIED}"] is not None
        and settings[f"{camera.section}.calibration"] is None
    )


def _clock(time_zone: str | None, start: datetime | None) -> LoggerClock:
    """Say in which zone tables are stamped, and on which day of it the dive began.

    start: of the dive. One without a zone is in that of the tables.
    """
    zone = zone_of(time_zone)
    if start is not None and start.tzinfo is not None:
        start = start.astimezone(zone or start.tzinfo)
    return LoggerClock(zone=zone, day=None if start is None else start.date())


def _instant(settings: StageSettings, name: str) -> Instant:
    """Read a limit of the time window: a date, s from the log's start, or None for no limit."""
    value = settings[name]
    return value if isinstance(value, datetime) else settings.read_optional(name, float)


def _beams(settings: StageSettings) -> Array | None:
    """Read the DVL's beams (b, 3) from angles or unit vectors. None if dive.toml has neither."""
    angle_deg = settings.read_optional("dvl.beam_angle_deg", float)
    if angle_deg is not None:
        return tilted_beams(angle_deg, settings.read("dvl.beam_azimuth_deg", tuple))
    beams = settings.read_optional("dvl.beams", tuple)
    return None if beams is None else np.array(beams, float)


def run(context: Context[NoOptions]) -> None:
    """Read the package into the artifact, so that no later step reads a log again.

    Images go to their files while logs are read, and pings by way of a temporary file, so that
    memory does not grow with the dive. What was lost or noted gives warnings.
    """
    with ExitStack() as files:

        def open_file(camera: str) -> BinaryIO:
            path = files.enter_context(context.out.path(f"images_{camera}.bin"))
            return files.enter_context(path.open("wb"))

        def keep_pings(shape: tuple[int, int, int], images: Iterator[Images]) -> Images:
            return _write_images(files.enter_context(context.out.path(SONAR_IMAGES)), shape, images)

        spool = files.enter_context(context.out.scratch())
        found = ingest(
            context.source,
            request_of(context.settings),
            open_file,
            lambda messages: context.progress(messages, "messages"),
            pings=PingStorage(spool, keep_pings),
        )
    _write(context, found)
    for finding in (*found.lost, *found.notes):
        context.warn(finding.sentence)


def _write_images(path: Path, shape: tuple[int, int, int], images: Iterator[Images]) -> Images:
    """Write images one after another as one .npy, and map it, so that they need not fit in memory.

    shape: (pings, beams, ranges) of all images together.
    """
    write_blocks(path, np.dtype(np.uint8), shape, images)
    return np.asarray(np.load(path, mmap_mode="r", allow_pickle=False))


def _write(context: Context[NoOptions], found: IngestResult) -> None:
    """Write streams, image indices, cameras, mounts, CAD model and findings.

    What the dive lacks has no file. Images of the sonar are in a file already. Calibrations of
    cameras without images are dropped.
    """
    for name, record in found.records.by_name().items():
        apart = {"image"} if isinstance(record, SonarPings) else set()
        context.out.arrays(
            f"{name}.npz",
            {key: value for key, value in to_arrays(record).items() if key not in apart},
        )
    for name, index in found.images.items():
        context.out.arrays(f"images_{name}.npz", to_arrays(index))
    cameras = {
        name.removeprefix("camera_"): asdict(camera)
        for name, camera in found.cameras.items()
        if name in found.images
    }
    context.out.json("cameras.json", cameras)
    if found.sensors:
        context.out.json(MOUNTS, {sensor: asdict(fixed) for sensor, fixed in found.sensors.items()})
    if found.hull is not None:
        context.out.arrays("hull.npz", {"vertices": found.hull.vertices, "faces": found.hull.faces})
    context.out.json("findings.json", found.document())


def _drop_empty(values: Mapping[str, str | None]) -> dict[str, str]:
    """Drop values that are None or empty."""
    return {name: value for name, value in values.items() if value}
