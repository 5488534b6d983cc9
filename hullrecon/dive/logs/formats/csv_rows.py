# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rows of a CSV with a header. An error in a line costs that line alone."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import TextIO

from hullrecon.dive.files import marked_coding
from hullrecon.dive.logs.readers.file_log import require_regular_file, unreadable
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.errors import InputError

LONGEST_LINE = 1 << 16  # characters
MOST_COLUMNS = 512
ENDS = ("\n", "\r")
SEPARATORS = ",;\t"
HEADER_WITHIN = 50  # first lines in which the header is sought; loggers write remarks above it
TIMES = ("time", "timestamp", "datetime")  # other names of column t
SHOWN = 60  # characters of a line that is no header
# as spreadsheets write numbers where the comma does not separate cells
DECIMAL_COMMA = re.compile(r"\s*[-+]?\d+,\d+(e[-+]?\d+)?\s*", re.IGNORECASE)

Row = Mapping[str, str]  # cells by column; those that a short line lacks are empty


def read_rows(path: Path, needed: Sequence[str]) -> Iterator[tuple[int, Row | None]]:
    """Yield line numbers and rows. None in place of a line that is too long or no CSV.

    Cells are separated as those of the header, by commas, semicolons or tabs. Names of columns are
    made lower case. Blank lines and those above the header are skipped. A further header holds for
    the rows below it.

    Parameters
    ----------
    path : the table's file
    needed : columns that every row needs

    Raises
    ------
    InputError
        The file cannot be read, a needed column is not in the header, or rows have so many cells
        that the decimal commas of their numbers must separate cells too.
    """
    try:
        require_regular_file(path)
        with path.open(encoding=_encoding(path), errors="replace", newline="") as stream:
            lines = enumerate(_lines(stream), 1)
            header, separator = _find_header(path, lines, needed)
            for number, line in lines:
                cells = _cells(line, separator)
                _refuse_decimal_commas(path, number, cells, header, separator)
                names = _names(cells)
                if set(needed) <= set(names):  # once more, where tables were pasted together
                    _check_header(path, names, needed)
                    header = names
                    continue
                if cells is None or (
                    line is not None and 0 < len(cells) < len(header) and not line.endswith(ENDS)
                ):
                    yield number, None  # too long, no CSV, or the last one and cut off
                elif cells:
                    yield number, dict(zip_longest(header, cells[: len(header)], fillvalue=""))
    except OSError as error:
        raise unreadable(path, error) from None


def _encoding(path: Path) -> str:
    """Tell UTF-16, which spreadsheets write as "Unicode text", by its first bytes from UTF-8."""
    with path.open("rb") as stream:
        start = stream.read(2)
    return marked_coding(start) or "utf-8-sig"


def _find_header(
    path: Path, lines: Iterator[tuple[int, str | None]], needed: Sequence[str]
) -> tuple[list[str], str]:
    """Find the line that names the needed columns: its cells, and the separator.

    Raises InputError where none of the first HEADER_WITHIN lines does.
    """
    first, missing = "", list(needed)
    for number, line in lines:
        for separator in SEPARATORS:
            header = _names(_cells(line, separator))
            lacking = [name for name in needed if name not in header]
            if not lacking:
                _check_header(path, header, needed)
                return header, separator
            if not first and len(lacking) < len(missing):
                missing = lacking
        first = first or (line or "").strip()
        if number == HEADER_WITHIN:
            break
    begins = f": it begins with {printable(first, SHOWN)!r}" if first else ""
    raise InputError(
        f"{path.name} has no column {', '.join(missing)}{begins}",
        where=printable(str(path.parent)),
        remedy=f"its header row needs {', '.join(needed)}, with commas, semicolons or tabs between",
    )


def _names(cells: Sequence[str] | None) -> list[str]:
    """Make names of columns of a row. Where none is t, the first of TIMES is."""
    names = [cell.strip().lower() for cell in cells or []]
    stamp = next((name for name in TIMES if name in names), "t")
    return names if "t" in names else ["t" if name == stamp else name for name in names]


def _refuse_decimal_commas(
    path: Path, number: int, cells: Sequence[str] | None, header: Sequence[str], separator: str
) -> None:
    """Raise InputError for a row that has more than 1.5 times as many cells as the header.

    Where commas separate cells and are decimal points as well, each number falls into two cells.
    Rows with long remarks are accepted: more cells than the header has must hold digits.
    """
    if separator != "," or cells is None or 2 * len(cells) <= 3 * len(header):
        return
    if sum(any(c.isdigit() for c in cell) for cell in cells) <= len(header):
        return
    raise InputError(
        f"line {number} of {path.name} has {len(cells)} cells, its header {len(header)}: commas "
        "stand in its numbers and between them",
        where=printable(str(path.parent)),
        remedy="write the table with semicolons or tabs between, or with decimal points",
    )


def _check_header(path: Path, header: Sequence[str], needed: Sequence[str]) -> None:
    """Raise InputError for too many columns, or for a needed one that is there twice."""
    where = printable(str(path.parent))
    if len(header) > MOST_COLUMNS:
        raise InputError(
            f"{path.name} has {len(header)} columns",
            where=where,
            remedy=f"keep {', '.join(needed)} and few more",
        )
    twice = [name for name in needed if header.count(name) > 1]
    if twice:
        raise InputError(
            f"{path.name} has the column {twice[0]} {header.count(twice[0])} times",
            where=where,
            remedy="give each column a name of its own",
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


def _cells(line: str | None, separator: str) -> list[str] | None:
    """Split one line into cells, with decimal points. None where it is no CSV.

    A quote that is not closed ends with the line, so that it does not swallow those below.
    """
    if line is None:
        return None
    try:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:
        return None
    if separator == ",":
        return cells
    return [c.replace(",", ".") if DECIMAL_COMMA.fullmatch(c) else c for c in cells]
