# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Track by topic what a reader saw and what it could not read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping

from hullrecon.dive.logs.readers.protocol import Loss, Message

MOST_LOSSES = 2000  # that are told apart; what a hostile file adds to them is counted
MOST_TOPICS = 200
MOST_REASONS = 16  # for one and the same gap


class LossTracker:
    """Losses of one pass over one log. A gap is open until the next message tells its end."""

    def __init__(self) -> None:
        self.losses: list[Loss] = []
        self.seen: Counter[str] = Counter()
        self._last: dict[str, int] = {}
        self._open: list[tuple[str, dict[str, int]]] = []
        self._more = 0

    def record(self, message: Message) -> Message:
        """Count a message, close open losses at its time, and return it."""
        if self._open:
            self._close(message.t_ns)
        topic = message.channel.topic
        self.seen[topic] += 1
        self._last[topic] = max(message.t_ns, self._last.get(topic, message.t_ns))
        return message

    def add_loss(self, why: str, start_ns: int, end_ns: int, topics: Collection[str] = ()) -> None:
        """Add the loss of a part with a known span. Without topics, of every topic seen so far."""
        if self._is_full():
            return
        self._add(why, dict.fromkeys(topics or self._last, start_ns), end_ns, start_ns)

    def open_gap(self, why: str) -> None:
        """Open the loss of a part of unknown content.

        For each topic it reaches from its last message to the next message of the log.
        """
        if len(self._open) < MOST_REASONS and not self._is_full():
            self._open.append((why, dict(self._last)))

    def count_lost(self, why: str, count: int) -> None:
        """Add the loss of messages of which only the count is known."""
        if count:
            self.losses.append(Loss(why, messages=count))

    def finish(self, expected: Mapping[str, int] | None = None) -> None:
        """Close what is open, and count lost messages.

        expected: messages by topic, where the log tells them.
        """
        self._close(None)
        rows: dict[str, list[int]] = {}
        for row, loss in enumerate(self.losses):
            rows.setdefault(loss.topic, []).append(row)
        for topic, count in sorted((expected or {}).items()):
            missing = count - self.seen[topic]
            mine = rows.get(topic, [])
            if missing > 0 and len(mine) == 1:
                loss = self.losses[mine[0]]
                self.losses[mine[0]] = Loss(loss.why, topic, loss.start_ns, loss.end_ns, missing)
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

    def _is_full(self) -> bool:
        """Count a loss that is beyond the number kept."""
        full = len(self.losses) >= MOST_LOSSES
        self._more += full
        return full

    def _close(self, end_ns: int | None) -> None:
        for why, last in self._open:
            self._add(why, last, end_ns, min(last.values(), default=None))
        self._open = []

    def _add(
        self, why: str, starts: Mapping[str, int], end_ns: int | None, start_ns: int | None
    ) -> None:
        """Add a loss of each topic from its start on, or one for all where there are too many."""
        named = sorted(starts.items()) if len(starts) <= MOST_TOPICS else []
        self.losses += [Loss(why, topic, start, end_ns) for topic, start in named] or [
            Loss(why, "", start_ns, end_ns)
        ]
