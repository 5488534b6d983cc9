# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What changed on the hull since an earlier dive, whose run is named."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import msgspec

from hullrecon.artifacts.manifest import FILE_NAME
from hullrecon.artifacts.stage import Context, Stage, StageSettings
from hullrecon.artifacts.workspace import PUBLISHED
from hullrecon.dive.config.schema import FileName
from hullrecon.errors import InputError, StageError
from hullrecon.records.change import HullChange
from hullrecon.report.change.chapter import change_chapter, is_foreseen
from hullrecon.report.change.deliver import change_files
from hullrecon.steps.artifacts import CHANGE_CHAPTER, HULL_SURVEY_FILES
from hullrecon.steps.finished_run import workspace_of
from hullrecon.steps.hull_survey import FinishedRun, compare_runs, map_of, read_run, read_survey


class EarlierDive(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The dive that this one is compared with."""

    earlier: Annotated[
        FileName | None,
        msgspec.Meta(
            description="folder of an earlier dive's run (RUNS/<dive>), relative to dive.toml; the report says what changed"
        ),
    ] = None


def run(context: Context[EarlierDive]) -> None:
    """Write what changed since the earlier dive: its files, and the texts of the report's chapter."""
    before, change = _compare(context)
    files = change_files(change, map_of(before), _this_dive(context).last_t_ns)
    for name, data in files.items():
        context.out.bytes(name, data)
    context.out.json(CHANGE_CHAPTER, msgspec.to_builtins(change_chapter(change)))
    if not is_foreseen(change.offset):
        context.warn(
            f"{change.first} and this dive lie farther apart on the CAD model than their hull poses foresaw: one of these is"
            " worse than it says"
        )


def _compare(context: Context[EarlierDive]) -> tuple[FinishedRun, HullChange]:
    """Return the earlier dive and what changed since.

    Raises StageError for whatever stands against it: all but the chapter on change goes without the
    earlier dive.
    """
    earlier = str(context.parameters.earlier)
    try:
        before, after = _earlier_dive(context), _this_dive(context)
        return before, compare_runs(before, after)
    except InputError as error:
        what, remedy = error.what, error.remedy
    except OSError as error:
        what, remedy = f"its files cannot be read: {error.strerror}", "give leave to read it"
    raise StageError(
        f"no comparison with an earlier dive: {what}",
        where=f"change.earlier = {earlier}",
        remedy=remedy,
    )


def _earlier_dive(context: Context[EarlierDive]) -> FinishedRun:
    """Return the earlier dive, named by its folder; with the folder above it where both dives have
    one name.
    """
    root = workspace_of(context.source / str(context.parameters.earlier)).root.resolve()
    if root == context.inputs["detect"].resolve().parent:
        raise InputError("that is this dive's own run", remedy="name the run of an earlier dive")
    found = read_run(root)
    if found.survey.name != context.settings["dive.name"]:
        return found
    return replace(found, survey=replace(found.survey, name=f"{root.parent.name}/{root.name}"))


def _this_dive(context: Context[EarlierDive]) -> FinishedRun:
    spacing = context.settings.read_optional("hull.frame_spacing", float)
    return read_survey(context.inputs, context.settings.read("dive.name", str), spacing)


def files_of_earlier_dive(settings: StageSettings, package: Path) -> list[Path]:
    """Return the files of the earlier dive's run that are read, as far as they are there: without
    them the step says why it cannot be done, and the rest of the chain runs.
    """
    earlier = settings.read("change", EarlierDive).earlier
    if earlier is None:
        return []
    root = Path(earlier).parent if Path(earlier).name == PUBLISHED else Path(earlier)
    files = [
        root / step / name
        for step, names in HULL_SURVEY_FILES.items()
        for name in (*names, FILE_NAME)
    ]
    return [
        file
        for file in files
        if os.path.isfile(package / file) and os.access(package / file, os.R_OK)
    ]


def why_not(settings: StageSettings, package: Path) -> str | None:
    """Return why a dive is not compared with an earlier one; None where it is."""
    if settings.read("change", EarlierDive).earlier is None:
        return "no earlier dive is named (change.earlier)"
    return "no CAD model was given" if settings["hull.mesh"] is None else None


STAGE = Stage(
    name="change",
    summary="say what changed since an earlier dive of the hull",
    inputs=("ingest", "adjust", "surface", "detect"),
    parameters=EarlierDive,
    version=3,
    run=run,
    fails_alone=True,
    uses=("dive.name", "hull.mesh", "hull.frame_spacing"),
    external=files_of_earlier_dive,
    applies=why_not,
)
