# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Track by topic what a reader saw and what it could not read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping

from hullrecon.dive.logs.readers.protocol import Loss, Message

MOST_LOSSES = 2000  # that are listed; what a hostile file adds to them is only counted
MOST_TOPICS = 200  # for which a loss is listed one by one; else it is listed once for all
MOST_REASONS = 16  # for one and the same gap


class LossTracker:
    """Losses of one pass over one log. A gap is open until the next message tells its end."""

    def __init__(self) -> None:
        self.losses: list[Loss] = []
        self.seen: Counter[str] = Counter()  # messages by topic
        self._last: dict[str, int] = {}  # time of the latest message by topic, ns
        # gaps whose end is not known yet: why, and where it starts by topic, ns
        self._open: list[tuple[str, dict[str, int]]] = []
        self._more = 0  # losses beyond MOST_LOSSES

    def record(self, message: Message) -> Message:
        """Count a message, close open losses at its time, and return it."""
        if self._open:
            self._close(message.t_ns)
        topic = message.channel.topic
        self.seen[topic] += 1
        self._last[topic] = max(message.t_ns, self._last.get(topic, message.t_ns))
        return message

    def add_loss(self, why: str, start_ns: int, end_ns: int, topics: Collection[str] = ()) -> None:
        """Add the loss of a part with a known span, of every topic seen so far if none is given.

        Beyond MOST_LOSSES it is only counted.
        """
        if self._is_beyond_limit():
            return
        self._add_by_topic(why, dict.fromkeys(topics or self._last, start_ns), end_ns, start_ns)

    def open_gap(self, why: str) -> None:
        """Note the loss of a part of unknown content.

        For each topic the loss lasts from the topic's last message to the next message of the log,
        of any topic.
        """
        if len(self._open) < MOST_REASONS and not self._is_beyond_limit():
            self._open.append((why, dict(self._last)))

    def count_lost(self, why: str, count: int) -> None:
        """Add the loss of messages of which only the count is known."""
        if count:
            self.losses.append(Loss(why, messages=count))

    def finish(self, expected: Mapping[str, int] | None = None) -> None:
        """Close the open gaps at the end of the log, and add the number of missing messages.

        expected: messages by topic, where the log states them. A topic with one loss gets the
        number of its missing messages there, any other a loss of its own that says how many.
        """
        self._close(None)
        rows: dict[str, list[int]] = {}
        for row, loss in enumerate(self.losses):
            rows.setdefault(loss.topic, []).append(row)
        for topic, count in sorted((expected or {}).items()):
            missing = count - self.seen[topic]
            of_topic = rows.get(topic, [])
            if missing > 0 and len(of_topic) == 1:
                (row,) = of_topic
                loss = self.losses[row]
                self.losses[row] = Loss(loss.why, topic, loss.start_ns, loss.end_ns, missing)
            elif missing > 0:
                self.losses.append(
                    Loss(
                        "the log says that it holds more of them than could be read",
                        topic,
                        messages=missing,
                    )
                )
        if self._more:
            self.losses.append(Loss(f"{self._more} more parts could not be read"))
            self._more = 0

    def _is_beyond_limit(self) -> bool:
        """Tell whether MOST_LOSSES are listed already, and count the loss that is to be added."""
        full = len(self.losses) >= MOST_LOSSES
        self._more += full
        return full

    def _close(self, end_ns: int | None) -> None:
        """End all open gaps at a time of the log, None: at its end."""
        for why, last in self._open:
            self._add_by_topic(why, last, end_ns, min(last.values(), default=None))
        self._open = []

    def _add_by_topic(
        self, why: str, starts: Mapping[str, int], end_ns: int | None, start_ns: int | None
    ) -> None:
        """Add a loss for each topic, or one for all where there are more than MOST_TOPICS.

        Parameters
        ----------
        why : what cannot be read
        starts : where the loss begins, by topic, ns
        end_ns : where it ends, None: at the log's end
        start_ns : where it begins if it is added for all topics at once
        """
        named = sorted(starts.items()) if len(starts) <= MOST_TOPICS else []
        self.losses += [Loss(why, topic, start, end_ns) for topic, start in named] or [
            Loss(why, "", start_ns, end_ns)
        ]
