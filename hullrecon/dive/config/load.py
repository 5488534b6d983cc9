# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read dive.toml strictly: unknown keys, wrong types and values out of bounds are errors."""

from __future__ import annotations

import posixpath
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

import msgspec
from msgspec import Struct, structs

from hullrecon.dive.config.config_errors import (
    explain_error,
    refuse_deep,
    refuse_not_finite,
    shorten,
)
from hullrecon.dive.config.mount_units import (
    refuse_lever_arm,
    refuse_one_place,
    refuse_radians,
)
from hullrecon.dive.config.schema import DiveConfig, Dvl, HullRegion, Topics
from hullrecon.dive.files import MIB, read_text
from hullrecon.errors import InputError, UsageError

LEAST_AIR_PA = 50_000.0  # of the air at 5 km above the sea; weather changes it by 5,000
FILE = "dive.toml"
# of dive.toml; one with everything set and explained has some ten thousand
LARGEST_BYTES = MIB // 4
MOST_DOTS = 100  # in a line: tomllib's time grows with the square of the dots in a key
NAVIGATION = frozenset(("dvl", "imu", "pressure"))  # sensors that may share a topic, as of poses
Table = dict[str, object]  # of TOML, not yet decoded
Kind = TypeVar("Kind")


@dataclass(frozen=True, kw_only=True)
class LoadedConfig:
    """A decoded dive.toml."""

    package: Path  # its folder
    config: DiveConfig
    # structs by dotted name ("dvl", "camera.top", a step's name), None when absent
    sections: Mapping[str, object]
    given: frozenset[str]  # the dotted keys that the file or an override set; others are defaults

    def value(self, dotted: str) -> object:
        """Look up a section or key by its dotted name, "camera.top". None in an absent section."""
        if dotted in self.sections:
            return self.sections[dotted]
        parent, _, key = dotted.rpartition(".")
        section = self.value(parent) if parent else None
        if not isinstance(section, Struct):
            return None if section is None else getattr(section, key)
        names = {field.encode_name: field.name for field in structs.fields(type(section))}
        if key not in names:
            raise KeyError(dotted)
        return getattr(section, names[key])


def load_config(
    package: Path,
    step_sections: Mapping[str, type[Struct]] = MappingProxyType({}),
    overrides: Sequence[str] = (),
) -> LoadedConfig:
    """Decode the dive.toml of a package, with `a.b=value` overrides applied before.

    Keys that are left out get their defaults. Raises InputError when there is no dive.toml,
    UsageError for anything wrong inside it or in an override.

    step_sections: the structs of the sections that steps add, by name.
    """
    raw = _read_toml(package)
    for text in overrides:
        _apply_override(raw, text)
    refuse_deep(raw, FILE)
    given = frozenset(_leaves(raw))
    steps = {name: raw.pop(name, {}) for name in step_sections}
    refuse_not_finite({**raw, **steps}, FILE)
    config = _decode(raw, DiveConfig, "", list(step_sections))
    sections: dict[str, object] = {
        name: getattr(config, name) for name in config.__struct_fields__ if name != "camera"
    }
    sections |= {"camera.top": config.camera.top, "camera.bottom": config.camera.bottom}
    sections |= {name: _decode(steps[name], kind, name, []) for name, kind in step_sections.items()}
    _check_whole(config)
    return LoadedConfig(
        package=package, config=config, sections=MappingProxyType(sections), given=given
    )


