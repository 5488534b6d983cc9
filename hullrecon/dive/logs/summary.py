# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Summarise a log without a dive.toml: its topics, and which of them could be which sensor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field

import numpy as np

from hullrecon.dive.check import messages
from hullrecon.dive.logs.fixed_frames import MOST_FRAME_MESSAGES, is_static
from hullrecon.dive.logs.messages.decode import ENCODINGS, Fields, decode, type_name
from hullrecon.dive.logs.messages.descriptions import CAMERA_INFO, COMPRESSED
from hullrecon.dive.logs.messages.samples import COMMON_TYPES, IMAGE_TYPES, TYPES
from hullrecon.dive.logs.readers.protocol import Channel, Log, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, printable
from hullrecon.dive.logs.samples import DepthSample, ImuSample
from hullrecon.dive.logs.streams import LEAST_ATTITUDES, UNFILLED
from hullrecon.dive.logs.unused_topics import describe_unused, unread_dvls
from hullrecon.geometry.frames import Camera
from hullrecon.records.clock import NS, format_time

NAMED = {
    "dvl": ("dvl",),
    "imu": ("imu", "ahrs", "attitude"),
    "pressure": ("pressure", "depth", "bar30", "vfr_hud"),
    "joints": ("joint",),
    "sonar": ("sonar", "oculus", "fls"),
    "position": ("usbl", "gps", "gnss"),
}
UPPER, LOWER = ("top", "upper", "left", "cam0"), ("bottom", "lower", "right", "cam1")
# the lowest air pressure at any sea is 87 kPa
DIFFERENTIAL, LOWEST_ABSOLUTE_PA = ("diff", "gauge", "relative"), 80e3
WITHOUT_CAMERAS = (
    "take [camera.top] and [camera.bottom] out of dive.toml (a lone camera is the top one)"
)
A_RUN_NEEDS = "a run needs a DVL with an IMU, or two cameras"
IMU = "sensor_msgs/msg/Imu"
MOST_REMARKS = 2  # sentences of a reader in one line
UNIT = 0.05  # how far the length of an attitude's quaternion may be off 1
MOST_DECODED = 256  # channels whose first message is looked at: each definition is compiled


@dataclass(kw_only=True)
class TopicNote:
    """One topic. first: its first message, decoded, or the sample; None where it does not decode.
    later: of an IMU, one that follows. frames: the messages of tf_static, of which there may be
    many with a part each.
    """

    channel: Channel
    first: object = None
    later: object = None
    frames: list[Fields] = field(default_factory=list)
    count: int = 0
    start_ns: int = 0
    end_ns: int = 0

    def sentence(self) -> str:
        seconds = (self.end_ns - self.start_ns) / NS
        many = messages.count_noun(self.count, "message")
        pace = (
            f" in {seconds:.1f} s, {(self.count - 1) / seconds:.1f} Hz"
            if self.count > 1 and seconds > 0
            else ""
        )
        return f"{self.channel.topic}: {many}{pace}, {self.channel.type}"


