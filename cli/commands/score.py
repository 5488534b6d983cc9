# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""evaluate: figures of a run against truth."""

from __future__ import annotations

from pathlib import Path

import click

from ..dives import FOLDER
from ..state import state_of


@click.command()
@click.argument("run", type=FOLDER, metavar="RUN_OR_DELIVER")
@click.argument("package", type=FOLDER)
def evaluate(run: Path, package: Path) -> None:
    """Score a run (RUNS/<dive> or its deliver/) against the truth in a simulated dive's PACKAGE."""
    from hullrecon.evaluation.score import score_run, table_rows, without_nan

    figures = score_run(run, package)
    width = max(len(name) for name, _, _ in table_rows(figures))
    lines = [
        f"{name:{width}}  {value} {unit}".rstrip() for name, value, unit in table_rows(figures)
    ]
    state_of().emit(without_nan(figures), lines)
