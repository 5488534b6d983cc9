# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read a whole dive package into records: what the ingest step keeps and `check` describes."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import BinaryIO, TypeVar

import numpy as np

from hullrecon.dive.check.contents import describe_losses, describe_streams
from hullrecon.dive.check.time_overlap import clock_gaps
from hullrecon.dive.check.topics import describe_unused, unread_dvls
from hullrecon.dive.config.calibration import read_camera, read_pose_in_top
from hullrecon.dive.hull.load import read_hull
from hullrecon.dive.images.logged_calibrations import LoggedCalibrations
from hullrecon.dive.images.sink import ImageSink
from hullrecon.dive.logs.fixed_frames import RIG, FixedSensor, FrameListener, is_static
from hullrecon.dive.logs.ping_spool import KeepImages, PingSpool, PingStorage, SpooledPing
from hullrecon.dive.logs.positions import is_acoustic, position_fixes
from hullrecon.dive.logs.read_streams import LogContents, Watch, read_streams
from hullrecon.dive.logs.readers.open import open_log
from hullrecon.dive.logs.readers.protocol import Log, Loss, Message
from hullrecon.dive.logs.republished import drop_republished
from hullrecon.dive.logs.samples import (
    DepthSample,
    DvlSample,
    ImageSample,
    ImuSample,
    JointSample,
    PositionSample,
    PressureSample,
    Sample,
    are_written_twice,
    find_copies,
    is_of_dvl,
)
from hullrecon.dive.logs.streams.dvl import dvl_pings
from hullrecon.dive.logs.streams.imu import imu_samples
from hullrecon.dive.logs.streams.joints import joint_samples
from hullrecon.dive.logs.streams.pressure import PressureModel, pressure_samples
from hullrecon.dive.logs.streams.sonar import leave_black, sonar_pings
from hullrecon.dive.logs.time_bases import BagStamps, join_time_bases
from hullrecon.dive.logs.time_window import Instant, TimeWindow, time_window
from hullrecon.dive.logs.timeline import put_in_order
from hullrecon.dive.problems import Problems
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding, sentences
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
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

# without a velocity; at a decimetre a second the vehicle may then be anywhere in a harbour
LONG_SILENCE_S = 3600.0
LEAST_SINKING_S = 20.0  # span of velocities by which the unit of depths can be judged
JOINT_KEYS = {"tray": "tray.joint", "sonar_tray": "sonar.joint"}
OpenFile = Callable[[str], BinaryIO]  # opens the file for the images of the camera of that name
Kind = TypeVar("Kind", bound=Sample)
DEPTHS: tuple[type[PressureSample | DepthSample], ...] = (PressureSample, DepthSample)


@dataclass(frozen=True)
class LogUnits:
    """The units of what was logged, as dive.toml gives them."""

    rates: str = "rad/s"
    velocity: str = "m/s"
    joints: Mapping[str, str] = field(default_factory=dict)  # by record ("tray", "sonar_tray")


@dataclass(frozen=True, kw_only=True)
class IngestRequest:
    """What ingest needs of dive.toml."""

    logs: tuple[str, ...]  # relative to the package, as all files
    topics: Mapping[str, str]  # by sensor
    joints: Mapping[str, str]  # name of the servo by record ("tray", "sonar_tray")
    tray_positive: str = "up"  # or "down": which way it tilts where its logged angle grows
    tray_offset_deg: float = 0.0  # added to the angles, growing up
    imu_frame: str  # "ned" or "enu"
    imu_mount_deg: tuple[float, float, float] | None = None  # roll, pitch, yaw in the vehicle
    imu_heading: str = "orientation"  # or "rates"
    pressure: PressureModel
    beams: Array | None  # (b, 3) of the DVL, for messages without
    sigma_velocity: float  # m/s, where a message has none
    calibration: Mapping[str, str]  # file by camera ("camera_top", "camera_bottom")
    added_ns: Mapping[str, int]  # by sensor, added to the stamps (positive where they are early)
    mesh: str | None  # the CAD model
    units: str  # of the CAD model
    uncalibrated: tuple[str, ...] = ()  # cameras whose calibration the logs have to hold
    start: Instant = None  # of the part of the logs that is used
    end: Instant = None
    sonar_azimuth_deg: Array | None = None  # (beams,), for logs that do not say
    log_units: LogUnits = field(default_factory=LogUnits)
    position_source: str | None = None  # "satellite", "acoustic"; None: by type and topic
    position_frame: str = "enu"  # or "ned", of local positions
    sigma_position: float = 2.0  # m, where a message has none


