# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solve a problem in parts that share poses and field nodes, by the same steps as the whole."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from hullrecon.native.columns import integers
from hullrecon.native.problem import Problem, Unknowns
from hullrecon.native.solver import (
    DEFAULTS,
    Covariance,
    IterationRecord,
    Options,
    covariance_from,
)
from hullrecon.typing import Array, Ints32, Mask


@dataclass(frozen=True, kw_only=True)
class Part:
    """A part of a problem, with its own numbering of poses, landmarks etc.

    Every factor and every prior is in a single part. An unknown that factors of several parts meet
    is shared. It is in each of these parts, with the same start value, and has a number among all
    shared unknowns, from 0 on. Globals are shared by all parts. A global that always has a prior
    (navigation, intrinsics, world, lenses) has a sigma of 1e150 in all parts but one.
    """

    problem: Problem
    # (k, 2) each: number in this part, number among all shared unknowns
    shared_poses: Ints32 = integers(0, 2)
    shared_nodes: Ints32 = integers(0, 2)  # of the deviation field
    shared_planes: Ints32 = integers(0, 2)
    shared_switches: Ints32 = integers(0, 2)  # of links


@dataclass(frozen=True, kw_only=True)
class PartResult:
    """The solution of a part: its unknowns, and labels, distances and hits as in Result."""

    unknowns: Unknowns
    label: Ints32
    distance: Array
    ray_hit: Mask


@dataclass(frozen=True, kw_only=True)
class PartsResult:
    """The result of all parts."""

    parts: tuple[PartResult, ...]
    iterations: IterationRecord
    converged: bool
    message: str
    seconds: dict[str, float]  # that the steps took, by stage


def solve_parts(
    parts: Iterable[Part], options: Options = DEFAULTS, folder: Path | None = None
) -> PartsResult:
    """Find the unknowns of least cost of a problem in parts.

    Landmarks and other unknowns of a single part are eliminated in it. The reduced systems of all
    parts, on shared unknowns and globals, are added and solved (docs/schur.md, *Parts*). Sums have
    the order of the parts, and the bytes of the result do not depend on the number of threads.

    Parameters
    ----------
    parts
        Read one after the other. With a folder, the arrays of a part are not needed after it was
        read, so that a generator has one part in memory at a time.
    options
        Of the solve.
    folder
        For temporary files, which hold the large arrays of parts that are not at work. None: all
        parts stay in memory. The bytes of the result are the same.

    Raises
    ------
    InputError
        Where parts do not fit together, otherwise as `solve`.
    OSError
        Where the folder's disk is full.
    """
    from hullrecon.native.compiled import native  # loads the solver's libraries

    got = native.solve_parts(parts, options, None if folder is None else str(folder))
    found = tuple(
        PartResult(unknowns=Unknowns(**part.pop("unknowns")), **part) for part in got.pop("parts")
    )
    return PartsResult(parts=found, iterations=IterationRecord(**got.pop("iterations")), **got)


def covariance_parts(
    parts: Iterable[Part],
    options: Options = DEFAULTS,
    folder: Path | None = None,
    *,
    of_landmarks: bool = True,
) -> tuple[Covariance, ...]:
    """Compute the marginal covariances of a problem in parts at the start values, by part.

    They are marginals of the whole problem, for the unknowns of each part. Leverages are those of
    the part's own factors. `parts` and `folder` are as for `solve_parts`, `of_landmarks` as for
    `covariance`. Raises as `covariance`, and OSError.
    """
    from hullrecon.native.compiled import native

    place = None if folder is None else str(folder)
    found = native.covariance_parts(parts, options, place, of_landmarks)
    return tuple(covariance_from(of_part) for of_part in found)
