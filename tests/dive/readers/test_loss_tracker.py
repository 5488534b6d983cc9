# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from hypothesis import given
from hypothesis import strategies as st

from hullrecon.dive.logs.readers.loss_tracker import MOST_LOSSES, LossTracker
from hullrecon.dive.logs.readers.protocol import Channel, Loss, Message

A, B = Channel("/a", "x/msg/A", "cdr"), Channel("/b", "x/msg/B", "cdr")


def tracker_of(*messages: tuple[Channel, int]) -> LossTracker:
    tracker = LossTracker()
    for channel, t_ns in messages:
        tracker.record(Message(channel, t_ns, b""))
    return tracker


def test_a_log_without_gaps_has_no_losses():
    tracker = tracker_of((A, 1), (B, 2))
    tracker.finish({"/a": 1, "/b": 1})
    assert tracker.losses == []
    assert tracker.seen == {"/a": 1, "/b": 1}


def test_a_message_is_handed_on_as_it_came():
    message = Message(A, 5, b"bytes")
    assert LossTracker().record(message) is message


def test_a_known_span_is_lost_to_the_topics_that_are_named():
    tracker = tracker_of((A, 1), (B, 2))
    tracker.add_loss("a chunk is damaged", 10, 20, ["/b"])
    assert tracker.losses == [Loss("a chunk is damaged", "/b", 10, 20)]


def test_known_span_without_topics_is_lost_to_every_seen_topic():
    tracker = tracker_of((B, 2), (A, 1))
    tracker.add_loss("a chunk is damaged", 10, 20)
    assert [loss.topic for loss in tracker.losses] == ["/a", "/b"]


def test_a_known_span_before_any_message_is_of_no_topic():
    tracker = LossTracker()
    tracker.add_loss("a chunk is damaged", 10, 20)
    assert tracker.losses == [Loss("a chunk is damaged", "", 10, 20)]


def test_a_gap_that_never_closes_runs_to_the_end():
    tracker = tracker_of((A, 7))
    tracker.open_gap("the file is cut off")
    tracker.finish()
    assert tracker.losses == [Loss("the file is cut off", "/a", 7, None)]


def test_two_gaps_end_at_the_same_next_message():
    tracker = tracker_of((A, 7))
    tracker.open_gap("first")
    tracker.open_gap("second")
    tracker.record(Message(A, 9, b""))
    tracker.finish()
    assert [(loss.why, loss.start_ns, loss.end_ns) for loss in tracker.losses] == [
        ("first", 7, 9),
        ("second", 7, 9),
    ]


def test_counted_but_unread_messages_are_a_loss():
    tracker = tracker_of((A, 1))
    tracker.finish({"/a": 3})
    (loss,) = tracker.losses
    assert (loss.topic, loss.messages, loss.start_ns) == ("/a", 2, None)
    assert "holds more of them than could be read" in loss.why


@given(
    st.lists(st.tuples(st.sampled_from([A, B]), st.integers(0, 100), st.booleans()), max_size=30)
)
def test_loss_starts_no_later_than_last_message_before_gap(entries):
    tracker = LossTracker()
    latest = 0
    for channel, t_ns, damaged in entries:
        if damaged:
            tracker.open_gap("damage")
        tracker.record(Message(channel, t_ns, b""))
        latest = max(latest, t_ns)
    tracker.finish()
    assert all(loss.start_ns is None or loss.start_ns <= latest for loss in tracker.losses)
    assert sum(tracker.seen.values()) == len(entries)


def test_losses_without_end_are_counted_and_not_kept():
    """A hostile file has a gap behind each message, and thousands of topics."""
    tracker = LossTracker()
    channels = [Channel(f"/t{n}", "x", "cdr") for n in range(50)]
    for t in range(3000):
        tracker.record(Message(channels[t % 50], t, b""))
        tracker.open_gap("damaged")
    tracker.finish()
    assert MOST_LOSSES <= len(tracker.losses) <= MOST_LOSSES + 51
    assert "more parts could not be read" in tracker.losses[-1].why


def test_counted_messages_become_a_loss_and_none_become_none():
    tracker = LossTracker()
    tracker.count_lost("gone", 0)
    tracker.count_lost("gone", 3)
    assert tracker.losses == [Loss("gone", messages=3)]
