# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Take a camera's calibration from the CameraInfo that was logged with its images."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from hullrecon.dive.config.calibration import (
    REGION_KEYS,
    camera_of,
    has_region,
    is_rectified,
)
from hullrecon.dive.images.encoded import Size, header_size
from hullrecon.dive.logs.messages.decode import ENCODINGS, decode, type_name
from hullrecon.dive.logs.messages.descriptions import CAMERA_INFO, calibration_keys, lies_beside
from hullrecon.dive.logs.readers.protocol import Log, Message
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.problems import Problems
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera

REMEDY = "give the YAML of the camera in water"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"

Keys = Mapping[str, object]


class LoggedCalibrations:
    """The logged calibrations of the cameras that dive.toml does not calibrate."""

    def __init__(self, image_topics: Mapping[str, str | None]) -> None:
        """Take the image topics by camera ("camera_top"), None for a camera without a topic."""
        self._image_topics = image_topics
        self._keys: dict[str, Keys] = {}  # the calibration by camera, as in a camera_info YAML
        self._sizes: dict[str, Size | None] = {}  # of the first image by camera
        # by camera, the topic of a CameraInfo that differs from the first one
        self._changes: dict[str, str] = {}
        self.topics: dict[str, str] = {}  # by camera, the topic of the first CameraInfo

    def find(self, logs: Sequence[Log], problems: Problems) -> dict[str, CameraModel]:
        """Build each camera from its first CameraInfo.

        Logs are read until each camera has one. InputErrors for a camera that has none, or one
        that cannot be used, are raised or collected in `problems`.
        """
        for log in logs:
            if self._is_complete():
                break
            with problems.collect():
                self._look_for_first(log.messages())
        found: dict[str, CameraModel] = {}
        for camera in self._image_topics:
            with problems.collect():
                found[camera] = self._build_camera(camera)
        return found

    def watch(self, messages: Iterable[Message]) -> Iterator[Message]:
        """Pass messages on, and note a CameraInfo that differs from the camera's first one."""
        for message in messages:
            for camera, keys in self._read_calibration(message):
                if repr(keys) != repr(self._keys.get(camera, keys)):  # NaN is unlike itself
                    self._changes.setdefault(camera, message.channel.topic)
            yield message

    def check_constant(self, problems: Problems) -> None:
        """Raise InputError where a calibration changed, or collect it in `problems`.

        Call it once all messages have passed `watch`.
        """
        for camera, topic in self._changes.items():
            first = self.topics[camera]
            what = (
                "changes within the log" if topic == first else f"is another than that on {topic}"
            )
            with problems.collect():
                raise InputError(
                    f"the CameraInfo on {first} {what}", where=_key(camera), remedy=REMEDY
                )

    def notes(self, cameras: Mapping[str, CameraModel]) -> list[Finding]:
        """Report each camera whose calibration is the logged one."""
        return [
            Finding("calibration-of-log", {"topic": topic}, camera)
            for camera, topic in self.topics.items()
            if camera in cameras
        ]

    def _look_for_first(self, messages: Iterable[Message]) -> None:
        """Keep the first CameraInfo and the size of the first image of each camera.

        Stops reading when nothing more is needed.
        """
        for message in messages:
            for camera, keys in self._read_calibration(message):
                if camera not in self._keys:
                    self._keys[camera], self.topics[camera] = keys, message.channel.topic
            for camera, images in self._image_topics.items():
                if images == message.channel.topic and camera not in self._sizes:
                    self._sizes[camera] = _size_of(message)
            if self._is_complete():
                return

    def _is_complete(self) -> bool:
        """Tell whether each camera has a CameraInfo, and an image size where that is needed.

        It is needed to interpret a region of interest.
        """
        return len(self._keys) == len(self._image_topics) and all(
            camera in self._sizes or not has_region(keys) for camera, keys in self._keys.items()
        )

    def _read_calibration(self, message: Message) -> Iterator[tuple[str, Keys]]:
        """Yield the cameras that a CameraInfo message belongs to, with its calibration.

        They are those whose images are logged beside it, as /front/image_raw is beside
        /front/camera_info.
        """
        channel = message.channel
        if (
            channel.encoding not in ENCODINGS
            or type_name(channel) != CAMERA_INFO
            or not isinstance(message.data, bytes)
        ):
            return
        cameras = [
            c
            for c, images in self._image_topics.items()
            if images and lies_beside(channel.topic, images)
        ]
        if not cameras:
            return
        try:
            keys = calibration_keys(decode(channel, message.data))
        # the log's own definition may leave fields out
        except (DamagedError, AttributeError, TypeError, ValueError):
            return
        yield from ((camera, keys) for camera in cameras)

    def _build_camera(self, camera: str) -> CameraModel:
        """Build a camera from its CameraInfo.

        Raises InputError where that is missing or empty, belongs to two cameras, or describes the
        pictures before they were rectified.
        """
        images, keys, topic = (
            self._image_topics[camera],
            self._keys.get(camera),
            self.topics.get(camera),
        )
        if keys is None or topic is None or images is None:
            what = f"{_key(camera)} is missing" + (
                f", and no CameraInfo was logged beside {images}" if images else ""
            )
            raise InputError(what, where="dive.toml", remedy=REMEDY)
        shared = [
            other for other, known in self.topics.items() if known == topic and other != camera
        ]
        if shared:
            raise InputError(
                f"{topic} lies beside the images of {camera} and {shared[0]}",
                where=_key(camera),
                remedy=REMEDY,
            )
        if is_rectified(images):
            raise InputError(
                f"{images} is rectified, and {topic} describes what was before",
                where=_key(camera),
                remedy="give the YAML of the rectified pictures, which have no distortion",
            )
        matrix = keys["camera_matrix"]
        if isinstance(matrix, list) and not any(matrix):
            raise InputError(
                f"the CameraInfo on {topic} has no calibration: K is zero",
                where=_key(camera),
                remedy=REMEDY,
            )
        where = f"{topic}, for {_key(camera)}"
        whole = {name: value for name, value in keys.items() if name not in REGION_KEYS}
        # Some drivers state the region of the sensor that they read beside a calibration that is
        # already for images of that size: the region is then not applied.
        is_whole = self._sizes.get(camera) == (keys["image_width"], keys["image_height"])
        if has_region(keys) and is_whole and not _is_shifted(keys):
            return camera_of(whole, where)
        return camera_of(keys, where)


def _is_shifted(keys: Keys) -> bool:
    """Tell whether a region of interest does not begin at the sensor's corner.

    It is then unclear which of the two the principal point counts from.
    """
    region = keys["roi"]
    return isinstance(region, Mapping) and bool(region["x_offset"] or region["y_offset"])


def _size_of(message: Message) -> Size | None:
    """Read the size of a logged image. None where it cannot be read."""
    if not isinstance(message.data, bytes):
        return None
    try:
        fields = decode(message.channel, message.data)
        if type_name(message.channel) == COMPRESSED_IMAGE:
            return header_size(bytes(fields.data))
        return int(fields.width), int(fields.height)
    # the log's own definition may leave fields out
    except (DamagedError, AttributeError, TypeError, ValueError):
        return None


def _key(camera: str) -> str:
    return f"{Camera(camera.removeprefix('camera_')).section}.calibration"
