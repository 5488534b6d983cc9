# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A log file that was packed whole by zstd, as rosbag2 does in its compression mode FILE."""

from __future__ import annotations

import errno
import os
import shutil
import weakref
from collections.abc import Callable, Iterator
from pathlib import Path

from hullrecon.dive.logs.readers.file_log import require_regular_file, unreadable
from hullrecon.dive.logs.readers.protocol import Log, Loss, Message
from hullrecon.dive.logs.readers.scratch import scratch_folder, space_errors
from hullrecon.dive.logs.readers.unpack import DamagedError, UnpackBudget, printable
from hullrecon.findings.finding import Finding

SUFFIXES = (".zstd", ".zst")
BLOCK, FRAME_HEAD = 1 << 20, 18  # bytes


def unpacked_name(name: str) -> str:
    """Return the name of a file without the suffix that zstd gives, if it has one."""
    return name.removesuffix(Path(name).suffix) if Path(name).suffix.lower() in SUFFIXES else name


class PackedLog:
    """Unpacks the file into a temporary folder at the first pass, and reads it there.

    Of a damaged file the part that could be unpacked is read.
    """

    gives_samples = False

    def __init__(self, path: Path, reader: Callable[[Path], Log]) -> None:
        self.path = path
        self.kind = reader(path).kind
        self.notes: list[Finding] = []
        self._reader = reader
        self._log: Log | None = None
        self._damage: list[Loss] = []

    def messages(self) -> Iterator[Message]:
        """Unpack the log and yield its messages. Raises InputError if none can be read."""
        try:
            log = self._log or self._unpack()
        except OSError as error:
            raise unreadable(self.path, error) from None
        yield from log.messages()
        self.notes = list(log.notes)

    def losses(self) -> list[Loss]:
        """List what the last pass could not read."""
        return [*self._damage, *(self._log.losses() if self._log is not None else [])]

    def _unpack(self) -> Log:
        """Unpack the log into a scratch folder, up to the first damage, and open the copy.

        The folder is removed with this object. Raises StorageError where the disk has no room.
        """
        import zstandard

        require_regular_file(self.path)
        folder = scratch_folder()
        remove = weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        copy = folder / unpacked_name(self.path.name)
        budget = UnpackBudget(self.path.stat().st_size)
        with space_errors(folder, remove), self.path.open("rb") as packed, copy.open("wb") as out:
            stream = zstandard.ZstdDecompressor().stream_reader(packed, read_across_frames=True)
            try:
                whole = zstandard.frame_content_size(packed.read(FRAME_HEAD))  # -1: not given
                if whole > shutil.disk_usage(folder).free:
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                packed.seek(0)
                while block := stream.read(BLOCK):
                    budget.take(len(block))
                    out.write(block)
                if out.tell() < whole:
                    raise DamagedError(f"it gave {out.tell()} of {whole} bytes")
            except (zstandard.ZstdError, DamagedError) as error:
                name = printable(self.path.name)
                self._damage = [Loss(f"{name} could be unpacked in part only: {error}")]
        self._log = self._reader(copy)
        return self._log
