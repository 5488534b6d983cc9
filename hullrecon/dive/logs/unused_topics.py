# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Say of each topic that no sensor was given why a run does not use it: `init` and `check` print it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Set

from hullrecon.dive.logs.messages.decode import ENCODINGS, type_name
from hullrecon.dive.logs.messages.samples import COMMON_TYPES, TYPES
from hullrecon.dive.logs.readers.protocol import Channel

RANGE_TYPES = frozenset({"sensor_msgs/msg/Range"})
UNREAD_POSITION_TYPES = frozenset({"gps_common/msg/GPSFix", "gps_msgs/msg/GPSFix"})
POSITION_WORDS = frozenset({"usbl", "sbl", "lbl", "gps", "gnss", "fix"})  # in the name of a topic that gives positions
COMMAND_WORDS = frozenset({"cmd", "command", "setpoint", "goal"})
RANGES = "ranges are taken along the beams of a DVL alone, a single beam has no mount of its own"
POSITIONS = "positions from outside (GPS, USBL) of other types than are read"
COMMANDS = "by the name a command, no measurement"


def describe_unused(channels: Iterable[Channel], chosen: Set[str]) -> list[str]:
    """Return a sentence for each reason why topics that are not among those chosen are not used, with these topics."""
    by_reason: dict[str, list[str]] = {reason: [] for reason in (RANGES, POSITIONS, COMMANDS)}
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
        *(f"a run would not use {', '.join(topics)}: {reason}" for reason, topics in by_reason.items() if topics),
        *([f"a run would not use {', '.join(other)}: of other types than it reads"] if other else []),
    ]


def readable_as(channel: Channel) -> list[str]:
    """Return the sensors that a channel's messages could be read as; position alone where its name says so."""
    is_decoded = channel.encoding in ENCODINGS
    sensors = [sensor for sensor, types in TYPES.items() if is_decoded and type_name(channel) in types]
    return ["position"] if "position" in sensors and _words(channel) & POSITION_WORDS else sensors


def _words(channel: Channel) -> set[str]:
    return set(re.split(r"[^a-z]+", channel.topic.lower()))


def _reason(channel: Channel) -> str:
    """Return why a topic is of no use by its type, or by its name where its type is that of no one sensor; "" otherwise."""
    kind, words = type_name(channel), _words(channel)
    if kind in RANGE_TYPES:
        return RANGES
    sensors = readable_as(channel)
    has_own_type = bool(sensors) and kind not in COMMON_TYPES
    if kind in UNREAD_POSITION_TYPES or (words & POSITION_WORDS and not has_own_type and sensors != ["position"]):
        return POSITIONS
    return COMMANDS if words & COMMAND_WORDS and not has_own_type else ""
