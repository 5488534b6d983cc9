# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""hullrecon with steps that only join what their inputs hold; called as hullrecon is.

TOY_STEPS: a JSON file of [name, inputs, optional, needs a camera]. TOY_TRACE: a file that gets a
line for each step that runs. TOY_FAIL: a word; where it is among the arguments, navigate fails.
"""

from __future__ import annotations

import json
import os
import sys
from functools import partial
from pathlib import Path
from typing import Any

from hullrecon_cli.main import main
from msgspec import Struct

import hullrecon.steps.chain as chain
from hullrecon.api.fleet import processes
from hullrecon.artifacts.stage import Context, Stage
from hullrecon.errors import StageError


class Options(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    factor: int = 1


# Functions of the module, for steps that run in processes of their own.
def run(name: str, context: Context) -> None:
    if name == "navigate" and os.environ.get("TOY_FAIL", "?") in " ".join(sys.argv):
        raise StageError("the path could not be reckoned", remedy="look at the DVL")
    with open(os.environ["TOY_TRACE"], "a") as trace:
        trace.write(f"{name}\n")
    texts = [(folder / "text.txt").read_text() for folder in context.inputs.values()]
    total = sum(context.map(abs, [-1, -2, -3], "values")) * context.parameters.factor
    context.out.text("text.txt", f"{name}({','.join(texts)}){total}")
    if name == "report":
        context.out.text("deliver/report.txt", "done")


def no_camera(settings: Any, package: Path) -> str | None:
    return "there is no camera" if settings["camera.top"] is None else None


def files(name: str, settings: Any, source: Path) -> list[Path]:
    if name == "change":  # as the run of an earlier dive, outside the package
        return [file for file in [source.absolute().parent / "earlier.txt"] if file.exists()]
    return [Path(file) for file in settings["logs"].files]


def toy(name: str, inputs: list[str], optional: list[str], needs_camera: bool) -> Stage:
    return Stage(
        name, name, tuple(inputs), Options, 1, partial(run, name), ("camera.top", "logs"),
        tuple(optional), partial(files, name) if name in ("ingest", "change") else None,
        no_camera if needs_camera else None,
    )  # fmt: skip


if __name__ == "__main__":
    # started by a fleet, which gives its own process first
    if sys.argv[1:2] and sys.argv[1].isdigit():
        processes.end_with_parent(int(sys.argv.pop(1)))
    processes.PROGRAM = (sys.executable, "-P", __file__)
    stages = {step[0]: toy(*step) for step in json.loads(Path(os.environ["TOY_STEPS"]).read_text())}
    chain.stages = lambda: tuple(stages.values())
    chain.stage = stages.__getitem__
    sys.exit(main())
