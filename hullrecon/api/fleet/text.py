# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Show names and messages that others wrote: one line on a terminal, valid UTF-8 in JSON."""

from __future__ import annotations

import os


def one_line(text: str) -> str:
    r"""Return the text with every character that is not printable, a line's end or an escape
    sequence, as \n or \x1b.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def as_utf8(path: str | os.PathLike[str]) -> str:
    r"""Return a path as text that can be encoded; bytes that are not UTF-8 stand as \xNN."""
    return os.fsencode(path).decode(errors="backslashreplace")
