# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Add planes of the hull to a native problem."""

from __future__ import annotations

from dataclasses import replace

from hullrecon import native
from hullrecon.records.planes import TiedPlanes


def with_planes(problem: native.Problem, planes: TiedPlanes | None) -> native.Problem:
    """Add planes to a problem: as unknowns, with the DVL's ranges to them and pairs of them."""
    if planes is None:
        return problem
    return replace(
        problem,
        unknowns=replace(problem.unknowns, plane=planes.plane.copy()),
        planes=planes.table,
        plane_ranges=planes.ranges,
        plane_pairs=planes.pairs,
    )
