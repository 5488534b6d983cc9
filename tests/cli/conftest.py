# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A program whose chain is three small steps under names of the real ones, and a dive package for
it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from hullrecon_cli.main import main
from msgspec import Meta, Struct

from hullrecon.artifacts.stage import Context, Stage
from hullrecon.errors import StageError

Program = Callable[..., "Answer"]
DIVE_TOML = """
[dive]
name = "toy"
[logs]
files = ["log.txt"]
"""


class NoOptions(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    pass


class Options(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    times: Annotated[int, Meta(ge=1, le=9, description="how often the log is counted")] = 1
    margin_m: Annotated[float, Meta(gt=0, description="m, of nothing")] = 0.5
    end: Literal["well", "badly", "never", "fault"] = "well"
    loud: bool = False
    span: tuple[float, float] = (0.0, 1.0)


def ingest(context: Context) -> None:
    context.out.text("words.txt", (context.source / "log.txt").read_text())


def navigate(context: Context) -> None:
    if context.parameters.end == "badly":
        raise StageError("too few words", where="log.txt", remedy="write more")
    if context.parameters.end == "never":
        raise KeyboardInterrupt
    if context.parameters.end == "fault":
        raise ZeroDivisionError("a fault of ours")
    if context.parameters.loud:
        context.warn("the log is loud")
    words = (context.inputs["ingest"] / "words.txt").read_text().split()
    context.out.json(
        "count.json",
        {
            "words": context.parameters.times * len(words),
            "slop": context.settings["tray"].sigma_deg,
        },
    )


def report(context: Context) -> None:
    context.out.text("deliver/report.txt", (context.inputs["navigate"] / "count.json").read_text())


def logs(settings: Mapping[str, Any], source: Path) -> list[Path]:
    return [Path(name) for name in settings["logs"].files]


STAGES = (
    Stage("ingest", "read", (), NoOptions, 1, ingest, uses=("logs",), external=logs),
    Stage("navigate", "count the words", ("ingest",), Options, 1, navigate, uses=("tray",)),
    Stage("report", "write it up", ("navigate",), NoOptions, 1, report, optional=("mosaic-sonar",)),
)  # fmt: skip


class Answer(Struct):
    code: int
    out: str
    err: str


@pytest.fixture
def toy_stages(monkeypatch: pytest.MonkeyPatch) -> tuple[Stage, ...]:
    monkeypatch.setattr("hullrecon.steps.chain.stages", lambda: STAGES)
    monkeypatch.setattr(
        "hullrecon_cli.commands.steps.find_stage",
        lambda name: next(s for s in STAGES if s.name == name),
    )
    return STAGES


@pytest.fixture
def program(toy_stages: tuple[Stage, ...], capfd: pytest.CaptureFixture[str]) -> Program:
    """Calls the program with these arguments."""

    def call(*arguments: object) -> Answer:
        capfd.readouterr()
        code = main([str(a) for a in arguments])
        seen = capfd.readouterr()
        return Answer(code, seen.out, seen.err)

    return call


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "package"
    folder.mkdir()
    (folder / "dive.toml").write_text(DIVE_TOML)
    (folder / "log.txt").write_text("one two three\n")
    return folder


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    return tmp_path / "runs"
