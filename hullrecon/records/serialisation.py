# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Convert records to the members of an .npz and back: fields by name, nested ones by `part.field`.

A part that is None has no members, which distinguishes it from an empty part.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Arrays

Record = TypeVar("Record")


def to_arrays(record: object) -> Arrays:
    """Collect the arrays of a record by name. Fields and parts that are None are left out."""
    arrays: Arrays = {}
    for field in fields(record):  # type: ignore[arg-type]  # any dataclass
        value = getattr(record, field.name)
        if is_dataclass(value):
            arrays |= {f"{field.name}.{name}": array for name, array in to_arrays(value).items()}
        elif value is not None:
            arrays[field.name] = np.asarray(value)
    return arrays


def from_arrays(kind: type[Record], arrays: Mapping[str, NDArray[np.generic]]) -> Record:
    """Rebuild a record of that kind. Raises KeyError with the name of a missing member."""
    return _from_arrays(kind, arrays, "")


def _from_arrays(
    kind: type[Record], arrays: Mapping[str, NDArray[np.generic]], prefix: str
) -> Record:
    """Rebuild a record whose members are named with a prefix, as those of a nested one are."""
    hints = typing.get_type_hints(kind)
    values: dict[str, object] = {}
    for field in fields(kind):  # type: ignore[arg-type]  # any dataclass
        name, part = prefix + field.name, _nested_record(hints[field.name])
        if part is None:
            values[field.name] = arrays[name]
        elif _is_optional(hints[field.name]) and not any(
            member.startswith(name + ".") for member in arrays
        ):
            values[field.name] = None
        else:
            values[field.name] = _from_arrays(part, arrays, name + ".")
    return kind(**values)


def _nested_record(hint: object) -> type | None:
    """Find the record type of a field that holds a record or None. None for an array."""
    for candidate in (hint, *typing.get_args(hint)):
        if isinstance(candidate, type) and is_dataclass(candidate):
            return candidate
    return None


def _is_optional(hint: object) -> bool:
    return isinstance(hint, types.UnionType) and type(None) in typing.get_args(hint)
