# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stop at the first part of a package that cannot be used, as a run does, or go on and list all of
them, as `check` does.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hullrecon.errors import InputError


class Problems:
    """found: what could not be used, in the order of reading; empty where the first one is raised."""

    def __init__(self, *, go_on: bool = False) -> None:
        self._go_on = go_on
        self.found: list[InputError] = []

    @contextmanager
    def collect(self) -> Iterator[None]:
        """Keep an InputError of the block and go on behind it, or let it pass."""
        try:
            yield
        except InputError as error:
            if not self._go_on:
                raise
            if all(error.line() != known.line() for known in self.found):
                self.found.append(error)
