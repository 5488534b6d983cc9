# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A ROS 2 folder: its storage files, MCAP or SQLite, one after the other, with or without metadata.yaml."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from hullrecon.dive.config.calibration import read_yaml
from hullrecon.dive.logs.readers.mcap import McapLog
from hullrecon.dive.logs.readers.protocol import Log, Loss, Message
from hullrecon.dive.logs.readers.sqlite import SqliteLog
from hullrecon.errors import HullreconError, InputError

METADATA = "metadata.yaml"
STORAGE: dict[str, Callable[[Path], Log]] = {".mcap": McapLog, ".db3": SqliteLog}


class Rosbag2Log:
    """Files in the order of the metadata; files that it does not name (a recording that was cut short) follow by name."""

    kind = "ROS 2 folder"
    gives_samples = False

    def __init__(self, path: Path) -> None:
        self.path = path
        self.remarks: list[str] = []
        self._losses: list[Loss] = []

    def messages(self) -> Iterator[Message]:
        self.remarks, self._losses = [], []
        for log in self._parts():
            try:
                yield from (self._unpacked(message) for message in log.messages())
            except HullreconError as error:
                self._losses.append(Loss(error.what))
            self._losses += log.losses()
            self.remarks += [f"{log.path.name}: {remark}" for remark in log.remarks]

    def losses(self) -> list[Loss]:
        return list(self._losses)

    def _parts(self) -> list[Log]:
        info = self._metadata()
        if info.get("compression_mode", "").upper() == "FILE":
            raise InputError("the ROS 2 folder's files are compressed", where=str(self.path), remedy="unpack them with zstd -d")
        self._compressed = info.get("compression_mode", "").upper() == "MESSAGE"
        named = [self.path / Path(str(name)).name for name in info.get("relative_file_paths", [])]
        found = sorted(p for p in self.path.iterdir() if p.suffix in STORAGE)
        for missing in [p for p in named if p not in found]:
            self._losses.append(Loss(f"the file {missing.name} is missing"))
        order = [p for p in named if p in found] + [p for p in found if p not in named]
        for empty in [p for p in order if not p.stat().st_size]:
            self._losses.append(Loss(f"the file {empty.name} is empty"))
        return [STORAGE[p.suffix](p) for p in order if p.stat().st_size]

    def _metadata(self) -> dict[str, Any]:
        """Return what metadata.yaml holds; nothing, with a remark, when it is missing or damaged."""
        try:
            info = read_yaml(self.path / METADATA).get("rosbag2_bagfile_information")
        except HullreconError as error:
            self.remarks.append(f"{error.what}; the folder's files were read by name")
            return {}
        return info if isinstance(info, dict) else {}

    def _unpacked(self, message: Message) -> Message:
        if not self._compressed or not isinstance(message.data, bytes):
            return message
        import zstandard

        try:
            return replace(message, data=zstandard.ZstdDecompressor().decompress(message.data, max_output_size=1 << 30))
        except zstandard.ZstdError:
            return message  # the decoder will say that it is damaged
