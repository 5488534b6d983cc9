# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Planes of the hull in a native problem."""

from __future__ import annotations

from dataclasses import replace

from hullrecon import native
from hullrecon.records.planes import TiedPlanes


def with_planes(problem: native.Problem, planes: TiedPlanes | None) -> native.Problem:
    """Add planes as unknowns, the ranges to them and their pairs to a problem."""
    if planes is None:
        return problem
    return replace(
        problem,
        unknowns=replace(problem.unknowns, plane=planes.plane.copy()),
        planes=planes.table,
        plane_ranges=planes.ranges,
        plane_pairs=planes.pairs,
    )
