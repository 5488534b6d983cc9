# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Choose the reader of a log by its first bytes, or by its name where those are damaged."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path

from hullrecon.dive.files import LFS_POINTER
from hullrecon.dive.logs.formats import bag_records, mcap_records, pd0_ensemble
from hullrecon.dive.logs.formats.foreign_forms import (
    PACKED,
    describe_file,
    describe_folder,
    is_page,
)
from hullrecon.dive.logs.formats.stamps import LoggerClock
from hullrecon.dive.logs.readers import sqlite
from hullrecon.dive.logs.readers.ad2cp.blocks import is_ad2cp
from hullrecon.dive.logs.readers.ad2cp.log import Ad2cpLog
from hullrecon.dive.logs.readers.file_log import ZSTD, require_regular_file, unreadable
from hullrecon.dive.logs.readers.mcap import McapLog
from hullrecon.dive.logs.readers.oculus import log_items
from hullrecon.dive.logs.readers.oculus.log import OculusLog
from hullrecon.dive.logs.readers.packed import PackedLog, unpacked_name
from hullrecon.dive.logs.readers.pd0 import Pd0Log
from hullrecon.dive.logs.readers.plain import COLUMNS, PlainLog
from hullrecon.dive.logs.readers.protocol import Log
from hullrecon.dive.logs.readers.rosbag1 import Rosbag1Log
from hullrecon.dive.logs.readers.rosbag2 import METADATA, Rosbag2Log, is_stored
from hullrecon.dive.logs.readers.sound_metrics import aris_frames
from hullrecon.dive.logs.readers.sound_metrics.aris import ArisLog
from hullrecon.dive.logs.readers.sqlite import SqliteLog
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.dive.logs.readers.water_linked import (
    START_BYTES,
    SUFFIXES,
    WaterLinkedLog,
    is_water_linked,
)
from hullrecon.errors import InputError

BY_MAGIC: dict[bytes, Callable[[Path], Log]] = {
    mcap_records.MAGIC: McapLog,
    bag_records.MAGIC: Rosbag1Log,
    sqlite.MAGIC: SqliteLog,
    pd0_ensemble.MAGIC: Pd0Log,
    aris_frames.MAGIC: ArisLog,
    log_items.MAGIC: OculusLog,
}
BY_SUFFIX: dict[str, Callable[[Path], Log]] = {
    ".mcap": McapLog,
    ".bag": Rosbag1Log,
    ".db3": SqliteLog,
    ".pd0": Pd0Log,
    ".ad2cp": Ad2cpLog,
    ".aris": ArisLog,
    ".oculus": OculusLog,
}
SONAR_SUFFIXES = (".aris", ".oculus")
# First bytes by which a log is recognised whatever its name. SQLite's are left out, as other files
# have them too
TELLING = (mcap_records.MAGIC, bag_records.MAGIC, aris_frames.MAGIC, log_items.MAGIC)
PART = re.compile(r"_\d+$")  # end of the name of a part of a recording, as the recorder numbers it
MOST_LOOKED_AT = 50  # files of a folder without a log whose first bytes are read, to describe it
FORMS = (
    "an MCAP, a ROS 1 bag, a ROS 2 folder, a PD0, AD2CP, ARIS or ViewPoint file, the JSON lines of "
    "a Water Linked DVL or a"
    " folder of CSVs"
)


def open_log(path: Path, package: Path | None = None, clock: LoggerClock | None = None) -> Log:
    """Choose the reader of a log, by its first bytes, else by its name.

    Raises InputError where the log is missing, empty or of no known format.

    Parameters
    ----------
    path : the log
    package : the folder that paths in tables may be relative to
    clock : zone and day of the stamps of tables that do not tell them
    """
    where, name = printable(str(path.parent)), printable(path.name)
    try:
        if path.is_dir():
            return _open_folder(path, package, clock)
        start = _start(path)
    except FileNotFoundError:
        raise InputError(
            f"the log {name} is missing{_files_there_are(path)}",
            where=where,
            remedy=_missing_remedy(path),
        ) from None
    except OSError as error:
        raise InputError(f"the log {name} cannot be read: {error.strerror}", where=where) from None
    except ValueError as error:  # a name with a zero byte
        raise InputError(f"the log {name} cannot be read: {error}", where=where) from None
    if not start:
        raise InputError(f"the log {name} is empty", where=where)
    if is_water_linked(start):
        return WaterLinkedLog(path)
    if is_ad2cp(start):
        return Ad2cpLog(path)
    found = [reader for magic, reader in BY_MAGIC.items() if start.startswith(magic)]
    by_name = BY_SUFFIX.get(Path(unpacked_name(path.name)).suffix.lower())
    if by_name is not None and start.startswith(ZSTD):
        return PackedLog(path, by_name)
    if by_name is not None and not (start.startswith(LFS_POINTER) or is_page(start)):
        found.append(by_name)
    if not found and pd0_ensemble.holds_ensemble(start):
        found.append(Pd0Log)
    if not found:
        raise _not_read(name, where, *describe_file(path, start))
    return found[0](path)


def _open_folder(path: Path, package: Path | None, clock: LoggerClock | None) -> Log:
    """Choose the reader of a folder: of a ROS 2 recording, else of tables."""
    names = {p.name for p in path.iterdir()}
    if METADATA in names or any(map(is_stored, names)):
        return Rosbag2Log(path)
    if any(f"{sensor}.csv" in names for sensor in COLUMNS):
        return PlainLog(path, package, clock)
    raise _not_read(
        f"the folder {printable(path.name)}",
        printable(str(path.parent)),
        *_describe_contents(sorted(path.iterdir())),
    )


