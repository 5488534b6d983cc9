# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Common parts of the readers of single files: a pass over the file, its notes and its losses."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from hullrecon.dive.logs.readers.loss_tracker import LossTracker
from hullrecon.dive.logs.readers.protocol import Loss, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, UnpackBudget, printable, unpack_frame
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding

ZSTD = b"\x28\xb5\x2f\xfd"  # the start of a zstd frame; serialised messages start with 0


class FileLog:
    """A file that is opened anew for each pass. Readers fill `notes` and `_tracker` in `_read`."""

    kind: str
    gives_samples = False

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[Finding] = []
        self._tracker = LossTracker()

    def messages(self) -> Iterator[Message]:
        """Yield every whole message, in the order of the file.

        Where the system cannot read on, the rest is a loss. Raises InputError for a pipe, socket or
        device, and where the system cannot read the file's start.
        """
        self.notes, self._tracker = [], LossTracker()
        try:
            require_regular_file(self.path)
            budget = UnpackBudget(self.path.stat().st_size)
            for message in self._read():
                yield _unpack_message(message, budget)
        except OSError as error:  # a disk with a bad sector, a share that went away
            if not self._tracker.seen:
                raise unreadable(self.path, error) from None
            self._tracker.open_gap(f"the file cannot be read further: {error.strerror or error}")
            self._tracker.finish()

    def losses(self) -> list[Loss]:
        """List what the last pass could not read."""
        return list(self._tracker.losses)

    def _read(self) -> Iterator[Message]:
        """Yield the file's messages in order. Each format has its own."""
        raise NotImplementedError


def _unpack_message(message: Message, budget: UnpackBudget) -> Message:
    """Unpack a message that rosbag2 packed by itself (compression mode MESSAGE).

    One that cannot be unpacked is returned as it is, and the decoder will find it damaged.
    """
    data = message.data
    if not isinstance(data, bytes) or message.channel.encoding != "cdr":
        return message
    if not data.startswith(ZSTD):
        return message
    try:
        return replace(message, data=unpack_frame(data, budget))
    except DamagedError:
        return message


def unreadable(path: Path, error: OSError) -> InputError:
    """Make the error that says why the system does not give a file."""
    return InputError(
        f"{printable(path.name)} cannot be read: {error.strerror or error}",
        where=printable(str(path.parent)),
    )


def require_regular_file(path: Path) -> None:
    """Raise InputError for a pipe, a socket or a device, and OSError for what is not there."""
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        kinds = {stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket"}
        kind = kinds.get(stat.S_IFMT(mode), "a device")
        where = printable(str(path.parent))
        raise InputError(
            f"{printable(path.name)} is {kind}, not a file",
            where=where,
            remedy="copy the log into a file",
        )
