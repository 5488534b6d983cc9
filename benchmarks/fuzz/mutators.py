# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Damage bytes: bits, bytes, cuts, length fields, splices, insertions, duplications; fields,
records and text besides.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

import numpy as np

from benchmarks.fuzz.field_mutators import FIELDS, Mutator, edit_records
from benchmarks.fuzz.text_mutators import TEXT

SIZES = (
    0,
    1,
    2,
    0x7F,
    0x80,
    0xFF,
    0x7FFF,
    0xFFFF,
    0x7FFFFFFF,
    0x80000000,
    0xFFFFFFFF,
    1 << 40,
    1 << 62,
    (1 << 63) - 1,
    (1 << 64) - 1,
)
BYTES = bytes((0, 1, 2, 6, 0x0F, 0x20, 0x7F, 0x80, 0xFF))


def mutate(
    data: bytes, other: bytes, dice: Random, *, text: bool, marks: Sequence[int] = ()
) -> bytes:
    """Return the bytes with one to four damages.

    other: a sound input of the same format, for splices. text: the bytes are lines of tokens.
    marks: offsets where records start, which are damaged at times before all else.
    """
    out = bytearray(data)
    if marks and dice.random() < 0.3:
        if dice.random() < 0.4:
            out = edit_records(out, marks, dice)
        else:
            at = dice.choice(marks) + int(dice.expovariate(0.5))
            out = _at_mark(out, min(at, len(out) - 1), dice)
        if dice.random() < 0.5:
            return bytes(out)
    choices = [*BINARY, *FIELDS, *TEXT, *TEXT] if text else [*BINARY, *FIELDS]
    for _ in range(1 + min(3, int(dice.expovariate(1.2)))):
        out = dice.choice(choices)(out, other, dice)
    return bytes(out)


def _at_mark(data: bytearray, at: int, dice: Random) -> bytearray:
    how = dice.randrange(4)
    if how == 0:
        data[at] ^= 1 << dice.randrange(8)
    elif how == 1:
        data[at] = dice.choice(BYTES)
    elif how == 2:
        data[at:at] = dice.choice((b"\x02", b"\x0f", b"\0", b"\x06", bytes(9)))
    else:
        del data[at : at + dice.choice((1, 4, 9))]
    return data


def _place(data: bytearray, dice: Random) -> int:
    """Return an offset, often near the start, where headers lie, or the end, where closing records
    do.
    """
    where = dice.random()
    if where < 0.2:
        return dice.randrange(min(len(data), 64) or 1)
    if where < 0.35:
        return max(0, len(data) - 1 - dice.randrange(min(len(data), 256) or 1))
    return dice.randrange(len(data) or 1)


def _flip_bit(data: bytearray, other: bytes, dice: Random) -> bytearray:
    if data:
        data[_place(data, dice)] ^= 1 << dice.randrange(8)
    return data


def _set_byte(data: bytearray, other: bytes, dice: Random) -> bytearray:
    if data:
        data[_place(data, dice)] = (
            dice.choice(BYTES) if dice.random() < 0.5 else dice.randrange(256)
        )
    return data


def _set_run(data: bytearray, other: bytes, dice: Random) -> bytearray:
    at, length = _place(data, dice), dice.choice((2, 8, 64, 512))
    length = min(length, len(data) - at)
    data[at : at + length] = (
        dice.randbytes(length) if dice.random() < 0.5 else bytes([dice.choice(BYTES)]) * length
    )
    return data


def _cut_end(data: bytearray, other: bytes, dice: Random) -> bytearray:
    return data[: _place(data, dice)]


def _cut_out(data: bytearray, other: bytes, dice: Random) -> bytearray:
    at = _place(data, dice)
    del data[at : at + _length(data, dice)]
    return data


def _insert(data: bytearray, other: bytes, dice: Random) -> bytearray:
    at = _place(data, dice)
    data[at:at] = dice.randbytes(dice.choice((1, 1, 2, 4, 16, 300)))
    return data


def _insert_zeros(data: bytearray, other: bytes, dice: Random) -> bytearray:
    at = _place(data, dice)
    data[at:at] = bytes(dice.choice((1, 4, 512, 4096)))
    return data


def _splice(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Put a part of another input over or between."""
    at, start = _place(data, dice), dice.randrange(len(other) or 1)
    part = other[start : start + _length(other, dice)]
    data[at : at + (len(part) if dice.random() < 0.5 else 0)] = part
    return data


def _go_on_with(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Begin as one input, end as another."""
    return data[: _place(data, dice)] + other[dice.randrange(len(other) or 1) :]


def _duplicate(data: bytearray, other: bytes, dice: Random) -> bytearray:
    at = _place(data, dice)
    part = data[at : at + _length(data, dice)]
    data[at:at] = part * (1 if dice.random() < 0.8 else min(200, 1 + 20_000 // (len(part) or 1)))
    return data


def _swap(data: bytearray, other: bytes, dice: Random) -> bytearray:
    a, b = sorted((_place(data, dice), _place(data, dice)))
    length = min(_length(data, dice), b - a, len(data) - b)
    data[a : a + length], data[b : b + length] = data[b : b + length], data[a : a + length]
    return data


def _change_length(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Change an integer that could be a length: one that is no larger than the file."""
    width, order = dice.choice((2, 4, 4, 4, 8)), dice.choice("<<<>")
    if len(data) < width:
        return data
    shift = dice.randrange(min(width, len(data) - width + 1))
    values = np.frombuffer(bytes(data), f"{order}u{width}", (len(data) - shift) // width, shift)
    found = np.flatnonzero((values > 0) & (values <= len(data)))
    k = int(found[dice.randrange(len(found))]) if len(found) else dice.randrange(len(values))
    old = int(values[k])
    new = dice.choice(
        (
            *SIZES,
            old + 1,
            old - 1,
            2 * old,
            old + 8,
            len(data),
            old ^ (1 << dice.randrange(8 * width)),
        )
    )
    at = shift + k * width
    data[at : at + width] = (new % (1 << (8 * width))).to_bytes(
        width, "little" if order == "<" else "big"
    )
    return data


def _length(data: bytes | bytearray, dice: Random) -> int:
    return min(len(data), 1 + int(dice.expovariate(1 / dice.choice((3, 40, 700)))))


BINARY: list[Mutator] = [
    _flip_bit,
    _flip_bit,
    _set_byte,
    _set_run,
    _cut_end,
    _cut_out,
    _insert,
    _insert_zeros,
    _splice,
    _go_on_with,
    _duplicate,
    _swap,
    _change_length,
    _change_length,
]
