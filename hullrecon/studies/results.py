# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a study leaves on disk: a folder of its id with result.json, pictures and tables."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import msgspec
from msgspec import Struct

from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.errors import InputError
from hullrecon.evaluation.score import without_nan
from hullrecon.studies.study import ComparedValue, Study, StudyResult

RESULT, TABLE, TRACEBACK = "result.json", "table.csv", "traceback.txt"


class KeptFigure(Struct, frozen=True, kw_only=True):
    """A figure of a finished study: <name>.png, .csv and a film's .webm beside the result."""

    name: str
    caption: str
    compared: tuple[ComparedValue, ...] = ()
    moves: bool = False  # there is a film


class KeptStudy(Struct, frozen=True, kw_only=True):
    """What a study came to, as its result.json holds it."""

    id: str
    source: str
    shows: str
    needs_dive: bool
    seconds: float
    failure: str = ""  # why it has no result, empty for a finished study
    figures: tuple[KeptFigure, ...] = ()
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    compared: tuple[ComparedValue, ...] = ()  # besides those of its figures
    values: dict[str, object] = {}


def keep_result(study: Study, result: StudyResult, seconds: float, out: Path) -> KeptStudy:
    """Write a finished study into OUT/<id>: pictures and tables, result.json last."""
    writer = ArtifactWriter(out / study.id)
    (out / study.id / TRACEBACK).unlink(missing_ok=True)
    for figure in result.figures:
        writer.bytes(f"{figure.name}.png", figure.png)
        writer.text(f"{figure.name}.csv", figure.csv)
        if figure.film:
            writer.bytes(f"{figure.name}.webm", figure.film)
    if result.heads:
        writer.text(TABLE, _csv([result.heads, *result.rows]))
    kept = KeptStudy(
        id=study.id,
        source=study.source,
        shows=study.shows,
        needs_dive=study.needs_dive,
        seconds=round(seconds, 1),
        figures=tuple(
            KeptFigure(
                name=f.name,
                caption=f.caption,
                compared=_without_nan(f.compared),
                moves=bool(f.film),
            )
            for f in result.figures
        ),
        heads=result.heads,
        rows=result.rows,
        compared=_without_nan(result.compared),
        values=without_nan(result.values),
    )
    writer.json(RESULT, kept)
    return kept


def keep_failure(study: Study, reason: str, traceback: str, seconds: float, out: Path) -> KeptStudy:
    """Write why a study has no result. Pictures of an earlier run are no longer listed."""
    writer = ArtifactWriter(out / study.id)
    if traceback:
        writer.text(TRACEBACK, traceback)
    kept = KeptStudy(
        id=study.id,
        source=study.source,
        shows=study.shows,
        needs_dive=study.needs_dive,
        seconds=round(seconds, 1),
        failure=reason,
    )
    writer.json(RESULT, kept)
    return kept


def read_results(out: Path, ids: Sequence[str]) -> dict[str, KeptStudy]:
    """Read what studies left in a folder, by id and in the order of `ids`.

    Studies that were not run there are left out. Raises InputError for a file that is damaged.
    """
    found = {}
    for name in ids:
        file = out / name / RESULT
        if file.is_file():
            try:
                found[name] = msgspec.json.decode(file.read_bytes(), type=KeptStudy)
            except msgspec.DecodeError as error:
                raise InputError(
                    f"not readable as the result of a study: {error}",
                    where=str(file),
                    remedy="run the study again",
                ) from error
    return found


def _csv(rows: Sequence[Sequence[str]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _without_nan(compared: Sequence[ComparedValue]) -> tuple[ComparedValue, ...]:
    """Replace values that are not finite by None, as JSON has none."""
    return tuple(
        value
        if value.ours is None
        else replace(value, ours=float(value.ours) if math.isfinite(value.ours) else None)
        for value in compared
    )
