# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks that a solve lost: pushed behind their cameras or metres off the hull.

Mismatches along an epipolar line end so when every landmark is pulled to the hull, or when one
solve starts from dead reckoning. They hold nothing, but one of them is enough for the covariances
not to exist.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from hullrecon.native import MonoTable, Problem, Result, StereoTable, SurfaceTable
from hullrecon.typing import Mask

Table = TypeVar("Table", StereoTable, MonoTable, SurfaceTable)


def drop_landmarks(problem: Problem, keep: Mask) -> Problem:
    """Keep landmarks `keep` (L,) of a problem alone, and renumber their factors."""
    number = (np.cumsum(keep) - 1).astype(np.int32)

    def kept(table: Table) -> Table:
        rows = table.take(keep[table.landmark])
        return replace(rows, landmark=number[rows.landmark])

    return replace(
        problem,
        unknowns=replace(problem.unknowns, landmark=problem.unknowns.landmark[keep]),
        stereo=kept(problem.stereo),
        mono=kept(problem.mono),
        surface=kept(problem.surface),
    )


def drop_label_rows(result: Result, surface_rows: Mask) -> Result:
    """Keep rows (m,) of the surface table in the result of a problem with fewer landmarks."""
    if len(result.label) != len(surface_rows):
        return result
    return replace(result, label=result.label[surface_rows], distance=result.distance[surface_rows])
