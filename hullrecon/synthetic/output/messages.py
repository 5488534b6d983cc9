# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""ROS 2 message definitions of the logs, and the store that serialises them."""

from __future__ import annotations

from functools import cache
from typing import Any

from hullrecon.dive.logs.messages.definitions import DVL, PING_INFO, PROJECTED_SONAR_IMAGE

RosMessage = Any  # an instance of the class that rosbags makes for its type

# Of the published one without the types that no simulated image has: logs carry this text, and are
# the same bytes as ever.
SONAR_IMAGE_DATA = """
uint32 DTYPE_UINT8=0
bool is_bigendian
uint32 dtype
uint32 beam_count
uint8[] data
"""

DEFINITIONS = {
    "marine_acoustic_msgs/msg/Dvl": DVL,
    "marine_acoustic_msgs/msg/PingInfo": PING_INFO,
    "marine_acoustic_msgs/msg/SonarImageData": SONAR_IMAGE_DATA,
    "marine_acoustic_msgs/msg/ProjectedSonarImage": PROJECTED_SONAR_IMAGE,
}


@cache
def store() -> Any:
    """Return a rosbags type store that also knows the acoustic messages."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    known = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        known.register(get_types_from_msg(text, name))
    return known


def make(kind: str, **fields: Any) -> Any:
    """Return a message of that ROS type."""
    return store().types[kind](**fields)


def header(stamp_ns: int, frame: str) -> Any:
    """Return a std_msgs/Header."""
    stamp = make("builtin_interfaces/msg/Time", sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def vector(xyz: Any, kind: str = "geometry_msgs/msg/Vector3") -> Any:
    """Return a geometry_msgs/Vector3, or a Point."""
    return make(kind, x=float(xyz[0]), y=float(xyz[1]), z=float(xyz[2]))