@dataclass(kw_only=True)
class IngestResult:
    """What was read, filled while the logs stream by."""

    records: SensorRecords = field(default_factory=SensorRecords)  # each in order of time
    images: dict[str, ImageIndex] = field(default_factory=dict)  # by camera
    cameras: dict[str, CameraModel] = field(default_factory=dict)
    hull: Mesh | None = None  # the CAD model
    counts: dict[str, int] = field(default_factory=dict)  # messages by topic
    sensors: dict[str, FixedSensor] = field(default_factory=dict)  # those that tf_static leads to
    # topics that are a DVL's by their names, of types that are not read
    unread_dvls: list[str] = field(default_factory=list)
    is_whole: bool = True  # every log was read to its end
    attitude_is_dvls: bool = False  # by the DVL's own sensors, as no IMU was logged
    lost: list[Finding] = field(default_factory=list)
    hull_notes: list[Finding] = field(default_factory=list)  # what was found and repaired
    unused: list[Finding] = field(default_factory=list)  # topics that no sensor was given
    notes: list[Finding] = field(default_factory=list)

    @property
    def spans(self) -> list[Finding]:
        """Describe each sensor's readings."""
        return describe_streams(self.records, self.images)

    def document(self) -> dict[str, list[str]]:
        """Collect the sentences of findings.json."""
        return {
            "spans": sentences(self.spans),
            "lost": sentences(self.lost),
            "hull": sentences(self.hull_notes),
            "notes": sentences(self.notes),
        }


def ingest(
    package: Path,
    request: IngestRequest,
    open_file: OpenFile,
    watch: Watch = iter,
    problems: Problems | None = None,
    pings: PingStorage | None = None,
) -> IngestResult:
    """Read what a package holds, once: sensors, images, calibrations and CAD model.

    What is absent is left out of the result. Whatever was corrected, assumed or dropped is in its
    findings.

    Parameters
    ----------
    package : its folder
    request : what is read, and in which conventions
    open_file : called for each camera whose image bytes are to be kept
    watch : sees every message pass, to report progress
    problems : collects the errors that would be raised; None: the first one is raised
    pings : where the sonar's images go. None drops them (those of the result are black)

    Raises
    ------
    InputError
        What cannot be used, with the file, topic or size that is wrong.
    """
    out, problems = IngestResult(), problems or Problems()
    logs = _open_logs(package, request, problems)
    for name, path in request.calibration.items():
        with problems.collect():
            camera = Camera(name.removeprefix("camera_"))
            out.cameras[name] = read_camera(package / path, camera, request.topics.get(name, ""))
    topics = {} if all(log.gives_samples for log in logs) else request.topics
    calibrations = LoggedCalibrations({name: topics.get(name) for name in request.uncalibrated})
    out.cameras |= calibrations.find(logs, problems)
    if request.mesh is not None:
        with problems.collect():
            out.hull = read_hull(package / request.mesh, request.units, out.hull_notes)
    window = None
    with problems.collect():
        window = time_window(request.start, request.end, logs)
    sinks = _image_sinks(package, request, out.cameras, open_file)
    frames = FrameListener(topics)
    spool = PingSpool(None if pings is None else pings.spool)

    def watch_all(messages: Iterable[Message]) -> Iterator[Message]:
        return frames.watch(calibrations.watch(watch(messages)))

    found = read_streams(
        logs,
        _sensors_by_topic(topics),
        partial(_take_image, sinks),
        watch_all,
        problems,
        window,
        spool.keep,
        request.added_ns,
    )
    # a log that could not be read may hold the topics that seem to be missing
    out.is_whole = len(logs) == len(request.logs) and not found.unread
    if out.is_whole:
        _check_topics(topics, found, problems)
    calibrations.check_constant(problems)
    bags = [number for number, log in enumerate(logs) if not log.gives_samples]
    out.notes += _join_time_bases(found, sinks, bags, request.added_ns)
    out.sensors = frames.sensors(request.joints) | _rig_of_camchain(package, request, out.cameras)
    out.notes += [*found.notes, *calibrations.notes(out.cameras)]
    _describe_contents(out, found, {*topics.values(), *calibrations.topics.values()})
    keep_images = leave_black if pings is None else pings.keep
    source = _Source(request, found, out.notes, spool, keep_images)
    out.records = _build_records(source, problems)
    out.attitude_is_dvls = source.attitude_is_dvls
    for name, sink in sinks.items():
        with problems.collect():
            index = sink.finish(out.notes)
            if index is not None:
                out.images[name] = index
    _check_found(out, request, window if found.outside else None, found.losses, problems)
    return out


