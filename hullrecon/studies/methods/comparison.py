# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The results of each method, and a table that compares them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.evaluation.truth import Truth
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
from hullrecon.studies.study import ComparedValue
from hullrecon.typing import Array, Arrays


@dataclass(frozen=True, kw_only=True)
class SolvedVariant:
    """The result of one method and weighting."""

    method: str
    weighting: str
    solution: Solution
    iterations: Arrays  # rows of the solve's record
    seconds: float  # what the step took
    iterations_s: Array  # when each row was done, by the step's clock
    registered: Poses | None = None  # global_from_hull before the solve
    chart: Chart | None = None  # of the CAD model

    @property
    def name(self) -> str:
        """Name method and weighting."""
        return f"{self.method} {self.weighting}"

    @property
    def as_published(self) -> bool:
        """Whether it was solved as published."""
        return WEIGHTINGS[self.weighting]


@dataclass(frozen=True, kw_only=True)
class DeadReckoning:
    """The start of all methods."""

    trajectory: Trajectory
    returns: Returns | None
    rig: Rig


def compare_solutions(
    variants: Sequence[SolvedVariant], start: DeadReckoning, truth: Truth
) -> dict[str, MethodFigures]:
    """Score every solve, by method and weighting."""
    return {
        v.name: {
            **method_figures(v.solution, start.returns, start.rig, truth),
            "solve": {
                "iterations": _iterations(v),
                "seconds": v.seconds,
                "landmarks": len(v.solution.landmarks),
            },
        }
        for v in variants
    }


def _iterations(v: SolvedVariant) -> int:
    """Count iterations: of all rounds, or as published of the solve with the CAD model alone."""
    rounds = np.asarray(v.iterations["round"], np.int64)
    return count(rounds[rounds == rounds.max()] if v.as_published else rounds)


def comparison_table(figures: Mapping[str, MethodFigures]) -> tuple[list[str], list[list[str]]]:
    """Arrange the figures in heads and rows, lengths in millimetres."""
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


def compare_heights(figures: Mapping[str, MethodFigures]) -> tuple[ComparedValue, ...]:
    """Set what the source says of structures beside the share of their height that is kept."""
    said = {
        "naive as published": "the features do not lie on the surface of the DVL's ranges",
        "geva as published": 'growth is "squished" onto the surface',
        "maxmix as published": "structures are preserved",
    }
    kept = {name: figures.get(name, {}).get("heights", {}).get("ratio_median") for name in said}
    return tuple(
        ComparedValue(
            what=f"height of structures kept, {name}",
            unit="%",
            ours=100 * ratio if isinstance(ratio, float) else None,
            note=f"Figs 4.10, 4.11: {said[name]}",
        )
        for name, ratio in kept.items()
    )


def _unit(name: str) -> str:
    return "mm" if name.endswith("_m") else "%" if name.endswith("_percent") else ""


def _cell(name: str, parts: MethodFigures) -> str:
    """Write a figure by its name, part.key, in mm if it is a length. "-" where it is none."""
    part, _, key = name.partition(".")
    value = parts.get(part, {}).get(key)
    if not isinstance(value, int | float):
        return "-"
    return f"{1e3 * value:.2f}" if name.endswith("_m") else f"{value:.3f}"
