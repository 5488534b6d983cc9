# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of a native.Problem that come from planes of the hull."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon import native
from hullrecon.geometry.poses import Poses
from hullrecon.records.planes import TiedPlanes


def with_planes(problem: native.Problem, planes: TiedPlanes | None) -> native.Problem:
    """Add planes as unknowns, the ranges to them and their pairs to a problem."""
    if planes is None:
        return problem
    rows = planes.ranges
    return replace(
        problem,
        unknowns=replace(problem.unknowns, plane=planes.plane.copy()),
        planes=native.PlaneTable(anchor=planes.anchor.astype(np.int32)),
        plane_ranges=native.PlaneRangeTable(
            node=rows.node.astype(np.int32),
            plane=rows.plane.astype(np.int32),
            offset=Poses(rows.quaternion, rows.translation).vectors(),
            tray_offset=rows.tray_offset,
            beam=rows.beam,
            measured=rows.range_m,
            sigma=rows.sigma_m,
        ),
        plane_pairs=native.PlanePairTable(
            first=planes.first.astype(np.int32),
            second=planes.second.astype(np.int32),
            measured=planes.difference,
            sqrt_information=planes.information,
            point=planes.point,
            place=planes.place,
            by_place=planes.by_place,
        ),
    )