def _open_logs(package: Path, request: IngestRequest, problems: Problems) -> list[Log]:
    """Choose the reader of each log. Logs that cannot be opened are collected as problems."""
    logs = []
    for name in request.logs:
        with problems.collect():
            logs.append(open_log(package / name, package))
    return logs


def _sensors_by_topic(topics: Mapping[str, str]) -> dict[str, list[str]]:
    """Turn topics by sensor into sensors by topic: a pose topic may serve several."""
    return {
        topic: [sensor for sensor, named in topics.items() if named == topic]
        for topic in topics.values()
    }


def _rig_of_camchain(
    package: Path, request: IngestRequest, cameras: Mapping[str, CameraModel]
) -> dict[str, FixedSensor]:
    """Read how the lower camera sits in the upper one where both share a camchain. Else empty."""
    files = [request.calibration.get(camera.key) for camera in Camera]
    if files[0] is None or files[0] != files[1] or len(cameras) < len(files):
        return {}
    pose = read_pose_in_top(package / files[0], request.topics)
    return {} if pose is None else {RIG: FixedSensor(frame=files[0], pose=pose)}


def _image_sinks(
    package: Path,
    request: IngestRequest,
    cameras: Mapping[str, CameraModel],
    open_file: OpenFile,
) -> dict[str, ImageSink]:
    """Make the sink of each calibrated camera, which indexes and stores its images."""
    return {
        name: ImageSink(
            name,
            (camera.width, camera.height),
            package,
            partial(open_file, name),
        )
        for name, camera in cameras.items()
    }


def _take_image(
    sinks: Mapping[str, ImageSink], sample: ImageSample, logged_ns: int, log: int
) -> None:
    if sample.camera in sinks:
        sinks[sample.camera].take(sample, logged_ns, log)


def _join_time_bases(
    found: LogContents,
    sinks: Mapping[str, ImageSink],
    bags: Sequence[int],
    added_ns: Mapping[str, int],
) -> list[Finding]:
    """Put the stamps of sensors in bags onto one time base, and report what was moved.

    A sensor whose time offset dive.toml gives is left unchanged, as is one of which a part comes
    from a log whose messages have one time only.

    Parameters
    ----------
    found : samples, whose stamps are changed in place
    sinks : by camera, what takes its images. Their stamps are changed too
    bags : numbers of the logs in which messages have a time of logging of their own
    added_ns : by sensor, what dive.toml has added to the stamps
    """
    rows: dict[str, tuple[Sequence[int], Sequence[int], Sequence[int]]] = {
        sensor: ([s.t_ns for s in samples], found.logged_ns[sensor], found.log[sensor])
        for sensor, samples in found.samples.items()
    }
    rows |= {camera: sink.stamps() for camera, sink in sinks.items()}
    by_sensor: dict[str, BagStamps] = {}
    for sensor, (stamp_ns, logged_ns, log) in rows.items():
        if stamp_ns and not added_ns.get(sensor) and np.isin(log, bags).all():
            by_sensor[sensor] = BagStamps(
                np.array(stamp_ns, np.int64), np.array(logged_ns, np.int64)
            )
    shifts, notes = join_time_bases(by_sensor)
    for sensor, shift_ns in shifts.items():
        if sensor in sinks:
            sinks[sensor].move(shift_ns)
            continue
        found.samples[sensor] = [
            replace(sample, t_ns=sample.t_ns + int(more))
            for sample, more in zip(found.samples[sensor], shift_ns, strict=True)
        ]
    return notes


