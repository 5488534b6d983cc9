# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Summarise a log without a dive.toml: its topics, and which sensors they could be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from hullrecon.dive.check.contents import describe_losses
from hullrecon.dive.check.requirements import missing, needs
from hullrecon.dive.check.topics import COMMAND_WORDS, describe_unused, unread_dvls, words_of
from hullrecon.dive.init.depth_signal import DepthSignal, drop_still
from hullrecon.dive.logs.fixed_frames import MOST_FRAME_MESSAGES, is_static
from hullrecon.dive.logs.lost_values import UNFILLED
from hullrecon.dive.logs.messages.decode import ENCODINGS, Fields, decode, type_name
from hullrecon.dive.logs.messages.descriptions import CAMERA_INFO, COMPRESSED
from hullrecon.dive.logs.messages.samples import COMMON_TYPES, IMAGE_TYPES, TYPES
from hullrecon.dive.logs.readers.protocol import Channel, Log, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, printable
from hullrecon.dive.logs.samples import DepthSample, ImuSample
from hullrecon.dive.logs.streams.imu import LEAST_ATTITUDES, UNIT_QUATERNION
from hullrecon.findings.finding import Finding, sentences
from hullrecon.findings.logs import count_noun
from hullrecon.records.clock import NS, format_time

NAMED = {  # parts of topics' names, by the sensor that they suggest
    "dvl": ("dvl",),
    "imu": ("imu", "ahrs", "attitude"),
    "pressure": ("pressure", "depth", "bar30", "vfr_hud", "rel_alt"),
    "joints": ("joint",),
    "sonar": ("sonar", "oculus", "fls"),
    "position": ("usbl", "gps", "gnss"),
}
UPPER, LOWER = ("top", "upper", "left", "cam0"), ("bottom", "lower", "right", "cam1")
DIFFERENTIAL = ("diff", "gauge", "relative")  # parts of names of pressures that are not absolute
NO_DEPTH = COMMAND_WORDS | {"temp", "temperature", "target", "desired", "reference", "variance"}
IMU = "sensor_msgs/msg/Imu"
MOST_NOTES = 2  # of a reader in one line
MOST_DECODED = 256  # channels whose first message is looked at: each definition is compiled


@dataclass(kw_only=True)
class TopicNote:
    """The contents of one topic."""

    channel: Channel
    first: object = None  # its first message, decoded, or the sample; None: it does not decode
    later: object = None  # of an IMU, a message that follows
    depth: DepthSignal = field(default_factory=DepthSignal)  # of types that may hold one
    frames: list[Fields] = field(default_factory=list)  # messages of tf_static, a part each
    count: int = 0
    start_ns: int = 0
    end_ns: int = 0

    def sentence(self) -> str:
        """Describe the topic in one line: its messages, their rate and their type."""
        seconds = (self.end_ns - self.start_ns) / NS
        many = count_noun(self.count, "message")
        pace = (
            f" in {seconds:.1f} s, {(self.count - 1) / seconds:.1f} Hz"
            if self.count > 1 and seconds > 0
            else ""
        )
        return f"{self.channel.topic}: {many}{pace}, {self.channel.type}"


@dataclass(kw_only=True)
class LogSummary:
    """The contents of one log, or of several logs of one dive."""

    kind: str
    topics: list[TopicNote] = field(default_factory=list)
    lost: list[Finding] = field(default_factory=list)
    notes: list[Finding] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Describe the topics, the sensors among them, and what is missing for a run."""
        span = [t for t in self.topics if t.count]
        count = count_noun(sum(t.count for t in span), "message")
        head = f"{self.kind}: {count} on {count_noun(len(span), 'topic')}"
        if span:
            first, last = min(t.start_ns for t in span), max(t.end_ns for t in span)
            head += f", {(last - first) / NS:.1f} s from {format_time(first)}"
        guessed = guess_topics(self.topics)
        sensors = [
            f"{topic} can be {'joints' if name == 'joints' else 'the ' + name}"
            for name, topic in guessed.items()
        ]
        unused = describe_unused((t.channel for t in span), set(guessed.values()))
        found = [*unused, *self.lost, *self.notes, *missing(set(guessed))]
        return [head, *(t.sentence() for t in span), *sensors, *sentences(found)]

    def why_nothing(self) -> str:
        """Explain that no message could be read, with the reader's notes."""
        why = "; ".join(sentences([*self.notes, *self.lost][:MOST_NOTES]))
        return f"nothing could be read of the log{f': {why}' if why else ''}"

    def needs(self) -> list[Finding]:
        """List what the topics lack for a run."""
        channels = [topic.channel for topic in self.topics if topic.channel.encoding != "sample"]
        return needs(set(guess_topics(self.topics)), unread_dvls(channels))

    def document(self) -> dict[str, object]:
        """Build the summary that `--json` prints."""
        topics = [
            {
                "topic": t.channel.topic,
                "type": t.channel.type,
                "count": t.count,
                "start_ns": t.start_ns,
                "end_ns": t.end_ns,
            }
            for t in self.topics
        ]
        guessed = guess_topics(self.topics)
        absent = missing(set(guessed))
        return {
            "kind": self.kind,
            "topics": topics,
            "guessed": guessed,
            "lost": sentences(self.lost),
            "notes": sentences(self.notes),
            "missing": sentences(absent),
            "findings": [f.document() for f in (*self.lost, *self.notes, *absent, *self.needs())],
        }


