# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a method costs: processor seconds and multiplications, by stage."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager


class Effort:
    """Tally of a method.

    Multiplications are those of matrices times matrices, which do not depend on the machine:
    n rows updated by k observations cost n n k.
    """

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.multiplications: defaultdict[str, float] = defaultdict(float)
        self._stage = "other"

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add time and multiplications spent inside of this context to a stage, by its name."""
        before, self._stage = self._stage, name
        start = time.process_time()
        try:
            yield
        finally:
            self.seconds[name] += time.process_time() - start
            self._stage = before

    def count(self, *sizes: int) -> None:
        """Count the multiplications of an operation: the product of its sizes, as n k m."""
        product = 1.0
        for size in sizes:
            product *= size
        self.multiplications[self._stage] += product

    @property
    def total_seconds(self) -> float:
        """Seconds of all stages."""
        return sum(self.seconds.values())

    @property
    def total_multiplications(self) -> float:
        """Multiplications of all stages."""
        return sum(self.multiplications.values())

    def with_stages_of(self, other: Effort) -> Effort:
        """Add the stages of another tally to a copy of this one."""
        total = Effort()
        for part in (self, other):
            for name, value in part.seconds.items():
                total.seconds[name] += value
            for name, value in part.multiplications.items():
                total.multiplications[name] += value
        return total
