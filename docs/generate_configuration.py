# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/configuration.md, every key of dive.toml, from the declarations: python
docs/generate_configuration.py

A description that begins with a unit and a comma gives the unit; a key without one has none.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
from msgspec import inspect as types

from hullrecon.dive.config.schema import DiveConfig
from hullrecon.steps.chain import stages

UNIT = re.compile(
    r"(m and deg|m/s2|m/s|kg/m3|deg/h|deg|Pa|m2|m|s|px|share|ratio|sigmas|probability|chi2|bytes"
    r"|rad|Hz)(?:, |$)"
)
BOUNDS = {"ge": "≥ {}", "gt": "> {}", "le": "≤ {}", "lt": "< {}", "multiple_of": "multiple of {}"}
HEAD = """# Configuration

Every key of `dive.toml`, with its unit, default and meaning. This page is generated from the code
(`python docs/generate_configuration.py`), and a test holds it to the code. What else a dive package
holds is in [dive_package.md](dive_package.md).

- An unknown key is an error that names the nearest known one. `hullrecon check` prints what was
  read.
- A mount is six numbers: x, y, z in metres, then roll, pitch, yaw in degrees. The sigma of a mount
  is metres and a small rotation vector in degrees, in the parent frame.
- Every step has a section of its name. Its keys can also be given as options of its command or by
  `--set SECTION.KEY=VALUE`.
- The unit `share` is a number from 0 to 1, `sigmas` a multiple of one standard deviation.
"""


@dataclass(frozen=True, kw_only=True)
class Key:
    """One key of dive.toml, as the page has it."""

    name: str
    unit: str
    kind: str
    default: str
    meaning: str


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of dive.toml with what it is about."""

    name: str
    about: str
    keys: tuple[Key, ...]


def tables() -> list[Table]:
    """Return every table: those of the dive first, then those of the steps that have options."""
    found = list(_tables(DiveConfig, ""))
    for stage in stages():
        info = _struct(stage.parameters)
        if info.fields:
            about = f"Options of the step: {stage.summary}."
            found.append(
                Table(
                    name=stage.name,
                    about=about,
                    keys=tuple(_key(stage.name, f) for f in info.fields),
                )
            )
    return found


def text() -> str:
    """Return the whole page."""
    parts = [HEAD]
    for table in tables():
        parts.append(
            f"\n## [{table.name}]\n\n{table.about}\n\n"
            "| key | unit | values | default | meaning |\n|---|---|---|---|---|\n"
        )
        parts += [
            f"| `{k.name}` | {k.unit} | {k.kind} | {k.default} | {k.meaning} |\n"
            for k in table.keys
        ]
    return "".join(parts)


def _tables(kind: type[msgspec.Struct], name: str) -> Iterator[Table]:
    info = _struct(kind)
    sections = [(f, _inner(f.type)[0]) for f in info.fields]
    own = tuple(_key(name, f) for f, inner in sections if not isinstance(inner, types.StructType))
    if own:
        yield Table(name=name, about=" ".join((kind.__doc__ or "").split()), keys=own)
    for field, inner in sections:
        below = inner.item_type if isinstance(inner, types.VarTupleType) else inner
        if isinstance(below, types.StructType):
            yield from _tables(below.cls, f"{name}.{field.encode_name}".lstrip("."))


def _struct(kind: type) -> types.StructType:
    info = types.type_info(kind)
    if not isinstance(info, types.StructType):
        raise TypeError(f"{kind} is no struct")
    return info


def _key(section: str, field: types.Field) -> Key:
    inner, described = _inner(field.type)
    unit = UNIT.match(described)
    return Key(
        name=f"{section}.{field.encode_name}",
        unit=unit[1] if unit else "",
        kind=_kind(inner),
        default=_default(field),
        meaning=described[unit.end() :] if unit else described,
    )


def _inner(kind: types.Type) -> tuple[types.Type, str]:
    """The type without None and metadata, and its description: the outermost one."""
    if isinstance(kind, types.Metadata):
        inner, below = _inner(kind.type)
        return inner, str((kind.extra_json_schema or {}).get("description", "")) or below
    if isinstance(kind, types.UnionType):
        members = [m for m in kind.types if not isinstance(m, types.NoneType)]
        if len(members) == 1:
            return _inner(members[0])
    return kind, ""


def _kind(kind: types.Type) -> str:
    """What may be given, in words."""
    kind, _ = _inner(kind)
    if isinstance(kind, types.UnionType):
        return " or ".join(
            _kind(member) for member in kind.types if not isinstance(member, types.NoneType)
        )
    if isinstance(kind, types.LiteralType):
        return ", ".join(f'`"{v}"`' for v in kind.values)
    if isinstance(kind, types.TupleType):
        return f"{len(kind.item_types)} numbers{_bounds(kind.item_types[0])}"
    if isinstance(kind, types.VarTupleType):
        return f"list of {_plural(kind.item_type)}"
    names = {
        types.BoolType: "`true`, `false`",
        types.IntType: "whole number",
        types.FloatType: "number",
        types.StrType: "text",
        types.DateTimeType: "date and time",
    }
    return names[type(kind)] + _bounds(kind)


def _plural(kind: types.Type) -> str:
    inner, _ = _inner(kind)
    words = {types.StrType: "texts", types.FloatType: "numbers", types.StructType: "tables, below"}
    return (
        f"{len(inner.item_types)} numbers each"
        if isinstance(inner, types.TupleType)
        else words[type(inner)]
    )


def _bounds(kind: types.Type) -> str:
    inner, _ = _inner(kind)
    limits = [(form, getattr(inner, name, None)) for name, form in BOUNDS.items()]
    said = ", ".join(form.format(f"{limit:g}") for form, limit in limits if limit is not None)
    return f" {said}" if said else ""


def _default(field: types.Field) -> str:
    if field.default is msgspec.NODEFAULT:
        return "required"
    return "" if field.default is None or field.default == "" else f"`{_toml(field.default)}`"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple | list):
        return f"[{', '.join(_toml(v) for v in value)}]"
    return (
        f'"{value}"'
        if isinstance(value, str)
        else f"{value:g}"
        if isinstance(value, float)
        else str(value)
    )


if __name__ == "__main__":
    (Path(__file__).parent / "configuration.md").write_text(text())
