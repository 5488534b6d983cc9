# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of a rosbag2 database, row by row past damaged pages, and its write-ahead log.

SQLite silently stops at the first damaged frame of a write-ahead log, so that the log is checked
first. Layout and checksum: sqlite.org/fileformat2.html, section 4.
"""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

from hullrecon.dive.logs.readers.protocol import Channel
from hullrecon.dive.logs.readers.unpack import LARGEST_CHUNK, DamagedError

ROWS = "SELECT rowid, topic_id, timestamp, data FROM messages WHERE rowid >= ? ORDER BY rowid"
HIGHEST = (1 << 63) - 1  # row number
NEIGHBOURS = 512  # rows behind a damaged one that are asked for one by one; then the step doubles
ROWS_A_PAGE = 64  # failures for each page of the database, after which reading stops
# Steps of SQLite's virtual machine that a statement may take: a fixed number, plus a number for
# each byte of the file. A sound row takes some ten steps and has at least 20 bytes
FREE_STEPS, STEPS_A_BYTE = 4_000_000, 20
HANDLER_STEPS = 1000  # after which SQLite calls the handler that counts them
# sqlite3 decodes its own messages strictly
READ_ERRORS = (sqlite3.Error, UnicodeDecodeError, OverflowError, DamagedError)

Row = tuple[object, object, object]  # topic, time, data
HEADER, FRAME_HEAD = 32, 24  # bytes, of a write-ahead log and of each of its frames
MAGICS = {0x377F0682: "<", 0x377F0683: ">"}  # byte order of the checksums
WORD = 0xFFFFFFFF
BLOCK = 1 << 20


class Database:
    """A connection that runs no code of the file and limits the steps of each statement."""

    def __init__(self, address: str, size: int) -> None:
        """Open a database by its SQLite URI. size: of the file, bytes, which limits a search."""
        self.connection = sqlite3.connect(address, uri=True)
        # numbers between those of the rows that were read; recorders leave none out
        self.skipped = 0
        self._size, self._steps = size, 0
        self.connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_CHUNK)
        self.connection.text_factory = lambda data: data.decode(errors="replace")
        self.connection.set_progress_handler(self._step, HANDLER_STEPS)
        # With a writable schema SQLite opens a file that is shorter than its header says, and reads
        # the pages that are there. The connection itself is read-only.
        pragmas = ("trusted_schema = OFF", "cell_size_check = ON", "mmap_size = 0")
        for pragma in (*pragmas, "writable_schema = ON"):
            self.connection.execute(f"PRAGMA {pragma}")

    def channels(self) -> dict[int, Channel]:
        """Read the topics by their number.

        Those whose name, type or format is no text are left out.

        Raises DamagedError for a database without the tables of rosbag2, or in which they are views
        or computed columns, which would run code of the file.
        """
        tables = {name: kind for _, name, kind, *_ in self.connection.execute("PRAGMA table_list")}
        for name in ("topics", "messages"):
            if tables.get(name) != "table" or self._is_computed(name):
                raise DamagedError("it is no rosbag2 database")
        definitions: dict[object, tuple[object, object]] = {}
        if tables.get("message_definitions") == "table" and not self._is_computed(
            "message_definitions"
        ):
            rows = self.connection.execute(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            )
            definitions = {kind: (form, definition) for kind, form, definition in rows}
        out = {}
        for number, name, kind, encoding in self.connection.execute(
            "SELECT id, name, type, serialization_format FROM topics"
        ):
            form, definition = definitions.get(kind, ("ros2msg", ""))
            if isinstance(number, int) and all(
                isinstance(part, str) for part in (name, kind, encoding)
            ):
                out[number] = Channel(name, kind, encoding, _text(definition), _text(form))
        return out

    def rows(self, open_gap: Callable[[str], None]) -> Iterator[Row]:
        """Yield the rows by number. Behind an unreadable row, look for the next readable one.

        The search ends after a number of failures that grows with the size of the file: a damaged
        file must not take hours. Rows behind are then lost.

        open_gap: called with the reason where rows are lost.
        """
        # Behind a bad row the next NEIGHBOURS rows are tried one by one. Where all are bad, as when
        # their page is, the step doubles until a row can be read, and the first readable row
        # before it is found by bisection.
        at = bad = self._first()
        self.skipped = max(0, at - 1) if at < HIGHEST else 0
        patience, misses, left = NEIGHBOURS + ROWS_A_PAGE * self._pages(), 0, 2 * self._size
        while patience >= 0:
            try:
                if misses > NEIGHBOURS:
                    self._probe(at)
                    at, misses = self._first_readable(bad, at), 0
                for number, *row in self.connection.execute(ROWS, (at,)):
                    if not isinstance(number, int) or number < at:
                        raise DamagedError("its pages are out of order")
                    self.skipped += number - at
                    at, misses = number + 1, 0
                    left -= len(row[2]) if isinstance(row[2], bytes | str) else 0
                    if left < 0:
                        open_gap("the database is damaged: its rows claim more bytes than it has")
                        return
                    yield row[0], row[1], row[2]
                return
            except READ_ERRORS:
                if not misses:
                    open_gap(f"the database is damaged from row {at} on")
                if at >= HIGHEST:
                    return
                misses, patience = misses + 1, patience - 1
                bad, at = at, min(at + (1 << max(0, min(misses - NEIGHBOURS, 62))), HIGHEST)

    def _probe(self, at: int) -> None:
        """Read the first row from `at` on. Raises one of READ_ERRORS where that fails."""
        self.connection.execute(f"{ROWS} LIMIT 1", (at,)).fetchall()

    def _first_readable(self, bad: int, good: int) -> int:
        """Bisect for the first readable row between an unreadable and a readable one."""
        while good - bad > 1:
            middle = (good + bad) // 2
            try:
                self._probe(middle)
                good = middle
            except READ_ERRORS:
                bad = middle
        return good

    def _first(self) -> int:
        """Find the first row's number. 1, where rosbag2 starts, if damage hides it."""
        try:
            (low,) = self.connection.execute("SELECT min(rowid) FROM messages").fetchone()
        except READ_ERRORS:
            return 1
        return low if isinstance(low, int) else HIGHEST

    def _pages(self) -> int:
        """Count the pages of the database that are there. 0 where that cannot be read.

        The header of a file that was cut off or damaged may state any number.
        """
        try:
            stated, size = (
                int(self.connection.execute(f"PRAGMA page_{what}").fetchone()[0])
                for what in ("count", "size")
            )
            return min(stated, self._size // size + 1)
        except READ_ERRORS:
            return 0

    def _is_computed(self, table: str) -> bool:
        """Tell whether a table has columns that code in the file computes."""
        return any(hidden for *_, hidden in self.connection.execute(f"PRAGMA table_xinfo({table})"))

    def _step(self) -> bool:
        """Count SQLite's steps. True ends the query: a file of its size takes fewer."""
        self._steps += HANDLER_STEPS
        return self._steps > FREE_STEPS + STEPS_A_BYTE * self._size


def _text(value: object) -> str:
    return value if isinstance(value, str) else ""


def describe_damage(path: Path) -> str:
    """Describe what SQLite will silently ignore of a write-ahead log. "" for nothing.

    Frames are checked until one has another salt or a wrong checksum. SQLite reuses the file:
    behind the frames of the last generation those of an older one may lie, which have another salt.
    They are no damage. Where the last generation's salt occurs behind the first bad frame, frames
    of it are lost.
    """
    with path.open("rb") as stream:
        header = stream.read(HEADER)
        order = MAGICS.get(int.from_bytes(header[:4], "big"))
        if len(header) < HEADER or order is None:
            return "its header is damaged"
        page = int.from_bytes(header[8:12], "big")
        sums = _checksum(header[:24], order, (0, 0))
        if (
            sums != struct.unpack(">II", header[24:])
            or not 512 <= page <= 65536
            or page & (page - 1)
        ):
            return "its header is damaged"
        count = finished = 0
        while len(frame := stream.read(FRAME_HEAD + page)) == FRAME_HEAD + page:
            found = _checksum(frame[FRAME_HEAD:], order, _checksum(frame[:8], order, sums))
            if frame[8:16] != header[16:24] or found != struct.unpack(">II", frame[16:24]):
                break
            sums, count = found, count + 1
            # the last frame of a transaction states the size of the database, others 0
            finished = count if any(frame[4:8]) else finished
        if _contains(stream, frame, header[16:24]):
            return f"it is damaged from frame {count + 1} on"
    if frame and len(frame) < FRAME_HEAD + page:
        return "it is cut off"
    return "its last transaction was not finished" if count > finished else ""


def _contains(stream: BinaryIO, start: bytes, salt: bytes) -> bool:
    """Tell whether the salt of the last generation's frames occurs in `start` or behind it."""
    while start:
        if salt in start:
            return True
        following = stream.read(BLOCK)
        start = start[-len(salt) + 1 :] + following if following else b""
    return False


def _checksum(data: bytes, order: str, sums: tuple[int, int]) -> tuple[int, int]:
    """Continue SQLite's checksum of a write-ahead log over `data`.

    order: of the bytes, "<" or ">". sums: the checksum up to there, two words.
    """
    first, second = sums
    words = iter(struct.unpack(f"{order}{len(data) // 4}I", data))
    for one, two in zip(words, words, strict=True):
        first = (first + one + second) & WORD
        second = (second + two + first) & WORD
    return first, second