def summarise_log(log: Log) -> LogSummary:
    """Read the log once: count messages by topic, and decode the first of each.

    Further messages are decoded where a sensor is guessed by them: of depths, of IMUs and of
    tf_static.
    """
    notes: dict[Channel, TopicNote] = {}
    for message in log.messages():
        note = notes.get(message.channel)
        if note is None:
            first = _decode_if_read(message) if len(notes) < MOST_DECODED else None
            note = notes[message.channel] = TopicNote(
                channel=message.channel,
                first=first,
                frames=[],
                count=0,
                start_ns=message.t_ns,
                end_ns=message.t_ns,
            )
        if (
            is_static(note.channel)
            and note.count < MOST_FRAME_MESSAGES
            and isinstance(message.data, bytes)
        ):
            note.frames += _decode(message.channel, message.data)
        note.count += 1
        if (
            note.count == LEAST_ATTITUDES
            and note.first is not None
            and type_name(note.channel) == IMU
        ):
            note.later = _decode_if_read(message)
        _note_depth(note, message)
        note.start_ns, note.end_ns = (
            min(note.start_ns, message.t_ns),
            max(note.end_ns, message.t_ns),
        )
    topics = sorted(notes.values(), key=lambda n: n.channel.topic)
    return LogSummary(
        kind=log.kind,
        topics=topics,
        lost=describe_losses([(printable(log.path.name), loss) for loss in log.losses()]),
        notes=list(log.notes),
    )


def summarise_logs(logs: Sequence[Log]) -> LogSummary:
    """Summarise the logs of one dive together.

    The messages of a channel that several logs hold are counted together. Notes name their log
    where there are several.
    """
    parts = [summarise_log(log) for log in logs]
    notes: dict[Channel, TopicNote] = {}
    for note in (note for part in parts for note in part.topics):
        kept = notes.setdefault(note.channel, note)
        if kept is not note:
            kept.count += note.count
            kept.frames += note.frames
            kept.depth.values += note.depth.values
            kept.start_ns, kept.end_ns = (
                min(kept.start_ns, note.start_ns),
                max(kept.end_ns, note.end_ns),
            )
    return LogSummary(
        kind=" and ".join(dict.fromkeys(part.kind for part in parts)),
        topics=sorted(notes.values(), key=lambda n: n.channel.topic),
        lost=[loss for part in parts for loss in part.lost],
        notes=[
            note if len(logs) == 1 else note.inside(printable(log.path.name))
            for log, part in zip(logs, parts, strict=True)
            for note in part.notes
        ],
    )


def guess_topics(topics: Sequence[TopicNote]) -> dict[str, str]:
    """Guess each sensor's topic by type, then by name.

    The name decides among several topics of one type. It alone decides for types that many kinds of
    sensors use (COMMON_TYPES). Topics whose name or messages show that they are not the sensor's
    (UNFIT) are passed over. Tables and files of instruments name their sensor. They are preferred
    to topics, but for attitude and depth by sensors inside the DVL.

    Returns
    -------
    topic by sensor, without the sensors for which none was found
    """
    found: dict[str, str] = {}
    for sensor, parts in NAMED.items():
        fitting = [
            t for t in topics if _fits(t, TYPES[sensor]) and not UNFIT.get(sensor, _never)(t)
        ]
        own = [t.channel.topic for t in fitting if type_name(t.channel) not in COMMON_TYPES]
        common = [t.channel.topic for t in fitting if type_name(t.channel) in COMMON_TYPES]
        named, others = _with_part(own, parts), _with_part(common, parts)
        if sensor == "pressure":
            signals = {t.channel.topic: t.depth for t in fitting}
            named, own, others = _drop_still_topics(signals, named, own, others)
        chosen = named or own or others
        if chosen:
            found[sensor] = chosen[0]
    found |= _guess_cameras([t.channel.topic for t in topics if _fits(t, IMAGE_TYPES)])
    samples = [t for t in topics if t.channel.encoding == "sample" and t.channel.topic in TYPES]
    return found | {
        t.channel.topic: t.channel.topic
        for t in samples
        if t.channel.topic not in found or not _is_of_dvl(t)
    }


