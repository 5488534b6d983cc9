# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read MCAP chunk by chunk, each checked by its CRC. Damage between whole chunks is skipped."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from hullrecon.dive.logs.formats.mcap_records import (
    CHANNEL,
    CHUNK,
    CHUNK_HEAD,
    DATA_END,
    DATA_END_SIZE,
    HEAD,
    IN_DATA,
    MAGIC,
    MESSAGE,
    MESSAGE_INDEX,
    PRIVATE,
    SCHEMA,
    Chunk,
    Definitions,
    head,
    messages_of,
    messages_of_cut,
    packed_at,
    read_chunk,
)
from hullrecon.dive.logs.formats.mcap_summary import (
    Summary,
    claims_summary,
    is_end_of_data,
    read_summary,
)
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.protocol import Message
from hullrecon.dive.logs.readers.unpack import (
    LARGEST_CHUNK,
    PATIENCE,
    DamagedError,
    UnpackBudget,
    fields,
)
from hullrecon.findings.finding import Finding

BLOCK = 1 << 20  # bytes read at a time
# opcode of a chunk and a length of 8 bytes, of which no chunk needs the upper three
LIKE_A_CHUNK = re.compile(rb"\x06(?=.{5}\x00\x00\x00)", re.DOTALL)


class McapLog(FileLog):
    """Reads the chunks that the summary lists, else the file from its start, past every damage."""

    kind = "MCAP"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._definitions = Definitions()
        self._budget = UnpackBudget(0)
        self._seen = _Unchecked()

    def _read(self) -> Iterator[Message]:
        """Yield the messages by the chunks of the summary, or from the start without one.

        What could not be read becomes losses. At the end the counts that the summary states are
        compared with those that were read.
        """
        size = self.path.stat().st_size
        self._budget, self._seen = UnpackBudget(size), _Unchecked()
        with self.path.open("rb") as stream:
            summary = read_summary(stream, size)
            if summary is not None and summary.chunks:
                self._definitions = summary.definitions
                yield from self._by_summary(stream, size, summary)
            else:
                self._definitions = Definitions()
                yield from self._from_start(stream, size)
                if summary is None and claims_summary(stream, size):
                    self.notes.append(Finding("mcap-no-summary"))
        self._tracker.count_lost(
            "they belong to topics whose definition was lost", self._definitions.unknown
        )
        if self._seen.private:
            self.notes.append(Finding("mcap-private", {"count": self._seen.private}))
        self._tracker.finish(summary.counts if summary is not None else None)

    def _by_summary(self, stream: BinaryIO, size: int, summary: Summary) -> Iterator[Message]:
        """Read chunk by chunk as the summary lists them.

        A damaged chunk is lost alone, with its topics and times, which the summary states.
        """
        for note in summary.chunks:
            try:
                found = self._open(read_chunk(stream, note.offset, size))
            except DamagedError as error:
                self._seen.damaged = True
                why = f"the chunk at byte {note.offset} is damaged: {error}"
                self._tracker.add_loss(
                    why, note.start_ns, note.end_ns, note.topics or tuple(summary.counts)
                )
                continue
            yield from map(self._tracker.record, found)
        self._check_data(stream, summary.start - DATA_END_SIZE)

    def _from_start(self, stream: BinaryIO, size: int) -> Iterator[Message]:
        """Read record by record, and what is whole of a chunk that the file's end cuts off.

        Behind damage, look for the next chunk. The rest is given up where too many bytes that
        looked like chunks were none (PATIENCE).
        """
        at, patience = len(MAGIC), PATIENCE * size
        while at < size:
            length = 0
            try:
                opcode, length = head(stream, at, size)
                if is_end_of_data(stream, opcode, length, at, size):
                    self._check_data(stream, at)
                    return
                found = self._messages_at(stream, opcode, length, at, size)
            except DamagedError as error:
                self._seen.damaged = True
                cut = messages_of_cut(stream, at, size, self._definitions, self._budget)
                yield from map(self._tracker.record, cut)
                self._tracker.open_gap(f"the file is damaged at byte {at}: {error}")
                patience -= min(length, LARGEST_CHUNK)
                at = find_chunk(stream, at + 1, size) if patience >= 0 else size
                if at == size:
                    break
                continue
            yield from map(self._tracker.record, found)
            at += HEAD + length
        else:
            self._tracker.open_gap(f"the file ends at byte {size} without its closing records")
        self.notes.append(Finding("mcap-no-end"))
        self._check_data(stream, size)

    def _messages_at(
        self, stream: BinaryIO, opcode: int, length: int, at: int, size: int
    ) -> list[Message]:
        """Read the messages of the record at byte `at`. Empty for a record without messages.

        Raises DamagedError for a damaged record, and for one that does not belong there.

        Parameters
        ----------
        stream : the file
        opcode, length : kind of the record, and bytes behind its head
        at, size : where the record begins, and the size of the file
        """
        stream.seek(at + HEAD)
        if opcode == CHUNK or packed_at(stream.read(min(length, CHUNK_HEAD)), length) is not None:
            if opcode != CHUNK:
                self.notes.append(Finding("mcap-chunk-kind", {"byte": at}))
            return self._open(read_chunk(stream, at, size))
        if opcode >= PRIVATE:
            self._seen.private += 1
            return []
        if opcode not in IN_DATA or opcode == DATA_END:
            raise DamagedError("a record stands there that does not belong among the data")
        stream.seek(at + HEAD)
        if opcode == MESSAGE_INDEX and fields("<HI", stream.read(6))[1] > length - 6:
            raise DamagedError("an index there contradicts itself")
        if opcode not in (SCHEMA, CHANNEL, MESSAGE):
            return []
        if length > LARGEST_CHUNK:
            raise DamagedError(f"it claims {length} bytes")
        self._seen.loose = True
        message = self._definitions.take(opcode, stream.read(length))
        return [] if message is None else [message]

    def _open(self, chunk: Chunk) -> list[Message]:
        """List the messages of a chunk. That one has no checksum is noted."""
        if not chunk.crc:
            self._seen.chunks = True
        return messages_of(chunk, self._definitions, self._budget)

    def _check_data(self, stream: BinaryIO, at: int) -> None:
        """Compare the checksum over all data before `at`, where chunks have none of their own.

        `at` is the byte at which the record that holds the checksum begins. A wrong checksum is a
        loss, unless damage was found before, which explains it. A missing one is noted.
        """
        stream.seek(at)
        closing = stream.read(DATA_END_SIZE)
        crc = (
            int.from_bytes(closing[HEAD:], "little")
            if closing[:HEAD] == bytes([DATA_END, 4, *bytes(7)])
            else 0
        )
        if not (self._seen.loose or self._seen.chunks):
            return
        if crc and not self._seen.damaged and crc != checksum(stream, at):
            self._tracker.add_loss(
                "the checksum over all messages is wrong: some may be damaged", 0, 0
            )
        elif not crc and self._seen.chunks:
            self.notes.append(Finding("mcap-no-checksum"))


