# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the poses of sensors from tf_static: on the vehicle, or on a servo that turns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from hullrecon.dive.logs.messages.decode import ENCODINGS, Fields, decode, type_name
from hullrecon.dive.logs.messages.descriptions import (
    FRD_FROM_FLU,
    TRANSFORMS,
    Tree,
    frame_doubts,
    frame_tree,
    locate_frame,
    mount_of,
    names_above,
)
from hullrecon.dive.logs.messages.samples import WITHOUT_HEADER
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, printable

MOST_FRAME_MESSAGES = 64  # of tf_static, of which there may be many with a part each
SERVO_OF = {"dvl": "tray", "camera_top": "tray", "camera_bottom": "tray", "sonar": "sonar_tray"}
ENDINGS = ("", "_link", "_frame")  # of the frame that a joint turns


RIG = "rig"  # key of the lower camera in the upper one, by a calibration of both


@dataclass(frozen=True, kw_only=True)
class FixedSensor:
    """The pose of a sensor by tf_static, or of a rig's lower camera by its calibration."""

    frame: str  # its name in the log, or the calibration's file
    # x, y, z in m, roll, pitch, yaw in degrees: in the vehicle with its servo at zero, or on the
    # servo where tf_static leads no farther
    pose: tuple[float, ...]
    on_servo: bool = False
    # where the servo turns, m in the vehicle; None where no frame on the way is the servo's
    servo_origin: tuple[float, ...] | None = None
    doubt: str = ""  # why tf_static does not tell the pose, which is then zero


@dataclass
class FrameListener:
    """Collects tf_static and the names of the sensors' frames from the messages that pass."""

    topics: Mapping[str, str]  # by sensor
    tree_messages: list[Fields] = field(default_factory=list)
    frames: dict[str, str] = field(default_factory=dict)  # names by sensor
    _asked: set[str] = field(default_factory=set)  # sensors whose first message was looked at

    def watch(self, messages: Iterable[Message]) -> Iterator[Message]:
        """Pass all messages on, and note what each says of frames."""
        for message in messages:
            self._note(message)
            yield message

    def sensors(self, joints: Mapping[str, str]) -> dict[str, FixedSensor]:
        """Compute the poses of the sensors that tf_static leads to, by sensor.

        joints: names of the servos by record ("tray", "sonar_tray").
        """
        doubts = frame_doubts(self.tree_messages)
        return fixed_sensors(frame_tree(self.tree_messages), self.frames, joints, doubts)

    def _note(self, message: Message) -> None:
        """Keep the messages of tf_static, and the frame that each sensor's first message names.

        Sensors whose messages have no header, or no name in it, get no frame.
        """
        channel = message.channel
        if is_static(channel):
            if len(self.tree_messages) < MOST_FRAME_MESSAGES:
                self.tree_messages += _decoded(message)
            return
        named = [
            sensor
            for sensor, topic in self.topics.items()
            if topic == channel.topic and sensor not in self._asked
        ]
        if not named or type_name(channel) in WITHOUT_HEADER:
            return
        self._asked.update(named)
        for fields in _decoded(message):
            frame = frame_of(fields)
            self.frames.update(dict.fromkeys(named, frame) if frame else {})


def fixed_sensors(
    tree: Tree,
    frames: Mapping[str, str],
    joints: Mapping[str, str],
    doubts: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, FixedSensor]:
    """Compute the poses of the sensors whose frames tf_static reaches, by sensor.

    Poses are in the vehicle where tf_static leads up to it, else on the sensor's servo. A sensor
    whose frame has neither above it is left out. One whose pose is in doubt gets the doubt, and a
    pose of zeros.

    Parameters
    ----------
    tree : the transforms of tf_static
    frames : name of each sensor's frame, by sensor
    joints : names of the servos by record ("tray", "sonar_tray")
    doubts : by frame, why its pose is not known; it holds for the frames that hang on it as well
    """
    found = {}
    for sensor, frame in frames.items():
        doubt = next((doubts[at] for at in names_above(frame, tree) if at in doubts), "")
        if doubt:
            found[sensor] = FixedSensor(
                frame=printable(frame), pose=(0.0,) * 6, doubt=printable(doubt)
            )
            continue
        servo = joints.get(SERVO_OF.get(sensor, ""), "")
        located = locate_frame(
            frame, tree, {f"{servo}{ending}" for ending in ENDINGS} if servo else set()
        )
        if located.vehicle is not None:
            origin = (
                None
                if located.vehicle_from_servo is None
                else tuple(mount_of(located.vehicle_from_servo)[:3])
            )
            found[sensor] = FixedSensor(
                frame=printable(frame), pose=tuple(mount_of(located.vehicle)), servo_origin=origin
            )
        # the servo's frame in the log has the axes forward, port, up (REP 103), its angle at zero
        elif located.servo is not None:
            pose = tuple(mount_of(FRD_FROM_FLU @ located.servo))
            found[sensor] = FixedSensor(frame=printable(frame), pose=pose, on_servo=True)
    return found


def is_static(channel: Channel) -> bool:
    """Tell whether a topic holds the fixed frames."""
    return (
        channel.encoding in ENCODINGS
        and type_name(channel) in TRANSFORMS
        and channel.topic.endswith("tf_static")
    )


def frame_of(message: object) -> str | None:
    """Read the frame of a message's header. None where the log's own type gives it none."""
    frame = getattr(getattr(message, "header", None), "frame_id", None)
    return None if frame is None else str(frame)


def _decoded(message: Message) -> list[Fields]:
    """Decode a message. Empty where it cannot be, or where its reader has decoded it already."""
    if not isinstance(message.data, bytes):
        return []
    try:
        return [decode(message.channel, message.data)]
    except DamagedError:
        return []
