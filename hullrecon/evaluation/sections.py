# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Thin slices across the hull at a structure, for O's Figs 4.10 and 4.11."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.evaluation.alignment import Motion
from hullrecon.evaluation.plots import Section
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.casting import Scene

Array = NDArray[np.float64]


def cut(
    title: str, structure: dict[str, Any], landmarks: Array, on_surface: NDArray[np.bool_], dvl: Array, motion: Motion,
    truth: Truth, reach_m: float = 0.55, half_m: float = 0.08,
) -> Section:  # fmt: skip
    """The slice through the structure's middle, half_m to either side along the hull; points in M, moved by the alignment.

    The DVL's few returns are taken from a slice five times as thick."""
    axes = _axes(structure)
    foot = np.array(structure["center"]) - structure["height"] * axes[2]
    seen = _inside((motion.apply(landmarks) - foot) @ axes.T, half_m, reach_m)
    beams = _inside((motion.apply(dvl) - foot) @ axes.T, 5 * half_m, reach_m)
    marks = ((motion.apply(landmarks) - foot) @ axes.T)[:, 1:]
    returns = ((motion.apply(dvl) - foot) @ axes.T)[:, 1:]
    line = np.linspace(-reach_m, reach_m, 200)
    return Section(
        title=title,
        dvl=returns[beams],
        on=marks[seen & on_surface],
        off=marks[seen & ~on_surface],
        steel=_profile(truth.built, foot, axes, line),
        drawing=_profile(truth.drawing, foot, axes, line) if truth.drawing is not None else np.zeros((0, 2)),
    )


def _axes(structure: dict[str, Any]) -> Array:
    """Rows: along the hull, over its girth, outward."""
    normal = np.array(structure["normal"], float)
    along = np.array([1.0, 0.0, 0.0]) - normal * normal[0]
    along /= np.linalg.norm(along)
    return np.stack([along, np.cross(normal, along), normal])


def _inside(local: Array, half_m: float, reach_m: float) -> NDArray[np.bool_]:
    return (np.abs(local[:, 0]) < half_m) & (np.abs(local[:, 1]) < reach_m) & (np.abs(local[:, 2]) < 0.4)


def _profile(surface: Scene, foot: Array, axes: Array, line: Array) -> Array:
    """(m, 2) tangent and height where rays from outside meet the surface."""
    start = foot + line[:, None] * axes[1] + 0.5 * axes[2]
    way = surface.cast(start, np.tile(-axes[2], (len(line), 1)))
    met = np.isfinite(way) & (way < 1.2)
    return np.stack([line[met], 0.5 - way[met]], axis=1)
