# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Explain for each unused topic why a run does not use it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Set

from hullrecon.dive.logs.messages.decode import ENCODINGS, type_name
from hullrecon.dive.logs.messages.samples import COMMON_TYPES, TYPES
from hullrecon.dive.logs.readers.protocol import Channel
from hullrecon.findings.finding import Finding

RANGE_TYPES = frozenset({"sensor_msgs/msg/Range"})
UNREAD_POSITION_TYPES = frozenset({"gps_common/msg/GPSFix", "gps_msgs/msg/GPSFix"})
# in the name of a topic that gives positions
POSITION_WORDS = frozenset({"usbl", "sbl", "lbl", "gps", "gnss", "fix"})
DVL_WORDS = (
    "dvl",
    "doppler",
    "bottom_track",
    "teledyne",
    "nortek",
    "linkquest",
    "water_linked",
    "waterlinked",
)
COMMAND_WORDS = frozenset({"cmd", "command", "setpoint", "goal"})
ECHO_TYPES = frozenset(  # of mechanically scanned sonars: a beam a message
    {
        "ping360_sonar_msgs/msg/SonarEcho",
        "ping360_sonar/msg/SonarEcho",
        "tritech_micron/msg/ScanLine",
        "sensor_msgs/msg/LaserScan",
    }
)
CLOUD_TYPES = frozenset({"sensor_msgs/msg/PointCloud2", "sensor_msgs/msg/PointCloud"})
BAR30 = "bar30"  # a pressure sensor; some of its drivers have types of their own
# codes of the findings
RANGES, ECHOES, CLOUDS = "topics-of-ranges", "topics-of-echoes", "topics-of-clouds"
DEPTHS, POSITIONS = "topics-of-depths", "topics-of-positions"
COMMANDS, OTHERS = "topics-of-commands", "topics-of-other-types"
BY_TYPE = {
    **dict.fromkeys(RANGE_TYPES, RANGES),
    **dict.fromkeys(ECHO_TYPES, ECHOES),
    **dict.fromkeys(CLOUD_TYPES, CLOUDS),
}


def describe_unused(channels: Iterable[Channel], chosen: Set[str]) -> list[Finding]:
    """List the topics that a run would not use, one finding for each reason.

    Empty where all are used. channels: all that the logs hold. chosen: the topics that are used.
    """
    by_code: dict[str, list[str]] = {
        code: [] for code in (RANGES, ECHOES, CLOUDS, DEPTHS, POSITIONS, COMMANDS, OTHERS)
    }
    readable: dict[str, list[str]] = {}
    for channel in sorted({c for c in channels if c.topic not in chosen}, key=lambda c: c.topic):
        code = _unread_code(channel)
        if code:
            by_code[code].append(f"{channel.topic} ({channel.type})")
        elif sensors := readable_as(channel):
            readable[channel.topic] = sensors
        else:
            by_code[OTHERS].append(channel.topic)
    out = [Finding("topics-not-chosen", {"topics": readable})] if readable else []
    return out + [
        Finding(code, {"topics": ", ".join(topics)}) for code, topics in by_code.items() if topics
    ]


def unread_dvls(channels: Iterable[Channel]) -> list[str]:
    """List the topics, with their types, of DVLs (by name or maker) whose type is not read.

    They are named where a run lacks a DVL.
    """
    found = sorted(
        {c for c in channels if not readable_as(c) and not _unread_code(c)}, key=lambda c: c.topic
    )
    return [
        f"{c.topic} ({c.type})"
        for c in found
        if any(word in f"{c.topic} {c.type}".lower() for word in DVL_WORDS)
    ]


def readable_as(channel: Channel) -> list[str]:
    """List the sensors that a channel could be read as, by its type.

    Only "position" is listed where the channel's name says so.
    """
    is_decoded = channel.encoding in ENCODINGS
    sensors = [
        sensor for sensor, types in TYPES.items() if is_decoded and type_name(channel) in types
    ]
    return (
        ["position"]
        if "position" in sensors and words_of(channel.topic) & POSITION_WORDS
        else sensors
    )


def words_of(topic: str) -> set[str]:
    """Split a topic's name into words."""
    return set(re.split(r"[^a-z]+", topic.lower()))


def _unread_code(channel: Channel) -> str:
    """Classify a topic that a run cannot use, by its type, or by its name where the type is common.

    A type that only one kind of sensor sends says more than a name. Returns the code of the
    finding, "" for a topic that may be of use.
    """
    kind, words, sensors = type_name(channel), words_of(channel.topic), readable_as(channel)
    if kind in BY_TYPE:
        return BY_TYPE[kind]
    if (
        BAR30 in f"{channel.topic} {kind}".lower()
        and not kind.startswith("sensor_msgs/")
        and not sensors
    ):
        return DEPTHS
    has_own_type = bool(sensors) and kind not in COMMON_TYPES
    if kind in UNREAD_POSITION_TYPES or (
        words & POSITION_WORDS and not has_own_type and sensors != ["position"]
    ):
        return POSITIONS
    return COMMANDS if words & COMMAND_WORDS and not has_own_type else ""
