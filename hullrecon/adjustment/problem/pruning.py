# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks that a solve lost: pushed behind their cameras or metres off the hull, where nothing
determines them.

Mismatches along an epipolar line end so when every landmark is pulled to the hull, or when one
solve starts from dead reckoning. They hold nothing, but one of them is enough for the covariances
not to exist.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.native import FieldNodes, MonoTable, Problem, Result, StereoTable, SurfaceTable
from hullrecon.typing import Mask


def drop_landmarks(problem: Problem, keep: Mask) -> Problem:
    """Return the problem of the landmarks `keep` (L,) alone; their factors are renumbered, all
    other factors stay.
    """
    number = (np.cumsum(keep) - 1).astype(np.int32)
    stereo, mono, surface = problem.stereo, problem.mono, problem.surface
    kept = {
        "stereo": keep[stereo.landmark],
        "mono": keep[mono.landmark],
        "surface": keep[surface.landmark],
    }
    in_field = _rows(len(surface.field.index), kept["surface"])
    return replace(
        problem,
        unknowns=replace(problem.unknowns, landmark=problem.unknowns.landmark[keep]),
        stereo=StereoTable(
            node=stereo.node[kept["stereo"]],
            landmark=number[stereo.landmark[kept["stereo"]]],
            pixel=stereo.pixel[kept["stereo"]],
            sigma_ratio=stereo.sigma_ratio[_rows(len(stereo.sigma_ratio), kept["stereo"])],
        ),
        mono=MonoTable(
            node=mono.node[kept["mono"]],
            landmark=number[mono.landmark[kept["mono"]]],
            camera=mono.camera[kept["mono"]],
            pixel=mono.pixel[kept["mono"]],
            sigma_ratio=mono.sigma_ratio[_rows(len(mono.sigma_ratio), kept["mono"])],
        ),
        surface=SurfaceTable(
            landmark=number[surface.landmark[kept["surface"]]],
            weight=surface.weight[kept["surface"]],
            field=FieldNodes(
                index=surface.field.index[in_field], weight=surface.field.weight[in_field]
            ),
        ),
    )


def _rows(length: int, keep: Mask) -> Mask | slice:
    """Return which rows to keep of a column of that length, which may be empty."""
    return keep if length else slice(0)


def drop_label_rows(result: Result, surface_rows: Mask) -> Result:
    """Return the result with these rows (m,) of the surface table alone; its landmarks are those of
    the problem that goes with it.
    """
    if len(result.label) != len(surface_rows):
        return result
    return replace(result, label=result.label[surface_rows], distance=result.distance[surface_rows])
