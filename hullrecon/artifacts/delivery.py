# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""deliver/ at a workspace's top: copies of what a step delivers, guarded against changes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import msgspec

from hullrecon.artifacts.disk import (
    commit_folder,
    copy_file,
    make_folder,
    recover,
    remove,
    set_aside,
    storage_errors,
    write_file,
)
from hullrecon.artifacts.documents import DamagedArtifactError, seal, unseal
from hullrecon.artifacts.manifest import FileRecord, HashCache, Manifest, files_below

PUBLISHED = "deliver"  # a folder of that name in an artifact is copied to the workspace's top
RECORD = "deliver.json"  # in the workspace's private folder: what was copied last
Records = Mapping[str, FileRecord]  # size and hash by file name


def delivered_records(manifest: Manifest) -> dict[str, FileRecord]:
    """Select size and hash of each file that an artifact delivers, by its name below deliver/."""
    prefix = f"{PUBLISHED}/"
    return {
        name.removeprefix(prefix): record
        for name, record in manifest.outputs.items()
        if name.startswith(prefix)
    }


def unlike_files(folder: Path, records: Records, hashes: HashCache) -> dict[str, str]:
    """Find files below a folder that are not as recorded, or not recorded.

    Returns what is wrong with each, such as `is missing`, by name.
    """
    found = dict.fromkeys(set(files_below(folder)) - set(records), "does not belong there")
    for name, record in records.items():
        wrong = _difference(folder / name, record, hashes)
        if wrong:
            found[name] = wrong
    return dict(sorted(found.items()))


def _difference(path: Path, record: FileRecord, hashes: HashCache) -> str:
    """Say how a file differs from its record. Empty if it does not."""
    if path.is_symlink():
        return "is a symbolic link"
    try:
        now = hashes.record(path)
    except FileNotFoundError:
        return "is missing"
    except OSError as error:
        return f"cannot be read: {error.strerror}"
    if now.size != record.size:
        return f"has {now.size} bytes, not {record.size}"
    return "" if now == record else "is altered"


class DeliveredFolder:
    """The folder deliver/ of one workspace. Only the holder of the lock may change it."""

    def __init__(self, folder: Path, private: Path, building: Path) -> None:
        """Take the folder, the workspace's private folder, and a folder to build new copies in."""
        self.folder, self._record, self._building = folder, private / RECORD, building
        self.withdrawn = folder.with_name(f"{folder.name}-out-of-date")

    def read_record(self) -> dict[str, FileRecord] | None:
        """Read what was copied last. None if nothing was, or the record is damaged."""
        try:
            files = unseal(self._record.read_bytes())["files"]
            return msgspec.convert(files, dict[str, FileRecord])
        except (OSError, DamagedArtifactError, KeyError, msgspec.ValidationError):
            return None

    def unlike(self, original: Path, records: Records, hashes: HashCache) -> dict[str, str]:
        """Find files that are not copies of the artifact's files, with what is wrong with each.

        A hard link is no copy: older versions made them, and an edit of a deliverable then damaged
        the artifact.

        Parameters
        ----------
        original
            Folder of the artifact's files.
        records
            Size and hash of each.
        hashes
            Cache of hashes.
        """
        found = unlike_files(self.folder, records, hashes)
        for name in records:
            if name not in found and os.path.samefile(original / name, self.folder / name):
                found[name] = "is no copy"
        return found

    def changed_since(self, hashes: HashCache) -> dict[str, str]:
        """Find files that others changed since they were copied. Empty without a record of that."""
        recorded = self.read_record()
        if not recorded or not self.folder.is_dir():
            return {}
        return unlike_files(self.folder, recorded, hashes)

    def replace(self, original: Path, records: Records, hashes: HashCache) -> None:
        """Put copies of the artifact's files in place, in one step, and record them."""
        with storage_errors(self.folder.parent):
            remove(self._building)
            make_folder(self._building)
            for name in records:
                make_folder((self._building / name).parent)
                copy_file(original / name, self._building / name)
        commit_folder(self._building, self.folder)
        for name, record in records.items():
            hashes.learn(self.folder / name, record)
        self.note(records)

    def note(self, records: Records) -> None:
        """Record the files of the folder, unless they are recorded already."""
        if self.read_record() != dict(records):
            write_file(self._record, seal({"files": msgspec.to_builtins(dict(records))}))

    def save_changed(self, names: Mapping[str, str], apart: Path) -> None:
        """Copy the named files, if they exist, to the folder `apart`, where they are kept."""
        with storage_errors(apart.parent):
            for name in names:
                if (self.folder / name).is_file() and not (self.folder / name).is_symlink():
                    make_folder((apart / name).parent)
                    copy_file(self.folder / name, apart / name)

    def remove(self) -> None:
        """Remove the folder and its record."""
        for path in (self.folder, set_aside(self.folder), self.withdrawn, self._record):
            remove(path)

    def withdraw(self) -> bool:
        """Rename the folder, so that an earlier run's results do not look like today's.

        Returns False if there was no folder.
        """
        if not self.folder.is_dir():
            return False
        with storage_errors(self.folder.parent):
            remove(self.withdrawn)
            os.rename(self.folder, self.withdrawn)
        return True

    def restore(self) -> None:
        """Rename a withdrawn folder back, unless something was delivered since."""
        if self.withdrawn.is_dir() and not self.folder.exists():
            with storage_errors(self.folder.parent):
                os.rename(self.withdrawn, self.folder)

    def recover(self) -> None:
        """Finish or undo a replacement of the folder that a killed run left half done."""
        recover(self.folder)
