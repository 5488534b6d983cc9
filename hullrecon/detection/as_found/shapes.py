# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Alpha shapes of the features off the hull in each view [Ozog2016 4.3, Algorithms 4 and 5]."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hullrecon.detection.options import MIN_CLUSTER_POINTS, MIN_OFFSET_M, DetectOptions
from hullrecon.detection.views import CameraViews, iterate_views
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.neighbours import is_near, nearest
from hullrecon.threads import in_threads
from hullrecon.typing import Array, Ints, Ints32

ALPHA_RADIUS_M = 0.06  # largest circumradius of a triangle of an alpha shape


def detect_shapes(
    in_camera: Array,
    deviation: Array,
    threshold_m: float,
    reach_m: float,
    least: int,
    alpha_m: float,
) -> list[Mesh]:
    """Cluster and mesh a view's features that stand off the hull [Ozog2016 Algorithm 4].

    The meshes outline structures as this view shows them. Empty where no cluster has a triangle.
    Features beyond the threshold are taken as points (f_x, f_y, |d|) and clustered by DBSCAN. Each
    cluster is meshed by its alpha shape in (f_x, f_y). Raised and sunken features are clustered
    separately, as |d| alone would join a bump with the hole beside it.

    Parameters
    ----------
    in_camera
        Features (n, 3) m in the camera's frame.
    deviation
        Signed distances (n,) m of the features from the hull.
    threshold_m
        Features whose absolute deviation is smaller are of the hull, and left out.
    reach_m, least
        Radius and least number of points of DBSCAN.
    alpha_m
        Largest circumradius of a triangle: wider gaps between features stay open.
    """
    shapes = []
    for sign in (1.0, -1.0):
        off = np.flatnonzero(sign * deviation > threshold_m)
        points = np.column_stack([in_camera[off, :2], np.abs(deviation[off])])
        label = dbscan(points, reach_m, least)
        for cluster in range(int(label.max(initial=-1)) + 1):
            member = off[label == cluster]
            faces = alpha_shape(in_camera[member, :2], alpha_m)
            if len(faces):
                shapes.append(Mesh(in_camera[member], faces))
    return shapes


def dbscan(points: Array, reach_m: float, least: int) -> Ints:
    """Cluster points (n, k) by density (DBSCAN [Ester1996]): number of the cluster (n,), -1: noise.

    Clusters are numbered in the order of their first core points. A point is one of its own
    neighbours. A point on the rim of two clusters goes to the one with the nearest core point.

    Parameters
    ----------
    points
        (n, k) m.
    reach_m
        Radius of a neighbourhood.
    least
        Number of neighbours from which a point is a core point.
    """
    label = np.full(len(points), -1, np.int64)
    if len(points) < least:
        return label
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    # Core points within reach of each other are one cluster. Any other point is of the cluster of
    # its nearest core point.
    tree = cKDTree(points)
    core = np.flatnonzero(tree.query_ball_point(points, reach_m, return_length=True) >= least)
    if not len(core):
        return label
    pairs = cKDTree(points[core]).query_pairs(reach_m, output_type="ndarray")
    edges = coo_array(
        (np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(core), len(core))
    )
    number = connected_components(edges, directed=False)[1]
    # Number the clusters in the order of their first core points
    _, first = np.unique(number, return_index=True)
    rank = np.asarray(np.argsort(np.argsort(first))[number], np.int64)
    distance, near = nearest(points[core], points, 1, reach_m * (1 + 1e-9))
    joined = np.isfinite(distance[:, 0])
    label[joined] = rank[near[joined, 0]]
    return label


def alpha_shape(points: Array, alpha_m: float) -> Ints32:
    """Triangulate points (n, 2) m and keep triangles (m, 3) with a circumradius up to alpha.

    What is left outlines the points closely, gaps included. Empty for fewer than three points, or
    points on one line.
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


def find_shape_hits(
    views: CameraViews,
    features: Array,
    deviation: Array,
    vertices: Array,
    options: DetectOptions,
    threshold_m: float = MIN_OFFSET_M,
) -> Iterator[tuple[Ints, Array]]:
    """Intersect the rays to vertices with the shapes that each view's features span.

    Where the ray to a vertex hits a shape, that view shows the vertex to be on a structure.

    Parameters
    ----------
    views
        Images of the top camera.
    features, deviation
        Landmarks (l, 3) m, and their signed distances (l,) m from the hull.
    vertices
        Vertices (n, 3) m of the as-found mesh. Those far from all features off the hull are not
        looked at.
    options
        Gives the radius of clusters.
    threshold_m
        Least absolute deviation of a shape's features.

    Yields
    ------
    rows, points
        For each view with shapes, the k vertices whose rays meet one, and the intersections (k, 3).
    """
    # Only features off the hull make shapes, and only vertices near them can be met
    off = np.flatnonzero(np.abs(deviation) > threshold_m)
    near = np.flatnonzero(is_near(features[off], vertices, 3 * ALPHA_RADIUS_M))
    nearby = dict(iterate_views(views, vertices[near])) if len(near) else {}

    def meet(seen_by: tuple[int, Ints]) -> tuple[Ints, Array]:
        """Find where rays meet the shapes of one view, given its number and the features it saw."""
        view, rows = seen_by
        camera_from_result = views.result_from_camera[view].inverse()
        shapes = detect_shapes(
            camera_from_result.apply(features[off[rows]]),
            deviation[off[rows]],
            threshold_m,
            options.cluster_reach_m,
            MIN_CLUSTER_POINTS,
            ALPHA_RADIUS_M,
        )
        # Where the rays to the vertices in this view meet the shapes
        seen = near[nearby[view]]
        met = _intersections(shapes, camera_from_result.apply(vertices[seen]))
        hit = np.isfinite(met).all(axis=1)
        return seen[hit], views.result_from_camera[view].apply(met[hit])

    looking = iterate_views(views, features[off]) if nearby else ()
    yield from in_threads(meet, [(view, rows) for view, rows in looking if view in nearby])


def count_shapes(
    views: CameraViews, features: Array, deviation: Array, vertices: Array, options: DetectOptions
) -> Ints:
    """Count the views (n,) whose ray to each vertex meets a shape [Ozog2016 Algorithm 5].

    An object must be shown by enough views. features: (l, 3) m, landmarks. deviation: (l,) m from
    the hull. vertices: (n, 3) m.
    """
    count = np.zeros(len(vertices), np.int64)
    for rows, _ in find_shape_hits(views, features, deviation, vertices, options):
        count[rows] += 1
    return count


def _intersections(shapes: list[Mesh], vertices: Array) -> Array:
    """Intersect the rays from the camera to vertices with shapes, all in the camera's frame.

    Returns the intersections (n, 3) m, NaN where a ray meets no shape.
    """
    # All shapes as one mesh
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
