# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The methods side by side, from the artifacts that the adjustment left: one table."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.errors import InputError
from hullrecon.evaluation.comparison.method_comparison import TABLE, WEIGHTINGS, method_figures
from hullrecon.evaluation.scoring.truth import Truth
from hullrecon.geometry.charts.chart import Chart, chart_from_arrays
from hullrecon.geometry.poses import Poses
from hullrecon.records.iterations import count
from hullrecon.records.serialisation import from_arrays
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, Trajectory
from hullrecon.typing import Array


@dataclass(frozen=True)
class Solved:
    """One method's adjust artifact. seconds: what the step took; iterations_s: when each row of `iterations` was done, of the
    step's clock; registered (7,): T_g_M before the solve, chart: of the CAD model, both None without one."""

    method: str
    weighting: str
    solution: Solution
    iterations: dict[str, NDArray[Any]]
    seconds: float
    iterations_s: Array
    registered: Array | None = None
    chart: Chart | None = None

    @property
    def name(self) -> str:
        return f"{self.method} {self.weighting}"

    @property
    def printed(self) -> bool:
        return WEIGHTINGS[self.weighting]


@dataclass(frozen=True)
class Reckoned:
    """What all methods started from: navigate's artifact, and how the DVL hangs on the tray (nominal)."""

    trajectory: Trajectory
    returns: Returns | None
    tray_origin_m: Array
    T_s_d: Poses


def read_solved(method: str, weighting: str, artifact: Path, run: Mapping[str, Any]) -> Solved:
    """run: the run block of the artifact's manifest. InputError when the artifact is not there."""
    arrays, iterations = read_arrays(artifact / "solution.npz"), read_arrays(artifact / "iterations.npz")
    summary, chart = artifact / "adjust.json", artifact / "chart.npz"
    registration = json.loads(summary.read_text()).get("registration") if summary.exists() else None
    return Solved(
        method,
        weighting,
        from_arrays(Solution, arrays),
        iterations,
        float(run["seconds"]),
        np.asarray(run.get("times", {}).get("iterations_s", []), float),
        np.array(registration["T_g_M"]) if registration else None,
        chart_from_arrays(read_arrays(chart)) if chart.exists() else None,
    )


def read_reckoned(navigate: Path, tray_origin_m: Sequence[float], T_s_d: Poses) -> Reckoned:
    trajectory = from_arrays(Trajectory, read_arrays(navigate / "trajectory.npz"))
    path = navigate / "returns.npz"
    returns = from_arrays(Returns, read_arrays(path)) if path.exists() else None
    return Reckoned(trajectory, returns, np.array(tray_origin_m, float), T_s_d)


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except OSError as error:
        raise InputError("the adjustment left no such file", where=str(path), remedy="run `hullrecon compare` first") from error


def compare(solved: Sequence[Solved], start: Reckoned, truth: Truth) -> dict[str, dict[str, Any]]:
    """Figures by method and weighting."""
    return {
        s.name: {
            **method_figures(s.solution, start.returns, start.tray_origin_m, truth),
            "solve": {"iterations": count(s.iterations["round"]), "seconds": s.seconds, "landmarks": len(s.solution.landmarks)},
        }
        for s in solved
    }


def table_rows(figures: dict[str, dict[str, Any]]) -> tuple[list[str], list[list[str]]]:
    """Heads and rows of the table; lengths in millimetres, where the eye compares them best."""
    heads = ["method", *(f"{words}, {_unit(name)}".rstrip(", ") for name, words in TABLE.items()), "iterations"]
    rows = [
        [method, *(_cell(name, parts) for name in TABLE), str(parts["solve"]["iterations"])]
        for method, parts in figures.items()
    ]
    return heads, rows


def _unit(name: str) -> str:
    return "mm" if name.endswith("_m") else "%" if name.endswith("_percent") else ""


def _cell(name: str, parts: dict[str, Any]) -> str:
    part, _, key = name.partition(".")
    value = parts.get(part, {}).get(key)
    if value is None:
        return "-"
    return f"{1e3 * value:.2f}" if name.endswith("_m") else f"{value:.3f}"
