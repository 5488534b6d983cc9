# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run many cases over worker processes and put what was found into one document."""

from __future__ import annotations

import json
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from itertools import islice
from pathlib import Path
from queue import SimpleQueue
from typing import Any, TypeVar

from benchmarks.fuzz.cases import BAD, Verdict
from benchmarks.fuzz.worker import Worker

BATCH = 50
SHOWN_CASES = 8
KEPT_EVERY_S = 60.0
Row = TypeVar("Row")


@dataclass
class Finding:
    """Failures that look alike: the same verdict at the same place."""

    form: str
    kind: str
    text: str
    cases: list[int] = field(default_factory=list)
    count: int = 0


@dataclass
class Worst:
    """The most that one case of a format took: seconds of the processor, MiB."""

    seconds: float = 0.0
    mib: float = 0.0

    def add(self, verdict: Verdict) -> None:
        """Take one case into account."""
        self.seconds = round(max(self.seconds, verdict.seconds), 3)
        self.mib = round(max(self.mib, verdict.grown_bytes / (1 << 20)), 1)


@dataclass
class Campaign:
    """Verdicts by format, and the failures by how they look."""

    seed: int
    first: int = 0
    verdicts: dict[str, Counter[str]] = field(default_factory=dict)
    findings: dict[tuple[str, str, str], Finding] = field(default_factory=dict)
    worst: dict[str, Worst] = field(default_factory=dict)
    seconds: float = 0.0

    def add(self, form: str, case: int, verdict: Verdict) -> None:
        """Count one verdict."""
        self.verdicts.setdefault(form, Counter())[verdict.kind] += 1
        self.worst.setdefault(form, Worst()).add(verdict)
        if verdict.kind in BAD:
            key = (form, verdict.kind, signature(verdict))
            found = self.findings.setdefault(key, Finding(form, verdict.kind, verdict.text))
            found.count += 1
            found.cases = sorted([*found.cases, case])[:SHOWN_CASES]

    def count(self, form: str) -> int:
        """Count the cases run of a format."""
        return sum(self.verdicts.get(form, Counter()).values())

    def document(self) -> dict[str, Any]:
        """Return the figures, and each failure with the cases that reproduce it."""
        cases = sum(sum(counts.values()) for counts in self.verdicts.values())
        return {
            "seed": self.seed,
            "first": self.first,
            "cases": cases,
            "seconds": round(self.seconds, 1),
            "cases_per_second": round(cases / max(self.seconds, 1e-9), 1),
            "formats": {
                form: dict(sorted(counts.items())) for form, counts in sorted(self.verdicts.items())
            },
            "worst": {form: asdict(worst) for form, worst in sorted(self.worst.items())},
            "failures": [
                {
                    "format": f.form,
                    "verdict": f.kind,
                    "count": f.count,
                    "cases": f.cases,
                    "text": f.text[-3000:],
                }
                for f in sorted(self.findings.values(), key=lambda f: (f.form, f.kind, f.cases))
            ],
        }


def signature(verdict: Verdict) -> str:
    """Return the signature of a failure: a traceback's innermost place of ours and its type."""
    if verdict.kind not in ("traceback", "hang", "memory"):
        return ""
    places = [
        line.strip() for line in verdict.text.splitlines() if line.strip().startswith('File "')
    ]
    ours = [place for place in places if "/hullrecon/" in place]
    last = verdict.text.strip().splitlines()[-1] if verdict.text.strip() else ""
    return f"{(ours or places or [''])[-1]} {last.partition(':')[0]}"


def read_campaign(path: Path) -> Campaign:
    """Return the campaign whose document lies in a file."""
    document = json.loads(path.read_text())
    out = Campaign(document["seed"], document["first"], seconds=document["seconds"])
    out.verdicts = {form: Counter(counts) for form, counts in document["formats"].items()}
    out.worst = {form: Worst(**worst) for form, worst in document["worst"].items()}
    for row in document["failures"]:
        found = Finding(row["format"], row["verdict"], row["text"], row["cases"], row["count"])
        out.findings[found.form, found.kind, signature(Verdict(found.kind, found.text))] = found
    return out


def run_campaign(
    out: Campaign,
    forms: Sequence[str],
    cases: int,
    jobs: int,
    keep: Callable[[], None] = lambda: None,
) -> Campaign:
    """Add cases to a campaign until it has so many, shared among the formats, by `jobs` processes.

    Each format goes on behind the cases that it has. keep: called every minute.
    """
    start, before, kept = time.monotonic(), out.seconds, time.monotonic()
    share = {form: cases // len(forms) + (k < cases % len(forms)) for k, form in enumerate(forms)}
    left = {
        form: range(out.first + out.count(form), out.first + count) for form, count in share.items()
    }
    with (
        tempfile.TemporaryDirectory(prefix="hullrecon-fuzz-") as folder,
        ThreadPoolExecutor(jobs) as pool,
    ):
        workers = SimpleQueue[Worker]()
        for _ in range(jobs):
            workers.put(Worker(Path(folder)))

        def run(batch: tuple[str, range]) -> tuple[str, list[tuple[int, Verdict]]]:
            worker = workers.get()
            try:
                return batch[0], list(worker.run_batch(batch[0], out.seed, batch[1]))
            finally:
                workers.put(worker)

        try:
            for many in batched(_batches(left), 8 * jobs):
                for form, verdicts in pool.map(run, many):
                    for case, verdict in verdicts:
                        out.add(form, case, verdict)
                out.seconds = before + time.monotonic() - start
                if time.monotonic() - kept > KEPT_EVERY_S:
                    keep()
                    kept = time.monotonic()
        finally:
            for _ in range(jobs):
                workers.get().stop()
    return out


def batched(rows: Iterable[Row], count: int) -> Iterator[list[Row]]:
    """Yield lists of so many rows, the last of what is left."""
    rows = iter(rows)
    while some := list(islice(rows, count)):
        yield some


def _batches(left: dict[str, range]) -> Iterator[tuple[str, range]]:
    """Yield formats in turn, so that a campaign that is stopped has seen them all."""
    left = dict(left)
    while any(left.values()):
        for form, cases in left.items():
            if cases:
                yield form, cases[:BATCH]
                left[form] = cases[BATCH:]