@dataclass(kw_only=True)
class _Unchecked:
    """What was met in a file that the checksums of its chunks do not cover."""

    loose: bool = False  # definitions or messages outside chunks
    chunks: bool = False  # chunks without a checksum
    damaged: bool = False
    private: int = 0  # records of somebody's own kind


def checksum(stream: BinaryIO, end: int) -> int:
    """Compute the CRC32 of the bytes before `end`."""
    crc, left = 0, end
    stream.seek(0)
    while left > 0:
        block = stream.read(min(BLOCK, left))
        if not block:
            break
        crc, left = zlib.crc32(block, crc), left - len(block)
    return crc


def find_chunk(stream: BinaryIO, start: int, size: int) -> int:
    """Find the byte, at or after `start`, at which the next chunk begins.

    Returns `size`, the end of the file, if there is none.

    A chunk is accepted if the lengths in its head agree with each other. Bodies are not read: many
    bytes only look like a head, and reading the body behind each would take a time quadratic in the
    file's size.
    """
    at = start
    while at < size:
        stream.seek(at)
        block = stream.read(BLOCK + HEAD + CHUNK_HEAD)
        for match in LIKE_A_CHUNK.finditer(block, 0, min(len(block), BLOCK + HEAD)):
            begin = match.start() + HEAD
            length = int.from_bytes(block[match.start() + 1 : begin], "little")
            if (
                at + begin + length <= size
                and packed_at(block[begin : begin + CHUNK_HEAD], length) is not None
            ):
                return at + match.start()
        at += BLOCK
    return size
