# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Damage text: tokens, numbers, lines, columns, nesting, and the way in which it is encoded."""

from __future__ import annotations

import re
from random import Random

from benchmarks.fuzz.field_mutators import Mutator

TOKEN = re.compile(rb"[A-Za-z0-9_.+-]+|[^\sA-Za-z0-9_.+-]")
TOKENS = (
    b"",
    b"-1",
    b"0",
    b"nan",
    b"inf",
    b"-inf",
    b"1e308",
    b"1e999",
    b"-0.0",
    b"9223372036854775808",
    b"9" * 40,
    b"1" * 10_000,
    b"0x" + b"f" * 6_000,
    b"[" * 900,
    b"{" * 900,
    b"a." * 900 + b"a",
    b"[[1]]",
    b"true",
    b"'''",
    b'"',
    b'"""',
    b"\\u0000",
    b"\0",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\x1b[31m",
    b"&a [*a]",
    b"&a [1, 1]",
    b"*a",
    b"<<: *a",
    b"!!python/object:x y",
    b"- - -",
    b"? ",
    b"1979-05-27T07:32:00Z",
    b"1/2/3",
    b"x" * 5_000,
    b"\n",
    b",,,,",
    b"\r",
    b"/dev/null",
    b"..",
    b"\xc3\xa9",
    b"\xe2\x80\xa8",
)
SEPARATORS = (b",", b";", b"\t", b" ", b"\n")
LONGEST = 200_000  # bytes of a text that is to be made longer


def _replace_token(data: bytearray, other: bytes, dice: Random) -> bytearray:
    found = list(TOKEN.finditer(data))
    if found:
        start, end = dice.choice(found).span()
        data[start:end] = dice.choice(TOKENS)
    return data


def _swap_tokens(data: bytearray, other: bytes, dice: Random) -> bytearray:
    found = list(TOKEN.finditer(data))
    if found:
        (start, end), source = dice.choice(found).span(), dice.choice(found).span()
        data[start:end] = data[slice(*source)]
    return data


def _drop_or_double_line(data: bytearray, other: bytes, dice: Random) -> bytearray:
    lines = data.splitlines(keepends=True)
    if lines:
        k = dice.randrange(len(lines))
        lines[k : k + 1] = [lines[k]] * dice.choice((0, 0, 2, 300))
    return bytearray(b"".join(lines))


def _shorten_line(data: bytearray, other: bytes, dice: Random) -> bytearray:
    lines = data.splitlines(keepends=True)
    if lines:
        k = dice.randrange(len(lines))
        words = lines[k].split()
        lines[k] = bytearray(b" ".join(words[: dice.randrange(len(words) + 1)])) + b"\n"
    return bytearray(b"".join(lines))


def _swap_columns(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Let two columns change places in all lines or in some, or give one away."""
    separator = dice.choice(SEPARATORS[:4])
    rows = [line.split(separator) for line in bytes(data).split(b"\n")]
    a, b, share = dice.randrange(8), dice.randrange(8), dice.choice((1.0, 1.0, 0.3))
    for row in rows:
        if max(a, b) < len(row) and dice.random() <= share:
            row[a], row[b] = row[b], row[a]
            if a == b:
                del row[a]
    return bytearray(b"\n".join(separator.join(row) for row in rows))


def _shuffle_lines(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Move a block of lines elsewhere, or write it a second time there: a section that stands
    twice.
    """
    lines = data.splitlines(keepends=True)
    start = dice.randrange(len(lines) or 1)
    block = lines[start : start + 1 + dice.randrange(5)]
    if dice.random() < 0.5:
        del lines[start : start + len(block)]
    at = dice.randrange(len(lines) + 1)
    return bytearray(b"".join([*lines[:at], *block, *lines[at:]]))


def encode_otherwise(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Write the text with other line ends, a byte order mark, in UTF-16 or UTF-32, or with
    characters that are not ASCII.
    """
    text = bytes(data).decode("latin-1")
    how = dice.randrange(8)
    if how == 0:
        return bytearray(b"\xef\xbb\xbf" + data)
    if how == 1:
        return bytearray(
            data.replace(b"\n", dice.choice((b"\r\n", b"\r", b"\n\r", b"\x0b", b"\x85", b"\0")))
        )
    if how == 2:
        return bytearray(
            text.encode(dice.choice(("utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-7")))
        )
    if how == 3:
        return bytearray(text.replace(" ", dice.choice("\u00a0\u2003\u200b\t\u3000")).encode())
    if how == 4:
        return bytearray(text.replace("-", "\u2212").replace('"', "\u201c").encode())
    if how == 5:
        return bytearray(data.translate(bytes.maketrans(b".,", b",.")))
    if how == 6:
        # Arabic, Devanagari, wide: int() and float() take them
        digits = dice.choice((0x0660, 0x0966, 0xFF10))
        return bytearray(text.translate({48 + k: chr(digits + k) for k in range(10)}).encode())
    return bytearray(data.upper() if dice.random() < 0.5 else data.swapcase())


def _nest(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Put brackets around a token, many times."""
    found = list(TOKEN.finditer(data))
    if found:
        start, end = dice.choice(found).span()
        opening, closing = dice.choice(
            (
                (b"[", b"]"),
                (b"{a = ", b"}"),
                (b"{a: ", b"}"),
                (b"(", b")"),
                (b"- ", b""),
                (b"!!str ", b""),
            )
        )
        times = dice.choice((1, 2, 30, 900, 20_000))
        data[start:end] = opening * times + data[start:end] + closing * times
    return data


def _lengthen(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Repeat a token or a line so often that it is longer than any buffer."""
    found = list(TOKEN.finditer(data))
    if found:
        start, end = dice.choice(found).span()
        times = min(dice.choice((3, 300, 70_000)), LONGEST // (end - start))
        data[start:end] = dice.choice((b"", b"", b" ", b",")).join([bytes(data[start:end])] * times)
    return data


def _set_separator(data: bytearray, other: bytes, dice: Random) -> bytearray:
    """Write another separator, a quote or a comment sign between two tokens."""
    found = list(TOKEN.finditer(data))
    if found:
        at = dice.choice(found).start()
        data[at:at] = dice.choice(
            (*SEPARATORS, b'"', b"'", b"#", b"=", b":", b"\\", b"%", b"//", b"\x00")
        )
    return data


TEXT: list[Mutator] = [
    _replace_token,
    _replace_token,
    _replace_token,
    _swap_tokens,
    _swap_tokens,
    _drop_or_double_line,
    _shorten_line,
    _swap_columns,
    _shuffle_lines,
    encode_otherwise,
    _nest,
    _lengthen,
    _set_separator,
]
