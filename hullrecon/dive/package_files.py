# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Confine a dive package to its folder: files named by dive.toml and tables must lie inside it."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from hullrecon.dive.config.config_errors import shorten
from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.files import special_file
from hullrecon.dive.images.encoded import IMAGE_SUFFIXES
from hullrecon.dive.logs.readers.file_log import require_regular_file
from hullrecon.dive.logs.readers.open import open_log
from hullrecon.dive.logs.readers.plain import PlainLog
from hullrecon.dive.logs.readers.rosbag2 import METADATA, STORAGE, is_stored
from hullrecon.dive.logs.readers.sqlite import write_ahead_log
from hullrecon.errors import InputError
from hullrecon.geometry.frames import Camera

TABLE = ".csv"
WRITE_AHEAD = tuple(f"{suffix}-wal" for suffix in STORAGE)
REMEDY = "put it into the package, or give --allow-outside if you trust who wrote the package"


def check_files(
    loaded: LoadedConfig, *, allow_outside: bool = False, trusted_keys: Collection[str] = ()
) -> None:
    """Raise InputError, with the key, for special files and for files outside the package.

    Links are followed. Files that are missing are left to their readers. Only tables are read.

    Parameters
    ----------
    loaded : the configuration
    allow_outside : files may lie anywhere
    trusted_keys : keys that the package did not set, whose files may lie anywhere
    """
    for key, path in _named_files(loaded):
        _check_file(key, path, loaded.package, allow_outside or key in trusted_keys)


def check_log(path: Path, root: Path, *, allow_outside: bool = False) -> None:
    """Raise InputError, as check_files does, for a log in the folder `root` and its files."""
    for key, file in _files_of_log("the log", path, root):
        _check_file(key, file, root, allow_outside)


def _check_file(key: str, path: Path, package: Path, allow_outside: bool) -> None:
    """Raise InputError for a special file, or one outside the package if that is not allowed.

    key: what names the file, for the message.
    """
    kind = special_file(path)
    if kind:
        raise InputError(
            f"{key} names {kind}, not a file: {shorten(path.name)}",
            where=shorten(str(path.parent), 200),
        )
    if not (allow_outside or lies_inside(path, package)):
        what = f"{key} names a file outside the package: {_shown(path, package)}"
        raise InputError(what, where=shorten(str(package), 200), remedy=REMEDY)


def lies_inside(path: Path, package: Path) -> bool:
    """Tell whether a file, its links followed, lies in the package's folder.

    True also for a name that no file can have: its reader says what is wrong.
    """
    try:
        return path.resolve().is_relative_to(package.resolve())
    # too long, a loop of links, a zero byte: its reader says so
    except (OSError, RuntimeError, ValueError):
        return True


def log_files(package: Path, name: str) -> list[Path]:
    """List the files that reading the log `name` opens.

    Of a file these are itself and the write-ahead log beside a database, of a folder its tables
    with the images that they name, or its bags. Paths are relative to the package, absolute if
    outside. Raises InputError for a folder that holds no log.
    """
    folder = package / name
    try:
        if not folder.is_dir():
            if folder.exists():
                require_regular_file(folder)
            return [
                Path(name),
                *([Path(f"{name}-wal")] if write_ahead_log(folder).is_file() else []),
            ]
    except OSError:  # a name that no file can have: open_log raises, and says so
        open_log(folder, package)
    log = open_log(folder, package)
    if isinstance(log, PlainLog):
        return [*(Path(name) / table for table in log.tables()), *log.named_files()]
    files = sorted(
        path for path in folder.iterdir() if path.name == METADATA or _is_stored(path.name)
    )
    return [Path(name) / path.name for path in files if path.is_file()]


def named_images(package: Path, logs: Collection[str]) -> list[Path]:
    """List the existing image files that logs which are folders of CSVs name.

    Paths are relative to the package, absolute for a file outside of it. Logs that are files name
    none.

    logs: of the package, relative to it.
    """
    folders = [PlainLog(package / name, package) for name in logs if _is_folder(package / name)]
    return sorted(
        file
        for folder in folders
        for file in folder.named_files()
        if file.suffix.lower() in IMAGE_SUFFIXES
    )


def _named_files(loaded: LoadedConfig) -> Iterator[tuple[str, Path]]:
    """Yield the files of a package with the keys that name them."""
    package, config = loaded.package, loaded.config
    for camera in Camera:
        calibration = loaded.value(f"{camera.section}.calibration")
        if isinstance(calibration, str):
            yield f"{camera.section}.calibration", package / calibration
    if config.hull is not None:
        yield "hull.mesh", package / config.hull.mesh
    logo = logo_of(loaded)
    if logo is not None:
        yield "report.logo", package / logo
    earlier = earlier_dive_of(loaded)
    if earlier is not None:
        yield from _files_of_run("change.earlier", package / earlier)
    for name in config.logs.files:
        yield from _files_of_log("logs.files", package / name, package)


def logo_of(loaded: LoadedConfig) -> str | None:
    """Look up the file that [report] names as logo. None where it names none."""
    logo: object = getattr(loaded.sections.get("report"), "logo", None)
    return logo if isinstance(logo, str) else None


def earlier_dive_of(loaded: LoadedConfig) -> str | None:
    """Look up the folder of the earlier run that [change] names. None where it names none."""
    earlier: object = getattr(loaded.sections.get("change"), "earlier", None)
    return earlier if isinstance(earlier, str) else None


def _files_of_run(key: str, run: Path) -> Iterator[tuple[str, Path]]:
    """Yield the folder of a run, and then what the folders of its steps hold."""
    yield key, run
    if _is_folder(run):
        yield from ((key, file) for file in sorted(run.glob("*/*")))


def _files_of_log(key: str, log: Path, package: Path) -> Iterator[tuple[str, Path]]:
    """Yield a log, what its folder holds, and what its tables name, with what names each.

    Each file is yielded before it is read, so that the caller can refuse it first.

    Parameters
    ----------
    key : key of dive.toml that names the log, for errors
    log : its file or folder
    package : the folder that paths in tables may be relative to
    """
    yield key, log
    if not _is_folder(log):
        yield key, write_ahead_log(log)
        return
    members = [
        p
        for p in sorted(log.iterdir())
        if p.name == METADATA or p.suffix == TABLE or _is_stored(p.name)
    ]
    yield from ((key, member) for member in members)
    if any(member.suffix == TABLE for member in members) and _is_plain(log, package):
        yield from (
            (f"a table of {shorten(log.name)}", package / file)
            for file in log_files(package, str(log.absolute()))
        )


def _is_stored(name: str) -> bool:
    return is_stored(name) or name.endswith(WRITE_AHEAD)


def _is_folder(path: Path) -> bool:
    """Tell whether a path is a folder. A name that no file can have is none."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def _is_plain(folder: Path, package: Path) -> bool:
    """Tell whether a folder is a log of tables."""
    try:
        return isinstance(open_log(folder, package), PlainLog)
    except InputError:  # no log: said when it is read
        return False


def _shown(path: Path, package: Path) -> str:
    """Format a path as named by the package, and its target if it is a link."""
    name = str(path.relative_to(package)) if path.is_relative_to(package) else str(path)
    return (
        f"{shorten(name, 100)} (a link to {shorten(str(path.resolve()), 100)})"
        if path.is_symlink()
        else shorten(name, 100)
    )
