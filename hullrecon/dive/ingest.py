# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read a whole dive package into records: what the ingest step keeps and `check` describes."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import BinaryIO, TypeVar

import numpy as np

from hullrecon.dive.check import messages
from hullrecon.dive.config.calibration import read_camera
from hullrecon.dive.hull.load import read_hull
from hullrecon.dive.images.logged_calibrations import LoggedCalibrations
from hullrecon.dive.images.sink import ImageSink
from hullrecon.dive.logs import streams
from hullrecon.dive.logs.fixed_frames import FixedSensor, FrameListener, is_static
from hullrecon.dive.logs.ping_spool import KeepImages, PingSpool, PingStorage, SpooledPing
from hullrecon.dive.logs.positions import position_fixes
from hullrecon.dive.logs.read_streams import LogContents, Watch, read_streams
from hullrecon.dive.logs.readers.open import open_log
from hullrecon.dive.logs.samples import (
    DepthSample,
    DvlSample,
    ImageSample,
    ImuSample,
    JointSample,
    PositionSample,
    PressureSample,
    Sample,
)
from hullrecon.dive.logs.time_window import Instant, TimeWindow, time_window
from hullrecon.dive.logs.timeline import put_in_order
from hullrecon.dive.logs.unused_topics import describe_unused, unread_dvls
from hullrecon.dive.problems import Problems
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.clock import NS, format_time
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PositionFixes,
    PressureSamples,
    SensorRecord,
    SensorRecords,
    SonarPings,
)
from hullrecon.typing import Array

# without velocity: at a decimetre a second the vehicle may be anywhere in a harbour
LONG_SILENCE_S = 3600.0
JOINT_KEYS = {"tray": "tray.joint", "sonar_tray": "sonar.joint"}
OpenFile = Callable[[str], BinaryIO]  # a file for the images of that camera
Kind = TypeVar("Kind", bound=Sample)
DEPTHS: tuple[type[PressureSample | DepthSample], ...] = (PressureSample, DepthSample)


@dataclass(frozen=True, kw_only=True)
class IngestRequest:
    """Hold what ingest needs of dive.toml. topics: topic by sensor; joints: servo by record
    ("tray", "sonar_tray"); calibration and offset_ns by camera ("camera_top", "camera_bottom");
    uncalibrated: the cameras whose calibration the logs have to hold; beams (b, 3) or None; start,
    end: what of the logs is used; sonar_azimuth_deg: of an imaging sonar's beams; sonar_offset_ns,
    position_offset_ns: added to the stamps; position_frame: "enu" or "ned", of local positions;
    sigma_position: m, where a message has none.
    """

    logs: tuple[str, ...]
    topics: Mapping[str, str]
    joints: Mapping[str, str]
    imu_frame: str
    imu_mount_deg: tuple[float, float, float] | None = None
    pressure: streams.PressureModel
    beams: Array | None
    sigma_velocity: float
    calibration: Mapping[str, str]
    offset_ns: Mapping[str, int]
    mesh: str | None
    units: str
    uncalibrated: tuple[str, ...] = ()
    start: Instant = None
    end: Instant = None
    sonar_azimuth_deg: Array | None = None
    sonar_offset_ns: int = 0
    position_frame: str = "enu"
    sigma_position: float = 2.0
    position_offset_ns: int = 0


@dataclass(kw_only=True)
class IngestResult:
    """Hold what was read, by sensor and by camera; filled while the logs stream by. hull: None
    without a CAD model.
    """

    records: SensorRecords = field(default_factory=SensorRecords)
    images: dict[str, ImageIndex] = field(default_factory=dict)
    cameras: dict[str, CameraModel] = field(default_factory=dict)
    hull: Mesh | None = None
    counts: dict[str, int] = field(default_factory=dict)
    lost: list[str] = field(default_factory=list)
    hull_messages: list[str] = field(default_factory=list)
    # topics that dive.toml does not name, and why a run does not use them
    unused: list[str] = field(default_factory=list)
    sensors: dict[str, FixedSensor] = field(default_factory=dict)  # those that tf_static leads to
    remarks: list[str] = field(default_factory=list)
    # topics that are a DVL's by their names, of types that are not read
    unread_dvls: list[str] = field(default_factory=list)
    attitude_is_dvls: bool = False  # by the DVL's own sensors, as no IMU was logged

    def findings(self) -> dict[str, list[str]]:
        """Return the sentences of findings.json."""
        spans = messages.describe_streams(self.records, self.images)
        return {
            "spans": spans,
            "lost": self.lost,
            "hull": self.hull_messages,
            "remarks": self.remarks,
        }


