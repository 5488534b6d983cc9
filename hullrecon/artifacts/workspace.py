# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""RUNS/<dive>: where its artifacts are, the lock on it, and what may not be overwritten."""

from __future__ import annotations

import errno
import fcntl
import os
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hullrecon.artifacts.delivery import PUBLISHED, DeliveredFolder, delivered_records, unlike_files
from hullrecon.artifacts.disk import (
    existing_folder,
    make_folder,
    recover,
    remove,
    storage_errors,
    temporary_name,
    write_file,
)
from hullrecon.artifacts.documents import DamagedArtifactError, seal, unseal
from hullrecon.artifacts.manifest import FILE_NAME, HashCache, Manifest, read_manifest
from hullrecon.errors import LockedError, StorageError, UsageError

__all__ = ["COMPARE_FOLDER", "PRIVATE", "PUBLISHED", "Workspace", "damaged_files", "hold_lock"]
PRIVATE = ".hullrecon"  # lock, hashes, where the package lies, folders under construction
COMPARE_FOLDER = "compare"  # RUNS/<dive>/compare/<variant>: a workspace for each studied variant
_LISTED = 3  # deliverables that a sentence names one by one
_POLL_S = 0.2  # between two tries to get the lock
_REMEDY = "choose another folder with --runs, or another dive.name"


class Workspace:
    """One dive's folder. Reading needs no lock. Only the holder of `lock()` may change it."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def artifact(self, name: str) -> Path:
        """Locate the folder of a step's artifact, whether it exists or not."""
        return existing_folder(self.root / name)

    def manifest(self, name: str) -> Manifest | None:
        """Read a step's manifest. None without an artifact.

        Raises DamagedArtifactError if it cannot be trusted.
        """
        return read_manifest(self.artifact(name))

    def build_folder(self, name: str) -> Path:
        return self.root / PRIVATE / "building" / name

    def parts_folder(self, name: str) -> Path:
        """Locate what is kept of a step that was not finished."""
        return self.root / PRIVATE / "parts" / name

    def hashes(self, *, trusting: bool = True) -> HashCache:
        return HashCache(self.root / PRIVATE / "hashes.json", trusting=trusting)

    @contextmanager
    def lock(self, wait_s: float = 0.0) -> Iterator[Callable[[], bool]]:
        """Hold the lock of the workspace. Yields a function that says whether it is still held.

        Raises LockedError if another run holds it after wait_s, UsageError if the folder is not a
        run's own, StorageError if somebody removed it meanwhile.
        """
        with storage_errors(self.root):
            _refuse_foreign(self.root)
        with hold_lock(self.root / PRIVATE / "lock", wait_s) as held:
            yield held

    @property
    def delivery(self) -> DeliveredFolder:
        """The folder of the deliverables."""
        return DeliveredFolder(
            self.root / PUBLISHED, self.root / PRIVATE, self.build_folder(PUBLISHED)
        )

    def exists(self) -> bool:
        return (self.root / PRIVATE).is_dir()

    @property
    def package(self) -> Path | None:
        """The package that the last run read. None if unknown."""
        try:
            noted = unseal((self.root / PRIVATE / "workspace.json").read_bytes())
            return Path(str(noted["package"]))
        except (OSError, DamagedArtifactError, KeyError):
            return None

    def refuse_package(self, package: Path) -> None:
        """Raise UsageError if this folder is or holds the dive package, or its name is too long.

        A run would write among the files of the package.
        """
        root = self.root
        try:
            root.is_symlink()
        except OSError as error:
            if error.errno != errno.ENAMETOOLONG:
                raise
            shown = f"{str(root)[:60]}..."
            what = "the name of the run's folder is too long"
            raise UsageError(what, where=shown, remedy=_REMEDY) from error
        if package.resolve().is_relative_to(root.resolve()):
            verb = "is" if package.resolve() == root.resolve() else "holds"
            what = f"the run's folder {verb} the dive package"
            raise UsageError(what, where=str(root), remedy=_REMEDY)

    def other_package(self, package: Path, files: Iterable[str]) -> Path | None:
        """Find the package that the last run read, if it is another one that still exists.

        Else None: where the old folder is gone, the package has moved and is the same. `files`:
        relative paths that a folder must have to be a package.
        """
        last = self.package
        with storage_errors(self.root):
            if last is None or not os.path.isdir(last) or os.path.samefile(last, package):
                return None
            return last if all(os.path.isfile(last / name) for name in files) else None

    def remember_package(self, package: Path) -> None:
        """Note in the workspace of which package it holds the results."""
        if self.package != package.resolve():
            noted = seal({"package": str(package.resolve())})
            write_file(self.root / PRIVATE / "workspace.json", noted)

    def tidy(self, names: Iterable[str]) -> None:
        """Remove what a killed run was building, and finish or undo its half-done renames."""
        with storage_errors(self.root):
            remove(self.root / PRIVATE / "building")
            for unfinished in (self.root / PRIVATE).glob(temporary_name(Path("*")).name):
                remove(unfinished)
        for name in names:
            recover(self.root / name)
        self.delivery.recover()

    def remove(self, name: str) -> bool:
        """Remove an artifact, and deliver/ with the last artifact that delivers.

        Returns False if there was no artifact.
        """
        folder = self.artifact(name)
        if not folder.exists():
            return False
        gone = self.build_folder(f"removed-{name}")
        make_folder(gone.parent)
        with storage_errors(self.root):
            remove(gone)
            os.rename(folder, gone)  # out of sight at once
            remove(gone)
            if not any(self.root.glob(f"*/{PUBLISHED}")):
                self.delivery.remove()
        return True

    def quarantine(self, name: str) -> Path:
        """Set a damaged artifact apart under a new name, for its owner to look at."""
        target = self._quarantine_folder(name)
        with storage_errors(self.root):
            os.rename(self.artifact(name), target)
        return target

    def _quarantine_folder(self, name: str) -> Path:
        """Choose a name in quarantine that is not taken."""
        folder, number = self.root / "quarantine", 1
        make_folder(folder)
        while os.path.lexists(folder / f"{name}-{number}"):
            number += 1
        return folder / f"{name}-{number}"

    def publish(self, name: str, hashes: HashCache) -> str | None:
        """Copy the artifact's `deliver` folder to the workspace's top, unless it is there intact.

        Files that others changed there are kept in quarantine. Returns a sentence about them, None
        if there are none or the artifact delivers nothing.
        """
        manifest, delivery = self.manifest(name), self.delivery
        records = delivered_records(manifest) if manifest is not None else {}
        if not records:
            return None
        delivery.restore()
        original = self.artifact(name) / PUBLISHED
        if not delivery.unlike(original, records, hashes):
            delivery.note(records)
            return None
        changed, kept = delivery.changed_since(hashes), ""
        if any(what != "is missing" for what in changed.values()):
            apart = self._quarantine_folder(PUBLISHED)
            delivery.save_changed(changed, apart)
            kept = f", what lay there is in {apart}"
        delivery.replace(original, records, hashes)
        return f"{_list_changes(changed)}: restored{kept}" if changed else None