def _read_toml(package: Path) -> Table:
    """Read dive.toml as TOML, not yet decoded to sections.

    Raises InputError if it is missing or cannot be read, UsageError if it is not valid TOML.
    """
    path = package / FILE
    try:
        text = read_text(path, LARGEST_BYTES)
        if max(line.count(".") for line in text.split("\n")) > MOST_DOTS:
            raise UsageError(
                f"{FILE} is not valid: a line with more than {MOST_DOTS} dots", where=str(path)
            )
        return tomllib.loads(text)
    except (FileNotFoundError, NotADirectoryError):
        advice = f"give the folder that holds {FILE}; `hullrecon init LOG` writes one from a log"
        raise InputError(f"no {FILE} here", where=str(package), remedy=advice) from None
    except OSError as error:
        raise InputError(f"{FILE} cannot be read: {error.strerror}", where=str(path)) from None
    except tomllib.TOMLDecodeError as error:
        raise UsageError(
            f"{FILE} is not valid TOML: {shorten(str(error), 160)}{_line_of(str(error), text)}",
            where=str(path),
            remedy="write paths with / between folders" if "Unescaped" in str(error) else "",
        ) from None
    except UnicodeDecodeError as error:
        raise UsageError(
            f"{FILE} is not UTF-8: byte {error.start}", where=str(path), remedy="save it as UTF-8"
        ) from None
    except RecursionError:
        raise UsageError(
            f"{FILE} is not valid TOML: its values are nested too deeply", where=str(path)
        ) from None
    except ValueError as error:  # Python reads no number of more than some thousand digits
        raise UsageError(
            f"{FILE} is not valid TOML: {str(error).partition(';')[0]}", where=str(path)
        ) from None


def _line_of(error: str, text: str) -> str:
    """Show the line that an error of tomllib names. "" where it names none."""
    named = re.search(r"at line (\d+)", error)
    lines = text.split("\n")
    number = int(named[1]) if named else 0
    return f": {shorten(lines[number - 1].strip())}" if 0 < number <= len(lines) else ""


def _apply_override(raw: Table, text: str) -> None:
    """Apply an override `a.b=value` to the raw tables. A value that is no TOML is a string.

    Tables that are absent are made. Whether the key exists is checked when the whole is decoded.
    """
    key, equals, value = text.partition("=")
    parts = [part.strip() for part in key.split(".")]
    if not equals or not all(parts):
        raise UsageError(f"--set {text} is not of the form section.key=value")
    try:
        decoded = tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):
        decoded = value.strip()
    tables = raw
    for part in parts[:-1]:
        inner = tables.setdefault(part, {})
        if not isinstance(inner, dict):
            raise UsageError(f"--set {text}: {part} is a value, not a section")
        tables = inner
    tables[parts[-1]] = decoded


def _decode(raw: object, kind: type[Kind], prefix: str, more: Sequence[str]) -> Kind:
    """Decode a table to a struct. Raises UsageError in words (`explain_error`)."""
    try:
        return msgspec.convert(raw, kind)
    except msgspec.ValidationError as error:
        raise explain_error(str(error), raw, kind, prefix, more, FILE) from None


def _leaves(raw: Mapping[str, object], prefix: str = "") -> Iterator[str]:
    """Yield the dotted keys of all values in a table and the tables within it."""
    for key, value in raw.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"


def _check_whole(config: DiveConfig) -> None:
    """Raise UsageError for keys that are valid alone but contradict each other."""
    if config.camera.bottom is not None and config.camera.top is None:
        raise UsageError(
            "[camera.bottom] without [camera.top]",
            where=FILE,
            remedy="a mono rig has camera.top only",
        )
    files = [posixpath.normpath(name) for name in config.logs.files]
    twice = [name for name in files if files.count(name) > 1]
    if twice:
        raise UsageError(
            f"logs.files names {twice[0]} twice", where=FILE, remedy="name each log once"
        )
    _check_topics(config.topics)
    lengths = [reduce(lambda s, x: s + x * x, beam, 0.0) ** 0.5 for beam in config.dvl.beams or ()]
    if any(abs(length - 1) > 0.02 for length in lengths):
        raise UsageError(
            "dvl.beams are not unit vectors",
            where=FILE,
            remedy="give each beam as x, y, z of length 1",
        )
    _check_tilt(config.dvl)
    _check_units(config)
    _check_regions(() if config.hull is None else config.hull.region or ())


