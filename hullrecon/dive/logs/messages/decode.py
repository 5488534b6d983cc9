# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Decode serialised messages by the definition carried in the log, else by a bundled one."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from hullrecon.dive.logs.messages.definition_limits import check_idl, check_text, check_types
from hullrecon.dive.logs.messages.definitions import BUNDLED
from hullrecon.dive.logs.readers.protocol import Channel
from hullrecon.dive.logs.readers.unpack import LONGEST_REASON, DamagedError, printable
from hullrecon.typing import Array

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

Fields = Any  # an instance of the class that rosbags makes for a message type
ENCODINGS = ("cdr", "ros1")
# as a .db3 that a recorder before Iron wrote; `ros2 bag convert` writes MCAP with definitions
UNDEFINED = (
    "the log has no definition of their type; convert it to MCAP by `ros2 bag convert` where the "
    "type's package is installed"
)


def type_name(channel: Channel) -> str:
    """Write the type in its three-part form, "sensor_msgs/msg/Imu"."""
    parts = channel.type.split("/")
    return f"{parts[0]}/msg/{parts[-1]}" if len(parts) > 1 else channel.type


def decode(channel: Channel, data: bytes) -> Fields:
    """Decode a message. Raises DamagedError for damaged bytes and types without a definition."""
    store = _type_store(channel)
    if isinstance(store, str):
        raise DamagedError(store)
    try:
        if channel.encoding == "ros1":
            return store.deserialize_ros1(data, type_name(channel))
        return store.deserialize_cdr(data, type_name(channel))
    # bytes of any content: rosbags' generated code raises whatever they lead it to
    except Exception as error:
        raise DamagedError(f"a {channel.type} cannot be decoded: {describe(error)}") from None


def describe(error: Exception) -> str:
    """Shorten an exception of a library to one line."""
    reason = printable(str(error).strip().partition("\n")[0], LONGEST_REASON)
    return reason if isinstance(error, DamagedError) else f"{type(error).__name__} {reason}"


@lru_cache(maxsize=64)
def _type_store(channel: Channel) -> Typestore | str:
    """Compile the types for decoding a channel's messages, or explain why that fails."""
    if channel.encoding not in ENCODINGS:
        return f"messages in the encoding {channel.encoding!r} are not read"
    try:
        if channel.definition.strip():
            return _from_definition(channel)
        store = _standard_types(channel.encoding)
        return store if type_name(channel) in store.types else UNDEFINED
    except Exception as error:  # the grammar of a damaged definition may fail anywhere
        return f"the definition of {channel.type} cannot be read: {describe(error)}"


def _from_definition(channel: Channel) -> Typestore:
    """Compile the message definition that the log itself holds.

    Raises DamagedError for one that would take hours to compile or to decode by.
    """
    from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    check_text(channel.definition)
    if channel.definition_format == "ros2idl":
        check_idl(channel.definition)
        types = get_types_from_idl(channel.definition)
    else:
        types = get_types_from_msg(channel.definition, type_name(channel))
    check_types(types, type_name(channel))
    store.register(types)
    # compiles it: where that fails it would fail anew for each message
    store.get_msgdef(type_name(channel))
    return store


@lru_cache(maxsize=2)
def _standard_types(encoding: str) -> Typestore:
    """Load the types of ROS 1 or 2 and those bundled here, for logs without definitions."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if encoding == "ros1" else Stores.ROS2_JAZZY)
    for name, text in BUNDLED.items():
        store.register(get_types_from_msg(text, name))
    return store


def vector(v: Fields) -> Array:
    """Convert a geometry_msgs/Vector3 or Point to an array (3,)."""
    return np.array([v.x, v.y, v.z], float)
