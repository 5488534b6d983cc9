# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The registry of stages, in the order of the chain."""

from __future__ import annotations

from importlib import import_module
from typing import cast

from hullrecon.artifacts.stage import Stage

NAMES = (
    "ingest", "navigate", "features", "links", "matches", "adjust", "surface", "detect",
    "mosaic-optical", "mosaic-sonar", "change", "report",
)  # fmt: skip


def stage(name: str) -> Stage:
    """Import the stage of that name."""
    return cast(Stage, import_module(_module(name)).STAGE)


def stages() -> tuple[Stage, ...]:
    """Import all stages, each after its inputs."""
    return tuple(stage(name) for name in NAMES)


def _module(name: str) -> str:
    return f"hullrecon.steps.{name.replace('-', '_')}"
