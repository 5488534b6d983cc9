# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Work on items one by one, in threads: their results, in order."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

MAX_AT_A_TIME = 8  # items; a tile of a mosaic takes some 100 MB while it is made
Item = TypeVar("Item")
Made = TypeVar("Made")


def in_threads(
    make: Callable[[Item], Made], items: Sequence[Item], label: str = "", most: int | None = None
) -> Iterator[Made]:
    """Apply a function to items in threads, ahead of use, and yield results in the items' order.

    `label`: what the items are. It is not used here, and is there as other functions that map show
    it. `most`: threads, MAX_AT_A_TIME if None.
    """
    from concurrent.futures import ThreadPoolExecutor

    count = min(most or MAX_AT_A_TIME, len(os.sched_getaffinity(0)))
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
