# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How each dive of a fleet ended last, kept between calls."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import msgspec

from hullrecon.api.fleet.packages import as_utf8
from hullrecon.artifacts.disk import write_file
from hullrecon.artifacts.documents import DamagedArtifactError, seal, unseal

FOLDER = ".fleet"  # in RUNS, no dive can have this name
# Exit codes of failures whose cause is in package or program. Other causes (a full disk, a lock, a
# kill) may be gone by the next call.
LASTING = (1, 2, 3, 4)
# Time after which such a failure is tried again: it may have had another cause, such as a lack of
# memory
TRIED_AGAIN_S = 86_400.0


@dataclass(frozen=True, kw_only=True)
class Terms:
    """What a dive of a fleet may do."""

    allow_outside: bool = False  # read files outside its package
    time_limit_s: float | None = None  # None for no limit


class DiveRecord(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a dive ended last, with the state of package, result and program at that time."""

    name: str | None
    package: str  # signature (hash of names, sizes and times) of the package's files
    result: str  # of the files of its run
    program: str  # of hullrecon's own files
    exit_code: int
    reason: str
    refused: bool  # it was not run
    ended_s: float  # since 1970
    allow_outside: bool = False
    time_limit_s: float | None = None  # the limit that ended it, None if no limit did

    def is_likely_to_recur(self, terms: Terms) -> bool:
        """Decide whether a failed dive, run again unchanged, would most likely fail again.

        It may not after TRIED_AGAIN_S, or if the terms now allow more time, or files outside.
        """
        more_time = self.time_limit_s is not None and (
            terms.time_limit_s is None or terms.time_limit_s > self.time_limit_s
        )
        return (
            self.exit_code in LASTING
            and not self.refused
            and not more_time
            and not (terms.allow_outside and not self.allow_outside)
            and 0 <= time.time() - self.ended_s < TRIED_AGAIN_S
        )


class FleetRecords:
    """The records of a folder of runs by package, in one document rewritten after each dive."""

    def __init__(self, runs: Path) -> None:
        """Read the records of earlier calls in the folder of runs, none if they are damaged."""
        self._path = runs / FOLDER / "dives.json"
        try:
            document = unseal(self._path.read_bytes())
            self._records = msgspec.convert(document, dict[str, DiveRecord])
        except (OSError, DamagedArtifactError, msgspec.ValidationError):
            self._records = {}  # each dive then counts as new

    def get(self, package: Path) -> DiveRecord | None:
        return self._records.get(as_utf8(package))

    def put(self, package: Path, record: DiveRecord) -> None:
        """Remember how a dive ended, durably."""
        self._records[as_utf8(package)] = record
        write_file(self._path, seal(msgspec.to_builtins(self._records)))

    def forget_all_but(self, dives: Path, packages: Iterable[Path]) -> None:
        """Forget the packages that are gone from a folder of dives, from the next `put` on."""
        there = {as_utf8(package) for package in packages}
        self._records = {
            key: record
            for key, record in self._records.items()
            if key in there or not Path(key).is_relative_to(dives)
        }
