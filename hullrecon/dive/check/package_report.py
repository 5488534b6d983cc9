# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What `check` found in a package: the findings in order, the verdict, the lines and the JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hullrecon.dive.check.time_overlap import Stream
from hullrecon.dive.ingest.result import IngestResult
from hullrecon.findings.finding import Finding, sentences
from hullrecon.records.clock import rate_hz


@dataclass(frozen=True, kw_only=True)
class PackageCheck:
    """The findings of `check` about a package."""

    name: str  # of the dive
    vessel: str
    found: IngestResult  # what was read
    missing_files: list[Finding]  # those but logs that dive.toml names and that are not there
    unusable: list[Finding]  # what is there but cannot be used, and what to do
    needs: list[Finding]  # required sensors that are absent
    missing: list[Finding]  # what the absence of other sensors means
    to_fill_in: list[Finding]  # keys that the sensors need and dive.toml leaves open
    warnings: list[Finding]  # contradictions
    start_offset: list[Finding]  # of the first image relative to the first ping
    bow: list[Finding]  # which end of the CAD model is taken for it
    regions: list[Finding]  # how much hull each of dive.toml holds
    mounts: list[Finding]  # those that the log gave
    defaults: dict[str, object]  # keys left at their default, with the value used
    costs: list[Finding] = field(default_factory=list)  # of a run: time, memory, disk
    suspects: list[dict[str, object]]  # what may be wrong with a sensor, and how much it explains

    @property
    def findings(self) -> list[Finding]:
        """All findings, in the order in which they are printed."""
        found = self.found
        return [
            *(*found.spans, *self.start_offset, *found.hull_notes, *self.bow, *self.regions),
            *(*self.missing_files, *self.unusable, *self.needs, *found.lost, *found.notes),
            *(*self.mounts, *found.unused, *self.missing, *self.to_fill_in, *self.warnings),
            *self.costs,
        ]

    @property
    def reasons(self) -> list[str]:
        """List all reasons against a run. Empty where a run is possible."""
        return sentences(f for f in self.findings if f.severity == "error")

    @property
    def run_is_possible(self) -> bool:
        return not self.reasons

    @property
    def verdict(self) -> str:
        """Say in one line whether a run is possible, with its assumptions or what prevents it."""
        if self.reasons:
            return f"not ready: {'; '.join(self.reasons)}"
        remaining = [f"{len(self.warnings)} above"] if self.warnings else []
        if self.to_fill_in:
            remaining.append(
                f"to fill in: {', '.join(str(f.values['key']) for f in self.to_fill_in)}"
            )
        return f"ready, with warnings ({'; '.join(remaining)})" if remaining else "ready"

    def lines(self) -> list[str]:
        """Write the report, one sentence per line."""
        defaults = ", ".join(
            f"{key} = {_toml(value)}" for key, value in sorted(self.defaults.items())
        )
        notes = (*self.found.notes, *self.mounts, *self.found.unused)
        return [
            f"{self.name}: {self.vessel}" if self.vessel else self.name,
            *sentences((*self.found.spans, *self.start_offset, *self.found.hull_notes)),
            *sentences((*self.bow, *self.regions, *self.missing_files)),
            *(f"not usable: {line}" for line in sentences(self.unusable)),
            *(f"lost: {line}" for line in sentences(self.found.lost)),
            *(f"note: {line}" for line in sentences(notes)),
            *sentences((*self.missing, *self.to_fill_in)),
            *(f"warning: {line}" for line in sentences(self.warnings)),
            *sentences(self.costs),
            f"defaults used: {defaults}",
            f"verdict: {self.verdict}",
        ]

    def document(self) -> dict[str, object]:
        """Build the report that `--json` prints."""
        streams: Mapping[str, Stream] = {**self.found.records.by_name(), **self.found.images}
        return {
            "name": self.name,
            "vessel": self.vessel,
            "streams": {
                name: _describe_stream(stream)
                for name, stream in streams.items()
                if len(stream.t_ns)
            },
            **self.found.document(),
            "missing_files": [
                f"{f.values['file']} ({f.values['key']})" for f in self.missing_files
            ],
            "unusable": sentences(self.unusable),
            "missing": sentences(self.missing),
            "to_fill_in": sentences(self.to_fill_in),
            "warnings": sentences(self.warnings),
            "bow": next(iter(sentences(self.bow)), None),
            "regions": sentences(self.regions),
            "mounts": sentences(self.mounts),
            "topics": self.found.counts,
            "unused": sentences(self.found.unused),
            "offset": sentences(self.start_offset),
            "defaults": self.defaults,
            "suspects": self.suspects,
            "findings": [finding.document() for finding in self.findings],
            "run_is_possible": self.run_is_possible,
            "verdict": self.verdict,
        }


def _describe_stream(stream: Stream) -> dict[str, int | float]:
    """Summarise a stream of readings for `--json`."""
    t = stream.t_ns
    return {
        "count": len(t),
        "start_ns": int(t[0]),
        "end_ns": int(t[-1]),
        "rate_hz": round(rate_hz(t), 3),
    }


def _toml(value: object) -> str:
    """Format a number, a text or a list of them as TOML."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return f"{value:g}" if isinstance(value, int | float) else f'"{value}"'
