# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solve a problem in the parts of a plan, and put together what they find.

The parts are in temporary files, and only the one at work is in memory.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon import native
from hullrecon.adjustment.partition.plan import Plan
from hullrecon.adjustment.partition.sub_problem import SubProblems
from hullrecon.native.parts import covariance_parts, solve_parts
from hullrecon.typing import Ints

Number = TypeVar("Number", bound=np.generic)
GLOBALS = (
    "T_g_M",
    "T_s_ct",
    "T_ct_cb",
    "T_s_d",
    "navigation",
    "intrinsics_top",
    "intrinsics_bottom",
    "world",
    "lens_top",
    "lens_bottom",
)


def solve(problem: native.Problem, plan: Plan, options: native.Options) -> native.Result:
    """Solve a problem as `native.solve` does, to rounding, by the parts of a plan."""
    if plan.parts == 1:
        return native.solve(problem, options)
    parts = SubProblems(problem, plan.owner)
    with tempfile.TemporaryDirectory() as folder:
        found = solve_parts(parts.parts(), options, Path(folder))
    unknowns = replace(
        found.parts[0].unknowns,
        **{
            name: _rows(rows, [getattr(part.unknowns, name) for part in found.parts])
            for name, rows in _unknowns_of(parts).items()
        },
    )
    surface, ranges = (_rows_of(parts, name) for name in ("surface", "ranges"))
    return native.Result(
        unknowns=unknowns,
        label=_rows(surface, [part.label for part in found.parts]),
        distance=_rows(surface, [part.distance for part in found.parts]),
        ray_hit=_rows(ranges, [part.ray_hit for part in found.parts]),
        iterations=found.iterations,
        converged=found.converged,
        message=found.message,
        seconds=found.seconds,
    )


def covariance(
    problem: native.Problem, plan: Plan, options: native.Options, *, of_landmarks: bool = True
) -> native.Covariance:
    """Compute what `native.covariance` does, by the parts of a plan."""
    if plan.parts == 1:
        return native.covariance(problem, options, of_landmarks=of_landmarks)
    parts = SubProblems(problem, plan.owner)
    with tempfile.TemporaryDirectory() as folder:
        found = covariance_parts(parts.parts(), options, Path(folder), of_landmarks=of_landmarks)
    of_rows = _unknowns_of(parts)
    if not of_landmarks:
        del of_rows["landmark"]
    left_out = {"landmark_T_g_M"} if "T_g_M" in problem.constant else set()  # zero, and large
    gathered = {
        field.name: _rows(rows, [getattr(part, field.name) for part in found])
        for field in fields(native.Covariance)
        for name, rows in of_rows.items()
        if field.name in (name, f"{name}_T_g_M") and field.name not in left_out
    }
    for name in left_out:
        gathered[name] = np.zeros((len(gathered.get("landmark", ())), 3, 6))
    leverage = {
        kind: sum(part.leverage_by_factor[kind] for part in found)
        for kind in found[0].leverage_by_factor
    }
    return replace(found[0], leverage_by_factor=leverage, **gathered)


def residuals(
    problem: native.Problem, plan: Plan | None, options: native.Options
) -> dict[str, NDArray[np.float64]]:
    """Evaluate the whitened residuals of each kind of factor (native.FACTORS), part by part.

    plan: None, as one of a single part, evaluates the whole.
    """
    if plan is None or plan.parts == 1:
        return _by_factor(native.evaluate(problem, options, jacobian=False))
    parts = SubProblems(problem, plan.owner)
    found = []
    for k, part in enumerate(parts.parts()):
        # The first part has the priors of globals.
        alone = part.problem if k == 0 else part.problem.hold(*GLOBALS)
        found.append(_by_factor(native.evaluate(alone, options, jacobian=False)))
    return {name: np.concatenate([of_part[name] for of_part in found]) for name in native.FACTORS}


def _by_factor(evaluation: native.Evaluation) -> dict[str, NDArray[np.float64]]:
    return {
        name: evaluation.residual[evaluation.factor == number]
        for number, name in enumerate(native.FACTORS)
    }


def _unknowns_of(parts: SubProblems) -> dict[str, Sequence[Ints]]:
    """List where the rows of the parts' unknowns stand in the whole, by name."""
    return {
        "pose": parts.poses,
        "landmark": parts.landmarks,
        "deviation": parts.nodes,
        "plane": parts.planes,
    }


def _rows_of(parts: SubProblems, table: str) -> list[Ints]:
    return [np.flatnonzero(parts.row_owner[table] == k) for k in range(parts.count)]


def _rows(rows: Sequence[Ints], of_parts: Sequence[NDArray[Number]]) -> NDArray[Number]:
    """Put rows of parts where they stand in the whole. Of what is shared the first part's stays."""
    count = 1 + max((int(of_part[-1]) for of_part in rows if len(of_part)), default=-1)
    out = np.zeros((count, *of_parts[0].shape[1:]), of_parts[0].dtype)
    for of_part, values in zip(reversed(rows), reversed(of_parts), strict=True):
        out[of_part] = values
    return out
