# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Lever arms and mounts that dive.toml leaves out: those of the log's tf_static, else the defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from msgspec import Struct, structs

from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.schema import FROM_LOG, DiveConfig
from hullrecon.dive.logs.fixed_frames import FixedSensor
from hullrecon.dive.logs.messages.descriptions import mount_of
from hullrecon.errors import InputError
from hullrecon.geometry.poses import Poses, from_mount

Numbers = tuple[float, ...]
DEFAULTS: Mapping[str, Numbers] = MappingProxyType(
    {
        "tray.origin": (0.0, 0.0, 0.0),
        "pressure.origin": (0.0, 0.0, 0.0),
        "position.origin": (0.0, 0.0, 0.0),
        "dvl.mount": (0.0, 0.0, 0.0, 0.0, 90.0, 0.0),
        "camera.top.mount": (0.0, 0.0, 0.0, 90.0, 0.0, 90.0),
        "camera.bottom.pose_in_top": (0.0, 0.1, 0.0, 0.0, 0.0, 0.0),
        "sonar.origin": (0.0, 0.0, 0.0),
        "sonar.mount": (0.0, 0.0, 0.0, 0.0, 90.0, 0.0),
    }
)
ON_SERVO = {"dvl.mount": ("dvl", "tray.origin"), "camera.top.mount": ("camera_top", "tray.origin"),
            "sonar.mount": ("sonar", "sonar.origin")}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class ChosenMount:
    """The numbers of a key of DEFAULTS; source: where in the log they come from, "" for a default."""

    value: Numbers
    source: str = ""


def choose_mounts(
    values: Mapping[str, object], sensors: Mapping[str, FixedSensor]
) -> dict[str, ChosenMount]:
    """Return the mounts that stand in for the keys of DEFAULTS among `values` that are left to the
    log.

    values: by dotted key, as dive.toml has them; sensors: where tf_static has each ("dvl",
    "camera_top", ...). A mount on a servo is counted from where that turns, by dive.toml, else by
    the servo's own frame, else from the vehicle's origin.
    """
    chosen: dict[str, ChosenMount] = {}
    for key in ("tray.origin", "sonar.origin"):
        servo = [
            sensors[sensor]
            for sensor, origin in ON_SERVO.values()
            if origin == key and sensor in sensors
        ]
        named = next((s for s in servo if s.servo_origin is not None), None)
        if named is not None and named.servo_origin is not None:
            chosen[key] = ChosenMount(
                value=named.servo_origin, source=f"tf_static, on the way to {named.frame}"
            )
        elif servo and not any(s.on_servo for s in servo):
            chosen[key] = ChosenMount(
                value=DEFAULTS[key],
                source="tf_static, which has no frame of the servo: the vehicle's origin",
            )
    origins = {
        key: numbers_of(values[key])
        for key in ("tray.origin", "sonar.origin")
        if _is_given(values.get(key))
    }
    for key, (sensor, origin) in ON_SERVO.items():
        if sensor in sensors:
            at = origins.get(origin, chosen[origin].value if origin in chosen else DEFAULTS[origin])
            chosen[key] = ChosenMount(
                value=_on_servo(sensors[sensor], at),
                source=f"tf_static, frame {sensors[sensor].frame}",
            )
    for sensor in ("pressure", "position"):
        if sensor in sensors:
            fixed = sensors[sensor]
            chosen[f"{sensor}.origin"] = ChosenMount(
                value=fixed.pose[:3], source=f"tf_static, frame {fixed.frame}"
            )
    top, bottom = sensors.get("camera_top"), sensors.get("camera_bottom")
    if top is not None and bottom is not None and top.on_servo == bottom.on_servo:
        pose = from_mount(top.pose).inverse() @ from_mount(bottom.pose)
        chosen["camera.bottom.pose_in_top"] = ChosenMount(
            value=tuple(mount_of(pose)), source=f"tf_static, frame {bottom.frame}"
        )
    return {
        key: chosen.get(key, ChosenMount(value=DEFAULTS[key]))
        for key in DEFAULTS
        if values.get(key) == FROM_LOG
    }


def parted_on_tray(sensors: Mapping[str, FixedSensor]) -> tuple[FixedSensor, FixedSensor] | None:
    """Return of DVL and upper camera the one that tf_static has on the tray's servo and the one
    that it fixes to the vehicle; None where there are no such two.
    """
    both = [
        sensors[sensor]
        for sensor, origin in ON_SERVO.values()
        if origin == "tray.origin" and sensor in sensors
    ]
    on, fixed = (
        [s for s in both if (s.on_servo or s.servo_origin is not None) == turns]
        for turns in (True, False)
    )
    return (on[0], fixed[0]) if on and fixed else None


def refuse_parted_tray(values: Mapping[str, object], sensors: Mapping[str, FixedSensor]) -> None:
    """Raise InputError where one of DVL and upper camera is on the tray's servo, which turns, and
    the other one is not.

    One tray carries both, so that what is fixed would turn as well.

    values, sensors: as of choose_mounts. Where dive.toml gives the mounts, it is taken to know.
    """
    parted = parted_on_tray(sensors)
    if parted is not None and FROM_LOG in [
        values.get(key) for key in ("dvl.mount", "camera.top.mount")
    ]:
        turning, fixed = parted
        raise InputError(
            f"tf_static has {turning.frame} on the tray's servo and {fixed.frame} fixed to the vehicle; one tray carries DVL "
            "and cameras, so that both would turn",
            where="dvl.mount, camera.top.mount",
            remedy="give both mounts and tray.origin where tf_static is wrong; where it is right, the dive can be used only if "
            'the servo stood still: tray.joint = "" and both mounts as they were',
        )


def describe_mounts(mounts: Mapping[str, ChosenMount]) -> list[str]:
    """Return a sentence for each mount that the log gave."""
    return [
        f"{key} = [{', '.join(f'{v:g}' for v in mount.value)}] by {mount.source}"
        for key, mount in mounts.items()
        if mount.source
    ]


def filled_in(loaded: LoadedConfig, mounts: Mapping[str, ChosenMount]) -> LoadedConfig:
    """Return a configuration with those mounts in place."""
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
    """Return a section with another value."""
    return structs.replace(section, **{name: value}) if isinstance(section, Struct) else section


def numbers_of(value: object) -> Numbers:
    """Return a lever arm or mount that is given or was filled in. Raises TypeError for one that is
    still left to the log.
    """
    if not isinstance(value, tuple | list):
        raise TypeError(f"a list of numbers is expected, not {value!r}")
    return tuple(float(v) for v in value)


def _is_given(value: object) -> bool:
    return isinstance(value, tuple | list)


def _on_servo(sensor: FixedSensor, origin: Numbers) -> Numbers:
    """Return the sensor's mount in the frame of a servo at zero that turns about `origin`."""
    if sensor.on_servo:
        return sensor.pose
    shift = Poses(np.array([[0.0, 0.0, 0.0, 1.0]]), np.array([origin], float))
    return tuple(mount_of(shift.inverse() @ from_mount(sensor.pose)))
