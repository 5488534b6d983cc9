# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read a whole dive package into records: what the ingest step keeps and `check` describes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import BinaryIO

import numpy as np

from hullrecon.dive.check.contents import describe_losses
from hullrecon.dive.check.topics import describe_unused, unread_dvls
from hullrecon.dive.config.calibration import read_camera, read_pose_in_top
from hullrecon.dive.hull.load import read_hull
from hullrecon.dive.images.logged_calibrations import LoggedCalibrations
from hullrecon.dive.images.sink import ImageSink
from hullrecon.dive.ingest.records import Source, build_records
from hullrecon.dive.ingest.refusals import check_found, check_topics, refuse_same_files
from hullrecon.dive.ingest.request import IngestRequest
from hullrecon.dive.ingest.result import IngestResult
from hullrecon.dive.logs.fixed_frames import RIG, FixedSensor, FrameListener, is_static
from hullrecon.dive.logs.ping_spool import PingSpool, PingStorage
from hullrecon.dive.logs.read_streams import LogContents, Watch, read_streams
from hullrecon.dive.logs.readers.open import open_log
from hullrecon.dive.logs.readers.protocol import Log, Message
from hullrecon.dive.logs.samples import ImageSample
from hullrecon.dive.logs.streams.sonar import leave_black
from hullrecon.dive.logs.time_bases import BagStamps, join_time_bases
from hullrecon.dive.logs.time_window import time_window
from hullrecon.dive.problems import Problems
from hullrecon.findings.finding import Finding
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.records.sensors import ImageIndex

OpenFile = Callable[[str], BinaryIO]  # opens the file for the images of the camera of that name


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
    # tables and instruments' files name their sensors themselves
    topics = {} if all(log.gives_samples for log in logs) else request.topics

    # Calibrations and CAD model, from their files. A log may hold calibrations instead.
    out.cameras = _read_calibrations(package, request, problems)
    calibrations = LoggedCalibrations({name: topics.get(name) for name in request.uncalibrated})
    out.cameras |= calibrations.find(logs, problems)
    if request.mesh is not None:
        with problems.collect():
            out.hull = read_hull(package / request.mesh, request.units, out.hull_notes)

    # Every message of the logs, once: samples are sorted by sensor, images go to their sinks.
    window = None
    with problems.collect():
        window = time_window(request.start, request.end, logs)
    sinks = _image_sinks(package, out.cameras, open_file)
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
        check_topics(topics, found, problems)
    calibrations.check_constant(problems)

    # Stamps on one time base, and what the logs hold beside samples.
    bags = [number for number, log in enumerate(logs) if not log.gives_samples]
    out.notes += _join_time_bases(found, sinks, bags, request.added_ns)
    out.sensors = frames.sensors(request.joints) | _rig_of_camchain(package, request, out.cameras)
    out.notes += [*found.notes, *calibrations.notes(out.cameras)]
    _describe_contents(out, found, {*topics.values(), *calibrations.topics.values()})

    # The samples of each sensor become its record, the images an index.
    keep_images = leave_black if pings is None else pings.keep
    source = Source(request, found, out.notes, spool, keep_images)
    out.records = build_records(source, problems)
    out.attitude_is_dvls = source.attitude_is_dvls
    out.images = _index_images(sinks, out.notes, problems)
    check_found(out, request, window if found.outside else None, found.losses, problems)
    return out


def _open_logs(package: Path, request: IngestRequest, problems: Problems) -> list[Log]:
    """Choose the reader of each log. Logs that cannot be opened are collected as problems."""
    logs = []
    for name in request.logs:
        with problems.collect():
            logs.append(open_log(package / name, package, request.clock))
    return logs


def _read_calibrations(
    package: Path, request: IngestRequest, problems: Problems
) -> dict[str, CameraModel]:
    """Read the camera calibrations that dive.toml names, by camera ("camera_top", ...)."""
    cameras = {}
    for name, path in request.calibration.items():
        with problems.collect():
            camera = Camera(name.removeprefix("camera_"))
            cameras[name] = read_camera(package / path, camera, request.topics.get(name, ""))
    return cameras


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
    """Pass an image to the sink of its camera. Cameras without a calibration have none."""
    if sample.camera in sinks:
        sinks[sample.camera].take(sample, logged_ns, log)


def _index_images(
    sinks: Mapping[str, ImageSink], notes: list[Finding], problems: Problems
) -> dict[str, ImageIndex]:
    """Index the images of each camera that has any, by the camera's name.

    notes: what was found wrong is added. problems: collects the error of a camera, so that the
    others are still indexed, or lets it pass.
    """
    images, still = {}, all(sink.is_still for sink in sinks.values())
    for name, sink in sinks.items():
        with problems.collect():
            index = sink.finish(notes, is_dive_still=still)
            if index is not None:
                images[name] = index
    with problems.collect():
        refuse_same_files(images)
        return images
    # `check` goes on: the pictures of one camera contradict nothing
    return dict([*images.items()][:1])


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
    channels = [channel for channel in found.counts if channel.encoding != "sample"]
    frames = {c.topic for c in found.counts if out.sensors and is_static(c)}
    out.unused = describe_unused(channels, chosen | frames)
    out.unread_dvls = unread_dvls(channels)
