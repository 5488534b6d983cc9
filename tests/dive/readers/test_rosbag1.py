# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import io
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hullrecon.dive.logs.formats.bag_records import record
from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.readers import rosbag1
from hullrecon.dive.logs.readers.rosbag1 import Rosbag1Log, find_chunk
from hullrecon.findings.finding import Finding, sentences

QUICK = settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)

NO_CHECKSUM = [Finding("bag-no-checksum")]


@pytest.fixture(scope="module")
def whole(kit, tmp_path_factory) -> Path:
    return kit.bag1(tmp_path_factory.mktemp("bag") / "dive.bag", kit.dive(ros=1))


def read(path: Path):
    log = Rosbag1Log(path)
    return list(log.messages()), log


def broken(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "broken.bag"
    path.write_bytes(data)
    return path


def test_a_whole_bag_gives_every_message_in_order(kit, whole):
    messages, log = read(whole)
    assert [(m.channel.topic, m.t_ns) for m in messages] == [(e.topic, e.t_ns) for e in kit.dive()]
    assert log.losses() == []
    assert log.notes == NO_CHECKSUM


def test_messages_decode_by_the_definition_in_the_bag(whole):
    messages, _ = read(whole)
    ping = next(m for m in messages if m.channel.topic == "/dvl")
    assert decode(ping.channel, ping.data).velocity.z == pytest.approx(0.3)


@pytest.mark.parametrize("compression", ["BZ2", "LZ4"])
def test_compressed_chunks_are_read(kit, tmp_path, compression):
    messages, log = read(kit.bag1(tmp_path / "x.bag", kit.dive(ros=1), compression=compression))
    assert len(messages) == len(kit.dive())
    assert log.losses() == []


@pytest.mark.parametrize("compression", [None, "LZ4"])
def test_the_whole_messages_of_a_cut_chunk_are_read(kit, tmp_path, compression):
    entries = [e for e in kit.dive(ros=1, seconds=200) if e.topic == "/imu"]
    content = kit.bag1(tmp_path / "x.bag", entries, 1 << 30, compression).read_bytes()
    messages, log = read(broken(tmp_path, content[: len(content) // 2]))
    assert 0.3 * len(entries) < len(messages) < len(entries)
    assert [m.t_ns for m in messages] == [e.t_ns for e in entries[: len(messages)]]
    assert [loss.start_ns for loss in log.losses()] == [messages[-1].t_ns]


@pytest.mark.parametrize("share", [0.25, 0.5, 0.9])
def test_cut_bag_gives_whole_messages_and_losses_by_topic(kit, tmp_path, whole, share):
    data = whole.read_bytes()
    messages, log = read(broken(tmp_path, data[: int(share * len(data))]))
    everything = [(e.topic, e.t_ns) for e in kit.dive()]
    assert [(m.channel.topic, m.t_ns) for m in messages] == everything[: len(messages)]
    assert 0 < len(messages) < len(everything)
    assert {loss.topic: loss.start_ns for loss in log.losses()} == {
        m.channel.topic: m.t_ns for m in messages
    }
    assert any("cut short" in note for note in sentences(log.notes))


def test_a_bag_without_its_index_loses_nothing_else(kit, tmp_path, whole):
    data = bytearray(whole.read_bytes())
    at = data.find(b"index_pos=") + 10
    data[at : at + 8] = bytes(8)
    messages, _ = read(broken(tmp_path, bytes(data)))
    assert len(messages) == len(kit.dive())


def test_damaged_chunk_is_lost_alone_with_span_and_counts(kit, tmp_path, whole):
    data = bytearray(whole.read_bytes())
    at = data.find(b"compression=none", len(data) // 2)
    data[at + 12 : at + 16] = b"n\x00ne"
    messages, log = read(broken(tmp_path, bytes(data)))
    gone = Counter(e.topic for e in kit.dive()) - Counter(m.channel.topic for m in messages)
    assert sum(gone.values()) > 0
    assert {loss.topic: loss.messages for loss in log.losses()} == dict(gone)
    assert all(loss.start_ns <= loss.end_ns for loss in log.losses())


def test_damage_without_index_skips_to_next_whole_chunk(kit, tmp_path, whole):
    data = bytearray(whole.read_bytes())
    at = data.find(b"index_pos=") + 10
    data[at : at + 8] = bytes(8)
    at = data.find(b"compression=none", len(data) // 3) - 8
    data[at : at + 4] = b"\xff\xff\xff\xff"
    messages, log = read(broken(tmp_path, bytes(data)))
    assert messages[-1].t_ns == kit.dive()[-1].t_ns
    assert len(messages) < len(kit.dive())
    assert log.losses()


@QUICK
@given(st.data())
def test_any_flipped_bit_is_survived(whole, tmp_path, data):
    content = bytearray(whole.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    messages, log = read(broken(tmp_path, bytes(content)))
    assert len(messages) >= 0.5 * len(list(Rosbag1Log(whole).messages()))
    assert all(loss.why for loss in log.losses())


@QUICK
@given(st.data())
def test_any_cut_is_survived_and_loses_nothing_unsaid(whole, tmp_path, data):
    content = whole.read_bytes()
    messages, log = read(broken(tmp_path, content[: data.draw(st.integers(1, len(content) - 1))]))
    original = [m.t_ns for m in Rosbag1Log(whole).messages()]
    assert [m.t_ns for m in messages] == original[: len(messages)]
    assert (
        len(messages) == len(original)
        or log.losses()
        or any("cut short" in note for note in sentences(log.notes))
    )


@QUICK
@given(st.binary(max_size=400))
def test_any_bytes_behind_the_magic_are_survived(tmp_path, tail):
    messages, _ = read(broken(tmp_path, b"#ROSBAG V2.0\n" + tail))
    assert messages == []


def test_a_real_bag_with_types_of_its_own_is_read_and_decoded(data):
    messages, log = read(data / "ros1-micron-bag" / "static_sonar.bag")
    assert Counter(m.channel.topic for m in messages)["/tritech_micron/scan"] == 553
    assert len(messages) == 2784
    assert log.losses() == []
    config = next(m for m in messages if m.channel.type == "tritech_micron/TritechMicronConfig")
    assert decode(config.channel, config.data).header.stamp.sec > 1_500_000_000


def test_half_of_a_real_bag_gives_its_whole_messages(data, tmp_path):
    content = (data / "ros1-micron-bag" / "static_sonar.bag").read_bytes()
    messages, log = read(broken(tmp_path, content[: len(content) // 2]))
    assert len(messages) == 1398
    assert {loss.topic for loss in log.losses()} == {m.channel.topic for m in messages}


class CountedBytes(io.BytesIO):
    """Counts what is read from it."""

    count = 0

    def read(self, size: int | None = -1) -> bytes:
        out = super().read(size)
        self.count += len(out)
        return out


def head_of_chunk(count: int, op: int = 5) -> bytes:
    parts = [b"op=" + bytes([op]), b"compression=none", b"size=" + count.to_bytes(4, "little")]
    head = b"".join(len(part).to_bytes(4, "little") + part for part in parts)
    return len(head).to_bytes(4, "little") + head + count.to_bytes(4, "little")


def test_false_chunk_heads_are_skipped_without_reading_data():
    """Each claims a byte more than the file has: reading them would take the square of it."""
    size, data = 1 << 20, bytearray()
    while len(data) < size - 100:
        data += head_of_chunk(size - len(data))
    data += bytes(size - len(data))
    stream = CountedBytes(data)
    assert find_chunk(stream, 13, size) == size
    assert stream.count < 2 * size


def test_damaged_chunks_are_read_in_time_linear_in_file_size(tmp_path, monkeypatch):
    size, data = 300_000, bytearray(b"#ROSBAG V2.0\n")
    width = len(head_of_chunk(0))
    while len(data) < size - 100:
        data += head_of_chunk(size - len(data) - width)
    data += b"\xff" * (size - len(data))
    opened = []
    monkeypatch.setattr(
        rosbag1, "record", lambda s, at, end: opened.append(end - at) or record(s, at, end)
    )
    messages, log = read(broken(tmp_path, bytes(data)))
    assert messages == []
    assert log.losses()
    assert sum(opened) < 8 * size


def test_index_that_repeats_a_chunk_is_not_trusted(kit, tmp_path, whole):
    """Each of a hundred thousand entries would unpack the same chunk."""
    data = bytearray(whole.read_bytes())
    positions = [at + 10 for at in range(len(data)) if data[at : at + 10] == b"chunk_pos="]
    data[positions[1] : positions[1] + 8] = data[positions[0] : positions[0] + 8]
    messages, log = read(broken(tmp_path, bytes(data)))
    assert len(messages) == len(kit.dive())
    assert any("no usable index" in note for note in sentences(log.notes))


@pytest.mark.parametrize("op", [1, 4, 7, 2])
def test_chunk_of_damaged_kind_is_a_gap_without_index(kit, tmp_path, whole, op):
    data = bytearray(whole.read_bytes())
    at = data.find(b"index_pos=") + 10
    data[at : at + 8] = bytes(8)
    at = data.find(b"op=\x05", len(data) // 3)
    data[at + 3] = op
    messages, log = read(broken(tmp_path, bytes(data)))
    assert 0 < len(messages) < len(kit.dive())
    assert log.losses()


@pytest.mark.parametrize("compression", ["BZ2", "LZ4"])
def test_compressed_chunk_without_its_checksum_is_damaged(kit, tmp_path, compression):
    """The stream's last bytes, behind all of its content, are its checksum."""
    path = kit.bag1(tmp_path / "x.bag", kit.dive(ros=1), compression=compression)
    data = bytearray(path.read_bytes())
    magic = {"BZ2": b"BZh9", "LZ4": b"\x04\x22\x4d\x18"}[compression]
    at = data.find(magic)
    size = int.from_bytes(data[at - 4 : at], "little")
    data[at - 4 : at] = (size - 4).to_bytes(4, "little")
    del data[at + size - 4 : at + size]
    messages, log = read(broken(tmp_path, bytes(data)))
    assert len(messages) < len(kit.dive())
    assert log.losses()


def test_missing_chunk_checksums_are_noted_where_absent(kit, tmp_path):
    assert read(kit.bag1(tmp_path / "a.bag", kit.dive(ros=1)))[1].notes == NO_CHECKSUM
    assert (
        sentences(read(kit.bag1(tmp_path / "b.bag", kit.dive(ros=1), compression="BZ2"))[1].notes)
        == []
    )


def test_a_bag_that_ends_between_two_records_is_a_gap_to_the_end(tmp_path, whole):
    data = whole.read_bytes()
    with whole.open("rb") as stream:
        at = 13
        while at < len(data) // 2:
            *_, at = record(stream, at, len(data))
    messages, log = read(broken(tmp_path, data[:at]))
    assert messages
    assert {loss.why for loss in log.losses()} == {f"the file ends at byte {at} without its index"}


@pytest.mark.parametrize("size", [1, 13])
def test_a_bag_that_is_no_more_than_its_first_bytes_is_a_loss(tmp_path, whole, size):
    messages, log = read(broken(tmp_path, whole.read_bytes()[:size]))
    assert messages == []
    assert log.losses()
