# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run many cases over worker processes and put what was found into one document."""

from __future__ import annotations

import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from benchmarks.fuzz.cases import BAD, Verdict
from benchmarks.fuzz.worker import Worker

BATCH = 50
SHOWN_CASES = 8


@dataclass
class Finding:
    """Failures that look alike: the same verdict at the same place."""

    form: str
    kind: str
    text: str
    cases: list[int] = field(default_factory=list)
    count: int = 0


@dataclass
class Campaign:
    """Verdicts by format, and the failures by how they look."""

    seed: int
    verdicts: dict[str, Counter[str]] = field(default_factory=dict)
    findings: dict[tuple[str, str, str], Finding] = field(default_factory=dict)
    seconds: float = 0.0

    def add(self, form: str, case: int, verdict: Verdict) -> None:
        """Count one verdict."""
        self.verdicts.setdefault(form, Counter())[verdict.kind] += 1
        if verdict.kind in BAD:
            key = (form, verdict.kind, signature(verdict))
            found = self.findings.setdefault(key, Finding(form, verdict.kind, verdict.text))
            found.count += 1
            found.cases = sorted([*found.cases, case])[:SHOWN_CASES]

    def document(self) -> dict[str, Any]:
        """Return the figures, and each failure with the cases that reproduce it."""
        cases = sum(sum(counts.values()) for counts in self.verdicts.values())
        return {
            "seed": self.seed, "cases": cases, "seconds": round(self.seconds, 1),
            "cases_per_second": round(cases / max(self.seconds, 1e-9), 1),
            "formats": {form: dict(sorted(counts.items())) for form, counts in sorted(self.verdicts.items())},
            "failures": [
                {"format": f.form, "verdict": f.kind, "count": f.count, "cases": f.cases, "text": f.text[-3000:]}
                for f in sorted(self.findings.values(), key=lambda f: (f.form, f.kind, f.cases))
            ],
        }  # fmt: skip


def signature(verdict: Verdict) -> str:
    """Return what failures of one cause share: of a traceback the innermost place of ours, and its type."""
    if verdict.kind not in ("traceback", "hang", "memory"):
        return ""
    places = [line.strip() for line in verdict.text.splitlines() if line.strip().startswith('File "')]
    ours = [place for place in places if "/hullrecon/" in place]
    last = verdict.text.strip().splitlines()[-1] if verdict.text.strip() else ""
    return f"{(ours or places or [''])[-1]} {last.partition(':')[0]}"


def run_campaign(forms: Sequence[str], cases: int, seed: int, jobs: int, first: int = 0) -> Campaign:
    """Run so many cases, shared among the formats, over `jobs` processes; those of each format are numbered from `first`."""
    out, start = Campaign(seed), time.monotonic()
    share = {form: cases // len(forms) + (k < cases % len(forms)) for k, form in enumerate(forms)}
    batches = list(_batches(share, first))
    with tempfile.TemporaryDirectory(prefix="hullrecon-fuzz-") as folder, ThreadPoolExecutor(jobs) as pool:
        workers = SimpleQueue[Worker]()
        for _ in range(jobs):
            workers.put(Worker(Path(folder)))

        def run(batch: tuple[str, range]) -> tuple[str, list[tuple[int, Verdict]]]:
            worker = workers.get()
            try:
                return batch[0], [(case, worker.run(batch[0], seed, case)) for case in batch[1]]
            finally:
                workers.put(worker)

        try:
            for form, verdicts in pool.map(run, batches):
                for case, verdict in verdicts:
                    out.add(form, case, verdict)
        finally:
            for _ in range(jobs):
                workers.get().stop()
    out.seconds = time.monotonic() - start
    return out


def _batches(share: dict[str, int], first: int) -> Iterator[tuple[str, range]]:
    """Yield formats in turn, so that a campaign that is stopped has seen them all."""
    left = {form: range(first, first + count) for form, count in share.items()}
    while any(left.values()):
        for form, cases in left.items():
            if cases:
                yield form, cases[:BATCH]
                left[form] = cases[BATCH:]