def _describe_contents(out: IngestResult, found: LogContents, chosen: set[str]) -> None:
    """Note losses, the message count of each topic, and topics that no sensor uses.

    Parameters
    ----------
    out : where it is noted
    found : what reading the logs gave
    chosen : topics that a sensor or a calibration takes
    """
    out.lost = describe_losses(found.losses)
    out.counts = {
        channel.topic: count
        for channel, count in sorted(found.counts.items(), key=lambda c: c[0].topic)
    }
    messages_of = [channel for channel in found.counts if channel.encoding != "sample"]
    frames = {c.topic for c in found.counts if out.sensors and is_static(c)}
    out.unused = describe_unused(messages_of, chosen | frames)
    out.unread_dvls = unread_dvls(messages_of)


def _check_found(
    out: IngestResult,
    request: IngestRequest,
    window: TimeWindow | None,
    losses: Sequence[tuple[str, Loss]],
    problems: Problems,
) -> None:
    """Refuse several dives in one, clocks that are apart, and a package without any reading.

    The latter is not refused where other problems were found, which explain it.

    Parameters
    ----------
    out : what was read
    request : what was asked for
    window : the time window, where it excluded measurements, else None
    losses : what of the logs could not be read, with the file's name
    problems : collects or raises what is refused
    """
    with problems.collect():
        _check_silence(out)
    for gap in clock_gaps({**out.records.by_name(), **out.images}, request.added_ns):
        if gap.severity == "error":
            problems.refuse(gap)
    if not out.records.by_name() and not out.images and not problems.found:
        with problems.collect():
            raise _nothing_read(request, window, [loss for _, loss in losses])


def _nothing_read(
    request: IngestRequest, window: TimeWindow | None, losses: Sequence[Loss]
) -> InputError:
    """Make the error that says why no sensor gave a reading: damage, the time window or topics."""
    if losses:
        return InputError(
            f"no sensor could be read from the logs: {losses[0].why}",
            where=", ".join(request.logs),
            remedy="give a log that is whole",
        )
    if window is not None:
        return InputError(
            f"nothing was measured {window.describe()}",
            where="dive.from",
            remedy="`hullrecon init LOG` says when a log begins",
        )
    return InputError(
        "no sensor could be read from the logs",
        where=", ".join(request.logs),
        remedy="`hullrecon init LOG` lists what a log holds; a run needs a DVL with an IMU, or two "
        "cameras, in [topics]",
    )