def _check_topics(topics: Topics) -> None:
    """Raise UsageError where two sensors share a topic.

    DVL, IMU and pressure may: a pose or odometry holds velocity, attitude and depth.
    """
    sensors_of: dict[str, list[str]] = {}
    for sensor in topics.__struct_fields__:
        topic = getattr(topics, sensor)
        if topic is None:
            continue
        others = sensors_of.setdefault(topic, [])
        if others and not {sensor, *others} <= NAVIGATION:
            what = f"topics.{sensor} and topics.{others[0]} are both {topic}"
            raise UsageError(what, where=FILE, remedy="give each sensor its own topic")
        others.append(sensor)


def _check_regions(regions: Sequence[HullRegion]) -> None:
    """Raise UsageError for regions with one name, without limits, or with empty ones."""
    names = [region.name for region in regions]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise UsageError(
            f"hull.region names {shorten(twice[0])} twice",
            where=FILE,
            remedy="give each region its own name",
        )
    for region in regions:
        what = f"hull.region {shorten(region.name)}"
        if region.along is None and region.girth is None:
            raise UsageError(
                f"{what} has no limits",
                where=FILE,
                remedy="give along = [from, to], girth = [from, to] or both",
            )
        for key, limits in (("along", region.along), ("girth", region.girth)):
            if limits is not None and not limits[0] < limits[1]:
                raise UsageError(
                    f"{what}: {key} ends before it begins",
                    where=FILE,
                    remedy="give the lower limit first",
                )


def _check_units(config: DiveConfig) -> None:
    """Raise for lever arms that are no metres, angles no degrees, or an air pressure not in Pa.

    Their size shows it. Numbers that are left to the log are not looked at. Raises InputError for
    mounts, UsageError for the pressure.
    """
    top, bottom, hull = config.camera.top, config.camera.bottom, config.hull
    mounts = {
        "dvl.mount": config.dvl.mount,
        "sonar.mount": None if config.sonar is None else config.sonar.mount,
        "camera.top.mount": None if top is None else top.mount,
        "camera.bottom.pose_in_top": None if bottom is None else bottom.pose_in_top,
    }
    origins = {
        "tray.origin": config.tray.origin,
        "pressure.origin": config.pressure.origin,
    }
    for key, numbers in (mounts | origins).items():
        if isinstance(numbers, tuple):
            refuse_lever_arm(key, numbers)
    if bottom is not None and isinstance(bottom.pose_in_top, tuple):
        refuse_one_place("camera.bottom.pose_in_top", bottom.pose_in_top)
    turned = mounts | {"hull.pose": None if hull is None else hull.pose}
    for key, numbers in (turned | {"imu.mount_deg": config.imu.mount_deg}).items():
        if isinstance(numbers, tuple):
            refuse_radians(key, numbers)
    atmosphere = config.pressure.atmosphere
    if 0 < atmosphere < LEAST_AIR_PA:
        raise UsageError(
            f"pressure.atmosphere = {atmosphere:g}: no air is that thin: is it in hPa?",
            where=FILE,
            remedy="give it in Pa; 0 where the sensor shows the pressure above the air's",
        )


def _check_tilt(dvl: Dvl) -> None:
    """Raise UsageError for the beams' angle without their azimuths, or beside unit vectors."""
    given = [
        name for name in ("beam_angle_deg", "beam_azimuth_deg") if getattr(dvl, name) is not None
    ]
    if len(given) == 1:
        other = "beam_azimuth_deg" if given[0] == "beam_angle_deg" else "beam_angle_deg"
        raise UsageError(f"dvl.{given[0]} without dvl.{other}", where=FILE, remedy="give both")
    if given and dvl.beams is not None:
        raise UsageError(
            "dvl.beams and dvl.beam_angle_deg are both given",
            where=FILE,
            remedy="leave one of them away",
        )
