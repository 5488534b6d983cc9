# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""ROS 1 bags, chunk by chunk: by the index at the end, or from the start of a bag cut short."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import BinaryIO

from hullrecon.dive.logs.formats.bag_records import (
    CHUNK,
    CHUNK_INFO,
    MAGIC,
    MESSAGE,
    BagChunk,
    Connections,
    messages_of,
    messages_of_cut,
    op_of,
    parse_head,
    read_index,
    record,
)
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.protocol import Message
from hullrecon.dive.logs.readers.unpack import LARGEST_CHUNK, PATIENCE, DamagedError, UnpackBudget
from hullrecon.findings.finding import Finding

OP_CHUNK = b"\x04\x00\x00\x00op=\x05"  # the field of a head that makes its record a chunk
HEAD_REACH = 64  # bytes: largest distance from the start of a chunk's head to its `op` field
LONGEST_CHUNK_HEAD = 4 * HEAD_REACH
LIKE_A_LENGTH = re.compile(rb"(?=[\x09-\xff]\x00\x00\x00)", re.DOTALL)  # of a chunk's head
BLOCK = 1 << 20  # bytes read at a time


class Rosbag1Log(FileLog):
    """A bag. Few chunks have checksums: damage shows where lengths or types no longer fit."""

    kind = "ROS 1 bag"

    def _read(self) -> Iterator[Message]:
        """Yield the messages by the index, or from the bag's start without one.

        What could not be read becomes losses. At the end the counts that the index states are
        compared with those that were read.
        """
        size = self.path.stat().st_size
        connections, budget = Connections(), UnpackBudget(size)
        with self.path.open("rb") as stream:
            index = read_index(stream, size, connections)
            if index is None:
                self.notes.append(Finding("bag-no-index"))
                yield from self._from_start(stream, size, connections, budget)
            else:
                yield from self._by_index(stream, size, connections, index, budget)
        if connections.unchecked:
            self.notes.append(Finding("bag-no-checksum"))
        self._tracker.count_lost(
            "they belong to topics whose definition was lost", connections.unknown
        )
        self._tracker.finish(_expected_counts(index or [], connections))

    def _by_index(
        self,
        stream: BinaryIO,
        size: int,
        connections: Connections,
        index: list[BagChunk],
        budget: UnpackBudget,
    ) -> Iterator[Message]:
        """Read the chunks that the index lists. A damaged chunk is lost alone.

        So is one that holds another number of messages than the index says.

        Parameters
        ----------
        stream, size : the file, and its size
        connections : topics and types by number
        index : what the index says of each chunk
        budget : limits what the chunks unpack to
        """
        end = 0  # of the chunk before
        for listed in index:
            try:
                if listed.offset < end:
                    raise DamagedError("it lies inside the chunk before it")
                head, data, end = record(stream, listed.offset, size)
                found = messages_of(head, data, connections, budget)
                if len(found) != sum(listed.counts.values()):
                    raise DamagedError(
                        f"it holds {len(found)} messages instead of {sum(listed.counts.values())}"
                    )
            except DamagedError as error:
                topics = [connections[c].topic for c in listed.counts if c in connections]
                self._tracker.add_loss(
                    f"the chunk at byte {listed.offset} is damaged: {error}",
                    listed.start_ns,
                    listed.end_ns,
                    topics,
                )
                continue
            yield from map(self._tracker.record, found)

    def _from_start(
        self, stream: BinaryIO, size: int, connections: Connections, budget: UnpackBudget
    ) -> Iterator[Message]:
        """Read record by record without an index, and look for the next chunk after damage.

        Of a chunk that the file's end cuts off, what is whole is read. The rest is given up where
        too many bytes that looked like chunks were none (PATIENCE).
        """
        at, patience = len(MAGIC), PATIENCE * size
        closed = False
        while at < size:
            following = at
            try:
                head, data, following = record(stream, at, size)
                connections.unchecked |= op_of(head) == MESSAGE
                found = messages_of(head, data, connections, budget)
            except DamagedError as error:
                cut = messages_of_cut(stream, at, size, connections, budget)
                yield from map(self._tracker.record, cut)
                self._tracker.open_gap(f"the file is damaged at byte {at}: {error}")
                patience -= min(following - at, LARGEST_CHUNK)
                at = find_chunk(stream, at + 1, size) if patience >= 0 else size
                if at == size:
                    return
                continue
            yield from map(self._tracker.record, found)
            at, closed = following, op_of(head) == CHUNK_INFO
        if not closed:
            self._tracker.open_gap(f"the file ends at byte {size} without its index")


def find_chunk(stream: BinaryIO, start: int, size: int) -> int:
    """Find the byte, at or after `start`, at which the next chunk begins.

    Returns `size`, the end of the file, if there is none.

    A chunk is accepted if its head can be read and its data fit into the file. The data are not
    read: many bytes only look like a head, and reading the data behind each would take a time
    quadratic in the file's size.
    """
    at = start
    while at < size:
        stream.seek(max(0, at - HEAD_REACH))
        base = stream.tell()
        block = stream.read(BLOCK + HEAD_REACH + LONGEST_CHUNK_HEAD)
        found = block.find(OP_CHUNK)
        while 0 <= found < BLOCK + HEAD_REACH:
            for match in LIKE_A_LENGTH.finditer(
                block, max(start - base, found - HEAD_REACH, 0), found
            ):
                if _is_chunk(
                    block[match.start() : match.start() + 8 + LONGEST_CHUNK_HEAD],
                    size - base - match.start(),
                ):
                    return base + match.start()
            found = block.find(OP_CHUNK, found + 1)
        at += BLOCK
    return size


def _is_chunk(data: bytes, room: int) -> bool:
    """Tell whether a record that begins with these bytes is a chunk of `room` bytes at most."""
    length = int.from_bytes(data[:4], "little")
    if not len(OP_CHUNK) < length < LONGEST_CHUNK_HEAD or len(data) < 8 + length:
        return False
    try:
        head = parse_head(data[4 : 4 + length])
    except DamagedError:
        return False
    count = int.from_bytes(data[4 + length : 8 + length], "little")
    return (
        op_of(head) == CHUNK
        and {"compression", "size"} <= head.keys()
        and 8 + length + count <= room
    )


def _expected_counts(notes: list[BagChunk], connections: Connections) -> dict[str, int]:
    """Sum up the messages of each topic that the index counts."""
    out: dict[str, int] = {}
    for note in notes:
        for number, count in note.counts.items():
            if number in connections:
                topic = connections[number].topic
                out[topic] = out.get(topic, 0) + count
    return out
