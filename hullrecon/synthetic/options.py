# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The fields of a DiveSpec under flat names, as the command line and notebooks give them."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from hullrecon.errors import UsageError
from hullrecon.synthetic.spec import DiveSpec, Meta

RENAMED = {("cameras", "carried"): "cameras"}


@dataclass(frozen=True, kw_only=True)
class Option:
    """One option of a simulated dive."""

    name: str  # flat, in snake case
    part: str  # field of DiveSpec that holds its record, empty for DiveSpec's own
    field: str  # of that record
    kind: type  # of its value where one is given
    default: bool | int | float | str | None
    meta: Meta


def options() -> tuple[Option, ...]:
    """List all options in the order of the records."""
    return tuple(_options())


def with_options(spec: DiveSpec, **values: Any) -> DiveSpec:
    """Change options of a spec by flat name.

    Raises UsageError for an unknown name, and for a value out of bounds.
    """
    known = {option.name: option for option in options()}
    changes: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        if name not in known:
            raise UsageError(f"unknown option {name}", remedy="see `hullrecon simulate --help`")
        changes.setdefault(known[name].part, {})[known[name].field] = value
    own = changes.pop("", {})
    parts = {
        part: dataclasses.replace(getattr(spec, part), **changed)
        for part, changed in changes.items()
    }
    return dataclasses.replace(spec, **own, **parts)


def spec_from(**values: Any) -> DiveSpec:
    """Describe a dive by some options, with the defaults of all others."""
    return with_options(DiveSpec(), **values)


def _options() -> Iterator[Option]:
    spec = DiveSpec()
    for top in dataclasses.fields(spec):
        part = getattr(spec, top.name)
        if "meta" in top.metadata:
            meta = top.metadata["meta"]
            yield Option(
                name=top.name,
                part="",
                field=top.name,
                kind=_kind(spec, top.name),
                default=part,
                meta=meta,
            )
            continue
        for f in dataclasses.fields(part):
            if "meta" in f.metadata:
                name = RENAMED.get((top.name, f.name), part.prefix + f.name)
                default, meta = getattr(part, f.name), f.metadata["meta"]
                yield Option(
                    name=name,
                    part=top.name,
                    field=f.name,
                    kind=_kind(part, f.name),
                    default=default,
                    meta=meta,
                )


def _kind(record: object, field: str) -> type:
    """Find the type of a field's values: of `int | None`, int; of words, str."""
    default = getattr(record, field)
    if default is not None:
        return type(default)
    kinds: tuple[type, ...] = typing.get_args(typing.get_type_hints(type(record))[field])
    return next(kind for kind in kinds if kind is not type(None))
