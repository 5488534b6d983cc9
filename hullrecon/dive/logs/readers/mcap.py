# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""MCAP, chunk by chunk with the CRC of each: what whole chunks hold comes through, whatever lies between them."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from hullrecon.dive.logs.formats.mcap_records import (
    CHANNEL,
    CHUNK,
    DATA_END,
    FOOTER,
    HEAD,
    MAGIC,
    MESSAGE,
    SCHEMA,
    Chunk,
    Definitions,
    Summary,
    head,
    messages_of,
    read_chunk,
    read_summary,
)  # fmt: skip
from hullrecon.dive.logs.readers.loss_tracker import LossTracker
from hullrecon.dive.logs.readers.protocol import Loss, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, fields

BLOCK = 1 << 20
LIKE_A_CHUNK = re.compile(rb"\x06.{5}\x00\x00\x00", re.DOTALL)  # no chunk is longer than 2^40 bytes


class McapLog:
    """Walks the chunks that the summary names; without a usable summary, the file from its start, past every damage."""

    kind = "MCAP"
    gives_samples = False

    def __init__(self, path: Path) -> None:
        self.path = path
        self.remarks: list[str] = []
        self._tracker = LossTracker()
        self._definitions = Definitions()

    def messages(self) -> Iterator[Message]:
        self.remarks, self._tracker, self._definitions = [], LossTracker(), Definitions()
        size = self.path.stat().st_size
        with self.path.open("rb") as stream:
            summary = read_summary(stream, size)
            if summary is not None and summary.chunks:
                yield from self._by_summary(stream, size, summary)
            else:
                yield from self._from_start(stream, size)
        if self._definitions.unknown:
            self.remarks.append(f"{self._definitions.unknown} messages belong to topics whose definition was lost")
        self._tracker.finish(summary.counts if summary is not None else None)

    def losses(self) -> list[Loss]:
        return list(self._tracker.losses)

    def _by_summary(self, stream: BinaryIO, size: int, summary: Summary) -> Iterator[Message]:
        for note in summary.chunks:
            try:
                found = self._open(read_chunk(stream, note.offset, size), summary.definitions)
            except DamagedError as error:
                why = f"the chunk at byte {note.offset} is damaged: {error}"
                self._tracker.add_loss(why, note.start_ns, note.end_ns, note.topics or tuple(summary.counts))
                continue
            yield from map(self._tracker.record, found)

    def _from_start(self, stream: BinaryIO, size: int) -> Iterator[Message]:
        """Record by record; behind damage the next chunk is looked for."""
        definitions, loose, at = self._definitions, _LooseRecords(), len(MAGIC)
        while at < size:
            try:
                opcode, length = head(stream, at, size)
                if opcode == CHUNK:
                    found = self._open(read_chunk(stream, at, size), definitions)
                elif opcode in (DATA_END, FOOTER):
                    self._end_of_data(stream, opcode, length, at, loose)
                    return
                else:
                    found = _loose(stream, opcode, length, definitions)
                    loose.messages += len(found)
            except DamagedError as error:
                loose.whole = False
                self._tracker.open_gap(f"the file is damaged at byte {at}: {error}")
                at = find_chunk(stream, at + 1, size)
                if at == size:
                    break
                continue
            yield from map(self._tracker.record, found)
            at += HEAD + length
        else:
            self._tracker.open_gap(f"the file ends at byte {size} without its closing records")
        self.remarks.append("the MCAP has no closing records: its recording or its copy was cut short")

    def _open(self, chunk: Chunk, definitions: Definitions) -> list[Message]:
        if not chunk.crc and "no checksum" not in "".join(self.remarks):
            self.remarks.append("chunks of the MCAP carry no checksum: damage inside them may go unseen")
        return messages_of(chunk, definitions)

    def _end_of_data(self, stream: BinaryIO, opcode: int, length: int, at: int, loose: _LooseRecords) -> None:
        """Messages outside chunks are covered by one checksum over all that lies before."""
        crc = fields("<I", stream.read(length))[0] if opcode == DATA_END else 0
        if loose.messages and loose.whole and crc and crc != checksum(stream, at):
            self._tracker.add_loss(f"the checksum over {loose.messages} messages is wrong: some may be damaged", 0, 0)


class _LooseRecords:
    """Messages outside chunks: how many there are, and whether no damage was met on the way."""

    messages = 0
    whole = True


def _loose(stream: BinaryIO, opcode: int, length: int, definitions: Definitions) -> list[Message]:
    if opcode not in (SCHEMA, CHANNEL, MESSAGE):
        return []
    message = definitions.take(opcode, stream.read(length))
    return [] if message is None else [message]


def checksum(stream: BinaryIO, end: int) -> int:
    """CRC32 of the bytes before `end`."""
    crc, left = 0, end
    stream.seek(0)
    while left > 0:
        block = stream.read(min(BLOCK, left))
        crc, left = zlib.crc32(block, crc), left - len(block)
    return crc


def find_chunk(stream: BinaryIO, start: int, size: int) -> int:
    """Return the first byte at or after `start` where a whole chunk lies; `size` when there is none."""
    at = start
    while at < size:
        stream.seek(at)
        block = stream.read(BLOCK + HEAD)
        for match in LIKE_A_CHUNK.finditer(block):
            try:
                read_chunk(stream, at + match.start(), size)
            except DamagedError:
                continue
            return at + match.start()
        at += BLOCK
    return size
