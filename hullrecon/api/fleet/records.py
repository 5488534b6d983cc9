# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a fleet remembers of each package in RUNS/.fleet: how its dive ended, and what package,
result and program were then.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from pathlib import Path

import msgspec

from hullrecon.api.fleet.text import as_utf8
from hullrecon.artifacts.disk import write_file
from hullrecon.artifacts.documents import DamagedArtifactError, seal, unseal

FOLDER = ".fleet"  # in RUNS; no dive can have this name
# Failures that the package or the program decides; a full disk, a lock or a kill may be over by the
# next call.
LASTING = (1, 2, 3, 4)
TRIED_AGAIN_S = 86_400.0  # a failure may have other causes all the same, such as too little memory


class DiveRecord(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a dive ended. package, result, program: signatures; refused: it was not run; ended_s:
    seconds since 1970; allow_outside: it was let read files outside its package; time_limit_s: the
    limit that ended it, None where none did.
    """

    name: str | None
    package: str
    result: str
    program: str
    exit_code: int
    reason: str
    refused: bool
    ended_s: float
    allow_outside: bool = False
    time_limit_s: float | None = None

    @property
    def holds(self) -> bool:
        """Tell whether a failure would most likely come again."""
        return (
            self.exit_code in LASTING
            and not self.refused
            and 0 <= time.time() - self.ended_s < TRIED_AGAIN_S
        )


class FleetRecords:
    """The records of a folder of runs, one document, written whole after each dive."""

    def __init__(self, runs: Path) -> None:
        self._path = runs / FOLDER / "dives.json"
        self._records = _read(self._path)

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


def _read(path: Path) -> dict[str, DiveRecord]:
    """Return what was remembered; nothing where the document is lost or damaged, which costs a look
    at each dive.
    """
    try:
        return msgspec.convert(unseal(path.read_bytes()), dict[str, DiveRecord])
    except (OSError, DamagedArtifactError, msgspec.ValidationError):
        return {}
