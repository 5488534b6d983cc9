# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Lever arms, mounts and the guess of the hull's pose that dive.toml leaves out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from msgspec import Struct, structs

from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.mount_units import refuse_lever_arm, refuse_one_place
from hullrecon.dive.config.schema import DEFAULT_MOUNTS, FROM_LOG, DiveConfig
from hullrecon.dive.logs.fixed_frames import RIG, FixedSensor
from hullrecon.dive.logs.messages.descriptions import mount_of
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.poses import Poses, from_mount, up_in
from hullrecon.typing import Array

Numbers = tuple[float, ...]
ON_SERVO = {  # of each mount on a servo: the sensor, and the key of the servo's axis
    "dvl.mount": ("dvl", "tray.origin"),
    "camera.top.mount": ("camera_top", "tray.origin"),
    "sonar.mount": ("sonar", "sonar.origin"),
}
KEY_OF = {sensor: key for key, (sensor, _) in ON_SERVO.items()} | {
    "camera_bottom": "camera.bottom.pose_in_top",
    "pressure": "pressure.origin",
    "position": "position.origin",
}
# Default sigmas of hull.pose. Horizontally and vertically: the draught is known better than the
# berth
LEVEL_M, VERTICAL_M = 1.0, 0.3
# Of heel and trim, which are small and read off, and of the heading, by a compass near steel
TILT_DEG, HEADING_DEG = 1.0, 5.0


@dataclass(frozen=True, kw_only=True)
class ChosenMount:
    """The value chosen for a key of DEFAULT_MOUNTS."""

    value: Numbers
    source: str = ""  # where in the log they come from; "" for a default


def choose_mounts(
    values: Mapping[str, object], sensors: Mapping[str, FixedSensor]
) -> dict[str, ChosenMount]:
    """Choose the mounts for the keys of DEFAULT_MOUNTS that dive.toml leaves to the log.

    Those that the log does not give, or gives in two ways, get their default. A mount on a servo is
    relative to the servo's axis: that of dive.toml, else the servo's own frame, else the vehicle's
    origin.

    Parameters
    ----------
    values : lever arms and mounts by dotted key, as in dive.toml
    sensors : the pose of each sensor by tf_static ("dvl", "camera_top", ...), and that of RIG by a
        calibration
    """
    sensors = {name: sensor for name, sensor in sensors.items() if not sensor.doubt}
    chosen: dict[str, ChosenMount] = {}

    # The servos' axes, and the sensors on them relative to these axes.
    for key in ("tray.origin", "sonar.origin"):
        axis = _servo_axis(key, _on_axis(key, sensors))
        if axis is not None:
            chosen[key] = axis
    for key, (sensor, origin) in ON_SERVO.items():
        if sensor in sensors:
            axis_at = values.get(origin)
            if not _is_given(axis_at):
                axis_at = chosen[origin].value if origin in chosen else DEFAULT_MOUNTS[origin]
            chosen[key] = _by_frame(
                sensors[sensor], _on_servo(sensors[sensor], numbers_of(axis_at))
            )

    # The sensors fixed to the vehicle.
    for sensor in ("pressure", "position"):
        if sensor in sensors:
            chosen[f"{sensor}.origin"] = _by_frame(sensors[sensor], sensors[sensor].pose[:3])

    # The stereo rig, by its calibration, else by both cameras' frames.
    top, bottom = sensors.get("camera_top"), sensors.get("camera_bottom")
    if RIG in sensors:
        chosen["camera.bottom.pose_in_top"] = ChosenMount(
            value=sensors[RIG].pose, source=f"the calibration {sensors[RIG].frame}"
        )
    elif top is not None and bottom is not None and top.on_servo == bottom.on_servo:
        pose = from_mount(top.pose).inverse() @ from_mount(bottom.pose)
        chosen["camera.bottom.pose_in_top"] = _by_frame(bottom, tuple(mount_of(pose)))
    return {
        key: chosen.get(key, ChosenMount(value=DEFAULT_MOUNTS[key]))
        for key in DEFAULT_MOUNTS
        if values.get(key) == FROM_LOG
    }


def _by_frame(sensor: FixedSensor, value: Numbers) -> ChosenMount:
    """Make the choice of a value that a sensor's frame in tf_static gives."""
    return ChosenMount(value=value, source=f"tf_static, frame {sensor.frame}")


def _on_axis(origin: str, sensors: Mapping[str, FixedSensor]) -> list[FixedSensor]:
    """List the sensors that one servo carries. origin: key of the servo's axis."""
    return [
        sensors[sensor] for sensor, key in ON_SERVO.values() if key == origin and sensor in sensors
    ]


def _servo_axis(key: str, carried: Sequence[FixedSensor]) -> ChosenMount | None:
    """Choose a servo's axis by the sensors that it carries: its own frame, else the default.

    None where no sensor gives one.
    """
    for sensor in carried:
        if sensor.servo_origin is not None:
            source = f"tf_static, on the way to {sensor.frame}"
            return ChosenMount(value=sensor.servo_origin, source=source)
    if not carried or any(sensor.on_servo for sensor in carried):
        return None
    source = "tf_static, which has no frame of the servo: the vehicle's origin"
    return ChosenMount(value=DEFAULT_MOUNTS[key], source=source)


