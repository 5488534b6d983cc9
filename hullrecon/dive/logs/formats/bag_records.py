# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The records of a ROS 1 bag, checked as they are read, and the index at its end."""

from __future__ import annotations

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

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, BAG, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7
NEEDED = {  # the fields without which a record is none of its kind
    MESSAGE: {"conn", "time"},
    BAG: {"index_pos"},
    INDEX: {"conn", "count"},
    CHUNK: {"compression", "size"},
    CHUNK_INFO: {"chunk_pos", "count"},
    CONNECTION: {"conn", "topic"},
}
LARGEST_HEAD = 1 << 20  # bytes; a connection's head holds its topic, never more

Head = dict[str, bytes]


@dataclass(frozen=True, kw_only=True)
class BagChunk:
    """The index entry of one chunk."""

    offset: int  # bytes
    start_ns: int  # in log time
    end_ns: int
    counts: dict[int, int]  # messages by connection


class Connections(dict[int, Channel]):
    """The connections (topic and type, by number) that were read so far."""

    unknown = 0  # messages of connections whose definition was lost
    unchecked = False  # a chunk without a checksum was met


def record(stream: BinaryIO, at: int, size: int) -> tuple[Head, bytes, int]:
    """Read head and data of the record at byte `at`, and the byte behind it.

    Raises DamagedError where no whole record of a known kind lies there, so that damage is noticed
    before its lengths are used. size: of the file, bytes.
    """
    if at >= size:
        raise DamagedError(f"it would lie behind the end of the file, {size} bytes")
    stream.seek(at)
    (length,) = fields("<I", stream.read(4))
    if length > LARGEST_HEAD or at + 8 + length > size:
        raise DamagedError("no record starts there, or it is cut off")
    head = parse_head(stream.read(length))
    (count,) = fields("<I", stream.read(4))
    end = at + 8 + length + count
    if end > size:
        raise DamagedError("the record there is cut off")
    if not NEEDED.get(op_of(head), {""}) <= head.keys():
        raise DamagedError("no record starts there")
    if count > LARGEST_CHUNK:
        raise DamagedError(f"it claims {count} bytes")
    return head, stream.read(count), end


def messages_of_cut(
    stream: BinaryIO, at: int, size: int, connections: Connections, budget: UnpackBudget
) -> list[Message]:
    """Read the whole messages of a chunk that the file's end cuts off. Empty for any other record.

    No checksum covers them.
    """
    stream.seek(at)
    out = []
    try:
        (length,) = fields("<I", stream.read(4))
        head = parse_head(stream.read(min(length, LARGEST_HEAD)))
        (count,) = fields("<I", stream.read(4))
        if op_of(head) != CHUNK or stream.tell() + count <= size:
            return []
        how = text(head.get("compression", b""))
        for inner, data in records(decompress_start(stream.read(LARGEST_CHUNK), how, budget)):
            out += messages_of(inner, data, connections)
    except DamagedError:  # where it is cut
        pass
    return out


def messages_of(
    head: Head, data: bytes, connections: Connections, budget: UnpackBudget | None = None
) -> list[Message]:
    """Read the messages of a chunk or of a single message record.

    Empty for records of other kinds. Connections that it defines are added to `connections`.
    Messages of connections without a definition are dropped and counted there. The budget limits
    what a chunk unpacks to. Raises DamagedError for a chunk that cannot be read as a whole.
    """
    op = op_of(head)
    if op == CHUNK:
        how = text(head.get("compression", b""))
        connections.unchecked |= how in ("", "none")
        data = decompress(data, how, fields("<I", head.get("size", b""))[0], budget)
        return [
            m for h, d in records(data) for m in messages_of(h, d, connections) if op_of(h) != CHUNK
        ]
    if op == CONNECTION:
        number, channel = _connection(head, data)
        connections.setdefault(number, channel)
    if op != MESSAGE:
        return []
    (number,) = fields("<I", head.get("conn", b""))
    if number not in connections:
        connections.unknown += 1
        return []
    return [Message(connections[number], _time(head.get("time", b"")), data)]


def records(data: bytes) -> Iterator[tuple[Head, bytes]]:
    """Yield head and data of the records in a chunk.

    Raises DamagedError for records that are cut off, or no connection and no message.
    """
    at = 0
    while at < len(data):
        (length,) = fields("<I", data, at)
        (count,) = fields("<I", data, at + 4 + length)
        end = at + 8 + length + count
        if end > len(data):
            raise DamagedError("a record reaches beyond its end")
        head = parse_head(data[at + 4 : at + 4 + length])
        if op_of(head) not in (CONNECTION, MESSAGE):
            raise DamagedError("it holds a record of a kind that no chunk holds")
        yield head, data[at + 8 + length : end]
        at = end


def read_index(stream: BinaryIO, size: int, connections: Connections) -> list[BagChunk] | None:
    """Read the index at a bag's end: its chunks in the order of the file.

    With it, damage in one chunk does not hide the next ones. None where the index is damaged or
    empty, or does not list each chunk once. Connections that it defines are added to `connections`.
    size: of the file, bytes.
    """
    try:
        head, _, _ = record(stream, len(MAGIC), size)
        (at,) = fields("<Q", head.get("index_pos", b""))
        chunk_count = fields("<I", head.get("chunk_count", b""))[0]
        chunks = []
        while 0 < at < size:
            head, data, at = record(stream, at, size)
            if op_of(head) not in (CONNECTION, CHUNK_INFO):
                return None
            messages_of(head, data, connections)  # adds the connections that it defines
            if op_of(head) == CHUNK_INFO:
                chunks.append(_chunk(head, data))
    except DamagedError:
        return None
    chunks.sort(key=lambda chunk: chunk.offset)
    named_once = len({chunk.offset for chunk in chunks}) == len(chunks)
    return chunks if chunks and len(chunks) == chunk_count and named_once else None


def parse_head(data: bytes) -> Head:
    """Parse a record's head: fields name=value, each with its length in front."""
    out, at = {}, 0
    while at < len(data):
        (length,) = fields("<I", data, at)
        name, equals, value = data[at + 4 : at + 4 + length].partition(b"=")
        if not equals or at + 4 + length > len(data):
            raise DamagedError("a head's field does not fit")
        out[text(name)] = value
        at += 4 + length
    return out


def op_of(head: Head) -> int:
    """Read the kind of a record. -1 where its head does not say."""
    op = head.get("op", b"")
    return op[0] if len(op) == 1 else -1


def _connection(head: Head, data: bytes) -> tuple[int, Channel]:
    """Parse the record of a connection: its number, topic and type."""
    inner = parse_head(data)
    kind, topic = text(inner.get("type", b"")), text(head.get("topic", b""))
    # comments may be in any code page
    definition = inner.get("message_definition", b"").decode(errors="replace")
    return fields("<I", head.get("conn", b""))[0], Channel(topic, kind, "ros1", definition)


def _chunk(head: Head, data: bytes) -> BagChunk:
    """Parse the index entry of a chunk."""
    (offset,) = fields("<Q", head.get("chunk_pos", b""))
    pairs = [fields("<II", data, at) for at in range(0, len(data), 8)]
    counts: dict[int, int] = dict(pairs)  # type: ignore[arg-type]
    start_ns, end_ns = (_time(head.get(name, b"")) for name in ("start_time", "end_time"))
    return BagChunk(offset=offset, start_ns=start_ns, end_ns=end_ns, counts=counts)


def _time(value: bytes) -> int:
    """Convert a stamp of a record to ns."""
    seconds, nanoseconds = fields("<II", value)
    return seconds * 1_000_000_000 + nanoseconds
