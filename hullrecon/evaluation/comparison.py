# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The methods side by side, from the artifacts that the adjustment left: one table, and O's figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.records import Returns, Solution, Trajectory, from_arrays
from hullrecon.errors import InputError
from hullrecon.evaluation import plots
from hullrecon.evaluation.alignment import Motion
from hullrecon.evaluation.deliverables import Track
from hullrecon.evaluation.methods import (
    METHODS,
    TABLE,
    WEIGHTINGS,
    frame_of,
    height_over_steel,
    landmarks_in_hull,
    method_figures,
    stamps,
)
from hullrecon.evaluation.returns import adjusted_beams, range_residuals, reckoned_beams
from hullrecon.evaluation.sections import cut
from hullrecon.evaluation.trajectory import judge_trajectory
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.poses import Poses

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Solved:
    """One method's adjust artifact. seconds: what the step took."""

    method: str
    weighting: str
    solution: Solution
    iterations: dict[str, NDArray[Any]]
    seconds: float

    @property
    def name(self) -> str:
        return f"{self.method} {self.weighting}"


@dataclass(frozen=True)
class Reckoned:
    """What all methods started from: navigate's artifact, and how the DVL hangs on the tray (nominal)."""

    trajectory: Trajectory
    returns: Returns | None
    tray_origin_m: Array
    T_s_d: Poses


def read_solved(method: str, weighting: str, artifact: Path, seconds: float) -> Solved:
    """InputError when the artifact is not there."""
    arrays, iterations = read_arrays(artifact / "solution.npz"), read_arrays(artifact / "iterations.npz")
    return Solved(method, weighting, from_arrays(Solution, arrays), iterations, seconds)


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
            "solve": {"iterations": len(s.iterations["cost"]), "seconds": s.seconds, "landmarks": len(s.solution.landmark)},
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


def draw(solved: Sequence[Solved], start: Reckoned, truth: Truth) -> list[plots.Figure]:
    """O's Figs 4.10 (4.11), 4.12, 4.13, 4.14 and 4.16 from those solves; one without its data is left out."""
    figures = [plots.cost_history([_progress(s) for s in solved])]
    mixed = [_progress(s) for s in solved if s.method == "maxmix" and len(s.solution.landmark)]
    figures += [plots.label_frequency(mixed)] if mixed else []
    structure = _tallest(truth)
    if structure is not None and all(len(s.solution.landmark) for s in solved):
        figures.append(plots.cross_sections(_sections(solved, start, truth, structure)))
        figures.append(_heights(solved, truth, structure))
    if start.returns is not None and truth.drawing is not None:
        figures.append(_ranges(solved, start, truth))
    return figures


def _progress(s: Solved) -> plots.Progress:
    cost, labels = s.iterations["cost"], s.iterations["on_surface"]
    return plots.Progress(s.name, cost, labels.astype(float), len(s.solution.landmark), s.seconds)


def _tallest(truth: Truth) -> dict[str, Any] | None:
    """The cylinder, as in O, else the highest structure that enough frames saw."""
    seen = [o for o in truth.structures() if o["views"] >= 3 and o["height"] > 0]
    return max(seen, key=lambda o: (o["kind"] == "cylinder", o["height"]), default=None)


def _sections(solved: Sequence[Solved], start: Reckoned, truth: Truth, structure: dict[str, Any]) -> list[list[plots.Section]]:
    rows = []
    for weighting in WEIGHTINGS:
        row = [s for method in METHODS for s in solved if (s.method, s.weighting) == (method, weighting)]
        rows += [[_section(s, start, truth, structure) for s in row]] if row else []
    return rows


def _section(s: Solved, start: Reckoned, truth: Truth, structure: dict[str, Any]) -> plots.Section:
    frame = frame_of(s.solution, truth)
    dvl = np.zeros((0, 3))
    if start.returns is not None:
        dvl = adjusted_beams(s.solution, frame, start.returns, start.tray_origin_m).points()
    landmarks = landmarks_in_hull(s.solution, frame)
    return cut(s.name, structure, landmarks, s.solution.label == 1, dvl, _motion(s, truth), truth)


def _heights(solved: Sequence[Solved], truth: Truth, structure: dict[str, Any]) -> plots.Figure:
    found: dict[str, Array] = {}
    true = np.zeros(0)
    for s in solved:
        landmarks = landmarks_in_hull(s.solution, frame_of(s.solution, truth))
        found[s.name], expected = height_over_steel(landmarks, structure, truth, _motion(s, truth))
        true = expected if len(expected) > len(true) else true
    return plots.structure_heights(found, true, str(structure["kind"]))


def _ranges(solved: Sequence[Solved], start: Reckoned, truth: Truth) -> plots.Figure:
    assert start.returns is not None
    assert truth.drawing is not None
    best = solved[-1]
    before = reckoned_beams(start.trajectory, frame_of(best.solution, truth), start.T_s_d, start.returns, start.tray_origin_m)
    after = {
        s.name: range_residuals(
            adjusted_beams(s.solution, frame_of(s.solution, truth), start.returns, start.tray_origin_m), truth.drawing
        )
        for s in solved
        if s.method == "maxmix"
    }
    return plots.range_histogram(range_residuals(before, truth.drawing), after)


def _motion(s: Solved, truth: Truth) -> Motion:
    poses = frame_of(s.solution, truth).inverse() @ s.solution.poses()
    _, motion = judge_trajectory(Track(stamps(s.solution), poses, None), truth)
    return motion


def _unit(name: str) -> str:
    return "mm" if name.endswith("_m") else "%" if name.endswith("_percent") else ""


def _cell(name: str, parts: dict[str, Any]) -> str:
    part, _, key = name.partition(".")
    value = parts.get(part, {}).get(key)
    if value is None:
        return "-"
    return f"{1e3 * value:.2f}" if name.endswith("_m") else f"{value:.3f}"
