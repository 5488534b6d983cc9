# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Writing files below deliver/, with the size and hash of each."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from hullrecon.report.export.summary import FileEntry

FOLDER = "deliver"


class FileWriter(Protocol):
    """Writes files of an artifact, each in one step."""

    def bytes(self, name: str, value: bytes) -> None:
        """Write a file."""

    def json(self, name: str, value: object) -> None:
        """Write indented JSON with sorted keys."""

    def path(self, name: str) -> AbstractContextManager[Path]:
        """Yield a temporary path to write to, which is renamed at the end of the `with`."""


class DeliverableWriter:
    """Writes deliverables and keeps their sizes and hashes."""

    def __init__(self, out: FileWriter) -> None:
        self._out = out
        self._entries: dict[str, FileEntry] = {}

    @property
    def entries(self) -> Mapping[str, FileEntry]:
        """Size and hash of each file written so far, by name."""
        return dict(sorted(self._entries.items()))

    def write(self, name: str, data: bytes | str) -> None:
        """Write a file below deliver/."""
        raw = data.encode() if isinstance(data, str) else data
        self._out.bytes(f"{FOLDER}/{name}", raw)
        self._entries[name] = FileEntry(bytes=len(raw), sha256=hashlib.sha256(raw).hexdigest())

    def write_json(self, name: str, value: object) -> None:
        """Write a document with sorted keys. Raises ValueError for a NaN."""
        text = json.dumps(value, indent=1, sort_keys=True, allow_nan=False, ensure_ascii=False)
        self.write(name, f"{text}\n")

    def copy(self, name: str, source: Path) -> None:
        """Copy a file of a step."""
        with source.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
        with self._out.path(f"{FOLDER}/{name}") as target:
            shutil.copyfile(source, target)
        self._entries[name] = FileEntry(bytes=source.stat().st_size, sha256=digest)