@dataclass(kw_only=True)
class LogSummary:
    """What one log holds."""

    kind: str
    topics: list[TopicNote] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Return sentences: the topics, the sensors among them, what is missing for a run."""
        span = [t for t in self.topics if t.count]
        count = messages.count_noun(sum(t.count for t in span), "message")
        head = f"{self.kind}: {count} on {messages.count_noun(len(span), 'topic')}"
        if span:
            first, last = min(t.start_ns for t in span), max(t.end_ns for t in span)
            head += f", {(last - first) / NS:.1f} s from {format_time(first)}"
        guessed = guess_topics(self.topics)
        sensors = [
            f"{topic} can be {'joints' if name == 'joints' else 'the ' + name}"
            for name, topic in guessed.items()
        ]
        unused = describe_unused((t.channel for t in span), set(guessed.values()))
        lines = [head, *(t.sentence() for t in span), *sensors, *unused]
        return [*lines, *self.lost, *self.remarks, *missing(set(guessed))]

    def why_nothing(self) -> str:
        """Return a sentence for a log that holds no message at all, with what its reader had to
        say.
        """
        sentences = "; ".join([*self.remarks, *self.lost][:MOST_REMARKS])
        return f"nothing could be read of the log{f': {sentences}' if sentences else ''}"

    def needs(self) -> list[str]:
        """Return what the topics lack for a run; [] for nothing."""
        channels = [topic.channel for topic in self.topics if topic.channel.encoding != "sample"]
        return needs(set(guess_topics(self.topics)), unread_dvls(channels))

    def document(self) -> dict[str, object]:
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
        return {
            "kind": self.kind,
            "topics": topics,
            "guessed": guessed,
            "lost": self.lost,
            "remarks": self.remarks,
            "missing": missing(set(guessed)),
        }


def summarise_log(log: Log) -> LogSummary:
    """Read the log once, decoding the first message of each topic alone."""
    notes: dict[Channel, TopicNote] = {}
    for message in log.messages():
        note = notes.get(message.channel)
        if note is None:
            first = _first(message) if len(notes) < MOST_DECODED else None
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
            note.later = _first(message)
        note.start_ns, note.end_ns = (
            min(note.start_ns, message.t_ns),
            max(note.end_ns, message.t_ns),
        )
    topics = sorted(notes.values(), key=lambda n: n.channel.topic)
    return LogSummary(
        kind=log.kind,
        topics=topics,
        lost=messages.describe_losses([(printable(log.path.name), loss) for loss in log.losses()]),
        remarks=list(log.remarks),
    )


def summarise_logs(logs: Sequence[Log]) -> LogSummary:
    """Return what several logs of one dive hold together."""
    parts = [summarise_log(log) for log in logs]
    notes: dict[Channel, TopicNote] = {}
    for note in (note for part in parts for note in part.topics):
        kept = notes.setdefault(note.channel, note)
        if kept is not note:
            kept.count += note.count
            kept.frames += note.frames
            kept.start_ns, kept.end_ns = (
                min(kept.start_ns, note.start_ns),
                max(kept.end_ns, note.end_ns),
            )
    return LogSummary(
        kind=" and ".join(dict.fromkeys(part.kind for part in parts)),
        topics=sorted(notes.values(), key=lambda n: n.channel.topic),
        lost=[line for part in parts for line in part.lost],
        remarks=[
            line if len(logs) == 1 else f"{printable(log.path.name)}: {line}"
            for log, part in zip(logs, parts, strict=True)
            for line in part.remarks
        ],
    )


def guess_topics(topics: Sequence[TopicNote]) -> dict[str, str]:
    """Return topics by sensor: those whose type fits, by name where several do; of types that many
    things have, by both.
    """
    found: dict[str, str] = {}
    for sensor, parts in NAMED.items():
        fitting = [
            t for t in topics if _fits(t, TYPES[sensor]) and not UNFIT.get(sensor, _never)(t)
        ]
        own = [t.channel.topic for t in fitting if type_name(t.channel) not in COMMON_TYPES]
        common = [t.channel.topic for t in fitting if type_name(t.channel) in COMMON_TYPES]
        chosen = _with_part(own, parts) or own or _with_part(common, parts)
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
    """Tell whether an IMU's messages have rates and acceleration alone, as raw ones do; some leave
    the default of the type where the orientation belongs, all along.
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
    return unfilled or not abs(np.linalg.norm(found[0]) - 1) < UNIT


def _never(topic: TopicNote) -> bool:
    return False


def _is_of_dvl(topic: TopicNote) -> bool:
    """Tell whether attitude or depth is that of a DVL's own sensors, which yield to others."""
    return isinstance(topic.first, ImuSample | DepthSample) and topic.first.of_dvl