def _check_silence(found: IngestResult) -> None:
    """Raise InputError where the DVL is silent for LONG_SILENCE_S, without images in between.

    Nothing then tells how the vehicle moved, so the package holds several dives.
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
        f"the DVL gives no velocity for {silent_s[at] / 3600:.1f} h from "
        f"{format_time(int(t_ns[at]))} on, and no image tells how the vehicle moved meanwhile: "
        "these are several dives",
        where="logs.files",
        remedy="give one at a time, by other files or by dive.from and dive.to",
    )


def _check_topics(topics: Mapping[str, str], found: LogContents, problems: Problems) -> None:
    """Raise InputError for a topic that dive.toml names but no log holds.

    Where logs are damaged its messages may have been lost. That is only noted.
    """
    held = {channel.topic for channel in found.counts}
    for sensor, topic in sorted(topics.items()):
        if topic in held:
            continue
        if found.losses:
            found.notes.append(Finding("topic-lost", {"topic": topic}, sensor))
            continue
        with problems.collect():
            raise InputError(
                f"topic {topic} is not in the log, which holds "
                f"{', '.join(sorted(held)) or 'nothing'}",
                where=f"topics.{sensor}",
                remedy="name the topic that the log has, or leave the key away",
            )


@dataclass
class _Source:
    """The inputs from which the records are built, and the records so far."""

    request: IngestRequest
    found: LogContents  # samples by sensor
    notes: list[Finding]  # what is assumed or left out is added
    spool: PingSpool  # the images of the sonar's samples
    keep_images: KeepImages  # stores the images of the sonar's record
    attitude_is_dvls: bool = False  # the attitude is by sensors inside the DVL
    built: dict[str, SensorRecord | None] = field(default_factory=dict)  # by sensor

    def samples(
        self, sensor: str, kind: type[Kind] | tuple[type[Kind], ...], joint: str | None = None
    ) -> list[Kind]:
        """Collect the samples of a sensor in order of time, without duplicates.

        Empty where it was not logged. Attitudes and depths of the DVL's own sensors are ignored
        where another sensor was logged. Clock jumps are corrected. Readings that were stamped in
        bursts, when a buffer was read, are spread over the time in which they were measured.
        Readings that were written twice, or that a driver repeated until the next one, are dropped.

        Parameters
        ----------
        sensor : its key in [topics] of dive.toml
        kind : type of its samples; others are ignored
        joint : name of one servo among those of "joints"
        """
        found = self.found
        rows = [
            row
            for row in zip(
                found.samples[sensor], found.logged_ns[sensor], found.log[sensor], strict=True
            )
            if isinstance(row[0], kind) and joint in (None, getattr(row[0], "name", None))
        ]
        # done before sorting by time, as two sensors have two clocks
        own = [row for row in rows if not is_of_dvl(row[0])]
        if own and len(own) < len(rows):
            values = {"sensor": sensor, "count": len(rows) - len(own)}
            self.notes.append(Finding("dvl-sensors-ignored", values, sensor))
            rows = own
        name = sensor if joint is None else f"joint {joint}"
        copies = set(find_copies([sample for sample, *_ in rows], [log for *_, log in rows]))
        if copies and len(copies) < len(rows) - 1:  # else the clock stands still
            values = {"copies": len(copies), "count": len(rows)}
            self.notes.append(Finding("readings-twice", values, name))
            rows = [row for number, row in enumerate(rows) if number not in copies]
        line = put_in_order(
            name,
            [sample.t_ns for sample, *_ in rows],
            [logged for _, logged, _ in rows],
            [log for *_, log in rows],
            spread=not are_written_twice([sample for sample, *_ in rows]),
        )
        self.notes += line.notes
        ordered = ((rows[i][0], int(t_ns)) for i, t_ns in zip(line.keep, line.t_ns, strict=True))
        kept = [s if s.t_ns == t_ns else replace(s, t_ns=t_ns) for s, t_ns in ordered]
        return drop_republished(name, kept, self.notes)


def _build_dvl(source: _Source) -> DvlPings | None:
    samples, request = source.samples("dvl", DvlSample), source.request
    if not samples:
        return None
    unit = request.log_units.velocity
    return dvl_pings(samples, request.beams, request.sigma_velocity, source.notes, unit)


def _build_imu(source: _Source) -> ImuSamples | None:
    """Stack the attitudes, and note whether they are by the DVL's own sensors."""
    samples, request = source.samples("imu", ImuSample), source.request
    if not samples:
        return None
    source.attitude_is_dvls = all(sample.of_dvl for sample in samples)
    return imu_samples(
        samples,
        request.imu_frame,
        source.notes,
        request.imu_mount_deg,
        request.log_units.rates,
        request.imu_heading,
    )


def _build_pressure(source: _Source) -> PressureSamples | None:
    """Stack the depths."""
    samples = source.samples("pressure", DEPTHS)
    if not samples:
        return None
    return pressure_samples(samples, source.request.pressure, source.notes, _tells_depth(source))


def _tells_depth(source: _Source) -> bool:
    """Tell whether DVL and IMU give velocities for long enough to compare depths with.

    A wrong unit of the pressure is then found by that comparison, so that depths above the water
    need not be refused here.
    """
    dvl, imu = source.built.get("dvl"), source.built.get("imu")
    if not isinstance(dvl, DvlPings) or imu is None:
        return False
    heard_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    return len(heard_ns) > 1 and bool(heard_ns[-1] - heard_ns[0] >= LEAST_SINKING_S * NS)


