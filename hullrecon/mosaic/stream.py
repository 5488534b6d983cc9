# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Work on tiles and images one by one, in threads: their results, in order."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol, TypeVar

MAX_AT_A_TIME = 8  # tiles; one takes some 100 MB while it is made
Item = TypeVar("Item")
Made = TypeVar("Made")


class Stream(Protocol):
    """Yields what a function makes of items, in their order. The label says what they are."""

    def __call__(
        self, make: Callable[[Item], Made], items: Sequence[Item], label: str, /
    ) -> Iterator[Made]: ...


def in_threads(
    make: Callable[[Item], Made], items: Sequence[Item], label: str = ""
) -> Iterator[Made]:
    """Yield what is made of items in their order, begun ahead in threads. A `Stream`."""
    from concurrent.futures import ThreadPoolExecutor

    count = min(MAX_AT_A_TIME, len(os.sched_getaffinity(0)))
    # Twice as many as there are threads: none waits while an earlier item takes long or is written.
    ahead = 2 * count
    with ThreadPoolExecutor(count) as pool:
        begun = deque(pool.submit(make, item) for item in items[:ahead])
        try:
            for item in items[ahead:]:
                yield begun.popleft().result()
                begun.append(pool.submit(make, item))
            while begun:
                yield begun.popleft().result()
        finally:
            pool.shutdown(cancel_futures=True)
