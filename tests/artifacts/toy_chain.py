# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A chain of four small stages over a package of one file: read -> left, right -> join. Runs as a
script as well: toy_chain.py PACKAGE WORKSPACE [PAUSE_S].
"""

from __future__ import annotations

import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
from msgspec import Struct

from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.runner import RunContext, StepOutcome, run_chain
from hullrecon.artifacts.stage import Context, Stage, load_arrays
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import StageError


class Scale(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    factor: float = 1.0
    offset: float = 0.0


class Options(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    power: int = 1
    pause_s: float = 0.0


def read(context: Context) -> None:
    numbers = np.array(
        [float(line) for line in (context.source / "numbers.txt").read_text().split()]
    )
    context.out.arrays("numbers.npz", {"x": numbers * context.settings["scale"].factor})
    context.out.text("notes/words.txt", f"{len(numbers)} numbers\n")


def side(context: Context) -> None:
    numbers = load_arrays(context.inputs["read"] / "numbers.npz")["x"]
    if context.parameters.power < 0:
        raise StageError("no result for a negative power", remedy="give a positive one")
    time.sleep(context.parameters.pause_s)
    if context.parameters.power > 1:  # item by item
        power = partial(pow, exp=context.parameters.power)
        numbers = np.array(context.map(power, numbers.tolist(), "numbers"))
    context.out.arrays("side.npz", {"x": numbers})
    context.out.bytes("raw.bin", bytes(range(256)))


def join(context: Context) -> None:
    total = sum(
        float(load_arrays(folder / "side.npz")["x"].sum()) for folder in context.inputs.values()
    )
    context.out.json("deliver/total.json", {"total": total, "of": sorted(context.inputs)})
    if "right" not in context.inputs:
        context.warn("the right side is missing")


def no_right(settings: object, package: Path) -> str | None:
    return "no scale was given" if settings["scale"] is None else None  # type: ignore[index]


STAGES = (
    Stage(
        "read",
        "read",
        (),
        Options,
        1,
        read,
        uses=("scale",),
        external=lambda settings, source: [source / "numbers.txt"],
    ),
    Stage("left", "left", ("read",), Options, 1, side),
    Stage("right", "right", ("read",), Options, 1, side, uses=("scale",), applies=no_right),
    Stage("join", "join", ("left",), Options, 1, join, optional=("right",)),
)


def make_package(folder: Path) -> Path:
    folder.mkdir()
    (folder / "numbers.txt").write_text("1\n2\n3\n")
    return folder


def chain(package: Path, **sections: object) -> Chain:
    return Chain(STAGES, {"scale": Scale(), **sections}, package)


def run(
    package: Path, workspace: Workspace, *, from_scratch: bool = False, **sections: object
) -> list[StepOutcome]:
    run_context = RunContext(workspace.hashes(), Executor())
    return run_chain(chain(package, **sections), workspace, run_context, from_scratch=from_scratch)


def made(outcomes: list[StepOutcome]) -> list[str]:
    return [outcome.before.stage.name for outcome in outcomes if outcome.made]


if __name__ == "__main__":
    pause = Options(pause_s=float(sys.argv[3]) if len(sys.argv) > 3 else 0.0)
    run(Path(sys.argv[1]), Workspace(Path(sys.argv[2])), left=pause, right=pause)
