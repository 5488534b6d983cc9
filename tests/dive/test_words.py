# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from hullrecon.dive.check.messages import losses, spans
from hullrecon.dive.logs.readers.ledger import Ledger
from hullrecon.dive.logs.readers.protocol import Channel, Loss, Message
from hullrecon.records.sensors import JointSamples, PressureSamples

A, B = Channel("/a", "x/msg/A", "cdr"), Channel("/b", "x/msg/B", "cdr")


def test_a_loss_is_told_with_its_file_topic_span_count_and_reason():
    found = [("x.mcap", Loss("its checksum is wrong", "/a", 1_000_000_000, 2_500_000_000, 7))]
    assert losses(found) == [
        "x.mcap: /a: from 1970-01-01T00:00:01.000Z to 1970-01-01T00:00:02.500Z is lost (7 messages): its checksum is wrong"
    ]


def test_an_open_loss_runs_from_the_start_or_to_the_end():
    found = [("x", Loss("w", "/a", 10**9)), ("x", Loss("w", "", None, 10**9)), ("x", Loss("w", "/a"))]
    assert [line.split(": ", 2)[1:] for line in losses(found)] == [
        ["/a", "from 1970-01-01T00:00:01.000Z to the end is lost: w"],
        ["every topic", "from the start to 1970-01-01T00:00:01.000Z is lost: w"],
        ["/a", "an unknown part is lost: w"],
    ]


def test_a_gap_of_each_topic_runs_from_its_last_message_to_the_next_of_the_log():
    ledger = Ledger()
    ledger.saw(Message(A, 10, b""))
    ledger.saw(Message(B, 20, b""))
    ledger.gap("hole")
    ledger.saw(Message(A, 50, b""))
    ledger.finish()
    assert ledger.losses == [Loss("hole", "/a", 10, 50), Loss("hole", "/b", 20, 50)]


def test_a_gap_before_any_message_is_of_every_topic():
    ledger = Ledger()
    ledger.gap("hole")
    ledger.finish()
    assert ledger.losses == [Loss("hole")]


def test_counts_of_the_log_tell_how_many_messages_a_loss_took():
    ledger = Ledger()
    ledger.saw(Message(A, 10, b""))
    ledger.lose("bad", 20, 30, ["/a"])
    ledger.finish({"/a": 4, "/b": 2})
    assert ledger.losses[0] == Loss("bad", "/a", 20, 30, 3)
    assert (ledger.losses[1].topic, ledger.losses[1].messages) == ("/b", 2)


def test_a_silent_spell_and_the_range_of_a_servo_are_told():
    t = np.array([0, 1, 2, 30, 31], np.int64) * 1_000_000_000
    told = spans(
        {
            "pressure": PressureSamples(t_ns=t, depth=np.arange(5.0)),
            "tray": JointSamples(t_ns=t, angle=np.radians([0, 10, 20, 30, 45])),
        },
        {},
    )
    assert "pressure: nothing for 28.0 s from 1970-01-01T00:00:02.000Z to 1970-01-01T00:00:30.000Z" in told
    assert "tray angles run from 0.0 to 45.0 degrees" in told