def ingest(
    package: Path,
    request: IngestRequest,
    open_file: OpenFile,
    watch: Watch = iter,
    problems: Problems | None = None,
    pings: PingStorage | None = None,
) -> IngestResult:
    """Return what the package holds, read once.

    open_file is called for each camera whose image bytes are to be kept; pings: where the sonar's
    images go, None to leave them aside (those of the result are black); watch sees every message
    pass (progress). Raises InputError for what cannot be used, with the file, topic or size that is
    wrong, unless `problems` takes it.
    """
    out, problems = IngestResult(), problems or Problems()
    logs = []
    for name in request.logs:
        with problems.collect():
            logs.append(open_log(package / name, package))
    for name, path in request.calibration.items():
        with problems.collect():
            out.cameras[name] = read_camera(package / path)
    topics = {} if all(log.gives_samples for log in logs) else request.topics
    logged = LoggedCalibrations({name: topics.get(name) for name in request.uncalibrated})
    out.cameras |= logged.find(logs, problems)
    if request.mesh is not None:
        with problems.collect():
            out.hull = read_hull(package / request.mesh, request.units, out.hull_messages)
    sinks = {
        name: ImageSink(
            name, (c.width, c.height), request.offset_ns[name], package, partial(open_file, name)
        )
        for name, c in out.cameras.items()
    }

    def take_image(sample: ImageSample, logged_ns: int, log: int) -> None:
        if sample.camera in sinks:
            sinks[sample.camera].take(sample, logged_ns, log)

    sensors = {
        topic: [sensor for sensor, named in topics.items() if named == topic]
        for topic in topics.values()
    }
    window = None
    with problems.collect():
        window = time_window(request.start, request.end, logs)
    frames = FrameListener(topics)
    spool = PingSpool(None if pings is None else pings.spool)
    offsets = {
        **request.offset_ns,
        "sonar": request.sonar_offset_ns,
        "position": request.position_offset_ns,
    }
    found = read_streams(
        logs,
        sensors,
        take_image,
        lambda m: frames.watch(logged.watch(watch(m))),
        problems,
        window,
        spool.keep,
        offsets,
    )
    _check_topics(topics, found, problems)
    logged.check_constant(problems)
    out.sensors = frames.sensors(request.joints)
    out.remarks += [*found.remarks, *logged.remarks(out.cameras)]
    _note_contents(out, found, {*topics.values(), *logged.topics.values()})
    out.records = _build_records(
        out, request, found, problems, spool, streams.leave_black if pings is None else pings.keep
    )
    for name, sink in sinks.items():
        with problems.collect():
            index = sink.finish(out.remarks)
            if index is not None:
                out.images[name] = index
    _check_found(out, request, window if found.outside else None, problems)
    return out


def _note_contents(out: IngestResult, found: LogContents, chosen: set[str]) -> None:
    """Note what was lost, what each topic holds, and why those that are not among the chosen ones
    are not used.
    """
    out.lost = messages.describe_losses(found.losses)
    out.counts = {
        channel.topic: count
        for channel, count in sorted(found.counts.items(), key=lambda c: c[0].topic)
    }
    messages_of = [channel for channel in found.counts if channel.encoding != "sample"]
    out.unused = describe_unused(
        messages_of, chosen | {c.topic for c in found.counts if out.sensors and is_static(c)}
    )
    out.unread_dvls = unread_dvls(messages_of)


