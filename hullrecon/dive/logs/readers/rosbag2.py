# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A ROS 2 folder: its storage files, MCAP or SQLite, in order, with or without metadata.yaml."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from hullrecon.dive.config.yaml_files import read_yaml
from hullrecon.dive.logs.readers.file_log import require_regular_file, unreadable
from hullrecon.dive.logs.readers.mcap import McapLog
from hullrecon.dive.logs.readers.protocol import Log, Loss, Message
from hullrecon.dive.logs.readers.sqlite import SqliteLog
from hullrecon.dive.logs.readers.unpack import DamagedError, UnpackBudget, printable, unpack_frame
from hullrecon.errors import HullreconError, InputError
from hullrecon.findings.finding import Finding

METADATA = "metadata.yaml"
STORAGE: dict[str, Callable[[Path], Log]] = {".mcap": McapLog, ".db3": SqliteLog}
LARGEST_METADATA = 1 << 18  # bytes; a topic has some 400
MOST_MESSAGES = 1 << 63  # a recorder's integers; those of YAML may have thousands of digits


class Rosbag2Log:
    """Files in the order of the metadata, then by name those of a recording that was cut short."""

    kind = "ROS 2 folder"
    gives_samples = False

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[Finding] = []
        self._losses: list[Loss] = []

    def messages(self) -> Iterator[Message]:
        """Yield every whole message of the folder's files.

        Raises InputError where none can be read.
        """
        self.notes, self._losses = [], []
        seen: Counter[str] = Counter()
        info = self._metadata()
        for log in self._parts(info):
            unpack = _MessageUnpacker(log.path) if info.compression == "MESSAGE" else None
            try:
                for message in log.messages():
                    seen[message.channel.topic] += 1
                    yield message if unpack is None else unpack.unpack(message)
            except HullreconError as error:
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

    def _parts(self, info: _Metadata) -> list[Log]:
        if info.compression == "FILE":
            raise InputError(
                "the ROS 2 folder's files are compressed",
                where=str(self.path),
                remedy="unpack them with zstd -d",
            )
        try:
            found = sorted(p for p in self.path.iterdir() if p.suffix in STORAGE)
        except OSError as error:
            raise unreadable(self.path, error) from None
        named = [self.path / name for name in info.files]
        for missing in [p for p in named if p not in found]:
            self._losses.append(Loss(f"the file {printable(missing.name)} is missing"))
        order = [p for p in named if p in found] + [p for p in found if p not in named]
        return [STORAGE[p.suffix](p) for p in order if self._has_bytes(p)]

    def _has_bytes(self, path: Path) -> bool:
        try:
            require_regular_file(path)
            if path.stat().st_size:
                return True
            self._losses.append(Loss(f"the file {printable(path.name)} is empty"))
        except InputError as error:
            self._losses.append(Loss(error.what))
        except OSError as error:
            self._losses.append(Loss(unreadable(path, error).what))
        return False

    def _metadata(self) -> _Metadata:
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
        return _parse(table.get("rosbag2_bagfile_information"))


@dataclass(frozen=True, kw_only=True)
class _Metadata:
    """The contents of metadata.yaml."""

    compression: str = ""  # "", "FILE" or "MESSAGE"
    files: tuple[str, ...] = ()  # in their order, each once
    counts: Mapping[str, int] = field(default_factory=dict)  # messages by topic


def _parse(info: object) -> _Metadata:
    """Take the fields of the right type: a half-written file lacks the rest."""
    table = info if isinstance(info, Mapping) else {}
    mode, files, topics = (
        table.get(k)
        for k in ("compression_mode", "relative_file_paths", "topics_with_message_count")
    )
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
        compression=mode.upper() if isinstance(mode, str) else "",
        files=tuple(dict.fromkeys(name for name in names if name)),
        counts=counts,
    )


def _lost_messages(counted: int, read: int) -> int | None:
    """Count missing messages. None where what was counted is no number of messages."""
    return counted - read if counted < MOST_MESSAGES else None


def _refuse_bombs(path: Path) -> None:
    """Raise InputError for a file that is too long or merges aliases: recorders write neither."""
    size = path.stat().st_size
    if size > LARGEST_METADATA:
        raise InputError(f"{METADATA} has {size} bytes")
    text = path.read_text(encoding="utf-8", errors="replace")
    if "<<" in text or "!!merge" in text or "2002:merge" in text:
        raise InputError(f"{METADATA} merges aliases")


class _MessageUnpacker:
    """Unpacks messages that were compressed one by one."""

    def __init__(self, path: Path) -> None:
        self._budget = UnpackBudget(path.stat().st_size)

    def unpack(self, message: Message) -> Message:
        """Unpack a message. Where that fails the decoder will find it damaged."""
        if not isinstance(message.data, bytes):
            return message
        try:
            return replace(message, data=unpack_frame(message.data, self._budget))
        except DamagedError:
            return message
