# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read every log once and sort the samples by sensor."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from hullrecon.dive.logs.fixed_frames import frame_of
from hullrecon.dive.logs.messages.decode import ENCODINGS, decode, describe, type_name
from hullrecon.dive.logs.messages.samples import TYPES, WITHOUT_HEADER, stamp_ns
from hullrecon.dive.logs.readers.protocol import Channel, Log, Loss, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, printable
from hullrecon.dive.logs.samples import ImageSample, JointSample, Sample, SonarSample, is_of_dvl
from hullrecon.dive.logs.time_window import TimeWindow
from hullrecon.dive.logs.timeline import GAP_S
from hullrecon.dive.problems import Problems
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import Camera
from hullrecon.records.clock import NS, format_time

# the sample, when it was logged, ns, and the number of its log
TakeImage = Callable[[ImageSample, int, int], None]
KeepPing = Callable[[SonarSample], SonarSample]
Watch = Callable[[Iterable[Message]], Iterable[Message]]
LIMIT_NS = 1 << 62  # the year 2116; differences of smaller stamps do not overflow an int64
MOST_REASONS = 5  # for each topic, why its messages could not be used, that are listed
MOST_DEFINITIONS = 16  # of a topic's type: each is compiled, and a damaged log may have many
SENSORS = tuple(TYPES)
# two sensors on one topic: each sends a tenth of its messages at least, and they take turns
LEAST_SHARE, LEAST_TURNS = 0.1, 10
# Sensors whose messages may not all be lost: the dive would go on without its images, or as if its
# tray stood still
NOT_TO_BE_MISSED = frozenset({"joints", *(camera.key for camera in Camera)})
MOST_FRAMES = 16  # of a topic: damaged messages may each have a name of their own


@dataclass
class FrameNames:
    """The frames that the messages of one topic name."""

    counts: Counter[str] = field(default_factory=Counter)
    turns: int = 0  # messages of another frame than the message before them
    last: str = ""  # frame of the message before

    def add(self, frame: str) -> None:
        """Count a message's frame."""
        self.turns += bool(self.counts) and frame != self.last
        self.last = frame
        if frame in self.counts or len(self.counts) < MOST_FRAMES:
            self.counts[frame] += 1

    def refuse_two(self, topic: str) -> None:
        """Raise InputError where messages of two frames take turns: two sensors share the topic."""
        both = self.counts.most_common(2)
        least = LEAST_SHARE * self.counts.total()
        if len(both) < 2 or both[1][1] < least or self.turns < LEAST_TURNS:
            return
        shown = " and ".join(f"{printable(name) or 'none'} ({count})" for name, count in both)
        raise InputError(
            f"its messages are of two frames in turn, {shown}: two sensors share the topic",
            where=topic,
            remedy="give a log in which each has a topic of its own",
        )


@dataclass(kw_only=True)
class LogContents:
    """What reading all logs gave: samples by sensor, and what was lost or left out."""

    # By sensor ("dvl", ...), row by row in the order of the logs: the samples (images go to their
    # sinks instead), when each was logged, ns, and the number of its log.
    samples: dict[str, list[Sample]] = field(default_factory=lambda: {name: [] for name in SENSORS})
    logged_ns: dict[str, list[int]] = field(default_factory=lambda: {name: [] for name in SENSORS})
    log: dict[str, list[int]] = field(default_factory=lambda: {name: [] for name in SENSORS})
    counts: Counter[Channel] = field(default_factory=Counter)  # messages of each channel
    # messages that could not be used, by topic and reason
    undecoded: Counter[tuple[str, str]] = field(default_factory=Counter)
    unstamped: Counter[str] = field(default_factory=Counter)  # messages without a stamp, by topic
    # samples of tables and instruments' files that were ignored, as dive.toml names a topic for
    # the same sensor
    ignored: Counter[Channel] = field(default_factory=Counter)
    losses: list[tuple[str, Loss]] = field(default_factory=list)  # with the name of the file
    inside: int = 0  # samples in the time window
    outside: int = 0  # and out of it
    # by joint, the last angle before the time window, when that was logged, and its log
    joints_before: dict[str, tuple[JointSample, int, int]] = field(default_factory=dict)
    # topics of which a message could be used, and the sensors that took it
    used: set[tuple[str, str]] = field(default_factory=set)
    # the channels by which a topic was decoded
    definitions: dict[str, set[Channel]] = field(default_factory=dict)
    frames: dict[str, FrameNames] = field(default_factory=dict)  # by topic
    notes: list[Finding] = field(default_factory=list)
    unread: int = 0  # logs that could not be read to their end


