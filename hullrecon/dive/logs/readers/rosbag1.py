# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""ROS 1 bags, chunk by chunk: by the index at the end, or from the start when the bag was cut short."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from hullrecon.dive.logs.readers.loss_tracker import LossTracker
from hullrecon.dive.logs.readers.protocol import Channel, Loss, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, decompress, fields, text

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, BAG, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7
OPCODES = (MESSAGE, BAG, INDEX, CHUNK, CHUNK_INFO, CONNECTION)
LARGEST_HEAD = 1 << 20  # bytes; a connection's head holds its topic, never more
OP_CHUNK = b"\x04\x00\x00\x00op=\x05"
HEAD_REACH = 64  # a chunk's head starts at most so many bytes before its `op` field
BLOCK = 1 << 20

Head = dict[str, bytes]


@dataclass(frozen=True)
class BagChunk:
    """What the index says about one chunk: where it is, its span in log time, messages by connection."""

    offset: int
    start_ns: int
    end_ns: int
    counts: dict[int, int]


class Connections(dict[int, Channel]):
    """The connections met so far; unknown: messages of those whose definition was lost."""

    unknown = 0


class Rosbag1Log:
    """A bag has no checksums (bz2 and most lz4 chunks apart): damage shows where lengths or types no longer fit."""

    kind = "ROS 1 bag"
    gives_samples = False

    def __init__(self, path: Path) -> None:
        self.path = path
        self.remarks: list[str] = []
        self._tracker = LossTracker()

    def messages(self) -> Iterator[Message]:
        self.remarks, self._tracker = [], LossTracker()
        size = self.path.stat().st_size
        connections = Connections()
        with self.path.open("rb") as stream:
            notes = read_index(stream, size, connections)
            if notes is None:
                self.remarks.append("the bag has no usable index (was its recording cut short?): it was read from its start")
                yield from self._from_start(stream, size, connections)
            else:
                yield from self._by_index(stream, size, connections, notes)
        if connections.unknown:
            self.remarks.append(f"{connections.unknown} messages belong to topics whose definition was lost")
        self._tracker.finish(_expected(notes or [], connections))

    def losses(self) -> list[Loss]:
        return list(self._tracker.losses)

    def _by_index(self, stream: BinaryIO, size: int, connections: Connections, notes: list[BagChunk]) -> Iterator[Message]:
        for note in notes:
            try:
                head, data, _ = record(stream, note.offset, size)
                found = messages_of(head, data, connections)
                if len(found) != sum(note.counts.values()):
                    raise DamagedError(f"it holds {len(found)} messages instead of {sum(note.counts.values())}")
            except DamagedError as error:
                topics = [connections[c].topic for c in note.counts if c in connections]
                self._tracker.add_loss(
                    f"the chunk at byte {note.offset} is damaged: {error}", note.start_ns, note.end_ns, topics
                )
                continue
            yield from map(self._tracker.record, found)

    def _from_start(self, stream: BinaryIO, size: int, connections: Connections) -> Iterator[Message]:
        at = len(MAGIC)
        while at < size:
            try:
                head, data, following = record(stream, at, size)
                found = messages_of(head, data, connections)
            except DamagedError as error:
                self._tracker.open_gap(f"the file is damaged at byte {at}: {error}")
                at = find_chunk(stream, at + 1, size)
                continue
            yield from map(self._tracker.record, found)
            at = following


def record(stream: BinaryIO, at: int, size: int) -> tuple[Head, bytes, int]:
    """Head and data of the record at byte `at`, and the byte behind it."""
    stream.seek(at)
    (length,) = fields("<I", stream.read(4))
    if length > LARGEST_HEAD or at + 8 + length > size:
        raise DamagedError("no record starts there, or it is cut off")
    head = _head(stream.read(length))
    (count,) = fields("<I", stream.read(4))
    end = at + 8 + length + count
    if end > size:
        raise DamagedError("the record there is cut off")
    if _op(head) not in OPCODES:
        raise DamagedError("no record starts there")
    return head, stream.read(count), end


