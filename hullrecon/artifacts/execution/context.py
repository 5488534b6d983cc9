# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a stage's function is handed."""

from __future__ import annotations

import logging
import multiprocessing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from hullrecon.artifacts.execution.executor import Executor
from hullrecon.artifacts.execution.interruption import raise_if_requested
from hullrecon.artifacts.execution.machine import peak_rss
from hullrecon.artifacts.execution.progress import Progress, length
from hullrecon.artifacts.graph.job import Job
from hullrecon.artifacts.graph.stage import Writer

Item = TypeVar("Item")
Result = TypeVar("Result")
log = logging.getLogger(__name__)


class StageContext:
    """Implements `stage.Context`. `warnings`, `times` (s, by name) and `workers_peak_rss` (bytes)
    are read by the runner when the stage has ended.
    """

    def __init__(
        self, job: Job, out: Writer, executor: Executor, progress: Progress
    ) -> None:  # fmt: skip
        self.settings, self.inputs, self.out = job.settings, job.inputs, out
        self.failures: Mapping[str, str] = job.recipe.failures
        self.warnings: list[str] = []
        self.times: dict[str, list[float]] = {}
        self.workers_peak_rss = 0
        self._stage, self._source = job.stage, job.source
        self._executor, self._progress = executor, progress

    @property
    def source(self) -> Path:
        if self._source is None or self._stage.external is None:
            raise RuntimeError(
                f"step {self._stage.name} reads the package without declaring `external` files"
            )
        return self._source

    @property
    def parameters(self) -> Any:
        return self.settings[self._stage.name]

    def progress(
        self, items: Iterable[Item], label: str, total: int | None = None
    ) -> Iterable[Item]:
        total = total if total is not None else length(items)
        return self._progress.track(
            _until_interrupted(items), f"{self._stage.name}: {label}", total
        )

    def map(
        self, function: Callable[[Item], Result], items: Sequence[Item], label: str
    ) -> list[Result]:
        results = list(self.progress(self._executor.map(function, items), label, len(items)))
        workers = (peak_rss(worker.pid) for worker in multiprocessing.active_children())
        self.workers_peak_rss = max(self.workers_peak_rss, *workers, 0)
        return results

    def warn(self, message: str) -> None:
        log.warning("%s: %s", self._stage.name, message)
        self.warnings.append(message)

    def record_times(self, name: str, seconds: Sequence[float]) -> None:
        self.times[name] = [round(float(s), 3) for s in seconds]


def _until_interrupted(items: Iterable[Item]) -> Iterator[Item]:
    for item in items:
        raise_if_requested()
        yield item