def read_streams(
    logs: Sequence[Log],
    topics: Mapping[str, Sequence[str]],
    take_image: TakeImage,
    watch: Watch = iter,
    problems: Problems | None = None,
    window: TimeWindow | None = None,
    keep_ping: KeepPing = lambda ping: ping,
    added_ns: Mapping[str, int] = MappingProxyType({}),
) -> LogContents:
    """Read the logs once and collect the samples that lie in the time window.

    Messages that cannot be used are counted, with the reason, and become findings. A log that
    cannot be read to its end gives what was read before.

    Parameters
    ----------
    logs : in the order in which they are read
    topics : by topic, the sensors that it is read as (a pose has attitude and depth). A sensor
        named there comes from that topic, not from a further log that gives samples (tables, an
        instrument's file).
    take_image : called with each image
    watch : sees every message pass, to report progress
    problems : collects the errors that would be raised; None: the first one is raised
    window : samples outside are counted and dropped; None: all are used
    keep_ping : puts the image of a sonar's ping away, and returns what is kept in memory
    added_ns : by sensor, what is added to the stamps (positive where they are early)

    Raises
    ------
    InputError
        A topic of a type that is not read or that two sensors share, or a log of which nothing
        can be read.
    """
    out, problems = LogContents(), problems or Problems()
    refused: set[Channel] = set()
    for number, log in enumerate(logs):
        out.unread += 1
        with problems.collect():
            for message in watch(log.messages()):
                out.counts[message.channel] += 1
                if message.channel in refused:
                    continue
                problems_before = len(problems.found)
                with problems.collect():
                    _sort_by_sensor(
                        message, number, topics, take_image, out, window, keep_ping, added_ns
                    )
                # one complaint for each channel, not for each of its messages
                if len(problems.found) > problems_before:
                    refused.add(message.channel)
            out.unread -= 1
        name = printable(log.path.name)
        out.losses += [(name, loss) for loss in log.losses()]
        out.notes += [note.inside(name) for note in log.notes]
    for topic, frames in sorted(out.frames.items()):
        with problems.collect():
            frames.refuse_two(topic)
    _note_unusable(out, topics, problems)
    if window is not None:
        _carry_joints_into_window(out, window)
        values = {"window": window.describe(), "count": out.outside}
        out.notes.append(Finding("outside-window", values, "dive"))
    out.notes += [
        Finding("readings-ignored", {"count": n, "sensor": c.topic}, c.type)
        for c, n in out.ignored.items()
    ]
    return out


def _note_unusable(
    out: LogContents, topics: Mapping[str, Sequence[str]], problems: Problems
) -> None:
    """Note messages that could not be decoded, and those without a stamp, by topic.

    A topic of images or joints of which no message can be used is a problem. topics: as of
    `read_streams`.
    """
    used = {topic for topic, _ in out.used}
    for topic in sorted({topic for topic, _ in out.undecoded}):
        reasons = Counter({why: n for (name, why), n in out.undecoded.items() if name == topic})
        lost = [sensor for sensor in topics.get(topic, ()) if sensor in NOT_TO_BE_MISSED]
        if topic in used or not lost:
            out.notes += [
                Finding("messages-unusable", {"count": n, "why": why}, topic)
                for why, n in sorted(reasons.items())
            ]
            continue
        with problems.collect():
            why = reasons.most_common(1)[0][0]
            raise InputError(
                f"none of its {reasons.total()} messages can be used: {why}",
                where=topic,
                remedy=f"record them in a form that docs/dive_package.md names, or leave "
                f"{' and '.join(f'topics.{sensor}' for sensor in lost)} away",
            )
    out.notes += [
        Finding("messages-unstamped", {"count": n}, topic)
        for topic, n in sorted(out.unstamped.items())
    ]


def _sort_by_sensor(
    message: Message,
    log: int,
    topics: Mapping[str, Sequence[str]],
    take_image: TakeImage,
    out: LogContents,
    window: TimeWindow | None,
    keep_ping: KeepPing,
    added_ns: Mapping[str, int],
) -> None:
    """Add the samples of a message to those of its sensors, and count those outside the window.

    Arguments as of `read_streams`, for one message of the log with number `log`. Images go to
    `take_image`, all other samples to `out`.
    """
    for sensor, read in _samples_of(message, topics, out):
        # attitude and depth by sensors inside the DVL are stamped by the DVL's clock
        sensor_added_ns = added_ns.get("dvl" if is_of_dvl(read) else sensor, 0)
        sample = replace(read, t_ns=read.t_ns + sensor_added_ns) if sensor_added_ns else read
        logged_ns = message.t_ns + sensor_added_ns
        if window is not None and not window.holds(window.time_of(sample.t_ns, logged_ns)):
            out.outside += 1
            if isinstance(sample, JointSample) and np.isfinite(sample.angle):
                _note_joint_before(sample, logged_ns, log, out, window)
            continue
        out.inside += 1
        if isinstance(sample, ImageSample):
            take_image(sample, logged_ns, log)
        else:
            out.samples[sensor].append(
                keep_ping(sample) if isinstance(sample, SonarSample) else sample
            )
            out.logged_ns[sensor].append(logged_ns)
            out.log[sensor].append(log)


def _note_joint_before(
    sample: JointSample, logged_ns: int, log: int, out: LogContents, window: TimeWindow
) -> None:
    """Keep a joint's reading where it is the latest one before the window so far.

    It gives the servo's angle when the window begins (`_carry_joints_into_window`).
    """
    known = out.joints_before.get(sample.name)
    if (
        window.first_ns is not None
        and window.time_of(sample.t_ns, logged_ns) < window.first_ns
        and (known is None or sample.t_ns >= known[0].t_ns)
    ):
        out.joints_before[sample.name] = sample, logged_ns, log


