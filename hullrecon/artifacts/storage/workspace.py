# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""RUNS/<dive>: where artifacts lie, how damaged ones are set apart, how deliverables are shown."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable
from contextlib import AbstractContextManager
from pathlib import Path

from hullrecon.artifacts.storage.disk import (
    commit_folder,
    existing_folder,
    make_folder,
    recover,
    remove,
    storage_errors,
    sync_tree,
    write_file,
)
from hullrecon.artifacts.storage.documents import DamagedArtifactError, seal, unseal
from hullrecon.artifacts.storage.hashing import HashCache, files_below
from hullrecon.artifacts.storage.lock import hold_lock
from hullrecon.artifacts.storage.manifest import FILE_NAME, Manifest, read_manifest

PRIVATE = ".hullrecon"  # lock, hashes, where the package lies, folders under construction
PUBLISHED = "deliver"  # a folder of that name in an artifact is shown at the workspace's top as well


class Workspace:
    """One dive's folder. Reading needs no lock; every method that changes something is for the holder of `lock()`."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def artifact(self, name: str) -> Path:
        """The folder of a step's artifact, whether it is there or not."""
        return existing_folder(self.root / name)

    def manifest(self, name: str) -> Manifest | None:
        """None when there is no artifact; DamagedArtifactError when its manifest cannot be trusted."""
        return read_manifest(self.artifact(name))

    def build_folder(self, name: str) -> Path:
        return self.root / PRIVATE / "building" / name

    def hashes(self, *, trusting: bool = True) -> HashCache:
        return HashCache(self.root / PRIVATE / "hashes.json", trusting=trusting)

    def lock(self, wait_s: float = 0.0) -> AbstractContextManager[None]:
        return hold_lock(self.root / PRIVATE / "lock", wait_s)

    def exists(self) -> bool:
        return (self.root / PRIVATE).is_dir()

    @property
    def package(self) -> Path | None:
        """Return the package that the last run read; None when unknown."""
        try:
            return Path(str(unseal((self.root / PRIVATE / "workspace.json").read_bytes())["package"]))
        except (OSError, DamagedArtifactError, KeyError):
            return None

    def remember_package(self, package: Path) -> None:
        if self.package != package.resolve():
            write_file(self.root / PRIVATE / "workspace.json", seal({"package": str(package.resolve())}))

    def tidy(self, names: Iterable[str]) -> None:
        """Ends what a killed run left half done."""
        with storage_errors(self.root):
            remove(self.root / PRIVATE / "building")
        for name in (*names, PUBLISHED):
            recover(self.root / name)

    def remove(self, name: str) -> bool:
        """Removes an artifact; it is out of sight at once. False when there was none."""
        folder = self.artifact(name)
        if not folder.exists():
            return False
        gone = self.build_folder(f"removed-{name}")
        make_folder(gone.parent)
        with storage_errors(self.root):
            remove(gone)
            os.rename(folder, gone)
            remove(gone)
            if not any(self.root.glob(f"*/{PUBLISHED}")):
                remove(self.root / PUBLISHED)
        return True

    def quarantine(self, name: str) -> Path:
        """Sets a damaged artifact apart under a new name: what can still be read of it is not ours to throw away."""
        make_folder(self.root / "quarantine")
        taken = {p.name for p in (self.root / "quarantine").iterdir()}
        target = next(self.root / "quarantine" / n for i in range(1, len(taken) + 2) if (n := f"{name}-{i}") not in taken)
        with storage_errors(self.root):
            os.rename(self.artifact(name), target)
        return target

    def publish(self, name: str) -> Path | None:
        """Shows the artifact's `deliver` folder at the workspace's top, as hard links where the file system has them."""
        inside, shown = self.artifact(name) / PUBLISHED, self.root / PUBLISHED
        if not inside.is_dir():
            return None
        if not unequal_files(inside, shown):
            return shown
        copy = self.build_folder(PUBLISHED)
        with storage_errors(self.root):
            remove(copy)
            for file in files_below(inside):
                make_folder((copy / file).parent)
                _link(inside / file, copy / file)
            sync_tree(copy)
        commit_folder(copy, shown)
        return shown


def damaged_files(folder: Path, manifest: Manifest, hashes: HashCache) -> list[str]:
    """Each file of an artifact that is not as its manifest says, in words."""
    found = []
    for name, record in sorted(manifest.outputs.items()):
        try:
            now = hashes.record(folder / name)
        except OSError:
            found.append(f"{name} is missing")
            continue
        if now.size != record.size:
            found.append(f"{name} has {now.size} bytes, not {record.size}")
        elif now != record:
            found.append(f"{name} is altered")
    strange = set(files_below(folder)) - set(manifest.outputs) - {FILE_NAME}
    return found + [f"{name} does not belong there" for name in sorted(strange)]


def unequal_files(original: Path, shown: Path) -> list[str]:
    """Files that are not the same in both folders: other inode and other size or time."""
    names = sorted({*files_below(original), *(files_below(shown) if shown.is_dir() else [])})
    return [name for name in names if not _same(original / name, shown / name)]


def _same(first: Path, second: Path) -> bool:
    try:
        one, two = first.stat(), second.stat()
    except FileNotFoundError:
        return False
    return os.path.samestat(one, two) or (one.st_size, one.st_mtime_ns) == (two.st_size, two.st_mtime_ns)


def _link(source: Path, target: Path) -> None:
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)
