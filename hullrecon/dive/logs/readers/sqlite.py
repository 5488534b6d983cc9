# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The .db3 files of rosbag2, row by row, with the write-ahead log of an unfinished recording."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

from hullrecon.dive.logs.formats.db3_tables import READ_ERRORS, Database, describe_damage
from hullrecon.dive.logs.readers.file_log import FileLog, require_regular_file
from hullrecon.dive.logs.readers.protocol import Message
from hullrecon.dive.logs.readers.scratch import scratch_folder, space_errors
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding

MAGIC = b"SQLite format 3\0"


class SqliteLog(FileLog):
    """Reads a database. It has no checksums: damage shows where SQLite cannot follow its pages."""

    kind = "ROS 2 database"

    def _read(self) -> Iterator[Message]:
        """Yield the messages of the database, merged with its write-ahead log if there is one.

        Raises InputError for a database that SQLite cannot open at all, or that is none of rosbag2.
        """
        with ExitStack() as stack:
            merged = self._copy_with_log(stack)
            address = (
                f"{self._whole_pages(stack).absolute().as_uri()}?mode=ro&immutable=1"
                if merged is None
                else merged.as_uri()
            )
            size = self.path.stat().st_size + (
                write_ahead_log(self.path).stat().st_size if merged else 0
            )
            try:
                database = Database(address, size)
                stack.enter_context(closing(database.connection))
                yield from self._messages(database)
            except READ_ERRORS as error:
                name, where = printable(self.path.name), printable(str(self.path.parent))
                raise InputError(
                    f"{name} cannot be read: {printable(str(error), 200)}", where=where
                ) from None
            missing = bytes_missing(self.path) if merged is None else 0
        if missing > 0:
            self._tracker.open_gap(
                f"the database is cut off: {missing} bytes of its pages are missing"
            )
        if self.path.with_name(f"{self.path.name}-journal").is_file():
            self.notes.append(Finding("database-journal"))
        self.notes.append(Finding("database-no-checksum"))
        self._tracker.finish()

    def _messages(self, database: Database) -> Iterator[Message]:
        """Read the rows of the database as messages. Rows that are none are dropped and counted."""
        channels = database.channels()
        strange = foreign = 0
        for number, t_ns, data in database.rows(self._tracker.open_gap):
            if not (isinstance(number, int) and isinstance(t_ns, int) and isinstance(data, bytes)):
                strange += 1
            elif number not in channels:
                foreign += 1
            else:
                yield self._tracker.record(Message(channels[number], t_ns, data))
        self._tracker.count_lost(
            "their rows hold other things than a topic, a time and bytes", strange
        )
        self._tracker.count_lost("they belong to no topic of the database", foreign)
        if database.skipped:
            self.notes.append(Finding("database-rows-missing", {"count": database.skipped}))

    def _whole_pages(self, stack: ExitStack) -> Path:
        """Name a file with the whole pages of the database: a copy where the last one is cut off.

        SQLite would read zeros for what is missing of a page, as values of the last messages.
        """
        size, page = self.path.stat().st_size, page_bytes(self.path)
        if not page or size % page == 0:
            return self.path
        folder = scratch_folder()
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        with space_errors(folder, stack.close):
            copy = Path(shutil.copyfile(self.path, folder / "log.db3"))
            os.truncate(copy, size - size % page)
        return copy

    def _copy_with_log(self, stack: ExitStack) -> Path | None:
        """Copy database and write-ahead log for SQLite to merge. None without such a log.

        A log that cannot be read, or is damaged, becomes a loss. The former is left out.
        SQLite reads a write-ahead log only where it may write beside it, and the package is not
        written to.
        """
        log = write_ahead_log(self.path)
        try:
            if not log.exists() or (log.is_file() and not log.stat().st_size):
                return None
            require_regular_file(log)
            damage = describe_damage(log)
            folder = scratch_folder()
            stack.callback(shutil.rmtree, folder, ignore_errors=True)
            with space_errors(folder, stack.close):
                copy = Path(shutil.copyfile(self.path, folder / "log.db3"))
                shutil.copyfile(log, write_ahead_log(copy))
        except (OSError, InputError) as error:
            self._tracker.add_loss(
                f"the write-ahead log beside the database cannot be read: {error}", 0, 0
            )
            return None
        if damage:
            self._tracker.add_loss(
                f"the write-ahead log beside the database is not whole: {damage}", 0, 0
            )
        self.notes.append(Finding("database-wal"))
        return copy


def write_ahead_log(path: Path) -> Path:
    """Name the path of a database's write-ahead log."""
    return path.with_name(f"{path.name}-wal")


def page_bytes(path: Path) -> int:
    """Read the size of a database's pages from its header. 0 where that is cut off or damaged."""
    with path.open("rb") as stream:
        size = int.from_bytes(stream.read(18)[16:], "big")
    return 65536 if size == 1 else size


def bytes_missing(path: Path) -> int:
    """Count the bytes by which a file is shorter than its header says."""
    with path.open("rb") as stream:
        pages = int.from_bytes(stream.read(32)[28:], "big")
    return page_bytes(path) * pages - path.stat().st_size
