# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How work on tiles and images is spread."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol, TypeVar

Item = TypeVar("Item")
Made = TypeVar("Made")


class Stream(Protocol):
    """Yields what a function makes of items, in their order. The label says what they are."""

    def __call__(
        self, make: Callable[[Item], Made], items: Sequence[Item], label: str, /
    ) -> Iterator[Made]: ...
