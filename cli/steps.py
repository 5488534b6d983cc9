# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One command per step, its options made from the step's own declaration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import msgspec
from msgspec import inspect as types

from hullrecon.artifacts.graph.stage import Stage
from hullrecon.steps.chain import stage as find_stage

from .dives import FOLDER, open_dive
from .run import execute, run_options

_BOUNDS = {"ge": "at least", "gt": "above", "le": "at most", "lt": "below", "multiple_of": "a multiple of"}


def command(name: str) -> click.Command:
    """The click command of that step."""
    stage = find_stage(name)

    @click.command(name, help=_help(stage))
    @click.argument("package", type=FOLDER)
    @run_options
    def step(package: Path, runs: Path, overrides: tuple[str, ...], from_scratch: bool, **rest: Any) -> None:
        given = [f"{name}.{f.name}={_toml(rest.pop(f.name))}" for f in fields(stage) if rest.get(f.name) is not None]
        for field in fields(stage):
            rest.pop(field.name, None)
        execute(open_dive(package, runs, [*overrides, *given]), name, from_scratch=from_scratch, **rest)

    step.params = [*step.params, *(_option(f) for f in fields(stage))]
    return step


def fields(stage: Stage) -> tuple[types.Field, ...]:
    """The step's parameters; those whose names are taken by options of every step are left to --set."""
    info = types.type_info(stage.parameters)
    assert isinstance(info, types.StructType)
    return info.fields


def _help(stage: Stage) -> str:
    needs = ", ".join(stage.inputs) or "the package alone"
    return f"{stage.summary[0].upper()}{stage.summary[1:]}.\n\nTakes {needs}; what is out of date of it runs first."


def _option(field: types.Field) -> click.Option:
    inner, text = unwrap_type(field.type)
    dashed = field.name.replace("_", "-")
    default = field.default if field.default is not msgspec.NODEFAULT else None
    text = "; ".join(part for part in (text, _bounds(inner), f"default {_toml(default)}") if part)
    if isinstance(inner, types.BoolType):
        return click.Option([f"--{dashed}/--no-{dashed}", field.name], default=None, help=text)
    if isinstance(inner, types.LiteralType):
        return click.Option([f"--{dashed}", field.name], type=click.Choice([str(v) for v in inner.values]), help=text)
    return click.Option([f"--{dashed}", field.name], metavar=type(inner).__name__.removesuffix("Type").upper(), help=text)


def unwrap_type(kind: types.Type) -> tuple[types.Type, str]:
    """Return the type without its metadata, and its description."""
    if isinstance(kind, types.Metadata):
        inner, text = unwrap_type(kind.type)
        return inner, str((kind.extra_json_schema or {}).get("description", "")) or text
    if isinstance(kind, types.UnionType):
        members = [member for member in kind.types if not isinstance(member, types.NoneType)]
        return unwrap_type(members[0]) if len(members) == 1 else (kind, "")
    return kind, ""


def _bounds(kind: types.Type) -> str:
    limits = ((word, getattr(kind, name, None)) for name, word in _BOUNDS.items())
    return ", ".join(f"{word} {limit:g}" for word, limit in limits if limit is not None)


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple | list):
        return f"[{', '.join(_toml(v) for v in value)}]"
    return "none" if value is None else str(value)
