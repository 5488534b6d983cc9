# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The closing records of an MCAP file: the end of its data, and its summary of the chunks."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import BinaryIO

from hullrecon.dive.logs.formats.mcap_records import (
    CHUNK,
    CHUNK_INDEX,
    DATA_END,
    DATA_END_SIZE,
    FOOTER,
    FOOTER_SIZE,
    HEAD,
    IN_SUMMARY,
    MAGIC,
    MESSAGE,
    STATISTICS,
    Definitions,
    head,
    records,
)  # fmt: skip
from hullrecon.dive.logs.readers.unpack import LARGEST_CHUNK, DamagedError, fields


@dataclass(frozen=True, kw_only=True)
class ChunkNote:
    """The summary's entry of one chunk."""

    offset: int  # bytes
    end: int  # the byte behind it and its indices
    start_ns: int  # in log time
    end_ns: int
    topics: tuple[str, ...]  # that it holds; empty when the writer did not say


@dataclass(frozen=True, kw_only=True)
class Summary:
    """The summary of a file."""

    chunks: tuple[ChunkNote, ...]  # in the order of the file
    counts: dict[str, int]  # messages by topic; empty without statistics
    definitions: Definitions
    start: int  # its first byte


def read_summary(stream: BinaryIO, size: int) -> Summary | None:
    """Read the summary. None where there is none, or where it cannot be trusted.

    With it, chunks can be read by their place in the file instead of from the start.

    Its checksum, where it has one, must hold, and no message may lie outside the chunks that it
    names.
    """
    try:
        start, section = _read_section(stream, size)
        summary = _parse(section, start)
    except DamagedError:
        return None
    return summary if _names_all(stream, summary) else None


def is_end_of_data(stream: BinaryIO, opcode: int, length: int, at: int, size: int) -> bool:
    """Tell whether the record at byte `at` ends the data.

    Such a record is the file's footer, or a DATA_END of four bytes behind which the summary, if
    any, the footer and the magic follow. Anything else that looks like an end is damage: data may
    follow.

    Parameters
    ----------
    stream : the file
    opcode, length : kind of the record, and bytes behind its head
    at, size : where the record begins, and the size of the file
    """
    footer = _footer(stream, size)
    if footer is None:
        return False
    start, foot = footer
    behind = at + DATA_END_SIZE
    if opcode == FOOTER:
        return at == foot
    if opcode != DATA_END or length != 4:
        return False
    return behind == foot or start == behind or _is_summary(stream, behind, foot)


def claims_summary(stream: BinaryIO, size: int) -> bool:
    """Tell whether the file ends with a footer that says where its summary starts."""
    footer = _footer(stream, size)
    return footer is not None and footer[0] != 0


def _footer(stream: BinaryIO, size: int) -> tuple[int, int] | None:
    """Read from the footer where the summary starts, and where the footer itself starts, in bytes.

    The summary starts at 0 where there is none. None where the file does not end with a footer.
    """
    at = size - FOOTER_SIZE - len(MAGIC)
    try:
        if at < len(MAGIC) or head(stream, at, size) != (FOOTER, 20):
            return None
        start = fields("<QQI", stream.read(20))[0]
        return (start, at) if stream.read(len(MAGIC)) == MAGIC else None
    except DamagedError:
        return None


def _is_summary(stream: BinaryIO, at: int, foot: int) -> bool:
    """Tell whether only records of a summary lie between two bytes of a file."""
    try:
        opcodes = {opcode for opcode, _, _ in _heads(stream, at, foot)}
    except DamagedError:
        return False
    return opcodes <= IN_SUMMARY


def _heads(stream: BinaryIO, at: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, byte and length of the records between `at` and `end`.

    Raises DamagedError where records do not fill that span.
    """
    while at < end:
        opcode, length = head(stream, at, end)
        yield opcode, at, length
        at += HEAD + length


def _names_all(stream: BinaryIO, summary: Summary) -> bool:
    """Tell whether no chunk and no message lies outside the chunks that the summary names.

    Otherwise reading by the summary would miss them. False too where the records outside cannot be
    read.
    """
    # starts and ends, in turn, of the stretches between chunks; the loop below takes these alone
    edges = [
        len(MAGIC),
        *(edge for note in summary.chunks for edge in (note.offset, note.end)),
        summary.start,
    ]
    if not summary.chunks:
        return True
    try:
        found = {
            op
            for start, end in list(pairwise(edges))[::2]
            for op, _, _ in _heads(stream, start, end)
        }
    except DamagedError:
        return False
    return not found & {CHUNK, MESSAGE}


def _read_section(stream: BinaryIO, size: int) -> tuple[int, bytes]:
    """Read the byte at which the summary begins, and its bytes.

    Raises DamagedError without a footer or a summary, or where a checksum is given and wrong.

    size: of the file, bytes.
    """
    at = size - FOOTER_SIZE - len(MAGIC)
    if at < len(MAGIC) or head(stream, at, size) != (FOOTER, 20):
        raise DamagedError("no footer")
    start, _, crc = fields("<QQI", stream.read(20))
    if not len(MAGIC) <= start < at or at - start > LARGEST_CHUNK:
        raise DamagedError("no summary")
    stream.seek(start)
    section = stream.read(at - start)
    stream.seek(at)
    if crc and zlib.crc32(stream.read(FOOTER_SIZE - 4), zlib.crc32(section)) != crc:
        raise DamagedError("its checksum is wrong")
    return start, section


def _parse(section: bytes, start: int) -> Summary:
    """Parse a summary: definitions, place and topics of each chunk, counts by topic.

    Raises DamagedError where chunks overlap or their number is not the stated one.

    section: bytes of the summary. start: the byte of the file at which it begins.
    """
    definitions = Definitions()
    # of each chunk: first byte, byte behind it and its indices, log time of its first and last
    # message, numbers of the channels that it holds
    notes: list[tuple[int, int, int, int, list[int]]] = []
    by_channel: dict[int, int] = {}
    chunks = None
    for opcode, body in records(section):
        if opcode == CHUNK_INDEX:
            start_ns, end_ns, offset, size, length = fields("<QQQQI", body)
            indices = fields("<Q", body, 36 + length)[0]
            held = [fields("<H", body, at)[0] for at in range(36, 36 + length, 10)]
            notes.append((offset, offset + size + indices, start_ns, end_ns, held))
        elif opcode == STATISTICS:
            chunks, length = fields("<I", body, 22)[0], fields("<I", body, 42)[0]
            by_channel = dict(fields("<HQ", body, at) for at in range(46, 46 + length, 10))  # type: ignore[misc]
        else:
            definitions.take(opcode, body)
    notes.sort()
    following = [*(note[0] for note in notes), start][1:]
    if any(note[1] > behind for note, behind in zip(notes, following, strict=True)):
        raise DamagedError("its chunks overlap")
    if notes and chunks not in (None, len(notes)):
        raise DamagedError("it does not name every chunk")
    names = {number: channel.topic for number, channel in definitions.channels.items()}
    counts: dict[str, int] = {}
    for number, count in by_channel.items():
        if number in names:
            counts[names[number]] = counts.get(names[number], 0) + count
    named = (
        ChunkNote(
            offset=o,
            end=e,
            start_ns=first,
            end_ns=last,
            topics=tuple(sorted({names[c] for c in held if c in names})),
        )
        for o, e, first, last, held in notes
    )
    return Summary(chunks=tuple(named), counts=counts, definitions=definitions, start=start)
