# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The .db3 files of rosbag2, row by row; past damaged pages as far as SQLite reaches."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

from hullrecon.dive.logs.readers.loss_tracker import LossTracker
from hullrecon.dive.logs.readers.protocol import Channel, Loss, Message
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.errors import InputError

MAGIC = b"SQLite format 3\0"
BATCH = 256  # rows asked for at a time; after damage the step shrinks to one


class SqliteLog:
    """A database has no checksums: damage shows where SQLite cannot follow its pages."""

    kind = "ROS 2 database"
    gives_samples = False

    def __init__(self, path: Path) -> None:
        self.path = path
        self.remarks: list[str] = []
        self._tracker = LossTracker()

    def messages(self) -> Iterator[Message]:
        self.remarks, self._tracker = [], LossTracker()
        connection = sqlite3.connect(f"{self.path.absolute().as_uri()}?mode=ro&immutable=1", uri=True)
        try:
            channels = _channels(connection)
            for number, t_ns, data in self._rows(connection):
                if number in channels and isinstance(data, bytes):
                    yield self._tracker.record(Message(channels[number], t_ns, data))
        except (sqlite3.Error, DamagedError) as error:
            raise InputError(f"{self.path.name} cannot be read: {error}", where=str(self.path.parent)) from None
        finally:
            connection.close()
        missing = bytes_missing(self.path)
        if missing > 0:
            self._tracker.open_gap(f"the database is cut off: {missing} bytes of its pages are missing")
        self._tracker.finish()

    def losses(self) -> list[Loss]:
        return list(self._tracker.losses)

    def _rows(self, connection: sqlite3.Connection) -> Iterator[tuple[int, int, bytes]]:
        """topic, time, data by rowid. A batch that fails is asked for again row by row; a row that fails is lost."""
        at, end = _span(connection)
        step, failed = BATCH, 0
        while at <= end:
            try:
                rows = connection.execute(
                    "SELECT topic_id, timestamp, data FROM messages WHERE id >= ? AND id < ? ORDER BY id", (at, at + step)
                ).fetchall()
            except (sqlite3.Error, OverflowError, UnicodeDecodeError):
                if step > 1:
                    step = max(1, step // 16)
                    continue
                if not failed:
                    self._tracker.open_gap(f"the database is damaged from row {at} on")
                failed, at = failed + 1, at + 1
                continue
            yield from rows
            at, step = at + step, min(BATCH, step * 2)
            failed = 0 if rows else failed


def bytes_missing(path: Path) -> int:
    """How much shorter the file is than its header says."""
    with path.open("rb") as stream:
        head = stream.read(32)
    if len(head) < 32:
        return 0
    size = int.from_bytes(head[16:18], "big")
    return (65536 if size == 1 else size) * int.from_bytes(head[28:32], "big") - path.stat().st_size


def _channels(connection: sqlite3.Connection) -> dict[int, Channel]:
    definitions = {}
    tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if not {"topics", "messages"} <= tables:
        raise DamagedError("it is no rosbag2 database")
    if "message_definitions" in tables:
        rows = connection.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")
        definitions = {kind: (form, definition) for kind, form, definition in rows}
    topics = connection.execute("SELECT id, name, type, serialization_format FROM topics")
    out = {}
    for number, name, kind, encoding in topics:
        form, definition = definitions.get(kind, ("ros2msg", ""))
        out[number] = Channel(name, kind, encoding, definition, form)
    return out


def _span(connection: sqlite3.Connection) -> tuple[int, int]:
    """First and last row: the last by the damaged file's own word, or as many as its bytes could hold."""
    try:
        low, high = connection.execute("SELECT min(id), max(id) FROM messages").fetchone()
        return (low, high) if low is not None else (1, 0)
    except sqlite3.Error:
        (pages,) = connection.execute("PRAGMA page_count").fetchone()
        return 1, int(pages) * 64
