# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""SHA-256 of files, remembered by size, time of change and inode so that nothing is read twice without need."""

from __future__ import annotations

import hashlib
from pathlib import Path

from hullrecon.artifacts.storage.disk import write_file
from hullrecon.artifacts.storage.documents import DamagedArtifactError, seal, unseal
from hullrecon.artifacts.storage.manifest import FileRecord


def hash_file(path: Path) -> FileRecord:
    with path.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
        return FileRecord(sha256, file.tell())


def files_below(folder: Path) -> list[str]:
    """Return the relative paths of all files, sorted."""
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if not p.is_dir())


class HashCache:
    """Hashes of files as last read. `trusting` False reads every file once again; a lost cache file costs only time."""

    def __init__(self, store: Path | None = None, *, trusting: bool = True) -> None:
        self._store, self._trusting, self._changed = store, trusting, False
        self._known: dict[str, object] = {}
        self._read_here: set[str] = set()
        if store is not None and store.is_file():
            try:
                self._known = unseal(store.read_bytes())
            except DamagedArtifactError:
                self._changed = True

    def record(self, path: Path) -> FileRecord:
        """Return size and hash of a file. Raises FileNotFoundError when it is not there."""
        status = path.stat()
        mark = [status.st_size, status.st_mtime_ns, status.st_ino]
        known = self._known.get(str(path))
        trusted = self._trusting or str(path) in self._read_here
        if trusted and isinstance(known, list) and known[:3] == mark:
            return FileRecord(str(known[3]), status.st_size)
        record = hash_file(path)
        self._note(path, [*mark, record.sha256])
        return record

    def learn(self, path: Path, record: FileRecord) -> None:
        """Note the hash of a file that was just written."""
        status = path.stat()
        self._note(path, [status.st_size, status.st_mtime_ns, status.st_ino, record.sha256])

    def save(self) -> None:
        """Write the cache when it changed; only the holder of the lock may."""
        if self._changed and self._store is not None:
            write_file(self._store, seal(self._known))
            self._changed = False

    def _note(self, path: Path, entry: list[int | str]) -> None:
        self._read_here.add(str(path))
        if self._known.get(str(path)) != entry:
            self._known[str(path)] = entry
            self._changed = True
