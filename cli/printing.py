# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Print names from other people's files without the control codes that a terminal would execute."""

from __future__ import annotations

import io
import re
import sys

# Control characters but tab and line feed; those of C1, which some terminals obey; what turns the
# direction of writing; bytes of file names that are no UTF-8.
_UNPRINTABLE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)


def printable(text: str) -> str:
    r"""Replace control codes by escapes such as `\u001b`. JSON keeps its meaning."""
    return _UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def write_out_what_cannot_be_encoded() -> None:
    """Let standard output and error print characters that their encoding lacks as escapes."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
