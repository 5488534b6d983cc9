# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Say of each topic that no sensor was given why a run does not use it: `init` and `check` print
it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Set

from hullrecon.dive.logs.messages.decode import ENCODINGS, type_name
from hullrecon.dive.logs.messages.samples import COMMON_TYPES, TYPES
from hullrecon.dive.logs.readers.protocol import Channel

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
ECHOES = "echoes of a sonar that turns beam by beam, which never saw a whole fan at one time; those of imaging sonars are read"
CLOUDS = "points of a 3-D sonar or another scanner, which no step takes; DVL and IMU, or cameras, measure the hull"
DEPTHS = "a depth is read from sensor_msgs/FluidPressure, ds_sensor_msgs/DepthPressure or std_msgs/Float64: log one of these"
RANGES = "ranges are taken along the beams of a DVL alone, a single beam has no mount of its own"
POSITIONS = "positions from outside (GPS, USBL) of other types than are read"
COMMANDS = "by the name a command, no measurement"
NAMED_TYPES = {
    **dict.fromkeys(RANGE_TYPES, RANGES),
    **dict.fromkeys(ECHO_TYPES, ECHOES),
    **dict.fromkeys(CLOUD_TYPES, CLOUDS),
}


def describe_unused(channels: Iterable[Channel], chosen: Set[str]) -> list[str]:
    """Return a sentence for each reason why topics that are not among those chosen are not used,
    with these topics.
    """
    by_reason: dict[str, list[str]] = {
        reason: [] for reason in (RANGES, ECHOES, CLOUDS, DEPTHS, POSITIONS, COMMANDS)
    }
    readable, other = [], []
    for channel in sorted({c for c in channels if c.topic not in chosen}, key=lambda c: c.topic):
        reason, sensors = _reason(channel), readable_as(channel)
        if reason:
            by_reason[reason].append(f"{channel.topic} ({channel.type})")
        elif sensors:
            readable.append(f"{channel.topic} (could be {' or '.join(sensors)})")
        else:
            other.append(channel.topic)
    known = f"not chosen, though of a type that is read: {', '.join(readable)}; name it in [topics] to use it"
    return [
        *([known] if readable else []),
        *(
            f"a run would not use {', '.join(topics)}: {reason}"
            for reason, topics in by_reason.items()
            if topics
        ),
        *(
            [f"a run would not use {', '.join(other)}: of other types than it reads"]
            if other
            else []
        ),
    ]


def unread_dvls(channels: Iterable[Channel]) -> list[str]:
    """Return the topics, with their types, that are a DVL's by name or maker and of a type that is
    not read.
    """
    found = sorted(
        {c for c in channels if not readable_as(c) and not _reason(c)}, key=lambda c: c.topic
    )
    return [
        f"{c.topic} ({c.type})"
        for c in found
        if any(word in f"{c.topic} {c.type}".lower() for word in DVL_WORDS)
    ]


def readable_as(channel: Channel) -> list[str]:
    """Return the sensors that a channel's messages could be read as; position alone where its name
    says so.
    """
    is_decoded = channel.encoding in ENCODINGS
    sensors = [
        sensor for sensor, types in TYPES.items() if is_decoded and type_name(channel) in types
    ]
    return ["position"] if "position" in sensors and _words(channel) & POSITION_WORDS else sensors


def _words(channel: Channel) -> set[str]:
    return set(re.split(r"[^a-z]+", channel.topic.lower()))


def _reason(channel: Channel) -> str:
    """Return why a topic is of no use by its type, or by its name where its type is that of no one
    sensor; "" otherwise.
    """
    kind, words, sensors = type_name(channel), _words(channel), readable_as(channel)
    if kind in NAMED_TYPES:
        return NAMED_TYPES[kind]
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
