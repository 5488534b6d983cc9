# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes of all views fused into the mesh [Ozog2016 4.3.3, Algorithm 5]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.detection.objects.shapes import detect_shapes
from hullrecon.detection.options import DetectOptions
from hullrecon.detection.views import CameraViews, iterate_views
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.neighbours import nearest
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class FusedShapes:
    """vertex (n, 3): running means of the rays' intersections, the prior's where there were none;
    count (n,): views whose shapes met the ray to that vertex.
    """

    vertex: Array
    count: Ints


def fuse_shapes(
    views: CameraViews, features: Array, deviation: Array, vertices: Array, options: DetectOptions
) -> FusedShapes:
    """Return the vertices (n, 3) moved to the shapes that the views' features (m, 3) with
    deviations (m,) make.

    [Ozog2016 eq. 4.15] is a running mean in which the first observation replaces the prior: the
    mean of all intersections.
    """
    total, count = np.zeros_like(vertices), np.zeros(len(vertices), np.int64)
    off = np.flatnonzero(np.abs(deviation) > options.min_offset_m)
    near = _near(vertices, features[off], 3 * options.alpha_radius_m)
    nearby = dict(iterate_views(views, vertices[near])) if len(near) and len(off) else {}
    for view, rows in iterate_views(views, features[off]) if nearby else ():
        if view not in nearby:
            continue
        camera_from_result = views.result_from_camera[view].inverse()
        shapes = detect_shapes(
            camera_from_result.apply(features[off[rows]]),
            deviation[off[rows]],
            options.min_offset_m,
            options.cluster_reach_m,
            options.min_cluster_points,
            options.alpha_radius_m,
        )
        seen = near[nearby[view]]
        met = _intersections(shapes, camera_from_result.apply(vertices[seen]))
        hit = np.isfinite(met).all(axis=1)
        total[seen[hit]] += views.result_from_camera[view].apply(met[hit])
        count[seen[hit]] += 1
    vertex = np.where(count[:, None] > 0, total / np.maximum(count, 1)[:, None], vertices)
    return FusedShapes(vertex=vertex, count=count)


def _near(vertices: Array, features: Array, reach_m: float) -> Ints:
    """Return the vertices near enough to any feature off the hull to be moved."""
    if not len(features):
        return np.zeros(0, np.int64)
    return np.flatnonzero(np.isfinite(nearest(features, vertices, 1, reach_m)[0][:, 0]))


def _intersections(shapes: list[Mesh], vertices: Array) -> Array:
    """Find where the rays from the camera to vertices (n, 3), both in its frame, meet the nearest
    shape; NaN: nowhere.
    """
    if not shapes:
        return np.full(vertices.shape, np.nan)
    start = np.cumsum([0, *(len(s.vertices) for s in shapes)])
    faces = np.vstack([s.faces + at for s, at in zip(shapes, start[:-1], strict=True)]).astype(
        np.int32
    )
    scene = Scene(Mesh(np.vstack([s.vertices for s in shapes]), faces))
    ray = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    along = scene.cast(np.zeros(3), ray)
    return np.where(
        np.isfinite(along)[:, None], ray * np.where(np.isfinite(along), along, 0.0)[:, None], np.nan
    )
