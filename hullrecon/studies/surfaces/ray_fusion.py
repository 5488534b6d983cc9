# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull as found by running means along the cameras' rays [Ozog2016 4.3.3, eq. 4.15]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import Unfused
from hullrecon.detection.as_found.shapes import find_shape_hits
from hullrecon.detection.options import DetectOptions
from hullrecon.detection.views import CameraViews
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class FusedShapes:
    """Vertices moved to the shapes that rays to them met."""

    vertex: Array  # (n, 3), running means of the intersections, the prior's where there were none
    count: Ints  # (n,) views whose shapes met the ray to that vertex


def fuse_shapes(
    views: CameraViews, features: Array, deviation: Array, vertices: Array, options: DetectOptions
) -> FusedShapes:
    """Move vertices (n, 3) to the shapes that features (m, 3) with deviations (m,) make.

    [Ozog2016 eq. 4.15] is a running mean in which the first observation replaces the prior: the
    mean of all intersections.
    """
    total, count = np.zeros_like(vertices), np.zeros(len(vertices), np.int64)
    for rows, points in find_shape_hits(views, features, deviation, vertices, options):
        total[rows] += points
        count[rows] += 1
    vertex = np.where(count[:, None] > 0, total / np.maximum(count, 1)[:, None], vertices)
    return FusedShapes(vertex=vertex, count=count)


def move_along_rays(
    given: Unfused, views: CameraViews, options: DetectOptions
) -> tuple[Array, Array, Ints]:
    """Move vertices along rays that saw shapes, and leave the others on the hull."""
    at = given.mesh.vertices
    fused = fuse_shapes(views, given.features, given.feature_height, at, options)
    taken = fused.count > 0
    moved = np.where(taken[:, None], fused.vertex, at + given.normal * given.hull[:, None])
    off = np.einsum("ni,ni->n", moved - at, given.normal) - given.hull
    return moved, np.where(taken, off, 0.0), fused.count
