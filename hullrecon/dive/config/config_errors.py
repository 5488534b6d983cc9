# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Explain msgspec's errors in a configuration by the key, its value and the nearest known key."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import date
from typing import get_args, get_origin, get_type_hints

import msgspec
from msgspec import Struct

from hullrecon.errors import UsageError

ONE_LINE = (
    # a pattern of the schema: what reaches a terminal, a path or a report's line
    r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]*\Z"
)
NAME = r"^[A-Za-z0-9_][A-Za-z0-9._-]*\Z"  # a pattern of the schema: a folder's name anywhere
# What is expected of a text, by the pattern of the schema that it has to match
PATTERNS = {
    ONE_LINE: "text on one line, without control characters",
    NAME: "letters A to Z, digits and _, and behind the first also . and -",
}
LONGEST_SHOWN = 60  # characters of a foreign value in a message
LONGEST_REASON = 200  # characters of what a parser says
TYPES = {  # names of types in msgspec's messages, and the words for them
    "float": "a number",
    "int": "a whole number",
    "str": "text",
    "bool": "true or false",
    "array": "a list",
}
# Keys that were removed without a successor, and what is done instead
GONE = dict.fromkeys(
    ("matches.across", "matches.revisits"),
    "images are compared across legs for what each comparison would tell of the path",
)
DEEPEST = 30  # tables and lists within each other; the schema has five


def explain_error(
    message: str, raw: object, kind: type, prefix: str, more: Sequence[str], file: str
) -> UsageError:
    """Convert msgspec's message about a wrong key or value to a UsageError in words.

    Parameters
    ----------
    message : what msgspec says: what is wrong, and the path of the key in the table
    raw : the tables and values that could not be decoded
    kind : the struct that they were to be decoded to
    prefix : dotted name of the table in the file
    more : further known keys of the top level, to suggest them too
    file : name of the file that holds the keys, for the error
    """
    text, _, at = message.partition(" - at `")
    path = re.findall(r"[^.\[\]]+|\[\d+\]", at.rstrip("`").removeprefix("$").lstrip("."))
    dotted = _join([prefix, *path])
    unknown = re.search(r"unknown field `(.*)`", text)
    if unknown:
        return _unknown_key(unknown[1], dotted, kind, prefix, more, file)
    missing = re.search(r"missing required field `(.*)`", text)
    if missing:
        return UsageError(
            f"{_join([dotted, missing[1]])} is missing",
            where=file,
            remedy="this key has no default",
        )
    wanted = (
        text.replace("`", "")
        .replace("Expected", "expected")
        .replace("Object", "table")
        .replace("object", "table")
    )
    for name, word in TYPES.items():
        wanted = re.sub(rf"\b{name}\b", word, wanted)
    if text.startswith("Invalid enum value"):
        wanted = f"expected {_values_of(kind, path)}"
    wanted = wanted.replace(" | null", "").replace(" | ", " or ")  # TOML has no null
    if text == "Invalid RFC3339 encoded datetime" or text.startswith("Expected `datetime"):
        wanted = "expected a date and time such as 2026-05-04T09:30:00Z"
    for pattern, words in PATTERNS.items():
        if text.endswith(f"matching regex {pattern!r}"):
            wanted = f"expected {words}"
    shown = show_value(_look_up(raw, path))
    return UsageError(
        f"{shorten(dotted) or 'the file'} = {shown}: {shorten(wanted, LONGEST_REASON)}", where=file
    )


def refuse_not_finite(raw: object, file: str, path: str = "") -> None:
    """Raise UsageError for nan and inf, which TOML allows and no key of dive.toml does."""
    if isinstance(raw, float) and not math.isfinite(raw):
        raise UsageError(f"{path} = {raw}: expected a finite number", where=file)
    members = (
        raw.items() if isinstance(raw, dict) else enumerate(raw) if isinstance(raw, list) else ()
    )
    for key, value in members:
        refuse_not_finite(
            value, file, f"{path}[{key}]" if isinstance(raw, list) else _join([path, str(key)])
        )


def refuse_deep(raw: object, file: str) -> None:
    """Raise UsageError for tables and lists that lie deeper within each other than DEEPEST."""
    level = [raw]
    for _ in range(DEEPEST):
        level = [member for table in level for member in _members(table)]
        if not level:
            return
    raise UsageError(f"{file} is not valid: its values are nested too deeply", where=file)


def _members(table: object) -> Iterable[object]:
    """List the values in a table or list. Empty for anything else."""
    return (
        table.values() if isinstance(table, Mapping) else table if isinstance(table, list) else ()
    )


