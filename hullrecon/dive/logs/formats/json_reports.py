# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Lines of a text file, each a JSON object for itself: what is wrong with one line costs that line."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import BinaryIO

from hullrecon.dive.logs.readers.unpack import DamagedError

LONGEST_LINE = 1 << 16  # bytes; a report of four beams has 1,100
LARGEST = 10**18  # microseconds since 1970 have sixteen digits
Report = Mapping[str, object]


def read_reports(stream: BinaryIO) -> Iterator[tuple[int, Report | None]]:
    """Yield line numbers and objects; None for a line that is too long or holds none. Blank lines
    are passed over.
    """
    number = 0
    while line := stream.readline(LONGEST_LINE):
        number += 1
        whole = len(line) < LONGEST_LINE or line.endswith(b"\n")
        while not whole and (piece := stream.readline(LONGEST_LINE)):
            whole = piece.endswith(b"\n")
            line = b""  # too long to be kept
        if line.strip():
            yield number, _parse(line)
        elif not line:
            yield number, None


def number_of(report: Report, key: str) -> float:
    """Return a finite number of a report. Raises DamagedError where there is none."""
    value = report.get(key)
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not -LARGEST <= value <= LARGEST
    ):
        raise DamagedError(f"{key} is no number")
    return float(value)


def _parse(line: bytes) -> Report | None:
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None
