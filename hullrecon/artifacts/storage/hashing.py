# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""SHA-256 of files, remembered by size, time of change and inode so that nothing is read twice
without need.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from pathlib import Path

from hullrecon.artifacts.storage.disk import write_file
from hullrecon.artifacts.storage.documents import DamagedArtifactError, seal, unseal
from hullrecon.artifacts.storage.manifest import FileRecord


def hash_file(path: Path) -> FileRecord:
    """Return size and hash of a file, read whole."""
    with path.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
        return FileRecord(sha256, file.tell())


def files_below(folder: Path) -> list[str]:
    """Return the relative paths of all files, sorted."""
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if not p.is_dir())


class HashCache:
    """Hashes of files as last read. `trusting` False reads every file once again; a lost cache file
    costs only time.
    """

    def __init__(self, store: Path | None = None, *, trusting: bool = True) -> None:
        self._store, self._trusting, self._changed = store, trusting, False
        self._known: dict[str, object] = {}
        # time of the last change of inode or bytes, ns, of what this process has seen
        self._read_here: dict[str, int] = {}
        if store is not None and store.is_file():
            try:
                self._known = unseal(store.read_bytes())
            except DamagedArtifactError:
                self._changed = True

    def record(self, path: Path) -> FileRecord:
        """Return size and hash of a file. Raises OSError when it is not there, or is a device, FIFO
        or socket.
        """
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "not a regular file", str(path))
        known = self._known.get(str(path))
        if (
            isinstance(known, list)
            and known[:3] == _mark(status)
            and self._is_trusted(path, status)
        ):
            self._read_here.setdefault(str(path), status.st_ctime_ns)
            return FileRecord(str(known[3]), status.st_size)
        record = hash_file(path)
        self._note(path, status, record)
        return record

    def _is_trusted(self, path: Path, status: os.stat_result) -> bool:
        """Return whether a file of known size, time and inode need not be read.

        What this process has seen must also have kept its ctime, which no program can set back.
        """
        seen_ns = self._read_here.get(str(path))
        return self._trusting if seen_ns is None else seen_ns == status.st_ctime_ns

    def learn(self, path: Path, record: FileRecord) -> None:
        """Note the hash of a file that was just written."""
        self._note(path, path.stat(), record)

    def save(self) -> None:
        """Write the cache when it changed; only the holder of the lock may."""
        if self._changed and self._store is not None:
            write_file(self._store, seal(self._known))
            self._changed = False

    def _note(self, path: Path, status: os.stat_result, record: FileRecord) -> None:
        self._read_here[str(path)] = status.st_ctime_ns
        entry = [*_mark(status), record.sha256]
        if self._known.get(str(path)) != entry:
            self._known[str(path)] = entry
            self._changed = True


def _mark(status: os.stat_result) -> list[int]:
    """Return what changes with a file's bytes: size, time of modification and inode."""
    return [status.st_size, status.st_mtime_ns, status.st_ino]