def _check_found(
    out: IngestResult, request: IngestRequest, window: TimeWindow | None, problems: Problems
) -> None:
    """Raise InputError, or hand it to `problems`, where these are several dives, or nothing was
    read; window: see `_nothing_read`.
    """
    with problems.collect():
        _check_silence(out)
    if not out.records.by_name() and not out.images and not problems.found:
        with problems.collect():
            raise _nothing_read(request, window)


def _nothing_read(request: IngestRequest, window: TimeWindow | None) -> InputError:
    """Return why nothing could be read; window: outside of which all was measured, None where that
    is not the reason.
    """
    if window is not None:
        return InputError(
            f"nothing was measured {window.describe()}",
            where="dive.from",
            remedy="`hullrecon init LOG` says when a log begins",
        )
    return InputError(
        "no sensor could be read from the logs",
        where=", ".join(request.logs),
        remedy="`hullrecon init LOG` lists what a log holds; a run needs a DVL with an IMU, or two cameras, in [topics]",
    )


def _check_silence(found: IngestResult) -> None:
    """Raise InputError where the DVL is silent for so long that these are several dives, and no
    camera could join them.
    """
    dvl = found.records.dvl
    if dvl is None or found.images:
        return
    t_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    silent_s = np.diff(t_ns) / NS
    if not len(silent_s) or silent_s.max() < LONG_SILENCE_S:
        return
    at = int(silent_s.argmax())
    raise InputError(
        f"the DVL gives no velocity for {silent_s[at] / 3600:.1f} h from {format_time(int(t_ns[at]))} on, and no image tells "
        "how the vehicle moved meanwhile: these are several dives",
        where="logs.files",
        remedy="give one at a time, by other files or by dive.from and dive.to",
    )


def _check_topics(topics: Mapping[str, str], found: LogContents, problems: Problems) -> None:
    """Raise InputError for a topic that is named but absent, unless the log is damaged: its
    messages may be what was lost.
    """
    held = {channel.topic for channel in found.counts}
    for sensor, topic in sorted(topics.items()):
        if topic in held:
            continue
        if found.losses:
            found.remarks.append(f"{sensor}: nothing of {topic} is left in the damaged log")
            continue
        with problems.collect():
            raise InputError(
                f"topic {topic} is not in the log, which holds {', '.join(sorted(held)) or 'nothing'}",
                where=f"topics.{sensor}",
                remedy="name the topic that the log has, or leave the key away",
            )


def _build_records(
    out: IngestResult,
    request: IngestRequest,
    found: LogContents,
    problems: Problems,
    spool: PingSpool,
    keep_images: KeepImages,
) -> SensorRecords:
    """Return the records of all sensors but the cameras."""
    remarks = out.remarks
    built: dict[str, SensorRecord | None] = {}

    def build(name: str, record: Callable[[], SensorRecord | None]) -> None:
        with problems.collect():
            built[name] = record()

    def dvl() -> DvlPings | None:
        samples = _sort_samples("dvl", found, DvlSample, remarks)
        return (
            streams.dvl_pings(samples, request.beams, request.sigma_velocity, remarks)
            if samples
            else None
        )

    def imu() -> ImuSamples | None:
        samples = _sort_samples("imu", found, ImuSample, remarks)
        out.attitude_is_dvls = bool(samples) and all(sample.of_dvl for sample in samples)
        return (
            streams.imu_samples(samples, request.imu_frame, remarks, request.imu_mount_deg)
            if samples
            else None
        )

    def pressure() -> PressureSamples | None:
        samples = _sort_samples("pressure", found, DEPTHS, remarks)
        return streams.pressure_samples(samples, request.pressure, remarks) if samples else None

    def sonar() -> SonarPings | None:
        spooled = _sort_samples("sonar", found, SpooledPing, remarks)
        samples = [replace(s, t_ns=s.t_ns + request.sonar_offset_ns) for s in spooled]
        return streams.sonar_pings(
            samples, remarks, request.sonar_azimuth_deg, keep_images, spool.load
        )

    def position() -> PositionFixes | None:
        samples = _sort_samples("position", found, PositionSample, remarks)
        moved = [replace(s, t_ns=s.t_ns + request.position_offset_ns) for s in samples]
        depths = built.get("pressure")
        known = depths if isinstance(depths, PressureSamples) else None
        return position_fixes(moved, request.sigma_position, request.position_frame, known, remarks)

    build("dvl", dvl)
    build("imu", imu)
    build("pressure", pressure)
    build("sonar", sonar)
    build("position", position)
    with problems.collect():
        _check_joints(
            request,
            found,
            {s.name for s in found.samples["joints"] if isinstance(s, JointSample)},
            remarks,
        )
    for record in JOINT_KEYS:
        build(record, partial(_build_joint, record, request, found, remarks))
    return SensorRecords(**built)  # type: ignore[arg-type]