def known_keys(kind: type, prefix: str = "") -> Iterator[str]:
    """Yield every dotted key of a struct, its sections included, to suggest one for a wrong key."""
    for field in msgspec.structs.fields(kind):
        dotted = _join([prefix, field.encode_name])
        yield dotted
        for part in _structs_in(field.type):
            yield from known_keys(part, dotted)


def _values_of(kind: type, path: Sequence[str]) -> str:
    """List the texts that a key may have.

    kind: the struct of the outermost table. path: names of the tables in it, and of the key.
    """
    found: object = kind
    for name in path:
        hints = get_type_hints(_struct_of(found)) if not name.startswith("[") else {}
        found = hints.get(name, found)
    texts = [f'"{value}"' for value in _literals(found)]
    lists = ["a list of numbers"] if _has_list(found) else []
    return " or ".join([*lists, *texts]) or "another value"


def _has_list(kind: object) -> bool:
    """Tell whether a type has a list of numbers among its alternatives."""
    return get_origin(kind) in (tuple, list) or any(_has_list(part) for part in get_args(kind))


def _struct_of(kind: object) -> type:
    """Take the first struct in a type, else one without keys."""
    return next(_structs_in(kind), Struct)


def _literals(kind: object) -> Iterator[str]:
    """Yield the texts of the literals in a type."""
    for part in get_args(kind):
        if isinstance(part, str):
            yield part
        else:
            yield from _literals(part)


def _structs_in(kind: object) -> Iterator[type[Struct]]:
    """Yield the structs in a type: the type itself, an optional one, or those of a list."""
    if isinstance(kind, type) and issubclass(kind, Struct):
        yield kind
    for part in get_args(kind):
        yield from _structs_in(part)


def _unknown_key(
    key: str, section: str, kind: type, prefix: str, more: Sequence[str], file: str
) -> UsageError:
    """Make the error for a key that was removed or is unknown, with the nearest known one.

    The nearest key is sought in the same section first, then by its last name in all sections.

    Parameters
    ----------
    key, section : the unknown key, and the dotted name of its table
    kind, prefix, more, file : as of explain_error
    """
    dotted = _join([section, key])
    if dotted in GONE:
        return UsageError(
            f"the key {dotted} is gone: {GONE[dotted]}", where=file, remedy="delete it"
        )
    known = [*known_keys(kind, prefix), *more]
    section = re.sub(r"\[\d+\]", "", section)  # of a table in a list
    alike = _join([section, key])[:200]
    beside = [name for name in known if name.rpartition(".")[0] == section]
    nearest = [name for name in beside if name.startswith(alike)] or difflib.get_close_matches(
        alike, beside, n=1, cutoff=0.75
    )
    nearest = (
        nearest
        or _same_last_name(key, known)
        or difflib.get_close_matches(alike, beside or known, n=1, cutoff=0.0)
    )
    dotted = dotted[:200]
    return UsageError(
        f"unknown key {shorten(dotted)}",
        where=file,
        remedy=f"the nearest known key is {nearest[0]}" if nearest else "",
    )


def _same_last_name(key: str, known: Sequence[str]) -> list[str]:
    """Find a known key with the same last name in any section."""
    return [name for name in known if name.rpartition(".")[2] == key][:1]


def _join(parts: Sequence[str]) -> str:
    """Join names to a dotted key. The place in a list, such as [0], follows without a dot."""
    return re.sub(r"\.(?=\[)", "", ".".join(part for part in parts if part and part != "$"))


def _look_up(raw: object, path: Sequence[str]) -> object:
    """Look up a value by the names and [numbers] that lead to it. "?" where a name is missing."""
    for part in path:
        if part.startswith("[") and isinstance(raw, list):
            raw = raw[int(part[1:-1])]
        elif isinstance(raw, Mapping):
            raw = raw.get(part, "?")
    return raw


def show_value(value: object) -> str:
    """Format an untrusted value for a message."""
    if isinstance(value, date):
        return value.isoformat()
    try:
        return "a table" if isinstance(value, Mapping) else shorten(repr(value))
    except ValueError:  # Python prints no whole number of more than some thousand digits
        return "a number of thousands of digits"


def shorten(text: str, longest: int = LONGEST_SHOWN) -> str:
    """Shorten untrusted text for a message, escaping control characters and line breaks."""
    cut = text if len(text) < longest else text[: longest - 3] + "..."
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in cut)
