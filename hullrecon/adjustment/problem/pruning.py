# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks that a solve lost: pushed behind their cameras or metres off the hull, where nothing determines them.

Mismatches along an epipolar line end so when every landmark is drawn to the hull, or when one solve starts from dead reckoning.
They hold nothing, but one of them is enough for the covariances not to exist.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.native import Problem, Result
from hullrecon.typing import Mask


def without(problem: Problem, keep: Mask) -> Problem:
    """The problem of the landmarks `keep` (L,) alone; their factors are numbered anew, all other factors stay."""
    number = np.cumsum(keep) - 1
    cut = replace(problem, landmark=problem.landmark[keep])
    for table, others in (
        ("stereo", ("node", "pixel")),
        ("mono", ("node", "camera", "pixel")),
        ("surface", ("weight", "field_index", "field_weight")),
    ):
        owner = getattr(problem, f"{table}_landmark")
        rows = keep[owner]
        setattr(cut, f"{table}_landmark", number[owner[rows]].astype(np.int32))
        for other in others:
            values = getattr(problem, f"{table}_{other}")
            setattr(cut, f"{table}_{other}", values[rows] if len(values) == len(rows) else values)
    return cut


def result_without(result: Result, surface_rows: Mask) -> Result:
    """The result with these rows (m,) of the surface table alone; its landmarks are those of the problem that goes with it."""
    if len(result.label) != len(surface_rows):
        return result
    return replace(result, label=result.label[surface_rows], distance=result.distance[surface_rows])