def _is_differential(topic: TopicNote) -> bool:
    """Tell whether a pressure is one over another, by its name or by a value that no absolute one
    has under the air.
    """
    pascal = getattr(topic.first, "fluid_pressure", LOWEST_ABSOLUTE_PA)
    return (
        any(part in topic.channel.topic.lower() for part in DIFFERENTIAL)
        or not pascal >= LOWEST_ABSOLUTE_PA
    )


def _guess_cameras(topics: Sequence[str]) -> dict[str, str]:
    """Guess upper and lower camera by name; one alone is the upper one. Of one camera's topics the
    compressed one.
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
    return [topic for part in parts for topic in topics if part in topic.lower()]


def missing(sensors: set[str], hull: bool | None = None) -> list[str]:
    """Return what the absence of sensors means for a run. hull: whether there is a CAD model; None:
    not known yet.
    """
    stereo = {"camera_top", "camera_bottom"} <= sensors
    consequences = {
        "dvl": "motion comes from stereo images"
        if stereo
        else "and no stereo images either: no motion, no run is possible",
        "imu": _without_imu("dvl" in sensors, stereo),
        "pressure": "depth comes from dead reckoning and drifts",
        "joints": "the tray is taken as fixed at 0 degrees",
        "camera_top": "there will be no images, landmarks or optical mosaic",
        "camera_bottom": f"one camera: {'scale and depth come from the DVL' if 'dvl' in sensors else 'no scale without a DVL'}",
        "sonar": "there will be no sonar mosaic",
    }
    if "camera_top" not in sensors:
        del consequences["camera_bottom"]
    out = [f"no {name}: {what}" for name, what in consequences.items() if name not in sensors]
    if hull is False:
        out.append(
            "no hull: without a CAD model the run maps onto its own surface, in the frame global"
        )
    return out


def needs(sensors: Set[str], unread: Sequence[str] = ()) -> list[str]:
    """Return what is missing for the vehicle's motion (from DVL and IMU, else from stereo images);
    [] where nothing is.

    unread: topics that are a DVL's and of types that are not read.
    """
    if "dvl" in sensors:
        return (
            [] if "imu" in sensors else ["missing: an IMU with attitude, for the DVL's velocities"]
        )
    lacking = {camera.key for camera in Camera} - sensors
    if not lacking:
        return []
    shown = ", ".join(unread[:MOST_REMARKS]) + (", ..." if len(unread) > MOST_REMARKS else "")
    known = (
        f"; {shown} is a DVL's but of a type that is not read: log one of those in docs/dive_package.md"
        if unread
        else ""
    )
    if len(lacking) == 1:
        return [
            f"missing: {lacking.pop()} (a second camera), or a DVL{'' if 'imu' in sensors else ' with an IMU'}{known}"
        ]
    return [f"missing: a DVL{'' if 'imu' in sensors else ' with an IMU'}, or two cameras{known}"]


def _without_imu(dvl: bool, stereo: bool) -> str:
    """Say it as `navigate` does: velocities need a heading; stereo images alone do not."""
    if dvl:
        advice = (
            "; without the DVL it could take motion and attitude from stereo images"
            if stereo
            else ""
        )
        return f"the DVL's velocities have no heading: no run is possible{advice}"
    return (
        "attitude comes from stereo images and drifts"
        if stereo
        else "there is no attitude: no run is possible"
    )


def _fits(note: TopicNote, types: Mapping[str, object]) -> bool:
    return note.channel.encoding in ENCODINGS and type_name(note.channel) in types


def _decode(channel: Channel, data: bytes) -> list[Fields]:
    try:
        return [decode(channel, data)]
    except DamagedError:
        return []


def _first(message: Message) -> object:
    """Return the message decoded, where it is of a type that is read and holds what its type says."""
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


# what no sensor can be, whatever its type
UNFIT = {"pressure": _is_differential, "imu": _has_no_attitude}
