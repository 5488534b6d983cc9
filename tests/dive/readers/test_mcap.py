# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import IndexType

from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.readers.mcap import McapLog

QUICK = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], derandomize=True)


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
    assert log.remarks == []


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


def test_damage_in_a_file_without_chunks_is_told_by_the_checksum_over_all(kit, tmp_path):
    data = bytearray(kit.mcap(tmp_path / "x.mcap", kit.dive(), use_chunking=False, enable_data_crcs=True).read_bytes())
    data[data.find(b"\x00\x01\x00\x00", 5000) + 30] ^= 1
    _, log = read(broken(tmp_path, bytes(data)))
    assert any("checksum" in loss.why or "damaged" in loss.why for loss in log.losses())


def test_a_file_without_a_summary_is_read_from_its_start_without_loss_of_messages(kit, tmp_path):
    path = kit.mcap(
        tmp_path / "x.mcap", kit.dive(), index_types=IndexType.NONE, use_statistics=False, use_summary_offsets=False
    )
    messages, _ = read(path)
    assert len(messages) == len(kit.dive())


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_a_cut_file_gives_its_whole_chunks_and_says_from_when_on_each_topic_is_lost(kit, tmp_path, whole, share):
    data = whole.read_bytes()
    messages, log = read(broken(tmp_path, data[: int(share * len(data))]))
    everything = [(e.topic, e.t_ns) for e in kit.dive()]
    assert 0 < len(messages) < len(everything)
    assert [(m.channel.topic, m.t_ns) for m in messages] == everything[: len(messages)]
    last = {m.channel.topic: m.t_ns for m in messages}
    assert {loss.topic: loss.start_ns for loss in log.losses()} == last
    assert all(loss.end_ns is None for loss in log.losses())
    assert any("cut short" in remark for remark in log.remarks)


@pytest.mark.parametrize(("share", "least"), [(0.25, 1510), (0.5, 3095), (0.95, 6128)])
def test_a_cut_simulated_dive_gives_all_that_its_whole_chunks_hold(data, tmp_path, share, least):
    content = (data / "dive-a" / "logs" / "dive.mcap").read_bytes()
    messages, log = read(broken(tmp_path, content[: int(share * len(content))]))
    assert len(messages) == least
    assert len(log.losses()) == 7


def test_a_flipped_bit_in_a_chunk_loses_that_chunk_alone_and_names_its_span_and_counts(kit, tmp_path, whole):
    data = bytearray(whole.read_bytes())
    data[len(data) // 2] ^= 0x10
    messages, log = read(broken(tmp_path, bytes(data)))
    gone = Counter(e.topic for e in kit.dive()) - Counter(m.channel.topic for m in messages)
    assert {loss.topic: loss.messages for loss in log.losses()} == dict(gone)
    assert all(loss.start_ns < loss.end_ns for loss in log.losses())
    lost_times = {e.t_ns for e in kit.dive()} - {m.t_ns for m in messages}
    assert min(loss.start_ns for loss in log.losses()) <= min(lost_times)
    assert max(loss.end_ns for loss in log.losses()) >= max(lost_times)


def test_damage_without_a_summary_is_stepped_over_to_the_next_whole_chunk(kit, tmp_path, whole):
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


def test_chunks_without_a_checksum_are_remarked(kit, tmp_path):
    _, log = read(kit.mcap(tmp_path / "x.mcap", kit.dive(), enable_crcs=False))
    assert sum("no checksum" in remark for remark in log.remarks) == 1


def test_reading_twice_gives_the_same(whole):
    log = McapLog(whole)
    assert [m.t_ns for m in log.messages()] == [m.t_ns for m in log.messages()]


@QUICK
@given(st.data())
def test_any_flipped_bit_is_survived_and_loses_nothing_unsaid(kit, whole, tmp_path, data):
    """What comes out is a subset of what was written, byte for byte; what is missing is in the losses."""
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
