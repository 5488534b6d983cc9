# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""diff: what changed on a hull between two dives."""

from __future__ import annotations

from pathlib import Path

import click

from ..dives import FOLDER
from ..state import state_of


@click.command()
@click.argument("first", type=FOLDER, metavar="RUN1")
@click.argument("second", type=FOLDER, metavar="RUN2")
@click.option("--out", type=FOLDER, help="folder of the files; change-RUN1-RUN2 here if absent")
def diff(first: Path, second: Path, out: Path | None) -> None:
    """Say what changed on a hull from RUN1 to RUN2, both RUNS/<dive> of one hull with a CAD model.

    Objects that are new, gone, grown or shrunk, and bare hull that moved, each with its
    significance. How the two dives lie beside each other is estimated from what both saw and is no
    change. What only one dive looked at is said to be so. Leaves change.json, change.csv, layers
    for QGIS, a map and a page.
    """
    from hullrecon.api import change
    from hullrecon.report.change.chapter import move_sentence, object_sentence, verdict

    found = change.diff(first, second)
    folder = out or Path(f"change-{found.change.first}-{found.change.second}")
    names = change.write_change(folder, found)
    lines = [verdict(found.change), *(object_sentence(row) for row in found.change.changed())]
    lines += [move_sentence(row) for row in found.change.moves]
    document = {
        "verdict": lines[0],
        "changes": lines[1:],
        "folder": str(folder),
        "files": list(names),
    }
    state_of().emit(document, [*lines, f"files: {folder}"])
