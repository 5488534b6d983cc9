# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Computing many results of the report: one after another, or on several processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from threading import Lock
from typing import Any

# applies a function to items and yields the results in order, as Context.stream does
Stream = Callable[[Callable[[Any], Any], Sequence[Any], str], Iterator[Any]]
Drawing = Callable[[], Any]  # draws a picture, with what it needs bound to it


def draw(drawing: Drawing) -> Any:
    """Draw a picture, on whatever process this is called."""
    return drawing()


def in_turn(stream: Stream) -> Stream:
    """Let threads use a stream, each to its end before the next."""
    lock = Lock()

    def use(function: Callable[[Any], Any], items: Sequence[Any], label: str) -> Iterator[Any]:
        with lock:
            yield from stream(function, items, label)

    return use


def one_by_one(function: Callable[[Any], Any], items: Sequence[Any], _label: str) -> Iterator[Any]:
    """Apply a function to items here, one after another. This is a `Stream`."""
    return map(function, items)
