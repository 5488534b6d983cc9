# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""diff: what changed on a hull from one run to another."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.change.options import ChangeOptions
from hullrecon.errors import StorageError
from hullrecon.records.change import HullChange
from hullrecon.steps.change import FinishedRun, compare_runs, map_of, read_run

DOCUMENT = "change.json"


@dataclass(frozen=True, kw_only=True)
class RunComparison:
    """What changed, with both runs."""

    change: HullChange
    first: FinishedRun
    second: FinishedRun


def diff(
    first: Path | str,
    second: Path | str,
    options: ChangeOptions = ChangeOptions(),  # noqa: B008
) -> RunComparison:
    """Find what changed on a hull from one run (RUNS/<dive>) to another.

    options: sizes and significance of the changes that are looked for.

    Raises InputError if a run is not a finished run with a CAD model, or if the CAD models are of
    different hulls. Raises StageError if the runs saw too little of the same hull.
    """
    before, after = read_run(Path(first)), read_run(Path(second))
    return RunComparison(change=compare_runs(before, after, options), first=before, second=after)


def write_change(folder: Path, found: RunComparison) -> tuple[str, ...]:
    """Write change.json, change.csv, layers, map and page into a folder. Returns their names.

    Raises StorageError if the folder holds anything but an earlier comparison.
    """
    from hullrecon.report.change.files import comparison_files

    if folder.is_dir() and any(folder.iterdir()) and not (folder / DOCUMENT).is_file():
        raise StorageError(
            "the folder is not empty", where=str(folder), remedy="name a new one by --out"
        )
    files = comparison_files(found.change, map_of(found.first), found.second.last_t_ns)
    out = ArtifactWriter(folder)
    for name, data in files.items():
        out.bytes(name, data)
    return tuple(files)
