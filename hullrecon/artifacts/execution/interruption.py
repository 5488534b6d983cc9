# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C and SIGTERM, remembered: libraries turn a KeyboardInterrupt in their import into errors of
their own.
"""

from __future__ import annotations

import signal
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_requested: list[int] = []


def listen() -> None:
    """Let SIGINT and SIGTERM raise KeyboardInterrupt from now on, and forget those that came
    before.
    """
    _requested.clear()
    for number in _SIGNALS:
        signal.signal(number, _interrupt)


def is_requested() -> bool:
    """Return whether a signal has come, whatever became of its KeyboardInterrupt."""
    return bool(_requested)


def raise_if_requested() -> None:
    """Raise KeyboardInterrupt where a signal has come and some library has swallowed it."""
    if _requested:
        raise KeyboardInterrupt


def _interrupt(number: int, frame: FrameType | None) -> None:
    _requested.append(number)
    raise KeyboardInterrupt
