# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A ROS 2 folder: its storage files, MCAP or SQLite, in order, with or without metadata.yaml.

The files decide what is read, packed by zstd or not; the metadata tell their order and what is
missing. A recorder's compression mode goes stale when somebody unpacks the files.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hullrecon.dive.config.yaml_files import read_yaml
from hullrecon.dive.logs.readers.file_log import require_regular_file, unreadable
from hullrecon.dive.logs.readers.mcap import McapLog
from hullrecon.dive.logs.readers.packed import PackedLog, unpacked_name
from hullrecon.dive.logs.readers.protocol import Log, Loss, Message
from hullrecon.dive.logs.readers.sqlite import SqliteLog
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.errors import HullreconError, InputError
from hullrecon.findings.finding import Finding

METADATA = "metadata.yaml"
STORAGE: dict[str, Callable[[Path], Log]] = {".mcap": McapLog, ".db3": SqliteLog}
PACKED = (".gz", ".bz2", ".xz", ".lz4", ".zip")  # by hand: rosbag2 packs by zstd alone
LARGEST_METADATA = 1 << 18  # bytes; a topic has some 400
MOST_MESSAGES = 1 << 63  # a recorder's integers; those of YAML may have thousands of digits


def is_stored(name: str) -> bool:
    """Tell whether a file's name is that of a rosbag2 storage, packed or not."""
    return Path(unpacked_name(name)).suffix in STORAGE


def open_stored(path: Path) -> Log:
    """Open a storage file by its name, packed or not."""
    reader = STORAGE[Path(unpacked_name(path.name)).suffix]
    return reader(path) if path.suffix in STORAGE else PackedLog(path, reader)


class Rosbag2Log:
    """Reads the files in the order of the metadata, then those that it does not list, by name.

    The metadata of a recording that was cut short do not list all files.
    """

    kind = "ROS 2 folder"
    gives_samples = False

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[Finding] = []
        self._losses: list[Loss] = []
        self._opened: dict[Path, Log] = {}

    def messages(self) -> Iterator[Message]:
        """Yield every whole message of the folder's files.

        A file that cannot be read is a loss, as are messages that the metadata count and no file
        holds. Raises InputError where the folder cannot be read.
        """
        self.notes, self._losses = [], []
        seen: Counter[str] = Counter()
        info = self._read_metadata()
        for log in self._open_parts(info):
            try:
                for message in log.messages():
                    seen[message.channel.topic] += 1
                    yield message
            except InputError as error:
                self._losses.append(Loss(error.what))
            self._losses += log.losses()
            self.notes += [note.inside(printable(log.path.name)) for note in log.notes]
        self._losses += [
            Loss(
                f"{METADATA} counts more of them than could be read",
                topic,
                messages=_lost_messages(count, seen[topic]),
            )
            for topic, count in sorted(info.counts.items())
            if count > seen[topic]
        ]

    def losses(self) -> list[Loss]:
        """List what the last pass could not read."""
        return list(self._losses)

    def _open_parts(self, info: _Metadata) -> list[Log]:
        """Open the folder's files, and list those that the metadata name but are missing.

        Missing ones become losses. Files that the metadata do not name come last, by name. Where a
        file lies there both packed and unpacked, the unpacked one is taken.
        """
        try:
            inside = sorted(p for p in self.path.iterdir() if is_stored(p.name))
        except OSError as error:
            raise unreadable(self.path, error) from None
        forms: dict[str, list[Path]] = {}
        for path in sorted(inside, key=lambda p: p.suffix not in STORAGE):
            forms.setdefault(unpacked_name(path.name), []).append(path)
        named = dict.fromkeys(unpacked_name(name) for name in info.files)
        missing = [name for name in named if name not in forms]
        self._losses += [Loss(self._describe_missing(name)) for name in missing]
        order = [name for name in named if name in forms]
        order += [name for name in sorted(forms) if name not in named]
        chosen = [self._choose_form(forms[name]) for name in order]
        return [self._open(path) for path in chosen if path is not None]

    def _describe_missing(self, name: str) -> str:
        """Say that a file is missing, and which packed form of it lies there."""
        packed = next((name + end for end in PACKED if (self.path / (name + end)).exists()), None)
        there = f", {printable(packed)} lies there: unpack it" if packed else ""
        return f"the file {printable(name)} is missing{there}"

    def _choose_form(self, forms: Sequence[Path]) -> Path | None:
        """Choose the first of a file's forms, unpacked and packed, that has bytes.

        None where all are empty, which is added to the losses.
        """
        lost = []
        for path in forms:
            why = _why_empty(path)
            if not why:
                return path
            lost.append(Loss(why))
        self._losses += lost
        return None

    def _open(self, path: Path) -> Log:
        """Open a file, or take its reader of an earlier pass, as a packed file is unpacked once."""
        if path not in self._opened:
            self._opened[path] = open_stored(path)
        return self._opened[path]

    def _read_metadata(self) -> _Metadata:
        """Read metadata.yaml. Empty, with a note, when it is missing or damaged."""
        path = self.path / METADATA
        try:
            if path.exists():
                require_regular_file(path)
                _refuse_bombs(path)
            table = read_yaml(path)
        except HullreconError as error:
            self.notes.append(Finding("folder-by-name", {"why": error.what}))
            return _Metadata()
        except Exception as error:  # the parser fails in a dozen ways over a half-written file
            why = f"{METADATA} cannot be read: {type(error).__name__}"
            self.notes.append(Finding("folder-by-name", {"why": why}))
            return _Metadata()
        return _parse_metadata(table.get("rosbag2_bagfile_information"))


