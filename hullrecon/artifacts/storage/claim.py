# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Refuse a folder that is not a run's own: the dive package, somebody else's files, links that lead
out of RUNS; and tell whether the last run there read another package.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from hullrecon.errors import UsageError

PRIVATE = ".hullrecon"  # lock, hashes, where the package lies, folders under construction
COMPARE_FOLDER = (
    # RUNS/<dive>/compare/<variant>: a workspace for each variant of the method, beside the chain's
    # own artifacts
    "compare"
)
_REMEDY = "choose another folder with --runs, or another dive.name"


def refuse_package(root: Path, package: Path) -> None:
    """Raise UsageError where the run's folder would be the dive package, or hold it, or has a name
    that no folder can have.
    """
    try:
        root.is_symlink()
    except OSError as error:
        if error.errno != errno.ENAMETOOLONG:
            raise
        raise UsageError(
            "the name of the run's folder is too long", where=f"{str(root)[:60]}...", remedy=_REMEDY
        ) from error
    if package.resolve().is_relative_to(root.resolve()):
        same = package.resolve() == root.resolve()
        raise UsageError(
            f"the run's folder {'is' if same else 'holds'} the dive package",
            where=str(root),
            remedy=_REMEDY,
        )


def other_package(last: Path | None, package: Path, files: Iterable[str]) -> Path | None:
    """Return the package that the last run read where that is another one and still there; one that
    has moved is the same.

    files: those without which a folder is no package, relative to it.
    """
    if last is None or not os.path.isdir(last) or os.path.samefile(last, package):
        return None
    return last if all(os.path.isfile(last / name) for name in files) else None


def refuse_foreign(root: Path) -> None:
    """Raise UsageError where the folder is a link or holds files but no run, or where a link lies
    among those of a run.
    """
    if root.is_symlink():
        raise UsageError("the run's folder is a symbolic link", where=str(root), remedy=_REMEDY)
    if not root.is_dir():
        return
    if not (root / PRIVATE).is_dir() and any(root.iterdir()):
        raise UsageError(
            "the folder is not empty and holds no run", where=str(root), remedy=_REMEDY
        )
    link = next((path for path in _own_paths(root) if path.is_symlink()), None)
    if link is not None:
        raise UsageError(
            "a symbolic link lies among the run's own files", where=str(link), remedy="remove it"
        )


def _own_paths(root: Path) -> Iterator[Path]:
    """Yield every path that a run writes to or removes by name; what is inside an artifact is
    replaced with it as a whole.
    """
    yield from root.iterdir()
    for folder, folders, files in os.walk(root / PRIVATE):
        yield from (Path(folder, name) for name in (*folders, *files))
    if (root / COMPARE_FOLDER).is_dir():
        for variant in (root / COMPARE_FOLDER).iterdir():
            yield variant
            if variant.is_dir() and not variant.is_symlink():
                yield from _own_paths(variant)
