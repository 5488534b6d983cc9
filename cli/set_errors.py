# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Errors in the configuration, said of the place where the wrong value was given: dive.toml or --set."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import msgspec
from msgspec import inspect as types

from hullrecon.errors import UsageError


@contextmanager
def name_overrides(step_sections: Mapping[str, type[msgspec.Struct]], overrides: Sequence[str]) -> Iterator[None]:
    """Rewrite the UsageErrors of `load_config`: choices are listed, and a value given by --set is not blamed on dive.toml."""
    try:
        yield
    except UsageError as error:
        key, equals, rest = error.what.partition(" = ")
        if not equals:
            key = error.what.removeprefix("unknown key ").removesuffix(" is missing")
        given_by_set = key in {text.partition("=")[0].strip() for text in overrides}
        choices = _choices(step_sections, key) if "invalid enum value" in rest.lower() else ()
        if not given_by_set and not choices:
            raise
        value = rest.rpartition(": ")[0]
        what = f"{key}: {value} is not one of {', '.join(choices)}" if choices else error.what
        place = "from --set" if given_by_set else error.where
        raise UsageError(what, where=place, remedy=error.remedy) from None


def _choices(step_sections: Mapping[str, type[msgspec.Struct]], key: str) -> tuple[str, ...]:
    """Return the values that the option `section.key` of a step may take, none when it is not a choice."""
    section, _, name = key.rpartition(".")
    if section not in step_sections:
        return ()
    info = types.type_info(step_sections[section])
    assert isinstance(info, types.StructType)
    kind = next((field.type for field in info.fields if field.name == name), None)
    while isinstance(kind, types.Metadata):
        kind = kind.type
    return tuple(str(value) for value in kind.values) if isinstance(kind, types.LiteralType) else ()
