# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""manifest.json of an artifact, and the hashes of files that it records."""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from pathlib import Path
from typing import Any, TypeAlias

import msgspec
from msgspec import Struct

from hullrecon.artifacts.disk import complete_file
from hullrecon.artifacts.documents import DamagedArtifactError, digest, seal, unseal

FILE_NAME = "manifest.json"
SCHEMA = 1
JsonTable: TypeAlias = dict[str, Any]  # msgspec decodes no recursive type


class FileRecord(Struct, frozen=True):
    """Hash and size of a file."""

    sha256: str
    size: int  # bytes


class Recipe(Struct, frozen=True, kw_only=True):
    """What decides an artifact's content: equal recipe, equal bytes."""

    stage: str
    version: int  # of the stage's code
    settings: JsonTable  # resolved options by section, None for an absent section
    inputs: dict[str, str] = {}  # content hash of each input artifact
    external: dict[str, FileRecord] = {}  # files of the package by their path relative to it
    failures: dict[str, str] = {}  # why optional inputs left no artifact, by stage name

    @property
    def key(self) -> str:
        return digest(self.content)

    @property
    def content(self) -> JsonTable:
        """The content that the key hashes, without empty `failures`, as in older versions."""
        content: JsonTable = msgspec.to_builtins(self)
        if not self.failures:
            del content["failures"]
        return content


class Manifest(Struct, frozen=True, kw_only=True):
    """What an artifact was made from and what it holds."""

    recipe: Recipe
    key: str
    outputs: dict[str, FileRecord]  # every file by its path in the artifact
    warnings: list[str] = []
    run: JsonTable = {}  # what differs between equal runs: host, versions, seconds, memory
    schema: int = SCHEMA

    @property
    def content_hash(self) -> str:
        """Hash of all but `run`: what a step that reads this artifact depends on."""
        content = msgspec.to_builtins(self) | {"recipe": self.recipe.content}
        del content["run"]
        return digest(content)


def write_manifest(folder: Path, manifest: Manifest) -> None:
    with complete_file(folder / FILE_NAME) as file:
        file.write(seal(msgspec.to_builtins(manifest)))


def read_manifest(folder: Path) -> Manifest | None:
    """Read the manifest of an artifact. None if there is no artifact.

    Raises DamagedArtifactError if an artifact's manifest is missing, cut short or altered.
    """
    if not folder.is_dir():
        return None
    try:
        return msgspec.convert(unseal((folder / FILE_NAME).read_bytes()), Manifest)
    except FileNotFoundError as error:
        raise DamagedArtifactError("its manifest is missing") from error
    except msgspec.ValidationError as error:
        raise DamagedArtifactError(f"its manifest is of another kind: {error}") from error


def hash_file(path: Path) -> FileRecord:
    """Hash a file, read whole."""
    with path.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
        return FileRecord(sha256, file.tell())


def files_below(folder: Path) -> list[str]:
    """List the relative paths of all files below a folder, sorted."""
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if not p.is_dir())


class HashCache:
    """Cache of file hashes by size, time of modification and inode, kept in the file `store`.

    With trusting=False the store is not believed: every file is read once in this process. A lost
    store costs only time.
    """

    def __init__(self, store: Path | None = None, *, trusting: bool = True) -> None:
        """Read the store, if there is one. A damaged one is taken as empty, and written anew."""
        self._store, self._trusting, self._changed = store, trusting, False
        self._known: dict[str, object] = {}  # size, mtime_ns, inode and hash by path
        self._seen_ctime_ns: dict[str, int] = {}  # of files this process looked at, by path
        if store is not None and store.is_file():
            try:
                self._known = unseal(store.read_bytes())
            except DamagedArtifactError:
                self._changed = True

    def record(self, path: Path) -> FileRecord:
        """Look up or compute size and hash of a file.

        Raises OSError if it is missing, or is a device, FIFO or socket.
        """
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "not a regular file", str(path))
        known = self._known.get(str(path))
        if isinstance(known, list) and known[:3] == _mark(status):
            # A file that this process looked at before must still have its ctime, which, unlike the
            # time of modification, no program can set back.
            seen_ns = self._seen_ctime_ns.get(str(path))
            if self._trusting if seen_ns is None else seen_ns == status.st_ctime_ns:
                self._seen_ctime_ns.setdefault(str(path), status.st_ctime_ns)
                return FileRecord(str(known[3]), status.st_size)
        record = hash_file(path)
        self._note(path, status, record)
        return record

    def learn(self, path: Path, record: FileRecord) -> None:
        """Note the hash of a file that was just written."""
        self._note(path, path.stat(), record)

    def save(self) -> None:
        """Write the store if it changed. Only the holder of the workspace's lock may call this."""
        if self._changed and self._store is not None:
            with complete_file(self._store) as file:
                file.write(seal(self._known))
            self._changed = False

    def _note(self, path: Path, status: os.stat_result, record: FileRecord) -> None:
        """Remember the hash of a file that was just read."""
        self._seen_ctime_ns[str(path)] = status.st_ctime_ns
        entry = [*_mark(status), record.sha256]
        if self._known.get(str(path)) != entry:
            self._known[str(path)] = entry
            self._changed = True


def _mark(status: os.stat_result) -> list[int]:
    """List what identifies a file's state: size, time of modification (ns), inode."""
    return [status.st_size, status.st_mtime_ns, status.st_ino]
