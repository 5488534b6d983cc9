# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Damage what stands in fields: numbers of every width and in digits, signatures of formats, whole
records.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Sequence
from itertools import pairwise
from random import Random

import numpy as np

# the bytes, another sound input of the format, the dice
Mutator = Callable[[bytearray, bytes, Random], bytearray]
NUMBERS = (
    float("nan"),
    float("inf"),
    float("-inf"),
    -0.0,
    0.0,
    5e-324,
    1e-30,
    1e19,
    -1e19,
    1e38,
    1e308,
    -1.0,
    2.0**63,
)
DIGITS = re.compile(rb"[+-]?[0-9]+(?:[.][0-9]*)?(?:[eE][+-]?[0-9]+)?")
WORDS = (
    b"-1",
    b"0",
    b"1",
    b"-0",
    b"4294967295",
    b"4294967296",
    b"2147483648",
    b"-2147483649",
    b"9223372036854775807",
    b"1e308",
    b"1e-320",
    b"nan",
    b"-nan",
    b"inf",
    b"-Infinity",
    b"1_000",
    b"0x7f",
    b"1e",
    b"1.",
    b".5",
    b"+1",
    b"1" + b"0" * 30,
    b"9" * 400,
    b"1d3",
    b"1,5",
    b"0b1",
    b"1j",
    b"",
)
SIGNATURES = (
    b"\x89MCAP0\r\n",
    b"\x0f" + bytes(8),
    b"\x02" + b"\xff" * 8,
    b"\x05" + bytes(8),
    b"#ROSBAG V2.0\n",
    b"\x04\0\0\0op=\x05",
    b"\x04\0\0\0op=\x02",
    b"SQLite format 3\0",
    b"PK\x03\x04",
    b"PK\x01\x02",
    b"PK\x05\x06",
    b"PK\x06\x06",
    b"\x93NUMPY\x01\0",
    b"\x93NUMPY\x03\0",
    b"\x1f\x8b\x08\0",
    b"\x28\xb5\x2f\xfd",
    b"\x04\x22\x4d\x18",
    b"BZh9",
    b"\x7f\x7f",
    b"\x7f\x79",
    b"\xff\xd8",
    b"\xff\xd9",
    b"\xff\xda",
    b"\xff\xc0\0\x11\x08",
    b"\xff\xc2",
    b"\xff\xdd\0\x04\0\x01",
    b"IHDR",
    b"IDAT",
    b"IEND",
    b"acTL",
    b"\x89PNG\r\n\x1a\n",
    b"II*\0",
    b"MM\0*",
    b"BM",
    b"P6\n",
    b"P5 999999 999999 65535\n",
    b"GIF89a",
    b"RIFF",
    b"WEBPVP8X",
    b"glTF\x02\0\0\0",
    b"JSON",
    b"BIN\0",
    b"solid ",
    b"ply\n",
    b"element vertex 4294967295\n",
    b"property list uchar int vertex_indices\n",
    b"end_header\n",
    b"format binary_big_endian 1.0\n",
    b"OFF\n",
    b"STOFF\n",
    b"endsolid\n",
    b"'descr': '|O'",
    b"'shape': (9999999999, 9999)",
    b"'fortran_order': True",
    b"'<U99999999'",
    b"\x80\x04\x95",
    b"cposix\nsystem\n",
    b"uint8[] data\n",
    b"string[<=4294967295] name\n",
    b"float64[1000000000] x\n",
    b"a/B[] next\n",
    b"MSG: a/B\n",
    b"\0" * 64,
    b"\xff" * 64,
)


def edit_records(data: bytearray, marks: Sequence[int], dice: Random) -> bytearray:
    """Cut the bytes where a record starts, or drop, repeat, move or exchange whole records. marks:
    where they start.
    """
    spans = [*pairwise([*marks, len(data)])]
    (start, end), how = dice.choice(spans), dice.randrange(5)
    record = data[start:end]
    if how == 0:
        return data[:start]
    if how == 1:
        del data[start:end]
    elif how == 2:
        data[start:start] = record * dice.choice(
            (1, 1, 2, min(300, 1 + 50_000 // (len(record) or 1)))
        )
    else:
        other_start, other_end = dice.choice(spans)
        if how == 3:
            data[other_start:other_start] = record
        elif end <= other_start:
            data[start:other_end] = data[other_start:other_end] + data[end:other_start] + record
    return data


def _set_integer(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Set a field to a number at the border of its width: largest, least, minus one, a power of
    two.
    """
    width, order = dice.choice((1, 2, 4, 8)), dice.choice(("little", "little", "big"))
    at = dice.randrange(max(1, len(data) - width + 1))
    value = dice.choice(
        (-1, 0, 1, -(1 << 8 * width - 1), (1 << 8 * width - 1) - 1, 1 << dice.randrange(8 * width))
    )
    data[at : at + width] = (value % (1 << 8 * width)).to_bytes(width, order)
    return data


def set_float(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Set a field that looks like a sensor's float to a number that no sensor gives."""
    width = dice.choice((4, 8))
    shift = dice.randrange(width)
    if len(data) < width + shift:
        return data
    values = np.frombuffer(bytes(data), f"<f{width}", (len(data) - shift) // width, shift)
    with np.errstate(invalid="ignore"):
        found = np.flatnonzero((np.abs(values) > 1e-6) & (np.abs(values) < 1e10))
    k = int(found[dice.randrange(len(found))]) if len(found) else dice.randrange(len(values))
    number = dice.choice(NUMBERS)
    number = number if width == 8 or not 1e39 < abs(number) < float("inf") else 3e38
    data[shift + k * width : shift + (k + 1) * width] = struct.pack(
        "<f" if width == 4 else "<d", number
    )
    return data


def _swap_fields(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Let two neighbouring fields of one width change places."""
    width = dice.choice((1, 2, 4, 8))
    if len(data) >= 2 * width:
        at = dice.randrange(len(data) - 2 * width + 1)
        data[at : at + 2 * width] = data[at + width : at + 2 * width] + data[at : at + width]
    return data


def _change_digits(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Change a number that is written in digits, in headers of binary files too."""
    found = list(DIGITS.finditer(data, 0, 50_000))
    if found:
        start, end = (dice.choice(found[:40]) if dice.random() < 0.4 else dice.choice(found)).span()
        old = bytes(data[start:end])
        new = dice.choice(
            (*WORDS, b"-" + old, old + b"0" * dice.choice((1, 3, 9, 40)), old[1:], old + old)
        )
        data[start:end] = new.rjust(len(old), b"0")[: len(old)] if dice.random() < 0.3 else new
    return data


def _write_signature(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Write what a format begins with, or its parts, over the bytes or between them."""
    word = dice.choice(SIGNATURES)
    at = 0 if dice.random() < 0.1 else dice.randrange(len(data) + 1)
    data[at : at + (len(word) if dice.random() < 0.6 else 0)] = word
    return data


FIELDS: list[Mutator] = [_set_integer, set_float, _swap_fields, _change_digits, _write_signature]
