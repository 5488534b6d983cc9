# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solving a problem in parts that share poses and nodes, by the same steps as the whole."""

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
    """A part of a problem, with rows of its own numbers.

    Every factor and every prior is in one part alone. What factors of several parts meet is shared:
    it starts from the same value in each, and has a number among all that are shared, from 0 on.
    Globals are shared by all. A prior that a free global has anyway (navigation, intrinsics, world,
    lenses) gets a sigma of 1e150 in all parts but one, which is as good as none.
    """

    problem: Problem
    shared_poses: Ints32 = integers(0, 2)  # (k, 2) row here, number
    shared_nodes: Ints32 = integers(0, 2)  # of the deviation field
    shared_planes: Ints32 = integers(0, 2)
    shared_switches: Ints32 = integers(0, 2)  # of links


@dataclass(frozen=True, kw_only=True)
class PartResult:
    """The unknowns of a part at the end, and what became of its rows, as in Result."""

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
    seconds: dict[str, float]


def solve_parts(
    parts: Iterable[Part], options: Options = DEFAULTS, folder: Path | None = None
) -> PartsResult:
    """Find the unknowns of least cost of a problem in parts.

    Landmarks and whatever else a part does not share are eliminated inside it; what parts leave on
    shared blocks and globals is joined (docs/schur.md, *Parts*). Sums have the order of the parts,
    and the bytes do not depend on the number of threads.

    Parameters
    ----------
    parts
        Taken one after the other.
    options
        Of the solve.
    folder
        Of temporary files that hold what is large of each part while others are at work; its
        arrays are not needed once it was taken, so of a generator's parts one at a time is in
        memory. None: all are, all the time. The bytes are the same.

    Raises
    ------
    InputError
        Where parts do not fit together; else as `solve`.
    OSError
        Where the folder's disk is full.
    """
    import hullrecon._native as _native  # compiled; loads the solver's libraries

    got = _native.solve_parts(parts, options, None if folder is None else str(folder))
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
    """Compute what `covariance` does of a problem in parts, at their start values.

    Marginals are those of the whole problem; each part has those of its own rows. Leverages are of
    its own factors. Parts and folder are as in `solve_parts`, of_landmarks as in `covariance`.
    Raises as `covariance`, and OSError.
    """
    import hullrecon._native as _native

    place = None if folder is None else str(folder)
    found = _native.covariance_parts(parts, options, place, of_landmarks)
    return tuple(covariance_from(of_part) for of_part in found)