def _carry_joints_into_window(out: LogContents, window: TimeWindow) -> None:
    """Repeat the last reading of each joint before the window at the window's start.

    A joint that is logged once, or only when it turns, has stood still since. It is not repeated
    where a reading of it lies at that very time. Where no sensor measured in the window, nothing is
    added, so that the window stays empty.
    """
    if not out.inside:
        return
    first: dict[str, int] = {}
    for sample in out.samples["joints"]:
        if isinstance(sample, JointSample):
            first[sample.name] = min(sample.t_ns, first.get(sample.name, sample.t_ns))
    for name, (sample, logged_ns, log) in out.joints_before.items():
        if window.first_ns is None:
            continue
        later_ns = window.first_ns - window.time_of(sample.t_ns, logged_ns)
        if first.get(name) == sample.t_ns + later_ns:
            continue
        out.outside -= 1  # the reading was counted as outside of the window
        out.samples["joints"].insert(0, replace(sample, t_ns=sample.t_ns + later_ns))
        out.logged_ns["joints"].insert(0, logged_ns + later_ns)
        out.log["joints"].insert(0, log)
        if later_ns > GAP_S * NS:
            values = {"time": format_time(sample.t_ns)}
            out.notes.append(Finding("joint-before-window", values, f"joint {name}"))


def _samples_of(
    message: Message, topics: Mapping[str, Sequence[str]], out: LogContents
) -> Iterator[tuple[str, Sample]]:
    """Translate a message into samples, and yield each with its sensor.

    Nothing for messages that cannot be used, which are counted in `out` with the reason, and for
    samples of a sensor for which dive.toml names a topic.
    """
    channel = message.channel
    is_sample = not isinstance(message.data, bytes)
    if is_sample and any(channel.topic in sensors for sensors in topics.values()):
        out.ignored[channel] += 1
        return
    for sensor in (channel.topic,) if is_sample else topics.get(channel.topic, ()):
        try:
            found = (
                _translate(message, message.data, sensor, out)
                if isinstance(message.data, bytes)
                else [message.data]
            )
            if any(
                abs(t_ns) >= LIMIT_NS for t_ns in (message.t_ns, *(sample.t_ns for sample in found))
            ):
                raise DamagedError("their stamps lie beyond the year 2116")
        except DamagedError as error:
            out.undecoded[channel.topic, _limit_reasons(channel.topic, str(error), out)] += 1
            continue
        out.used.add((channel.topic, sensor))
        yield from ((sensor, sample) for sample in found)


def _translate(message: Message, data: bytes, sensor: str, out: LogContents) -> Sequence[Sample]:
    """Decode a serialised message into samples of a sensor.

    Raises InputError for a topic of a type or encoding that is not read, as dive.toml then names
    the wrong topic. Raises DamagedError where the message cannot be decoded, or is of another type
    than messages of the topic that were read before.
    """
    channel = message.channel
    if channel.encoding not in ENCODINGS and (channel.topic, sensor) not in out.used:
        raise InputError(
            f"topic {channel.topic} is encoded as {printable(channel.encoding) or 'unknown'}: "
            "messages of ROS are read (cdr, ros1)",
            where=f"topics.{sensor}",
            remedy="record it with rosbag2, or write its values as a table (docs/dive_package.md)",
        )
    translate = TYPES[sensor].get(type_name(channel))
    if translate is None and (channel.topic, sensor) in out.used:
        raise DamagedError(f"they are {channel.type}, unlike those before")
    if translate is None:
        raise InputError(
            f"topic {channel.topic} holds {channel.type}, which is not read as {sensor}",
            where=f"topics.{sensor}",
            remedy=f"name a topic of {' or '.join(sorted(TYPES[sensor]))}",
        )
    known = out.definitions.setdefault(channel.topic, set())
    if channel not in known and len(known) >= MOST_DEFINITIONS:
        raise DamagedError("the definition of their type changes over and over")
    known.add(channel)
    fields = decode(channel, data)
    try:
        with np.errstate(all="ignore"):
            stamp = 0 if type_name(channel) in WITHOUT_HEADER else stamp_ns(fields.header)
            found = translate(fields, stamp or message.t_ns, sensor)
    except DamagedError:
        raise
    # fields of any names and types, where the definition that the log carries is damaged
    except Exception as error:
        raise DamagedError(
            f"a {channel.type} is not what its name says: {describe(error)}"
        ) from None
    if stamp == 0:
        out.unstamped[channel.topic] += 1
    if sensor != "joints":  # several servos may share a topic, each with its own frame
        out.frames.setdefault(channel.topic, FrameNames()).add(frame_of(fields) or "")
    return found


def _limit_reasons(topic: str, reason: str, out: LogContents) -> str:
    """Replace a reason by a general one where the topic has MOST_REASONS others already.

    Each damaged message may have its own.
    """
    if (topic, reason) in out.undecoded or sum(t == topic for t, _ in out.undecoded) < MOST_REASONS:
        return reason
    return "for other reasons"