def split_by_servo(sensors: Mapping[str, FixedSensor]) -> tuple[FixedSensor, FixedSensor] | None:
    """Find which of DVL and upper camera tf_static has on the tray's servo, and which off it.

    A sensor is on the servo where the servo's frame lies between the vehicle and the sensor, or
    where tf_static ends at the servo. None where both or neither are on it.
    """
    both = _on_axis("tray.origin", sensors)
    turning, fixed = (
        [s for s in both if (s.on_servo or s.servo_origin is not None) == turns]
        for turns in (True, False)
    )
    return (turning[0], fixed[0]) if turning and fixed else None


def refuse_mounts(
    values: Mapping[str, object], sensors: Mapping[str, FixedSensor], has_tray: bool
) -> None:
    """Raise InputError where tf_static cannot give a mount that dive.toml leaves to it.

    Mounts given by dive.toml are trusted.

    Parameters
    ----------
    values, sensors : as in choose_mounts
    has_tray : the angles of a tray were logged
    """
    for sensor, key in KEY_OF.items():
        if values.get(key) == FROM_LOG and sensor in sensors and sensors[sensor].doubt:
            raise InputError(sensors[sensor].doubt, where=key, remedy=f"give {key} in dive.toml")
    known = {name: sensor for name, sensor in sensors.items() if not sensor.doubt}
    if has_tray:
        _refuse_parted_tray(values, known)
    for key, mount in choose_mounts(values, known).items():
        if mount.source:
            refuse_lever_arm(key, mount.value, mount.source)
            if key == "camera.bottom.pose_in_top":
                refuse_one_place(key, mount.value, mount.source)


def _refuse_parted_tray(values: Mapping[str, object], sensors: Mapping[str, FixedSensor]) -> None:
    """Raise InputError where tf_static has only one of DVL and upper camera on the tray's servo.

    One tray carries both, so that the fixed sensor would turn as well.
    """
    parted = split_by_servo(sensors)
    if parted is not None and FROM_LOG in [
        values.get(key) for key in ("dvl.mount", "camera.top.mount")
    ]:
        turning, fixed = parted
        raise InputError(
            f"tf_static has {turning.frame} on the tray's servo and {fixed.frame} fixed to the "
            "vehicle; one tray carries DVL and cameras, so that both would turn",
            where="dvl.mount, camera.top.mount",
            remedy="give both mounts and tray.origin where tf_static is wrong; where it is right, "
            'the dive can be used only if the servo stood still: tray.joint = "" and both mounts '
            "as "
            "they were",
        )


def describe_mounts(mounts: Mapping[str, ChosenMount]) -> list[Finding]:
    """Describe each mount that the log gave."""
    return [
        Finding("mount-of-log", {"key": key, "value": list(mount.value), "source": mount.source})
        for key, mount in mounts.items()
        if mount.source
    ]


def filled_in(loaded: LoadedConfig, mounts: Mapping[str, ChosenMount]) -> LoadedConfig:
    """Replace the mounts in a configuration by those that were chosen, by their dotted keys.

    Later steps then find numbers wherever dive.toml left a mount to the log. Sections that are
    absent in dive.toml stay absent.
    """
    sections = dict(loaded.sections)
    for key, mount in mounts.items():
        section, _, name = key.rpartition(".")
        sections[section] = with_value(sections[section], name, mount.value)
    camera = structs.replace(
        loaded.config.camera, top=sections["camera.top"], bottom=sections["camera.bottom"]
    )
    named = {name: sections[name] for name in DiveConfig.__struct_fields__ if name != "camera"}
    config = DiveConfig(**named, camera=camera)  # type: ignore[arg-type]
    return replace(loaded, config=config, sections=MappingProxyType(sections))


def with_value(section: object, name: str, value: Numbers) -> object:
    """Copy a section with one value changed. Anything but a section is returned unchanged."""
    return structs.replace(section, **{name: value}) if isinstance(section, Struct) else section


def numbers_of(value: object) -> Numbers:
    """Convert a lever arm or mount to numbers.

    Raises TypeError where it is still left to the log.
    """
    if not isinstance(value, tuple | list):
        raise TypeError(f"a list of numbers is expected, not {value!r}")
    return tuple(float(v) for v in value)


def _is_given(value: object) -> bool:
    return isinstance(value, tuple | list)


def _on_servo(sensor: FixedSensor, origin: Numbers) -> Numbers:
    """Compute a sensor's mount in the frame of a servo at zero that turns about `origin`.

    At zero the servo's axes are the vehicle's, so that only the origin differs.
    """
    if sensor.on_servo:
        return sensor.pose
    shift = Poses(np.array([[0.0, 0.0, 0.0, 1.0]]), np.array([origin], float))
    return tuple(mount_of(shift.inverse() @ from_mount(sensor.pose)))


def guess_sigma(pose: Sequence[float], given: Sequence[float] | None) -> Array:
    """Choose the sigma (6,) of `hull.pose`, m and deg, in the CAD model's axes.

    It is the given one, else a default: the height is known better than the berth, heel and trim
    better than the heading. The axis of the CAD model that the pose turns upward shows which is
    which.
    """
    if given is not None:
        return np.array(given, float)
    vertical = int(np.argmax(np.abs(up_in(from_mount(pose)))))
    sigma: Array = np.r_[np.full(3, LEVEL_M), np.full(3, TILT_DEG)]
    sigma[[vertical, 3 + vertical]] = VERTICAL_M, HEADING_DEG
    return sigma
