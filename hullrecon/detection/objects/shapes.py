# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes in one view [Ozog2016 4.3.2, Algorithm 4]: features off the hull, clustered and meshed."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.neighbours import nearest
from hullrecon.typing import Array, Ints, Ints32


def detect_shapes(
    in_camera: Array,
    deviation: Array,
    threshold_m: float,
    reach_m: float,
    least: int,
    alpha_m: float,
) -> list[Mesh]:
    """Return shapes among a view's features, as meshes of features in the camera's frame.

    in_camera (n, 3) m; deviation (n,) m from the hull. Features beyond the threshold are points
    (f_x, f_y, |d|), clustered by DBSCAN with that reach and number of points; each cluster is
    meshed by its alpha shape in (f_x, f_y). Raised and sunken features are clustered apart: |d|
    alone would join a bump with the hole beside it.
    """
    shapes = []
    for side in (1.0, -1.0):
        off = np.flatnonzero(side * deviation > threshold_m)
        points = np.column_stack([in_camera[off, :2], np.abs(deviation[off])])
        label = dbscan(points, reach_m, least)
        for cluster in range(int(label.max(initial=-1)) + 1):
            member = off[label == cluster]
            faces = alpha_shape(in_camera[member, :2], alpha_m)
            if len(faces):
                shapes.append(Mesh(in_camera[member], faces))
    return shapes


def dbscan(points: Array, reach_m: float, least: int) -> Ints:
    """Return the cluster (n,) of each point, -1 for noise; numbered in the points' order. A point
    counts among its own neighbours; one on the rim of two clusters goes to the nearer.
    """
    label = np.full(len(points), -1, np.int64)
    if len(points) < least:
        return label
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    core = np.flatnonzero(tree.query_ball_point(points, reach_m, return_length=True) >= least)
    if not len(core):
        return label
    pairs = cKDTree(points[core]).query_pairs(reach_m, output_type="ndarray")
    links = coo_array(
        (np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(core), len(core))
    )
    number = connected_components(links, directed=False)[1]
    _, first = np.unique(number, return_index=True)
    rank = np.asarray(np.argsort(np.argsort(first))[number], np.int64)
    distance, near = nearest(points[core], points, 1, reach_m * (1 + 1e-9))
    joined = np.isfinite(distance[:, 0])
    label[joined] = rank[near[joined, 0]]
    return label


def alpha_shape(points: Array, alpha_m: float) -> Ints32:
    """Return the Delaunay triangles (m, 3) of points (n, 2) whose circumscribed circle is no larger
    than alpha.
    """
    from scipy.spatial import Delaunay, QhullError

    if len(points) < 3:
        return np.zeros((0, 3), np.int32)
    try:
        faces = Delaunay(points).simplices
    except QhullError:  # all on one line: no area, no shape
        return np.zeros((0, 3), np.int32)
    a, b, c = points[faces].transpose(1, 0, 2)
    sides = [np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))]
    twice_area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    radius = sides[0] * sides[1] * sides[2] / np.maximum(2 * twice_area, 1e-15)
    return np.asarray(faces[radius <= alpha_m], np.int32)
