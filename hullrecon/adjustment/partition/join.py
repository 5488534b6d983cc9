# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solve a problem in the parts of a plan, and put the parts' results together.

The parts are kept in temporary files, and only the one at work is in memory.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon import native
from hullrecon.adjustment.partition.plan import Plan
from hullrecon.adjustment.partition.sub_problem import SubProblems
from hullrecon.memory import empty_array, release_pages, returning_large_blocks
from hullrecon.native.parts import covariance_parts, solve_parts
from hullrecon.typing import Ints

Number = TypeVar("Number", bound=np.generic)
# Unknowns of the dive as a whole, which every part has
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
    """Solve a problem by the parts of a plan. The result is that of `native.solve`, to rounding.

    A long dive's tables and factors do not fit into memory at once, those of one part do.
    """
    if plan.parts == 1:
        return native.solve(problem, options)
    parts = SubProblems(problem, plan.owner)
    with tempfile.TemporaryDirectory() as folder, returning_large_blocks():
        found = solve_parts(parts.parts(), options, Path(folder))
    # Unknowns of the dive as a whole are the same in all parts. The others are gathered
    unknowns = replace(
        found.parts[0].unknowns,
        **{
            name: _scatter(rows, [getattr(part.unknowns, name) for part in found.parts])
            for name, rows in _unknowns_of(parts).items()
        },
    )
    surface, ranges = (_rows_of(parts, name) for name in ("surface", "ranges"))
    return native.Result(
        unknowns=unknowns,
        label=_scatter(surface, [part.label for part in found.parts]),
        distance=_scatter(surface, [part.distance for part in found.parts]),
        ray_hit=_scatter(ranges, [part.ray_hit for part in found.parts]),
        iterations=found.iterations,
        converged=found.converged,
        message=found.message,
        seconds=found.seconds,
    )


def covariance(
    problem: native.Problem, plan: Plan, options: native.Options, *, of_landmarks: bool = True
) -> native.Covariance:
    """Compute the covariances as `native.covariance` does, by the parts of a plan.

    of_landmarks: False leaves out those of the landmarks.
    """
    if plan.parts == 1:
        return native.covariance(problem, options, of_landmarks=of_landmarks)
    parts = SubProblems(problem, plan.owner)
    with tempfile.TemporaryDirectory() as folder, returning_large_blocks():
        found = covariance_parts(parts.parts(), options, Path(folder), of_landmarks=of_landmarks)
    of_rows = _unknowns_of(parts)
    if not of_landmarks:
        del of_rows["landmark"]
    # With the hull's pose held, the cross covariances of landmarks are zero, and not gathered
    left_out = {"landmark_T_g_M"} if "T_g_M" in problem.constant else set()
    # Covariances of an unknown have its name, cross covariances with the hull's pose end in T_g_M
    gathered = {
        field.name: _scatter(rows, [getattr(part, field.name) for part in found])
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
) -> Iterator[dict[str, NDArray[np.float64]]]:
    """Evaluate the whitened residuals of each kind of factor (native.FACTORS), of each part.

    plan: None evaluates the whole problem, as a plan of a single part does.
    """
    if plan is None or plan.parts == 1:
        yield _by_factor(native.evaluate(problem, options, jacobian=False))
        return
    for k, part in enumerate(SubProblems(problem, plan.owner).parts()):
        # Priors of the globals are in the first part alone. The others hold the globals, so that
        # these have no residual.
        alone = part.problem if k == 0 else part.problem.hold(*GLOBALS)
        yield _by_factor(native.evaluate(alone, options, jacobian=False))


def _by_factor(evaluation: native.Evaluation) -> dict[str, NDArray[np.float64]]:
    """Split whitened residuals (m,) by the kind of factor that they belong to."""
    return {
        name: evaluation.residual[evaluation.factor == number]
        for number, name in enumerate(native.FACTORS)
    }


def _unknowns_of(parts: SubProblems) -> dict[str, Sequence[Ints]]:
    """List, by the name of an unknown, which of its rows in the whole problem each part has."""
    return {
        "pose": parts.poses,
        "landmark": parts.landmarks,
        "deviation": parts.nodes,
        "plane": parts.planes,
    }


def _rows_of(parts: SubProblems, table: str) -> list[Ints]:
    """List which rows of a table of the whole problem each part has."""
    return [np.flatnonzero(parts.row_owner[table] == k) for k in range(parts.count)]


def _scatter(rows: Sequence[Ints], of_parts: Sequence[NDArray[Number]]) -> NDArray[Number]:
    """Put the parts' rows back into an array of the whole problem.

    Where several parts share a row, the value of the first part is taken. Of many landmarks the
    array is kept in a file.

    Parameters
    ----------
    rows
        For each part, the numbers of its rows in the whole, ascending.
    of_parts
        For each part, its rows.
    """
    count = 1 + max((int(of_part[-1]) for of_part in rows if len(of_part)), default=-1)
    out = empty_array((count, *of_parts[0].shape[1:]), of_parts[0].dtype)
    for of_part, values in zip(reversed(rows), reversed(of_parts), strict=True):
        out[of_part] = values
        release_pages(out)
    return out