def _build_joint(
    record: str, request: IngestRequest, found: LogContents, remarks: list[str]
) -> JointSamples | None:
    """Return the angles of the servo of that record, "tray" or "sonar_tray"; None where none was
    logged.
    """
    joint = request.joints.get(record)
    samples = (
        _sort_samples("joints", found, JointSample, remarks, joint) if joint is not None else []
    )
    return streams.joint_samples(samples, joint, remarks) if samples and joint is not None else None


def _check_joints(
    request: IngestRequest, found: LogContents, held: set[str], remarks: list[str]
) -> None:
    """Raise InputError for a servo that is named but that no joint message holds, unless the log is
    damaged.

    Without any joint message the tray is known to be taken as fixed; for the sonar's servo a remark
    says so.
    """
    for record, joint in request.joints.items():
        where = JOINT_KEYS[record]
        if joint in held:
            continue
        if not held or found.losses:
            if held or record != "tray":
                remarks.append(
                    f"{where}: no reading of {joint} is in the log; it is taken as fixed at 0 degrees"
                )
            continue
        near = difflib.get_close_matches(joint, held, 1, 0.5)
        raise InputError(
            f"joint {joint} is not in the log, which holds {', '.join(sorted(held))}",
            where=where,
            remedy=f'did you mean "{near[0]}"?'
            if near
            else f'name one of them, or set {where} = "" if nothing turns there',
        )


def _sort_samples(
    sensor: str,
    found: LogContents,
    kind: type[Kind] | tuple[type[Kind], ...],
    remarks: list[str],
    joint: str | None = None,
) -> list[Kind]:
    """Return the samples of a sensor, of one joint where it is named, in order of time without
    duplicates. Those by the DVL's own sensors are left aside where others were logged.
    """
    rows = [
        (s, logged, log)
        for s, logged, log in zip(
            found.samples[sensor], found.logged_ns[sensor], found.log[sensor], strict=True
        )
        if isinstance(s, kind)
        and (joint is None or (isinstance(s, JointSample) and s.name == joint))
    ]
    # before they are put in order: two sensors are two clocks
    own = [row for row in rows if not streams.is_of_dvl(row[0])]
    if own and len(own) < len(rows):
        remarks.append(streams.describe_left_aside(sensor, len(rows) - len(own)))
        rows = own
    stamp_ns, logged_ns, log_of = (
        [s.t_ns for s, *_ in rows],
        [t for _, t, _ in rows],
        [n for *_, n in rows],
    )
    line = put_in_order(sensor if joint is None else f"joint {joint}", stamp_ns, logged_ns, log_of)
    remarks += line.remarks
    sorted_rows = ((rows[i][0], int(t_ns)) for i, t_ns in zip(line.keep, line.t_ns, strict=True))
    return [s if s.t_ns == t_ns else replace(s, t_ns=t_ns) for s, t_ns in sorted_rows]


def offset_ns(seconds: float) -> int:
    """Return a time offset in whole nanoseconds."""
    return round(seconds * NS)
