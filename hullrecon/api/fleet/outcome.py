# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The states of a fleet's dives, for people and for programs (fleet.schema.json)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from hullrecon.api.fleet.packages import Skipped, as_utf8, list_folder, one_line
from hullrecon.artifacts.workspace import PUBLISHED
from hullrecon.errors import StageError

State = Literal["delivered", "up to date", "failed", "to do"]


@dataclass(frozen=True, kw_only=True)
class FleetDive:
    """The state of one dive."""

    package: Path  # absolute
    name: str | None  # dive.name, None if unknown
    state: State
    exit_code: int | None  # of its run, None if it is still to do
    reason: str  # why it failed or is to do
    ran: bool  # in this call
    known: bool  # the last call found the same failure
    files: tuple[str, ...]  # of the package, relative to it
    log: Path | None  # of its last run, None without a log
    delivered: bool  # deliver/ is of its last run, in which a step may have failed alone

    def line(self) -> str:
        """Describe a failed dive in one line, whatever its names and messages hold."""
        return one_line(f"failed: {self.package.name}: exit code {self.exit_code}: {self.reason}")


@dataclass(frozen=True, kw_only=True)
class FleetResult:
    """The state of a folder of dives. Paths are absolute."""

    dives_folder: Path
    runs: Path
    dives: tuple[FleetDive, ...]
    skipped: tuple[Skipped, ...]

    def count(self, *states: State) -> int:
        return sum(dive.state in states for dive in self.dives)

    @property
    def exit_code(self) -> int:
        """0 if no dive failed, else 4."""
        return StageError.exit_code if self.count("failed") else 0

    def summary(self) -> str:
        """Count in one line the dives that are delivered, failed, to do or run now."""
        to_do, ran = self.count("to do"), sum(dive.ran for dive in self.dives)
        return (
            f"{len(self.dives)} dive{'s' if len(self.dives) > 1 else ''}:"
            f" {self.count('delivered', 'up to date')} delivered, {self.count('failed')} failed,"
            f" {f'{to_do} to do' if to_do else f'{ran} run now'}"
        )

    def document(self) -> dict[str, object]:
        """Build the document that --json prints."""
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
        """Describe one dive for `document`."""
        deliver = self.runs / dive.name / PUBLISHED if dive.name and dive.delivered else None
        files = list_folder(deliver, deliver).files if deliver is not None else ()
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
            "deliver_files": list(map(as_utf8, files)),
        }
