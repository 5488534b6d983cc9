# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The type of the function that spreads work on tiles and images over threads or processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol, TypeVar

Item = TypeVar("Item")
Made = TypeVar("Made")


class Stream(Protocol):
    """Map a function over items, and yield the results in the items' order.

    The label names the items in progress lines.
    """

    def __call__(
        self, make: Callable[[Item], Made], items: Sequence[Item], label: str, /
    ) -> Iterator[Made]: ...