def _why_empty(path: Path) -> str:
    """Say why a file gives no bytes. "" where it gives some."""
    try:
        require_regular_file(path)
        return "" if path.stat().st_size else f"the file {printable(path.name)} is empty"
    except InputError as error:
        return error.what
    except OSError as error:
        return unreadable(path, error).what


@dataclass(frozen=True, kw_only=True)
class _Metadata:
    """The contents of metadata.yaml."""

    files: tuple[str, ...] = ()  # in their order, each once
    counts: Mapping[str, int] = field(default_factory=dict)  # messages by topic


def _parse_metadata(info: object) -> _Metadata:
    """Take files and counts from the metadata, as far as fields are of the right type.

    A half-written file lacks the others.
    """
    table = info if isinstance(info, Mapping) else {}
    files, topics = (table.get(k) for k in ("relative_file_paths", "topics_with_message_count"))
    names = (
        [Path(name).name for name in files if isinstance(name, str)]
        if isinstance(files, list)
        else []
    )
    counts: dict[str, int] = {}
    for entry in topics if isinstance(topics, list) else []:
        topic = entry.get("topic_metadata") if isinstance(entry, Mapping) else None
        name = topic.get("name") if isinstance(topic, Mapping) else None
        count = entry.get("message_count") if isinstance(entry, Mapping) else None
        if isinstance(name, str) and isinstance(count, int):
            counts[printable(name)] = count
    return _Metadata(
        files=tuple(dict.fromkeys(name for name in names if name)),
        counts=counts,
    )


def _lost_messages(counted: int, read: int) -> int | None:
    """Count missing messages. None where what was counted is no number of messages."""
    return counted - read if counted < MOST_MESSAGES else None


def _refuse_bombs(path: Path) -> None:
    """Raise InputError for metadata that would expand to fill the memory.

    It is too long or merges aliases. Recorders write neither.
    """
    size = path.stat().st_size
    if size > LARGEST_METADATA:
        raise InputError(f"{METADATA} has {size} bytes")
    text = path.read_text(encoding="utf-8", errors="replace")
    if "<<" in text or "!!merge" in text or "2002:merge" in text:
        raise InputError(f"{METADATA} merges aliases")