def _has_no_attitude(topic: TopicNote) -> bool:
    """Tell whether an IMU's messages have rates and acceleration but no orientation.

    Some drivers of raw IMUs leave the message's default there. The first message and a later one
    are looked at, as a vehicle may have that very attitude once.
    """
    if type_name(topic.channel) != IMU or topic.first is None:
        return False
    looked_at = [message for message in (topic.first, topic.later) if message is not None]
    found = [
        s.quaternion
        for m in looked_at
        for s in TYPES["imu"][IMU](m, 0, "imu")
        if isinstance(s, ImuSample)
    ]
    unfilled = len(found) > 1 and all(
        np.array_equal(np.abs(quaternion), UNFILLED) for quaternion in found
    )
    return unfilled or not abs(np.linalg.norm(found[0]) - 1) < UNIT_QUATERNION


def _never(topic: TopicNote) -> bool:
    return False


def _is_of_dvl(topic: TopicNote) -> bool:
    """Tell whether a channel's attitude or depth is by sensors inside the DVL."""
    return isinstance(topic.first, ImuSample | DepthSample) and topic.first.of_dvl


def _is_no_depth(topic: TopicNote) -> bool:
    """Tell whether a topic is not the depth, by its name or by pressures that fit no unit."""
    name = topic.channel.topic.lower()
    if any(part in name for part in DIFFERENTIAL) or words_of(name) & NO_DEPTH:
        return True
    return topic.depth.is_pressure and topic.depth.unit is None


def _drop_still_topics(
    signals: Mapping[str, DepthSignal], *candidates: Sequence[str]
) -> tuple[list[str], ...]:
    """Drop from each list the topics that stay still while another topic shows a depth.

    Each list is sorted so that pressures in pascal come first: those of another unit need a key in
    dive.toml. Lists may become empty.

    Parameters
    ----------
    signals : readings by topic, of all candidates
    candidates : lists of topics that may be the depth
    """
    topics = list(dict.fromkeys(topic for listed in candidates for topic in listed))
    kept = {topics[row] for row in drop_still([signals[topic] for topic in topics])}
    return tuple(
        sorted(
            (topic for topic in listed if topic in kept),
            key=lambda topic: signals[topic].unit not in (None, "Pa"),
        )
        for listed in candidates
    )


def _note_depth(note: TopicNote, message: Message) -> None:
    """Add a message's readings to `note.depth`, if its type may be a pressure or a depth.

    Messages before the next one is due are skipped, so that readings are thinned out evenly over
    the log. They show later which topic moves as a depth does, and in which unit (`DepthSignal`).
    """
    translate = TYPES["pressure"].get(type_name(note.channel))
    if translate is None or note.first is None or not note.depth.is_due(message.t_ns):
        return
    if not isinstance(message.data, bytes):
        return
    with suppress(Exception):  # a message may not hold what its type says: it is then skipped
        fields = decode(message.channel, message.data)
        note.depth.take(message.t_ns, translate(fields, message.t_ns, "pressure"))


def _guess_cameras(topics: Sequence[str]) -> dict[str, str]:
    """Guess upper and lower camera among topics of images, by name.

    Compressed images are preferred to raw ones of the same camera. A single camera is taken as the
    upper one. Depth images are left out. Empty without images.
    """
    topics = [t for t in topics if t + COMPRESSED not in topics and "depth" not in t.lower()]
    lower = _with_part(topics, LOWER)
    upper = [t for t in _with_part(topics, UPPER) if t not in lower] or [
        t for t in topics if t not in lower[:1]
    ]
    if not upper:
        return {"camera_top": lower[0]} if lower else {}
    lower = lower or [t for t in topics if t != upper[0]]
    return {"camera_top": upper[0], **({"camera_bottom": lower[0]} if lower else {})}


def _with_part(topics: Sequence[str], parts: Sequence[str]) -> list[str]:
    """List the topics whose name holds one of the parts, in the order of the parts."""
    return [topic for part in parts for topic in topics if part in topic.lower()]


def _fits(note: TopicNote, types: Mapping[str, object]) -> bool:
    """Tell whether a topic's messages can be decoded and are of one of the types."""
    return note.channel.encoding in ENCODINGS and type_name(note.channel) in types


def _decode(channel: Channel, data: bytes) -> list[Fields]:
    """Decode a message. Empty where it cannot be."""
    try:
        return [decode(channel, data)]
    except DamagedError:
        return []


def _decode_if_read(message: Message) -> object:
    """Decode a message, if it is of a type that is read. A sample is returned as it is.

    None for other types, and where the message does not hold what its type says.
    """
    if not isinstance(message.data, bytes):
        return message.data
    kind = type_name(message.channel)
    reads = [
        (sensor, types[kind])
        for sensor, types in TYPES.items()
        if kind in types and types is not IMAGE_TYPES
    ]
    if kind in IMAGE_TYPES:
        return next(iter(_decode(message.channel, message.data)), None)
    try:
        fields: object = (
            decode(message.channel, message.data) if reads or kind == CAMERA_INFO else None
        )
        for sensor, translate in reads:
            translate(fields, 0, sensor)
    # fields of any names and types, where the definition that the log carries is damaged
    except Exception:
        return None
    return fields


# by sensor, the test for topics that cannot be its although their type fits
UNFIT = {"pressure": _is_no_depth, "imu": _has_no_attitude}
