# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The base surface, refined where the hull was seen: the mesh that is moved to what was found."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.geometry.neighbours import nearest
from hullrecon.typing import Array


def refine_near(mesh: Mesh, points: Array, edge_m: float, reach_m: float) -> Mesh:
    """Return a mesh with edges no longer than `edge_m` within `reach_m` of the points (n, 3), in
    proportion longer beyond.
    """
    cell = 0.5 * max(edge_m, reach_m)
    thinned: Array = np.unique(np.round(points / cell), axis=0) * cell

    def allowed_edge(middle: Array) -> Array:
        distance, _ = nearest(thinned, middle, 1)
        return np.asarray(edge_m + np.maximum(0.0, distance[:, 0] - reach_m - cell))

    return refine(mesh, allowed_edge, spared_m=edge_m)[0] if len(points) else mesh


def affordable_edge(points: Array, edge_m: float, max_vertices: int) -> float:
    """Return the edge, or a longer one where the seen area would need more vertices than that (a
    vertex an 0.43 edge^2).
    """
    cell = 0.2
    area = len(np.unique(np.floor(points / cell).astype(np.int64), axis=0)) * cell**2
    return float(max(edge_m, np.sqrt(area / (0.43 * max_vertices))))
