# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rows of a CSV with a header. An error in a line costs that line alone."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import TextIO

from hullrecon.dive.logs.readers.file_log import require_regular_file, unreadable
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.errors import InputError

LONGEST_LINE = 1 << 16  # characters
MOST_COLUMNS = 512
ENDS = ("\n", "\r")

Row = Mapping[str, str]  # cells by column; those that a short line lacks are empty


def read_rows(path: Path, needed: Sequence[str]) -> Iterator[tuple[int, Row | None]]:
    """Yield line numbers and rows. None for a line that is too long or no CSV.

    Blank lines are passed over. Raises InputError when the file cannot be read or a column that
    every row needs is not in the header.
    """
    try:
        require_regular_file(path)
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
            lines = _lines(stream)
            header = _cells(next(lines, "")) or []
            _check_header(path, header, needed)
            for number, line in enumerate(lines, 2):
                cells = _cells(line)
                if cells is None or (
                    line is not None and 0 < len(cells) < len(header) and not line.endswith(ENDS)
                ):
                    yield number, None  # too long, no CSV, or the last one and cut off
                elif cells:
                    yield number, dict(zip_longest(header, cells[: len(header)], fillvalue=""))
    except OSError as error:
        raise unreadable(path, error) from None


def _check_header(path: Path, header: Sequence[str], needed: Sequence[str]) -> None:
    where = printable(str(path.parent))
    missing = [name for name in needed if name not in header]
    if missing:
        raise InputError(
            f"{path.name} has no column {', '.join(missing)}",
            where=where,
            remedy=f"its header row needs {', '.join(needed)}",
        )
    if len(header) > MOST_COLUMNS:
        raise InputError(
            f"{path.name} has {len(header)} columns",
            where=where,
            remedy=f"keep {', '.join(needed)} and few more",
        )


def _lines(stream: TextIO) -> Iterator[str | None]:
    """Yield lines without zero bytes. None for a line that is too long."""
    while line := stream.readline(LONGEST_LINE):
        if len(line) < LONGEST_LINE or line.endswith(ENDS):
            yield line.replace("\0", "")
            continue
        while (piece := stream.readline(LONGEST_LINE)) and not piece.endswith(ENDS):
            pass
        yield None


def _cells(line: str | None) -> list[str] | None:
    """Split one line into cells. None where it is no CSV. An open quote ends with its line."""
    if line is None:
        return None
    try:
        return next(csv.reader([line], skipinitialspace=True), [])
    except csv.Error:
        return None
