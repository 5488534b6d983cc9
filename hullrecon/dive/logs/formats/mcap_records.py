# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The relevant records of an MCAP file, checked as they are read."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.unpack import (
    LARGEST_CHUNK,
    DamagedError,
    UnpackBudget,
    decompress,
    decompress_start,
    fields,
    text,
)

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(0x01, 0x09)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = (
    range(0x09, 0x10)
)
PRIVATE = 0x80  # and above: records of somebody's own
IN_DATA = {HEADER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, ATTACHMENT, METADATA, DATA_END}
IN_SUMMARY = {
    SCHEMA,
    CHANNEL,
    STATISTICS,
    CHUNK_INDEX,
    ATTACHMENT_INDEX,
    METADATA_INDEX,
    SUMMARY_OFFSET,
}
HEAD = 9  # bytes: opcode, length
FOOTER_SIZE, DATA_END_SIZE = HEAD + 20, HEAD + 4
COMPRESSIONS = {b"", b"none", b"zstd", b"lz4"}
CHUNK_HEAD = 28 + 4 + 4 + 8  # bytes of a chunk's body before what is packed, at most
UNWRITTEN = (1 << 64) - 1  # a length that a recorder fills in when it closes the chunk
LONGEST_DEFINITION = 1 << 20  # bytes


@dataclass(frozen=True, kw_only=True)
class Chunk:
    """A chunk: its records, still packed, and their span of time."""

    start_ns: int  # log time of its first message
    end_ns: int  # log time of its last message
    size: int  # bytes of its records once unpacked
    crc: int  # of the unpacked records, 0: none
    compression: str  # one of COMPRESSIONS
    packed: bytes  # its records


class Definitions:
    """The schemas and channels that were read so far."""

    def __init__(self) -> None:
        self._schemas: dict[int, tuple[str, str, str]] = {}  # name, format and text, by number
        self.channels: dict[int, Channel] = {}
        self.unknown = 0  # messages of channels whose definition was lost

    def take(self, opcode: int, body: bytes) -> Message | None:
        """Add a schema or a channel, or decode a message. None for any record but a message.

        A message of a channel that is not known is dropped and counted. A channel whose schema is
        not known is dropped too. Raises DamagedError for an invalid record.
        """
        if opcode == SCHEMA:
            name, at = _string(body, 2)
            form, at = _string(body, at)
            (length,) = fields("<I", body, at)
            if length > min(len(body) - at - 4, LONGEST_DEFINITION):
                raise DamagedError(f"a definition claims {length} bytes")
            self._schemas[fields("<H", body)[0]] = (
                name,
                form,
                text(body[at + 4 : at + 4 + length]),
            )
        elif opcode == CHANNEL:
            number, schema = fields("<HH", body)
            topic, at = _string(body, 4)
            if schema and schema not in self._schemas:
                return None  # its type was lost: nobody can say what its messages are
            kind, form, definition = self._schemas.get(schema, ("", "", ""))
            self.channels[number] = Channel(topic, kind, _string(body, at)[0], definition, form)
        elif opcode == MESSAGE:
            number, _, log_ns = fields("<HIQ", body)
            fields("<Q", body, 14)
            if number in self.channels:
                return Message(self.channels[number], log_ns, body[22:])
            self.unknown += 1
        return None


def head(stream: BinaryIO, at: int, end: int) -> tuple[int, int]:
    """Read opcode and length of the record at byte `at`, which has to end before `end`."""
    stream.seek(at)
    opcode, length = fields("<BQ", stream.read(HEAD))
    if not (HEADER <= opcode <= DATA_END or opcode >= PRIVATE):
        raise DamagedError("no record starts there")
    if at + HEAD + length > end:
        raise DamagedError("the record there is cut off")
    return opcode, length


