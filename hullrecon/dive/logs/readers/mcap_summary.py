# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The summary at the end of an MCAP: where its chunks lie, what is in each, how many messages each topic has."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import BinaryIO

from hullrecon.dive.logs.readers.mcap_records import FOOTER, HEAD, MAGIC, Definitions, head, records
from hullrecon.dive.logs.readers.unpack import DamagedError, fields

STATISTICS, CHUNK_INDEX = 0x0B, 0x08
FOOTER_SIZE = HEAD + 20


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
    """The summary, or None when there is none that can be trusted (its checksum, where it has one, must hold)."""
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
