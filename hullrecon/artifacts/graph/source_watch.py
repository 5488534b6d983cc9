# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The files of the package that a run has read, and whether they still are what was read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from hullrecon.artifacts.graph.job import Job
from hullrecon.artifacts.graph.recipe import external_files
from hullrecon.artifacts.storage.hashing import HashCache
from hullrecon.artifacts.storage.manifest import FileRecord
from hullrecon.errors import InputError

_LISTED = 3  # files that the error names one by one
REMEDY = "nothing was delivered: run again when nobody writes there"


class SourceWatch:
    """Keeps what each file was when a step of this run read it."""

    def __init__(
        self, hashes: HashCache, package: Path, read_before: Mapping[str, FileRecord] | None = None
    ) -> None:
        """Watch a package. read_before: files of it that were read before the first step, by their
        path relative to it.
        """
        self._hashes, self._package = hashes, package
        self._read: dict[str, FileRecord] = dict(read_before or {})

    def begin(self, job: Job) -> None:
        """Note the files that a step is about to read. Raises InputError where an earlier step of
        this run read another one.
        """
        changed = [
            name
            for name, record in job.recipe.external.items()
            if self._read.get(name, record) != record
        ]
        if changed:
            raise _changed_error(changed, self._package)
        self._read |= job.recipe.external

    def end(self, job: Job) -> None:
        """Raise InputError where a file that a step of this run has read is no longer what it was,
        or files came or went.
        """
        now = external_files(job.stage, job.settings, job.source, self._hashes)
        changed = {
            name
            for name in {*now, *job.recipe.external}
            if now.get(name) != job.recipe.external.get(name)
        }
        changed |= {
            name
            for name, record in self._read.items()
            if name not in now and not self._is_still(name, record)
        }
        if changed:
            raise _changed_error(sorted(changed), self._package)

    def _is_still(self, name: str, record: FileRecord) -> bool:
        try:
            return self._hashes.record(self._package / name) == record
        except OSError:
            return False


def _changed_error(names: list[str], package: Path) -> InputError:
    listed = ", ".join(names[:_LISTED]) + (
        f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    )
    return InputError(f"{listed} changed during the run", where=str(package), remedy=REMEDY)
