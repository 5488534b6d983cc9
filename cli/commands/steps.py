# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make one command per step, its options from the step's own declaration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import msgspec
from msgspec import inspect as types

from hullrecon.artifacts.stage import Stage
from hullrecon.steps.chain import stage as find_stage

from ..dives import FOLDER
from .run import run_and_print, run_options

_COMMON = (
    "runs",
    "allow_outside",
    "from_scratch",
    "read_data",
    "jobs",
    "memory_gb",
    "scheduler",
    "wait_s",
)  # as run_options adds them
_BOUNDS = {
    "ge": "at least",
    "gt": "above",
    "le": "at most",
    "lt": "below",
    "multiple_of": "a multiple of",
}


def command(name: str) -> click.Command:
    """Return the click command of a step."""
    stage = find_stage(name)

    @click.command(name, help=_help(stage))
    @click.argument("package", type=FOLDER)
    @run_options
    def step(package: Path, overrides: tuple[str, ...], **options: Any) -> None:
        """Run the chain up to the step. Options that are given override its section."""
        common = {name: options.pop(name) for name in _COMMON}
        given = [
            f"{name}.{option}={_toml(value)}"
            for option, value in options.items()
            if value is not None
        ]
        run_and_print(package, overrides=[*overrides, *given], last_step=name, **common)

    step.params = [*step.params, *(_option(f) for f in fields(stage))]
    return step


def fields(stage: Stage) -> tuple[types.Field, ...]:
    """Return the step's options as declared."""
    info = types.type_info(stage.parameters)
    assert isinstance(info, types.StructType)
    return info.fields


def _help(stage: Stage) -> str:
    """Write a step's help: what it does and which steps it reads."""
    what = f"{stage.summary[0].upper()}{stage.summary[1:]}."
    if not stage.inputs:
        return f"{what}\n\nReads the package alone."
    read = ", ".join((*stage.inputs, *stage.optional))
    return f"{what}\n\nReads what these steps left: {read}. Those that are out of date run first."


def _option(field: types.Field) -> click.Option:
    """Make the command's option of a field of the step's section of dive.toml."""
    inner, text = unwrap_type(field.type)
    dashed = field.name.replace("_", "-")
    default = field.default if field.default is not msgspec.NODEFAULT else None
    text = "; ".join(part for part in (text, _bounds(inner), f"default {_toml(default)}") if part)
    if isinstance(inner, types.BoolType):
        return click.Option([f"--{dashed}/--no-{dashed}", field.name], default=None, help=text)
    if isinstance(inner, types.LiteralType):
        return click.Option(
            [f"--{dashed}", field.name],
            type=click.Choice([str(v) for v in inner.values]),
            help=text,
        )
    return click.Option(
        [f"--{dashed}", field.name],
        metavar=_metavar(inner),
        help=text,
    )


def _metavar(kind: types.Type) -> str:
    """Name the type of an option's value for the help, such as FLOAT or a|b."""
    kind, _ = unwrap_type(kind)
    if isinstance(kind, types.UnionType):
        return "|".join(_metavar(member) for member in kind.types)
    if isinstance(kind, types.LiteralType):
        return "|".join(str(value) for value in kind.values)
    return type(kind).__name__.removesuffix("Type").upper()


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
    """Write the bounds of a number's type for the help. Empty without any."""
    limits = ((word, getattr(kind, name, None)) for name, word in _BOUNDS.items())
    return ", ".join(f"{word} {limit:g}" for word, limit in limits if limit is not None)


def _toml(value: object) -> str:
    """Write an option's value as --set reads it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple | list):
        return f"[{', '.join(_toml(v) for v in value)}]"
    return "none" if value is None else str(value)
