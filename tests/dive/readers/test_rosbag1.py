# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.readers.rosbag1 import NO_CHECKSUM, Rosbag1Log

QUICK = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], derandomize=True)


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
    assert log.remarks == [NO_CHECKSUM]


def test_messages_decode_by_the_definition_in_the_bag(whole):
    messages, _ = read(whole)
    ping = next(m for m in messages if m.channel.topic == "/dvl")
    assert decode(ping.channel, ping.data).velocity.z == pytest.approx(0.3)


@pytest.mark.parametrize("compression", ["BZ2", "LZ4"])
def test_compressed_chunks_are_read(kit, tmp_path, compression):
    messages, log = read(kit.bag1(tmp_path / "x.bag", kit.dive(ros=1), compression=compression))
    assert len(messages) == len(kit.dive())
    assert log.losses() == []


@pytest.mark.parametrize("share", [0.25, 0.5, 0.9])
def test_a_cut_bag_gives_its_whole_chunks_and_says_from_when_on_each_topic_is_lost(kit, tmp_path, whole, share):
    data = whole.read_bytes()
    messages, log = read(broken(tmp_path, data[: int(share * len(data))]))
    everything = [(e.topic, e.t_ns) for e in kit.dive()]
    assert [(m.channel.topic, m.t_ns) for m in messages] == everything[: len(messages)]
    assert 0 < len(messages) < len(everything)
    assert {loss.topic: loss.start_ns for loss in log.losses()} == {m.channel.topic: m.t_ns for m in messages}
    assert any("cut short" in remark for remark in log.remarks)


def test_a_bag_without_its_index_loses_nothing_else(kit, tmp_path, whole):
    data = bytearray(whole.read_bytes())
    at = data.find(b"index_pos=") + 10
    data[at : at + 8] = bytes(8)
    messages, _ = read(broken(tmp_path, bytes(data)))
    assert len(messages) == len(kit.dive())


def test_a_damaged_chunk_loses_that_chunk_alone_and_names_span_and_counts(kit, tmp_path, whole):
    data = bytearray(whole.read_bytes())
    at = data.find(b"compression=none", len(data) // 2)
    data[at + 12 : at + 16] = b"n\x00ne"
    messages, log = read(broken(tmp_path, bytes(data)))
    gone = Counter(e.topic for e in kit.dive()) - Counter(m.channel.topic for m in messages)
    assert sum(gone.values()) > 0
    assert {loss.topic: loss.messages for loss in log.losses()} == dict(gone)
    assert all(loss.start_ns <= loss.end_ns for loss in log.losses())


def test_damage_without_an_index_is_stepped_over_to_the_next_whole_chunk(kit, tmp_path, whole):
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
    assert len(messages) == len(original) or log.losses() or any("cut short" in remark for remark in log.remarks)


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


def test_half_of_a_real_bag_gives_what_its_whole_chunks_hold(data, tmp_path):
    content = (data / "ros1-micron-bag" / "static_sonar.bag").read_bytes()
    messages, log = read(broken(tmp_path, content[: len(content) // 2]))
    assert len(messages) == 1079
    assert {loss.topic for loss in log.losses()} == {m.channel.topic for m in messages}
