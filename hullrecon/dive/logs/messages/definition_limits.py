# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Refuse definitions of message types that take hours or gigabytes to compile or decode.

A log carries its types' definitions as text, and rosbags compiles them: each element of an array of
messages becomes lines of code, each nested type a call for each message. Real definitions stay far
below these limits.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from hullrecon.dive.logs.readers.unpack import DamagedError

LONGEST_TEXT = 1 << 17  # characters; those of the types that are read here have up to 10,000
MOST_TYPES, MOST_FIELDS = 200, 2000
MOST_ELEMENTS = 1000  # of fixed arrays of messages or strings, which are compiled one by one
# elements of a fixed array of numbers: none that a chunk could hold is larger
LARGEST_ARRAY = 1 << 27
DEEPEST = 32  # types within types
LONGEST_IDL = 1 << 16  # characters
# Depth of parentheses: each more multiplies the time of the IDL parser by sixty. Annotations have 1
MOST_PARENTHESES = 1
MOST_ANGLES = 2  # depth of angle brackets: each more multiplies the time by two

# strings and comments, also those that do not end
TEXT = re.compile(r'"(?:\\.|[^"\\])*(?:"|\\?\Z)|//[^\n]*|/\*(?:.*?\*/|.*)', re.DOTALL)
BASE, NAME, ARRAY, SEQUENCE = 1, 2, 3, 4  # rosbags' kinds of fields
WIDTHS = {"string": 4, "wstring": 4}  # bytes that are there at least; one for every other base type

# A field as rosbags has it: its kind; then a type's name, (base type, bound) or (element, count)
FieldKind = tuple[int, Any]
# by the name of a type: its constants, and its fields with their names
Types = Mapping[str, tuple[Sequence[object], Sequence[tuple[str, FieldKind]]]]


def check_text(text: str) -> None:
    """Raise DamagedError for a definition's text that a parser should not see."""
    if len(text) > LONGEST_TEXT:
        raise DamagedError(f"it has {len(text)} characters")


def check_idl(text: str) -> None:
    """Raise DamagedError for IDL that the parser would not finish: nested, open or computed."""
    if len(text) > LONGEST_IDL:
        raise DamagedError(f"it has {len(text)} characters")
    code = TEXT.sub(_blank_text, text)
    for opening, closing, deepest in (("(", ")", MOST_PARENTHESES), ("<", ">", MOST_ANGLES)):
        depth = 0
        for character in code:
            depth = max(0, depth + (character == opening) - (character == closing))
            if depth > deepest:
                raise DamagedError(f"it nests {opening}{closing}")
    if "<<" in code:
        raise DamagedError("it computes its constants")


def _blank_text(match: re.Match[str]) -> str:
    """Replace a string or a comment of IDL by blanks, so that its brackets are not counted.

    Raises DamagedError where it does not end.
    """
    found = match.group()
    if found.startswith("//"):
        return " "
    end = '"' if found.startswith('"') else "*/"
    if len(found) < 2 * len(end) or not found.endswith(end):
        raise DamagedError("a string or comment of it does not end")
    return '""' if end == '"' else " "


def check_types(types: Types, name: str) -> None:
    """Raise DamagedError for types that cannot be compiled or used in reasonable time.

    These are too many types or fields, too large arrays, bounds that are no numbers, and types
    nested too deeply or around nothing.

    types: the message's type and those within it. name: of the message itself.
    """
    fields = [kind for _, members in types.values() for _, kind in members]
    if len(types) > MOST_TYPES or len(fields) > MOST_FIELDS:
        raise DamagedError(f"it has {len(types)} types with {len(fields)} fields")
    elements = 0
    for kind, inner in fields:
        _check_bounds(kind, inner)
        if kind == ARRAY:
            base, count = inner
            is_number = base[0] == BASE and base[1][0] not in WIDTHS
            if not isinstance(count, int) or not 0 <= count <= LARGEST_ARRAY:
                raise DamagedError(f"it has an array of {count} elements")
            elements += 0 if is_number else count
        if elements > MOST_ELEMENTS:
            raise DamagedError(f"it has arrays of {elements} messages")
    if name in types:
        _Sizes(types).of(name, 0)


def _check_bounds(kind: int, inner: Any) -> None:
    """Raise DamagedError for a bound that is no number.

    Constants of IDL may be text, and rosbags before 0.11.9 wrote bounds unchanged into the code
    that it runs.
    """
    bound = 0 if kind == NAME else inner[1]
    if not isinstance(bound, int | None):
        raise DamagedError("it has a bound that is no number")
    if kind in (ARRAY, SEQUENCE):
        _check_bounds(*inner[0])


class _Sizes:
    """Count the least bytes of each type and the calls to decode it. Refuse calls without bytes.

    Types that are nested around nothing cost time for each message without needing a byte of it.
    """

    def __init__(self, types: Types) -> None:
        self._types = types
        self._known: dict[str, tuple[int, int]] = {}  # bytes and calls, by type

    def of(self, name: str, depth: int) -> tuple[int, int]:
        """Count the least bytes of a type, and the calls that decode them.

        Raises DamagedError for types nested too deeply, and for calls out of proportion to bytes.

        depth: types that this one is nested in.
        """
        if depth > DEEPEST:
            raise DamagedError("its types contain each other without end")
        if name not in self._types:
            return 1, 1  # rosbags will say that it is missing
        if name not in self._known:
            parts = [self._field(kind, depth) for _, kind in self._types[name][1]]
            size, calls = sum(p[0] for p in parts), 1 + sum(p[1] for p in parts)
            # real types need a byte or more for most calls; such bytes limit a message's calls
            if calls > 16 + 8 * size:
                raise DamagedError("its types are nested around nothing")
            self._known[name] = size, calls
        return self._known[name]

    def _field(self, kind: FieldKind, depth: int) -> tuple[int, int]:
        """Count the least bytes of a field and the calls that decode it.

        One call reads a whole array of numbers, else each element takes its own.
        """
        form, inner = kind
        if form == BASE:
            return WIDTHS.get(str(inner[0]), 1), 1
        if form == NAME:
            return self.of(str(inner), depth + 1)
        element, count = inner
        size, calls = self._field(element, depth)
        if size == 0:
            raise DamagedError("it has a list of an empty type")
        if form == SEQUENCE:
            return 4, 1
        return count * size, 1 if element[0] == BASE else 1 + count * calls