def _build_sonar(source: _Source) -> SonarPings | None:
    request, samples = source.request, source.samples("sonar", SpooledPing)
    return sonar_pings(
        samples, source.notes, request.sonar_azimuth_deg, source.keep_images, source.spool.load
    )


def _build_position(source: _Source) -> PositionFixes | None:
    """Stack the position fixes (USBL, GNSS). The depth tells when an antenna was under water."""
    request, samples = source.request, source.samples("position", PositionSample)
    acoustic = is_acoustic(request.position_source, request.topics.get("position", ""))
    samples = [replace(s, by_satellite=s.by_satellite and not acoustic) for s in samples]
    depths = source.built.get("pressure")
    pressure = depths if isinstance(depths, PressureSamples) else None
    return position_fixes(
        samples, request.sigma_position, request.position_frame, pressure, source.notes
    )


def _build_joint(record: str, source: _Source) -> JointSamples | None:
    """Stack the angles of the servo of a record, "tray" or "sonar_tray". None if not logged."""
    joint = source.request.joints.get(record)
    if joint is None:
        return None
    samples = source.samples("joints", JointSample, joint)
    unit = source.request.log_units.joints.get(record, "rad")
    if not samples:
        return None
    servo = joint_samples(samples, record, joint, source.notes, unit)
    return servo if servo is None or record != "tray" else _upwards(servo, source.request)


def _upwards(tray: JointSamples, request: IngestRequest) -> JointSamples:
    """Convert the tray's logged angles to those of the frame `tray`: growing as it tilts up.

    Sense and zero are those of [tray] in dive.toml.
    """
    sense = -1.0 if request.tray_positive == "down" else 1.0
    return replace(tray, angle=sense * tray.angle + np.radians(request.tray_offset_deg))


BUILDERS: dict[str, Callable[[_Source], SensorRecord | None]] = {
    "dvl": _build_dvl,
    "imu": _build_imu,
    "pressure": _build_pressure,
    "sonar": _build_sonar,
    "position": _build_position,  # after pressure, which tells when an antenna was under water
    **{record: partial(_build_joint, record) for record in JOINT_KEYS},
}


def _build_records(source: _Source, problems: Problems) -> SensorRecords:
    """Build the records of all sensors but the cameras, in the order of BUILDERS.

    A record is None without its sensor, and where what is wrong with it was collected as a problem.
    """
    for name, build in BUILDERS.items():
        if name == next(iter(JOINT_KEYS)):  # once, in front of the joints
            with problems.collect():
                _check_joints(source)
        with problems.collect():
            source.built[name] = build(source)
    return SensorRecords(**source.built)  # type: ignore[arg-type]


def _check_joints(source: _Source) -> None:
    """Raise InputError for a servo that dive.toml names but no joint message holds.

    It is only noted for the sonar's servo where no joint was logged at all, and where a damaged log
    may have held it. Nothing is said of the tray where no joint was logged: that it is taken as
    fixed is reported elsewhere.
    """
    held = {s.name for s in source.found.samples["joints"] if isinstance(s, JointSample)}
    for record, joint in source.request.joints.items():
        where = JOINT_KEYS[record]
        if joint in held:
            continue
        if not held or source.found.losses:
            if held or record != "tray":
                source.notes.append(Finding("joint-absent", {"joint": joint}, where))
            continue
        others = held - set(source.request.joints.values())  # joints that dive.toml does not name
        near = difflib.get_close_matches(joint, others, 1, 0.6)
        remedy = f'name one of them, or set {where} = "" if nothing turns there'
        if near:
            remedy = f'did you mean "{near[0]}"?'
        raise InputError(
            f"joint {joint} is not in the log, which holds {', '.join(sorted(held))}",
            where=where,
            remedy=remedy,
        )


def whole_ns(seconds: float) -> int:
    """Convert a time offset to whole nanoseconds."""
    return round(seconds * NS)
