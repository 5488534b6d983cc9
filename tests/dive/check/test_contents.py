# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.dive.check.contents import describe_losses, describe_streams
from hullrecon.dive.logs.readers.loss_tracker import LossTracker
from hullrecon.dive.logs.readers.protocol import Channel, Loss, Message
from hullrecon.findings.finding import sentences
from hullrecon.findings.logs import count_noun
from hullrecon.records.sensors import DvlPings, JointSamples, PressureSamples, SensorRecords

A, B = Channel("/a", "x/msg/A", "cdr"), Channel("/b", "x/msg/B", "cdr")


def test_loss_is_described_with_file_topic_span_count_reason():
    found = [("x.mcap", Loss("its checksum is wrong", "/a", 1_000_000_000, 2_500_000_000, 7))]
    assert sentences(describe_losses(found)) == [
        "x.mcap: /a: from 1970-01-01T00:00:01.000Z to 1970-01-01T00:00:02.500Z is lost (7 "
        "messages): its checksum is wrong"
    ]


def test_an_open_loss_runs_from_the_start_or_to_the_end():
    found = [
        ("x", Loss("w", "/a", 10**9)),
        ("x", Loss("w", "", None, 10**9)),
        ("x", Loss("w", "/a")),
    ]
    assert [line.split(": ", 2)[1:] for line in sentences(describe_losses(found))] == [
        ["/a", "from 1970-01-01T00:00:01.000Z to the end is lost: w"],
        ["every topic", "from the start to 1970-01-01T00:00:01.000Z is lost: w"],
        ["/a", "an unknown part is lost: w"],
    ]


def test_gap_of_a_topic_runs_from_its_last_to_next_message():
    tracker = LossTracker()
    tracker.record(Message(A, 10, b""))
    tracker.record(Message(B, 20, b""))
    tracker.open_gap("hole")
    tracker.record(Message(A, 50, b""))
    tracker.finish()
    assert tracker.losses == [Loss("hole", "/a", 10, 50), Loss("hole", "/b", 20, 50)]


def test_a_gap_before_any_message_is_of_every_topic():
    tracker = LossTracker()
    tracker.open_gap("hole")
    tracker.finish()
    assert tracker.losses == [Loss("hole")]


def test_counts_of_the_log_tell_how_many_messages_a_loss_took():
    tracker = LossTracker()
    tracker.record(Message(A, 10, b""))
    tracker.add_loss("bad", 20, 30, ["/a"])
    tracker.finish({"/a": 4, "/b": 2})
    assert tracker.losses[0] == Loss("bad", "/a", 20, 30, 3)
    assert (tracker.losses[1].topic, tracker.losses[1].messages) == ("/b", 2)


def test_a_silent_spell_and_the_range_of_a_servo_are_told():
    t = np.array([0, 1, 2, 30, 31], np.int64) * 1_000_000_000
    lines = sentences(
        describe_streams(
            SensorRecords(
                pressure=PressureSamples(t_ns=t, depth=np.arange(5.0)),
                tray=JointSamples(t_ns=t, angle=np.radians([0, 10, 20, 30, 45])),
            ),
            {},
        )
    )
    assert (
        "pressure: nothing for 28.0 s from 1970-01-01T00:00:02.000Z to 1970-01-01T00:00:30.000Z"
        in lines
    )
    assert "tray angles run from 0.0 to 45.0 degrees" in lines


def test_a_spell_without_bottom_lock_is_told():
    t = np.arange(60, dtype=np.int64) * 1_000_000_000
    velocity = np.zeros((60, 3))
    velocity[20:30] = np.nan
    pings = DvlPings(
        t_ns=t,
        velocity=velocity,
        velocity_sigma=np.ones(60),
        ranges=np.ones((60, 1)),
        beams=np.array([[0.0, 0.0, 1.0]]),
    )
    lines = sentences(describe_streams(SensorRecords(dvl=pings), {}))
    start, end = "1970-01-01T00:00:19.000Z", "1970-01-01T00:00:30.000Z"
    assert f"velocity of the DVL: nothing for 11.0 s from {start} to {end}" in lines


def test_single_reading_is_described_in_singular_without_rate():
    one = np.array([5], np.int64) * 1_000_000_000
    ping = DvlPings(
        t_ns=one,
        velocity=np.zeros((1, 3)),
        velocity_sigma=np.ones(1),
        ranges=np.array([[2.0]]),
        beams=np.array([[0.0, 0.0, 1.0]]),
    )
    lines = sentences(describe_streams(SensorRecords(dvl=ping), {}))
    assert lines[0] == "dvl: 1 ping in 0.0 s from 1970-01-01T00:00:05.000Z"
    assert "DVL ranges run from 2.00 to 2.00 m" in lines
    assert "DVL speeds reach 0.00 m/s" in lines


def test_rates_are_in_hertz():
    t = np.arange(5, dtype=np.int64) * 500_000_000
    (line, _) = sentences(
        describe_streams(SensorRecords(pressure=PressureSamples(t_ns=t, depth=np.arange(5.0))), {})
    )
    assert line == "pressure: 5 readings in 2.0 s from 1970-01-01T00:00:00.000Z, 2.0 Hz"


def test_sensors_without_readings_are_not_described():
    none = np.zeros(0, np.int64)
    assert (
        sentences(
            describe_streams(SensorRecords(tray=JointSamples(t_ns=none, angle=np.zeros(0))), {})
        )
        == []
    )
    lost = DvlPings(
        t_ns=none,
        velocity=np.zeros((0, 3)),
        velocity_sigma=np.zeros(0),
        ranges=np.zeros((0, 4)),
        beams=np.zeros((4, 3)),
    )
    assert sentences(describe_streams(SensorRecords(dvl=lost), {})) == []


@pytest.mark.parametrize(("count", "text"), [(0, "0 edges"), (1, "1 edge"), (22, "22 edges")])
def test_nouns_follow_their_count(count, text):
    assert count_noun(count, "edge") == text
