# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The records of an MCAP file that matter here, checked as they are read."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, decompress, fields, text

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 0x02, 0x03, 0x04, 0x05, 0x06, 0x0F
OPCODES = range(0x01, 0x10)
HEAD = 9  # bytes: opcode, length
STATISTICS, CHUNK_INDEX = 0x0B, 0x08
FOOTER_SIZE = HEAD + 20


@dataclass(frozen=True)
class Chunk:
    """Its span in log time and its records, still packed."""

    start_ns: int
    end_ns: int
    size: int
    crc: int
    compression: str
    packed: bytes


class Definitions:
    """The schemas and channels met so far."""

    def __init__(self) -> None:
        self._schemas: dict[int, tuple[str, str, str]] = {}
        self.channels: dict[int, Channel] = {}
        self.unknown = 0  # messages of channels whose definition was lost

    def take(self, opcode: int, body: bytes) -> Message | None:
        """Learns a schema or a channel; gives back a message; DamagedError when the record does not hold together."""
        if opcode == SCHEMA:
            name, at = _string(body, 2)
            form, at = _string(body, at)
            (length,) = fields("<I", body, at)
            self._schemas[fields("<H", body)[0]] = (name, form, text(body[at + 4 : at + 4 + length]))
        elif opcode == CHANNEL:
            number, schema = fields("<HH", body)
            topic, at = _string(body, 4)
            kind, form, definition = self._schemas.get(schema, ("", "", ""))
            self.channels[number] = Channel(topic, kind, _string(body, at)[0], definition, form)
        elif opcode == MESSAGE:
            number, _, log_ns = fields("<HIQ", body)
            if number in self.channels:
                return Message(self.channels[number], log_ns, body[22:])
            self.unknown += 1
        return None


def head(stream: BinaryIO, at: int, end: int) -> tuple[int, int]:
    """Opcode and length of the record at byte `at`; DamagedError when it is no record or reaches beyond `end`."""
    stream.seek(at)
    opcode, length = fields("<BQ", stream.read(HEAD))
    if opcode not in OPCODES and opcode < 0x80:
        raise DamagedError("no record starts there")
    if at + HEAD + length > end:
        raise DamagedError("the record there is cut off")
    return opcode, length


def read_chunk(stream: BinaryIO, at: int, end: int) -> Chunk:
    """Return the chunk at byte `at`; its lengths must agree with each other."""
    opcode, length = head(stream, at, end)
    if opcode != CHUNK:
        raise DamagedError("no chunk starts there")
    body = stream.read(length)
    start_ns, end_ns, size, crc = fields("<QQQI", body)
    compression, at_size = _string(body, 28)
    (packed,) = fields("<Q", body, at_size)
    if at_size + 8 + packed != length:
        raise DamagedError("its lengths contradict each other")
    return Chunk(start_ns, end_ns, size, crc, compression, body[at_size + 8 :])


def messages_of(chunk: Chunk, definitions: Definitions) -> list[Message]:
    """Return all messages of a whole chunk. Raises DamagedError."""
    data = decompress(chunk.packed, chunk.compression, chunk.size)
    if chunk.crc and zlib.crc32(data) != chunk.crc:
        raise DamagedError("its checksum is wrong")
    taken = (definitions.take(opcode, body) for opcode, body in records(data))
    return [message for message in taken if message is not None]


def records(data: bytes) -> Iterator[tuple[int, bytes]]:
    """(opcode, body) of records in a row."""
    at = 0
    while at < len(data):
        opcode, length = fields("<BQ", data, at)
        if at + HEAD + length > len(data):
            raise DamagedError("a record reaches beyond its end")
        yield opcode, data[at + HEAD : at + HEAD + length]
        at += HEAD + length


def _string(body: bytes, at: int) -> tuple[str, int]:
    """A string with its length in front, and the byte behind it."""
    (length,) = fields("<I", body, at)
    if at + 4 + length > len(body):
        raise DamagedError("a string reaches beyond its record")
    return text(body[at + 4 : at + 4 + length]), at + 4 + length


@dataclass(frozen=True)
class ChunkNote:
    """What the summary says about one chunk. topics: those it holds, empty when the writer did not say."""

    offset: int
    start_ns: int
    end_ns: int
    topics: tuple[str, ...]


@dataclass(frozen=True)
class Summary:
    """chunks in the order of the file; counts of messages by topic (empty without statistics)."""

    chunks: tuple[ChunkNote, ...]
    counts: dict[str, int]
    definitions: Definitions


def read_summary(stream: BinaryIO, size: int) -> Summary | None:
    """Return the summary; None when there is none that can be trusted (its checksum, where it has one, must hold)."""
    try:
        return _parse(_section(stream, size))
    except DamagedError:
        return None


def _section(stream: BinaryIO, size: int) -> bytes:
    at = size - FOOTER_SIZE - len(MAGIC)
    if at < len(MAGIC) or head(stream, at, size) != (FOOTER, 20):
        raise DamagedError("no footer")
    start, _, crc = fields("<QQI", stream.read(20))
    if not len(MAGIC) <= start < at:
        raise DamagedError("no summary")
    stream.seek(start)
    section = stream.read(at - start)
    stream.seek(at)
    if crc and zlib.crc32(stream.read(FOOTER_SIZE - 4), zlib.crc32(section)) != crc:
        raise DamagedError("its checksum is wrong")
    return section


def _parse(section: bytes) -> Summary:
    definitions, notes = Definitions(), []
    by_channel: dict[int, int] = {}
    for opcode, body in records(section):
        if opcode == CHUNK_INDEX:
            start, end, offset, _, length = fields("<QQQQI", body)
            notes.append((offset, start, end, [fields("<H", body, at)[0] for at in range(36, 36 + length, 10)]))
        elif opcode == STATISTICS:
            (length,) = fields("<I", body, 42)
            by_channel = dict(fields("<HQ", body, at) for at in range(46, 46 + length, 10))  # type: ignore[misc]
        else:
            definitions.take(opcode, body)
    names = {number: channel.topic for number, channel in definitions.channels.items()}
    chunks = [ChunkNote(o, s, e, tuple(sorted({names[c] for c in held if c in names}))) for o, s, e, held in sorted(notes)]
    counts: dict[str, int] = {}
    for number, count in by_channel.items():
        if number in names:
            counts[names[number]] = counts.get(names[number], 0) + count
    return Summary(tuple(chunks), counts, definitions)
