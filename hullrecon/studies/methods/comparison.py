# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The methods side by side: what each solve left, and one table of figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.evaluation.scoring.truth import Truth
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.poses import Poses
from hullrecon.records.iterations import count
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, Trajectory
from hullrecon.rig import Rig
from hullrecon.studies.methods.method_figures import (
    TABLE,
    WEIGHTINGS,
    MethodFigures,
    method_figures,
)
from hullrecon.typing import Array, Arrays


@dataclass(frozen=True, kw_only=True)
class SolvedVariant:
    """What one method and weighting left. iterations: rows of the solve's record; seconds: what the
    step took; iterations_s: when each row was done, of the step's clock; registered: T_g_M before
    the solve; chart: of the CAD model.
    """

    method: str
    weighting: str
    solution: Solution
    iterations: Arrays
    seconds: float
    iterations_s: Array
    registered: Poses | None = None
    chart: Chart | None = None

    @property
    def name(self) -> str:
        """Return method and weighting in words."""
        return f"{self.method} {self.weighting}"

    @property
    def as_published(self) -> bool:
        """Return whether it was solved as published."""
        return WEIGHTINGS[self.weighting]


@dataclass(frozen=True, kw_only=True)
class DeadReckoning:
    """What all methods started from: the dead-reckoned dive and the rig as configured."""

    trajectory: Trajectory
    returns: Returns | None
    rig: Rig


def compare_solutions(
    variants: Sequence[SolvedVariant], start: DeadReckoning, truth: Truth
) -> dict[str, MethodFigures]:
    """Return the figures by method and weighting."""
    return {
        v.name: {
            **method_figures(v.solution, start.returns, start.rig, truth),
            "solve": {
                "iterations": count(np.asarray(v.iterations["round"], np.int64)),
                "seconds": v.seconds,
                "landmarks": len(v.solution.landmarks),
            },
        }
        for v in variants
    }


def comparison_table(figures: Mapping[str, MethodFigures]) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows of the table; lengths in millimetres, where the eye compares them best."""
    heads = [
        "method",
        *(f"{label}, {_unit(name)}".rstrip(", ") for name, label in TABLE.items()),
        "iterations",
    ]
    rows = [
        [method, *(_cell(name, parts) for name in TABLE), str(parts["solve"]["iterations"])]
        for method, parts in figures.items()
    ]
    return heads, rows


def _unit(name: str) -> str:
    return "mm" if name.endswith("_m") else "%" if name.endswith("_percent") else ""


def _cell(name: str, parts: MethodFigures) -> str:
    part, _, key = name.partition(".")
    value = parts.get(part, {}).get(key)
    if not isinstance(value, int | float):
        return "-"
    return f"{1e3 * value:.2f}" if name.endswith("_m") else f"{value:.3f}"