def _list_changes(changed: dict[str, str]) -> str:
    """Write which delivered files changed and how, the first ones by name."""
    listed = [f"{PUBLISHED}/{name} {what}" for name, what in list(changed.items())[:_LISTED]]
    more = len(changed) - len(listed)
    return "; ".join(listed) + (f"; and {more} more" if more else "")


def damaged_files(folder: Path, manifest: Manifest, hashes: HashCache) -> list[str]:
    """Describe each file of an artifact that differs from its manifest."""
    found = unlike_files(folder, manifest.outputs, hashes)
    return [f"{name} {what}" for name, what in found.items() if name != FILE_NAME]


@contextmanager
def hold_lock(path: Path, wait_s: float = 0.0) -> Iterator[Callable[[], bool]]:
    """Hold the lock `path`, which the kernel frees when its holder dies, for whatever reason.

    Yields a function that says whether the lock is still held. It is not if somebody removed its
    folder.

    Raises LockedError if another process holds it after `wait_s` seconds. An error inside the block
    becomes a StorageError if the folder was removed meanwhile.
    """
    make_folder(path.parent)
    with storage_errors(path.parent):
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o666)
    try:
        _acquire(descriptor, path, time.monotonic() + wait_s)
        with storage_errors(path.parent):
            os.truncate(descriptor, 0)
            os.pwrite(descriptor, f"{os.getpid()}\n".encode(), 0)
        try:
            yield lambda: _is_open_at(descriptor, path)
        except Exception as error:
            if _is_open_at(descriptor, path):
                raise
            raise removed_meanwhile(path.parent.parent) from error
        finally:
            with suppress(OSError):
                # Every file of a finished run but this one has a checksum: leave it empty.
                os.truncate(descriptor, 0)
    finally:
        os.close(descriptor)


def _is_open_at(descriptor: int, path: Path) -> bool:
    """Decide whether a path still names the file that is open."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except OSError:
        return False


def removed_meanwhile(root: Path) -> StorageError:
    """Build the error of a run whose folder somebody removed."""
    what = "the run's folder was removed while it was worked on"
    return StorageError(what, where=str(root), remedy="run again when nobody removes it")


def _acquire(descriptor: int, path: Path, until: float) -> None:
    """Take the lock, trying again until the time `until` (s, monotonic).

    Raises LockedError if another process still holds it.
    """
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() >= until:
                holder = os.pread(descriptor, 32, 0).decode(errors="replace").strip() or "unknown"
                raise LockedError(
                    f"dive is locked by process {holder}",
                    where=str(path.parent.parent),
                    remedy="wait for it to end, or wait in the command with --wait SECONDS",
                ) from None
            time.sleep(_POLL_S)


def _refuse_foreign(root: Path) -> None:
    """Raise UsageError for a folder that is a link, is no run, or has links among its own files."""
    if root.is_symlink():
        raise UsageError("the run's folder is a symbolic link", where=str(root), remedy=_REMEDY)
    if not root.is_dir():
        return
    if not (root / PRIVATE).is_dir() and any(root.iterdir()):
        what = "the folder is not empty and holds no run"
        raise UsageError(what, where=str(root), remedy=_REMEDY)
    for path in _own_paths(root):
        if path.is_symlink():
            what = "a symbolic link lies among the run's own files"
            raise UsageError(what, where=str(path), remedy="remove it")


def _own_paths(root: Path) -> Iterator[Path]:
    """Yield every path that a run writes to or removes by name. Artifacts are replaced whole."""
    yield from root.iterdir()
    for folder, folders, files in os.walk(root / PRIVATE):
        yield from (Path(folder, name) for name in (*folders, *files))
    if (root / COMPARE_FOLDER).is_dir():
        for variant in (root / COMPARE_FOLDER).iterdir():
            yield variant
            if variant.is_dir() and not variant.is_symlink():
                yield from _own_paths(variant)