def messages_of(head: Head, data: bytes, connections: Connections) -> list[Message]:
    """Messages of a chunk, or of a message record that stands alone; connections met on the way are learnt."""
    op = _op(head)
    if op == CHUNK:
        data = decompress(data, text(head.get("compression", b"")), fields("<I", head.get("size", b""))[0])
        return [m for h, d in records(data) for m in messages_of(h, d, connections) if _op(h) != CHUNK]
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
    """Head and data of records in a row."""
    at = 0
    while at < len(data):
        (length,) = fields("<I", data, at)
        (count,) = fields("<I", data, at + 4 + length)
        end = at + 8 + length + count
        if end > len(data):
            raise DamagedError("a record reaches beyond its end")
        yield _head(data[at + 4 : at + 4 + length]), data[at + 8 + length : end]
        at = end


def read_index(stream: BinaryIO, size: int, connections: Connections) -> list[BagChunk] | None:
    """The chunks that the index at the end of the bag names, in the order of the file; None when there is none to trust."""
    try:
        head, _, _ = record(stream, len(MAGIC), size)
        (at,) = fields("<Q", head.get("index_pos", b""))
        chunks = fields("<I", head.get("chunk_count", b""))[0]
        notes = []
        while 0 < at < size:
            head, data, at = record(stream, at, size)
            messages_of(head, b"" if _op(head) == CHUNK else data, connections)
            if _op(head) == CHUNK_INFO:
                notes.append(_note(head, data))
    except DamagedError:
        return None
    return sorted(notes, key=lambda n: n.offset) if notes and len(notes) == chunks else None


def find_chunk(stream: BinaryIO, start: int, size: int) -> int:
    """The first byte at or after `start` where a whole chunk record lies; `size` when there is none."""
    at = start
    while at < size:
        stream.seek(max(0, at - HEAD_REACH))
        base = stream.tell()
        block = stream.read(BLOCK + 2 * HEAD_REACH)
        found = block.find(OP_CHUNK)
        while found >= 0:
            for begin in range(max(start, base + found - HEAD_REACH), base + found - 3):
                if _is_chunk(stream, begin, size):
                    return begin
            found = block.find(OP_CHUNK, found + 1)
        at += BLOCK
    return size


def _is_chunk(stream: BinaryIO, at: int, size: int) -> bool:
    stream.seek(at)
    length = int.from_bytes(stream.read(4), "little")
    if not len(OP_CHUNK) < length < 4 * HEAD_REACH:
        return False
    try:
        head, _, _ = record(stream, at, size)
        return _op(head) == CHUNK and {"compression", "size"} <= head.keys()
    except DamagedError:
        return False


def _head(data: bytes) -> Head:
    """The fields of a record's head: each with its length in front, name=value."""
    out, at = {}, 0
    while at < len(data):
        (length,) = fields("<I", data, at)
        name, equals, value = data[at + 4 : at + 4 + length].partition(b"=")
        if not equals or at + 4 + length > len(data):
            raise DamagedError("a head's field does not fit")
        out[text(name)] = value
        at += 4 + length
    return out


def _op(head: Head) -> int:
    op = head.get("op", b"")
    return op[0] if len(op) == 1 else -1


def _connection(head: Head, data: bytes) -> tuple[int, Channel]:
    inner = _head(data)
    kind, topic = text(inner.get("type", b"")), text(head.get("topic", b""))
    definition = inner.get("message_definition", b"").decode(errors="replace")  # comments may be in any code page
    return fields("<I", head.get("conn", b""))[0], Channel(topic, kind, "ros1", definition)


def _note(head: Head, data: bytes) -> BagChunk:
    (offset,) = fields("<Q", head.get("chunk_pos", b""))
    pairs = [fields("<II", data, at) for at in range(0, len(data), 8)]
    return BagChunk(offset, _time(head.get("start_time", b"")), _time(head.get("end_time", b"")), dict(pairs))  # type: ignore[arg-type]


def _time(value: bytes) -> int:
    seconds, nanoseconds = fields("<II", value)
    return seconds * 1_000_000_000 + nanoseconds


def _expected(notes: list[BagChunk], connections: Connections) -> dict[str, int]:
    out: dict[str, int] = {}
    for note in notes:
        for number, count in note.counts.items():
            if number in connections:
                topic = connections[number].topic
                out[topic] = out.get(topic, 0) + count
    return out
