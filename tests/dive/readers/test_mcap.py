# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses
import io
import os
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import IndexType

from benchmarks.fuzz.records import record_starts
from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.read_streams import read_streams
from hullrecon.dive.logs.readers import mcap as mcap_module
from hullrecon.dive.logs.readers.mcap import McapLog, find_chunk, read_chunk
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

QUICK = settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)


@pytest.fixture(scope="module")
def whole(kit, tmp_path_factory) -> Path:
    return kit.mcap(tmp_path_factory.mktemp("mcap") / "dive.mcap", kit.dive())


def read(path: Path):
    log = McapLog(path)
    return list(log.messages()), log


def broken(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "broken.mcap"
    path.write_bytes(data)
    return path


def test_a_whole_file_gives_every_message_in_order(kit, whole):
    messages, log = read(whole)
    assert [(m.channel.topic, m.t_ns) for m in messages] == [(e.topic, e.t_ns) for e in kit.dive()]
    assert log.losses() == []
    assert sentences(log.notes) == []


def test_messages_decode_by_the_definition_in_the_file(whole):
    messages, _ = read(whole)
    ping = next(m for m in messages if m.channel.topic == "/dvl")
    assert decode(ping.channel, ping.data).velocity.z == pytest.approx(0.3)


@pytest.mark.parametrize("compression", ["none", "lz4", "zstd"])
def test_every_compression_is_read(kit, tmp_path, compression):
    messages, log = read(kit.mcap(tmp_path / "x.mcap", kit.dive(), compression=compression))
    assert len(messages) == len(kit.dive())
    assert log.losses() == []


def test_a_file_without_chunks_is_read(kit, tmp_path):
    messages, log = read(kit.mcap(tmp_path / "x.mcap", kit.dive(), use_chunking=False))
    assert len(messages) == len(kit.dive())
    assert log.losses() == []


def test_damage_without_chunks_is_found_by_the_data_checksum(kit, tmp_path):
    data = bytearray(
        kit.mcap(
            tmp_path / "x.mcap", kit.dive(), use_chunking=False, enable_data_crcs=True
        ).read_bytes()
    )
    data[data.find(b"\x00\x01\x00\x00", 5000) + 30] ^= 1
    _, log = read(broken(tmp_path, bytes(data)))
    assert any("checksum" in loss.why or "damaged" in loss.why for loss in log.losses())


def test_file_without_summary_is_read_completely_from_start(kit, tmp_path):
    path = kit.mcap(
        tmp_path / "x.mcap",
        kit.dive(),
        index_types=IndexType.NONE,
        use_statistics=False,
        use_summary_offsets=False,
    )
    messages, _ = read(path)
    assert len(messages) == len(kit.dive())


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_cut_file_gives_whole_messages_and_losses_by_topic(kit, tmp_path, whole, share):
    data = whole.read_bytes()
    messages, log = read(broken(tmp_path, data[: int(share * len(data))]))
    everything = [(e.topic, e.t_ns) for e in kit.dive()]
    assert 0 < len(messages) < len(everything)
    assert [(m.channel.topic, m.t_ns) for m in messages] == everything[: len(messages)]
    last = {m.channel.topic: m.t_ns for m in messages}
    assert {loss.topic: loss.start_ns for loss in log.losses()} == last
    assert all(loss.end_ns is None for loss in log.losses())
    assert any("cut short" in note for note in sentences(log.notes))


@pytest.mark.parametrize("is_closed", [True, False])
@pytest.mark.parametrize("compression", ["none", "zstd", "lz4"])
def test_the_whole_messages_of_a_cut_chunk_are_read(kit, tmp_path, compression, is_closed):
    """A recorder that is killed may leave the lengths in the head of its last chunk unwritten."""
    entries = [entry for entry in kit.dive(seconds=200) if entry.topic == "/imu"]
    path = kit.mcap(tmp_path / "one.mcap", entries, 1 << 30, compression)
    content = bytearray(path.read_bytes())
    at, end = next(pair for pair in pairwise(boundaries(path)) if content[pair[0]] == 0x06)
    if not is_closed:
        for length in (at + 1, at + 9 + 32 + content[at + 9 + 28]):
            content[length : length + 8] = b"\xff" * 8
    messages, log = read(broken(tmp_path, bytes(content[: (at + 2 * end) // 3])))
    assert 0.3 * len(entries) < len(messages) < len(entries)
    assert [m.t_ns for m in messages] == [e.t_ns for e in entries[: len(messages)]]
    assert [loss.start_ns for loss in log.losses()] == [max(m.t_ns for m in messages)]


@pytest.mark.parametrize(("share", "least"), [(0.25, 1510), (0.5, 3161), (0.95, 6184)])
def test_cut_simulated_dive_gives_all_whole_messages(data, tmp_path, share, least):
    content = (data / "dive-a" / "logs" / "dive.mcap").read_bytes()
    messages, log = read(broken(tmp_path, content[: int(share * len(content))]))
    assert len(messages) == least
    assert len(log.losses()) == 7


def test_flipped_bit_loses_one_chunk_with_span_and_counts(kit, tmp_path, whole):
    data = bytearray(whole.read_bytes())
    data[len(data) // 2] ^= 0x10
    messages, log = read(broken(tmp_path, bytes(data)))
    gone = Counter(e.topic for e in kit.dive()) - Counter(m.channel.topic for m in messages)
    assert {loss.topic: loss.messages for loss in log.losses()} == dict(gone)
    assert all(loss.start_ns < loss.end_ns for loss in log.losses())
    lost_times = {e.t_ns for e in kit.dive()} - {m.t_ns for m in messages}
    assert min(loss.start_ns for loss in log.losses()) <= min(lost_times)
    assert max(loss.end_ns for loss in log.losses()) >= max(lost_times)


def test_damage_without_summary_skips_to_next_whole_chunk(kit, tmp_path, whole):
    data = bytearray(whole.read_bytes()[:-60])
    at = data.find(b"\x04\x00\x00\x00zstd", len(data) // 3) - 37  # the head of a chunk
    data[at] = 0x7E
    messages, log = read(broken(tmp_path, bytes(data)))
    assert log.losses()
    assert messages[-1].t_ns == kit.dive()[-1].t_ns
    assert all(loss.end_ns is not None for loss in log.losses()[: len(log.losses()) // 2])


def test_a_damaged_summary_is_done_without(kit, tmp_path, whole):
    data = bytearray(whole.read_bytes())
    data[-120] ^= 1
    messages, log = read(broken(tmp_path, bytes(data)))
    assert len(messages) == len(kit.dive())
    assert log.losses() == []
    assert [
        note
        for note in sentences(log.notes)
        if "summary is damaged or does not fit its records" in note
    ]


def test_a_chunk_that_was_cut_out_whole_is_no_silence(kit, tmp_path, whole):
    data = whole.read_bytes()
    start, end = next((a, b) for a, b in pairwise(record_starts(data)) if data[a] == 6)
    messages, log = read(broken(tmp_path, data[:start] + data[end:]))
    assert len(messages) < len(kit.dive())
    assert any("whole chunks may be missing" in note for note in sentences(log.notes))


def test_chunks_without_a_checksum_are_remarked(kit, tmp_path):
    _, log = read(kit.mcap(tmp_path / "x.mcap", kit.dive(), enable_crcs=False))
    assert sum("no checksum" in note for note in sentences(log.notes)) == 1


def test_reading_twice_gives_the_same(whole):
    log = McapLog(whole)
    assert [m.t_ns for m in log.messages()] == [m.t_ns for m in log.messages()]


@QUICK
@given(st.data())
def test_any_flipped_bit_is_survived_and_loses_nothing_unsaid(kit, whole, tmp_path, data):
    """What comes out is a subset of what was written, byte for byte; what is missing is in the
    losses.
    """
    content = bytearray(whole.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    messages, log = read(broken(tmp_path, bytes(content)))
    original = [(m.t_ns, m.data) for m in McapLog(whole).messages()]
    assert {(m.t_ns, bytes(m.data)) for m in messages} <= set(original)
    assert len(messages) == len(original) or log.losses()


@QUICK
@given(st.data())
def test_any_cut_is_survived(whole, tmp_path, data):
    content = whole.read_bytes()
    cut = data.draw(st.integers(1, len(content) - 1))
    messages, log = read(broken(tmp_path, content[:cut]))
    original = [m.t_ns for m in McapLog(whole).messages()]
    assert [m.t_ns for m in messages] == original[: len(messages)]
    assert len(messages) == len(original) or log.losses()


@QUICK
@given(st.binary(max_size=400))
def test_any_bytes_behind_the_magic_are_survived(tmp_path, tail):
    messages, _ = read(broken(tmp_path, b"\x89MCAP0\r\n" + tail))
    assert messages == []


def test_the_simulated_dive_is_read_whole(data):
    messages, log = read(data / "dive-a" / "logs" / "dive.mcap")
    assert Counter(m.channel.topic for m in messages)["/imu"] == 2927
    assert len(messages) == 6543
    assert log.losses() == []


def boundaries(path: Path) -> list[int]:
    """The bytes where records start, up to the end of the data."""
    data, at, out = path.read_bytes(), 8, []
    while data[at] != 0x0F:
        out.append(at)
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    return [*out, at]


@pytest.mark.parametrize("opcode", [0x02, 0x0F, 0x01, 0x04, 0x07, 0x86])
def test_chunk_with_damaged_opcode_is_still_read_and_noted(kit, whole, tmp_path, opcode):
    """An opcode of an end, of an index or of a private record where a chunk stands: its bytes say
    that it is a chunk.
    """
    content = whole.read_bytes()
    chunks = [at for at in boundaries(whole) if content[at] == 0x06]
    cut = content[: chunks[-1]]
    expected, _ = read(broken(tmp_path, cut))
    for at in chunks[:3]:
        damaged = bytearray(cut)
        damaged[at] = opcode
        messages, log = read(broken(tmp_path, bytes(damaged)))
        assert [m.data for m in messages] == [m.data for m in expected]
        assert any(f"byte {at}" in note for note in sentences(log.notes))


def test_end_of_data_inside_file_is_a_gap_and_rest_is_read(kit, whole, tmp_path):
    content = whole.read_bytes()
    starts = boundaries(whole)
    middle = starts[len(starts) // 2]
    end = b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00"
    cut = content[: starts[-2]]
    expected, _ = read(broken(tmp_path, cut))
    messages, log = read(broken(tmp_path, cut[:middle] + end + cut[middle:]))
    assert len(messages) == len(expected)
    assert any(f"byte {middle}" in loss.why for loss in log.losses())


@pytest.mark.parametrize("share", [0.2, 0.4, 0.6])
def test_an_inserted_byte_in_a_cut_file_costs_a_chunk_at_most(kit, whole, tmp_path, share):
    content = whole.read_bytes()
    cut = content[: int(0.9 * len(content))]
    expected, _ = read(broken(tmp_path, cut))
    at = next(at for at in boundaries(whole) if at > share * len(cut))
    messages, log = read(broken(tmp_path, cut[:at] + b"\x02" + cut[at:]))
    assert len(messages) > 0.8 * len(expected)
    assert len(messages) == len(expected) or any("damaged" in loss.why for loss in log.losses())


def test_a_closing_part_spliced_into_the_middle_hides_nothing(kit, whole, tmp_path):
    content = whole.read_bytes()
    starts = boundaries(whole)
    middle = starts[len(starts) // 2]
    tail = content[starts[-1] :]
    messages, log = read(broken(tmp_path, content[:middle] + tail + content[middle:]))
    assert len(messages) == len(kit.dive())
    assert log.losses()


def test_summary_naming_only_some_chunks_is_not_trusted(kit, tmp_path):
    path = kit.mcap(
        tmp_path / "x.mcap",
        kit.dive(),
        use_statistics=False,
        index_types=IndexType.CHUNK,
        use_summary_offsets=False,
    )
    data = bytearray(path.read_bytes())
    starts = boundaries(path)
    at = starts[-1] + 13
    while data[at] != 0x08:
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    data[at] = 0x0A  # the index of an attachment, as far as anybody can tell
    data[-12:-8] = bytes(4)  # no checksum over the summary
    messages, _ = read(broken(tmp_path, bytes(data)))
    assert len(messages) == len(kit.dive())


def test_messages_of_topic_without_definition_are_counted(kit, tmp_path):
    path = kit.mcap(
        tmp_path / "x.mcap",
        kit.dive(),
        use_chunking=False,
        repeat_channels=False,
        use_statistics=False,
    )
    data = bytearray(path.read_bytes())
    at = next(at for at in boundaries(path) if data[at] == 0x04)
    data[at] = 0x0C  # metadata
    messages, log = read(broken(tmp_path, bytes(data)))
    gone = len(kit.dive()) - len(messages)
    assert gone == 40
    assert [loss.messages for loss in log.losses()] == [gone]


class CountedBytes(io.BytesIO):
    """Counts what is read from it."""

    count = 0

    def read(self, size: int | None = -1) -> bytes:
        out = super().read(size)
        self.count += len(out)
        return out


def test_false_chunk_heads_are_skipped_without_reading_bodies():
    """Each claims the rest of the file: reading them would take the square of it."""
    size = 1 << 20
    heads = b"".join(
        b"\x06" + (size - at - 9).to_bytes(8, "little") for at in range(0, size - 9, 9)
    )
    stream = CountedBytes(heads)
    assert find_chunk(stream, 8, size) == size
    assert stream.count < 2 * size


def test_damaged_chunks_are_read_in_time_linear_in_file_size(tmp_path, monkeypatch):
    """Heads whose lengths agree, one within the other, each with a wrong checksum."""
    size, data = 200_000, bytearray(b"\x89MCAP0\r\n")
    while len(data) < size - 100:
        length = size - len(data) - 9
        packed = length - 40
        data += (
            b"\x06"
            + length.to_bytes(8, "little")
            + bytes(16)
            + packed.to_bytes(8, "little")
            + b"\x01\x00\x00\x00"
        )
        data += bytes(4) + packed.to_bytes(8, "little")
    data += bytes(size - len(data))
    opened = []
    monkeypatch.setattr(
        mcap_module,
        "read_chunk",
        lambda s, at, end: opened.append(end - at) or read_chunk(s, at, end),
    )
    messages, log = read(broken(tmp_path, bytes(data)))
    assert messages == []
    assert log.losses()
    assert sum(opened) < 8 * size


def test_a_small_file_does_not_unpack_to_gigabytes(tmp_path):
    """Chunks of 64 MiB of zeros in some kilobytes each."""
    packed = zstandard.ZstdCompressor().compress(bytes(1 << 26))
    body = bytes(16) + (1 << 26).to_bytes(8, "little") + bytes(4) + b"\x04\x00\x00\x00zstd"
    body += len(packed).to_bytes(8, "little") + packed
    chunk = b"\x06" + len(body).to_bytes(8, "little") + body
    _, log = read(broken(tmp_path, b"\x89MCAP0\r\n" + 3 * chunk))
    assert any("more than 256 times its size" in loss.why for loss in log.losses())


def test_a_pipe_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "x.mcap")
    with pytest.raises(InputError, match=r"x\.mcap is a pipe, not a file"):
        read(tmp_path / "x.mcap")


def test_names_that_a_terminal_would_obey_are_escaped(kit, tmp_path):
    entries = [
        dataclasses.replace(e, topic="/imu\x1b[2J\n\u202e") for e in kit.dive() if e.topic == "/imu"
    ]
    messages, _ = read(kit.mcap(tmp_path / "x.mcap", entries))
    assert messages[0].channel.topic == "/imu\\x1b[2J\\n\\u202e"


def test_topic_of_lost_type_costs_only_its_messages(kit, tmp_path):
    path = kit.mcap(
        tmp_path / "x.mcap",
        kit.dive(),
        use_chunking=False,
        repeat_schemas=False,
        use_statistics=False,
    )
    data = bytearray(path.read_bytes())
    at = next(at for at in boundaries(path) if data[at] == 0x03)
    data[at] = 0x0C  # the schema of /imu becomes metadata
    found = read_streams(
        [McapLog(broken(tmp_path, bytes(data)))],
        {"/imu": ("imu",), "/dvl": ("dvl",)},
        lambda *_: None,
    )
    assert not found.samples["imu"]
    assert len(found.samples["dvl"]) == 8
    assert [loss.messages for _, loss in found.losses] == [40]
