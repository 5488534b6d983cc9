# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a fleet ends with: each dive's state, and all as a document for programs
(report/schemas/fleet.schema.json).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from hullrecon.api.fleet.listing import list_folder
from hullrecon.api.fleet.packages import Skipped
from hullrecon.api.fleet.text import as_utf8, one_line
from hullrecon.artifacts.workspace import PUBLISHED
from hullrecon.errors import StageError

State = Literal["delivered", "up to date", "failed", "to do"]


@dataclass(frozen=True, kw_only=True)
class FleetDive:
    """How one dive stands. name: of the dive, None where unknown; exit_code: of its run, None where
    it is to do; reason: why it failed or is to do; ran: in this call; known: the last call found
    the same failure; files: of the package, relative to it; log: of its last run, None without one;
    delivered: its deliverables are of its last run, which may have failed in a step that the others
    do without.
    """

    package: Path
    name: str | None
    state: State
    exit_code: int | None
    reason: str
    ran: bool
    known: bool
    files: tuple[str, ...]
    log: Path | None
    delivered: bool

    def line(self) -> str:
        """Return a failed dive in one line, whatever its names and messages hold."""
        return one_line(f"failed: {self.package.name}: exit code {self.exit_code}: {self.reason}")


@dataclass(frozen=True, kw_only=True)
class FleetResult:
    """How a folder of dives stands. Paths are absolute."""

    dives_folder: Path
    runs: Path
    dives: tuple[FleetDive, ...]
    skipped: tuple[Skipped, ...]

    def count(self, *states: State) -> int:
        return sum(dive.state in states for dive in self.dives)

    @property
    def exit_code(self) -> int:
        """Return 0 when no dive failed, else 4."""
        return StageError.exit_code if self.count("failed") else 0

    def summary(self) -> str:
        """Return the counts in one line."""
        delivered, failed, to_do = (
            self.count("delivered", "up to date"),
            self.count("failed"),
            self.count("to do"),
        )
        ran = sum(dive.ran for dive in self.dives)
        counts = [
            f"{delivered} delivered",
            f"{failed} failed",
            *([f"{to_do} to do"] if to_do else [f"{ran} run now"]),
        ]
        return f"{len(self.dives)} dive{'s' if len(self.dives) > 1 else ''}: {', '.join(counts)}"

    def document(self) -> dict[str, object]:
        """Return all of it as JSON has it."""
        return {
            "dives_folder": as_utf8(self.dives_folder),
            "runs": as_utf8(self.runs),
            "exit_code": self.exit_code,
            "delivered": self.count("delivered", "up to date"),
            "failed": self.count("failed"),
            "to_do": self.count("to do"),
            "dives": [self._dive(dive) for dive in self.dives],
            "skipped": [{"path": as_utf8(s.path), "reason": s.reason} for s in self.skipped],
        }

    def _dive(self, dive: FleetDive) -> dict[str, object]:
        deliver = (
            self.runs / dive.name / PUBLISHED if dive.name is not None and dive.delivered else None
        )
        return {
            "package": as_utf8(dive.package),
            "name": dive.name,
            "state": dive.state,
            "exit_code": dive.exit_code,
            "reason": as_utf8(dive.reason),
            "ran": dive.ran,
            "log": None if dive.log is None else as_utf8(dive.log),
            "package_files": list(map(as_utf8, dive.files)),
            "deliver": None if deliver is None else as_utf8(deliver),
            "deliver_files": list(_files_of(deliver)),
        }


def _files_of(deliver: Path | None) -> Iterator[str]:
    if deliver is not None:
        yield from map(as_utf8, list_folder(deliver, deliver).files)