def _not_read(name: str, where: str, what: str, remedy: str) -> InputError:
    """Make the error for a file or folder that no reader knows.

    what, remedy: what it is and what to do, "" where unknown.
    """
    state = "holds no log" if name.startswith("the folder ") else "is no log"
    kind = f": {what}" if what else ""
    return InputError(
        f"{name} {state} that is read here{kind}", where=where, remedy=remedy or f"give {FORMS}"
    )


def find_logs(path: Path) -> list[Path]:
    """Find the logs at a path: the path itself if it is one, else those in it or its `logs`.

    Raises InputError where there is none.
    """
    try:
        return _find_logs(path)
    except OSError as error:
        raise unreadable(path, error) from None


def _find_logs(path: Path) -> list[Path]:
    """Find the logs at a path as `find_logs` does, with OSError where it cannot be read."""
    if not path.is_dir() or _holds_log(path):
        return [path]
    for folder in (path, path / "logs"):
        if folder.is_dir() and _holds_log(folder):
            return [folder]
        inside = sorted(folder.iterdir()) if folder.is_dir() else []
        found = [p for p in inside if _is_log(p)]
        if found:
            return found
    inside = [
        p for folder in (path, path / "logs") if folder.is_dir() for p in sorted(folder.iterdir())
    ]
    raise _not_read(
        f"the folder {printable(path.name)}",
        printable(str(path.parent)),
        *_describe_contents(inside),
    )


def _is_log(path: Path) -> bool:
    """Tell whether a file or folder in a folder is a log by itself."""
    if path.is_dir():
        return path.name != "logs" and (_holds_log(path) or _is_bag(path))
    suffix = Path(unpacked_name(path.name)).suffix.lower()
    if suffix in BY_SUFFIX or not path.is_file():
        return suffix in BY_SUFFIX
    start = _peek(path)
    return is_log_of_any_name(start) or (suffix in SUFFIXES and is_water_linked(start))


def is_log_of_any_name(start: bytes) -> bool:
    """Recognise a log by its first bytes alone: a PD0 file is often called .000, .ENR or .bin."""
    return (
        pd0_ensemble.is_pd0(start)
        or is_ad2cp(start)
        or pd0_ensemble.holds_ensemble(start)
        or any(start.startswith(magic) for magic in TELLING)
    )


def is_of_sonar(path: Path) -> bool:
    """Tell whether a log gives pings of an imaging sonar without a topic being named.

    A sonar's own file does, and a folder of CSVs with a table of pings.
    """
    if path.is_dir():
        return (path / "sonar.csv").exists()
    return path.suffix.lower() in SONAR_SUFFIXES or _peek(path).startswith(
        (aris_frames.MAGIC, log_items.MAGIC)
    )


def _describe_contents(inside: Sequence[Path]) -> tuple[str, str]:
    """Describe a folder without a log by the names of its files, else by their first bytes.

    Returns what it is and what to do about it, both "" where unknown. A packed file is described
    only where no other file is known.
    """
    found = describe_folder(p.name for p in inside)
    if found[0]:
        return found
    files = [path for path in inside[:MOST_LOOKED_AT] if path.is_file()]
    described = [(path, *describe_file(path, _peek(path))) for path in files]
    known = sorted((row for row in described if row[1]), key=lambda row: row[1] == PACKED)
    if not known:
        return "", ""
    path, what, remedy = known[0]
    return (
        (f"{printable(path.name)} is {what}", f"{remedy}; else give {FORMS}")
        if what == PACKED
        else (what, remedy)
    )


def _holds_log(folder: Path) -> bool:
    """Tell whether a folder is itself a log: of CSVs, or with the metadata of ROS 2."""
    names = {p.name for p in folder.iterdir()}
    return METADATA in names or any(f"{sensor}.csv" in names for sensor in COLUMNS)


def _is_bag(folder: Path) -> bool:
    """Tell whether a folder holds parts of a recording of ROS 2 whose metadata are missing."""
    stems = [Path(unpacked_name(p.name)).stem for p in folder.iterdir() if is_stored(p.name)]
    return any(stem == folder.name or PART.search(stem) for stem in stems)


def _peek(path: Path) -> bytes:
    """Read the first bytes of a file among logs. Empty where it cannot be read."""
    try:
        return _start(path)
    except (OSError, InputError):
        return b""


def _start(path: Path) -> bytes:
    """Read the first bytes of a file, by which its kind is told."""
    require_regular_file(path)
    with path.open("rb") as stream:
        return stream.read(START_BYTES)


def _missing_remedy(path: Path) -> str:
    """Say what to do about a log that is not there."""
    if path.is_symlink():
        return f"it is a link to {printable(os.readlink(path))}, which is not there: copy the log"
    if "\\" in path.name:
        return "write / between folders in logs.files"
    return "correct logs.files"


def _files_there_are(path: Path) -> str:
    """Name some files of the folder in which a log was looked for."""
    if path.is_symlink():
        return ""
    try:
        names = sorted(p.name for p in path.parent.iterdir())[:6]
    except OSError:
        return ""
    return f" (there are {', '.join(map(printable, names))})" if names else ""