def packed_at(body: bytes, length: int) -> int | None:
    """Find where the packed records start within a chunk's body. None when it is no chunk's body.

    With it a chunk is recognised whatever its opcode says: the lengths in a chunk agree with each
    other, as the bytes of another record hardly do by chance.

    body: its first CHUNK_HEAD bytes suffice. length: of the whole body.
    """
    if len(body) < 40:
        return None
    named = int.from_bytes(body[28:32], "little")
    at = 32 + named
    packed = UNWRITTEN if length == UNWRITTEN else length - at - 8
    if (
        named > 4
        or body[32:at] not in COMPRESSIONS
        or int.from_bytes(body[at : at + 8], "little") != packed
    ):
        return None
    return at + 8


def read_chunk(stream: BinaryIO, at: int, end: int) -> Chunk:
    """Read the chunk at byte `at`, still packed, whatever its opcode says.

    Raises DamagedError where its lengths do not agree, or where it is cut off or too large.
    end: byte before which it has to end.
    """
    _, length = head(stream, at, end)
    start = packed_at(stream.read(min(length, CHUNK_HEAD)), length)
    if start is None:
        raise DamagedError("its lengths contradict each other")
    if length > LARGEST_CHUNK:
        raise DamagedError(f"it claims {length} bytes")
    stream.seek(at + HEAD)
    body = stream.read(length)
    start_ns, end_ns, size, crc = fields("<QQQI", body)
    return Chunk(
        start_ns=start_ns,
        end_ns=end_ns,
        size=size,
        crc=crc,
        compression=body[32 : start - 8].decode(),
        packed=body[start:],
    )


def messages_of_cut(
    stream: BinaryIO, at: int, size: int, definitions: Definitions, budget: UnpackBudget
) -> list[Message]:
    """Read the whole messages of a chunk that the file's end cuts off. Empty for any other record.

    No checksum covers them.
    """
    stream.seek(at)
    start = stream.read(HEAD + CHUNK_HEAD)
    length = int.from_bytes(start[1:HEAD], "little")
    begin = packed_at(start[HEAD:], length)
    if begin is None or start[0] != CHUNK or at + HEAD + length <= size:
        return []
    compression = start[HEAD + 32 : HEAD + begin - 8].decode()
    stream.seek(at + HEAD + begin)
    out = []
    try:
        data = decompress_start(stream.read(LARGEST_CHUNK), compression, budget)
        for opcode, body in records(data):
            message = definitions.take(opcode, body)
            if message is not None:
                out.append(message)
    except DamagedError:  # where it is cut
        pass
    return out


def messages_of(
    chunk: Chunk, definitions: Definitions, budget: UnpackBudget | None = None
) -> list[Message]:
    """Read all messages of a whole chunk, and add the definitions in it to `definitions`.

    The budget limits what it unpacks to. Raises DamagedError where its checksum is wrong, or where
    a record of it cannot be read.
    """
    data = decompress(chunk.packed, chunk.compression, chunk.size, budget)
    if chunk.crc and zlib.crc32(data) != chunk.crc:
        raise DamagedError("its checksum is wrong")
    out = []
    for opcode, body in records(data):
        if not (SCHEMA <= opcode <= MESSAGE or opcode >= PRIVATE):
            raise DamagedError("it holds a record of a kind that no chunk holds")
        message = definitions.take(opcode, body)
        if message is not None:
            out.append(message)
    return out


def records(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield (opcode, body) of records in a row."""
    at = 0
    while at < len(data):
        opcode, length = fields("<BQ", data, at)
        if at + HEAD + length > len(data):
            raise DamagedError("a record reaches beyond its end")
        yield opcode, data[at + HEAD : at + HEAD + length]
        at += HEAD + length


def _string(body: bytes, at: int) -> tuple[str, int]:
    """Read a string with its length in front, and the byte behind it."""
    (length,) = fields("<I", body, at)
    if at + 4 + length > len(body):
        raise DamagedError("a string reaches beyond its record")
    return text(body[at + 4 : at + 4 + length]), at + 4 + length
