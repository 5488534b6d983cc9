# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A triangulated grid of the chart, only where returns support it."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array


def supported_lattice(at: Array, step_m: float, reach_m: float) -> Mesh:
    """Return grid nodes (along, girth, 0) no farther than `reach_m` from a return at (n, 2),
    triangulated (Delaunay).

    Faces look along along x girth. Nodes that no whole cell uses are left out.
    """
    from scipy.spatial import cKDTree

    low = np.floor((at.min(axis=0) - reach_m) / step_m)
    count = (np.ceil((at.max(axis=0) + reach_m) / step_m) - low).astype(int) + 1
    along, girth = np.meshgrid(
        *(step_m * (low[k] + np.arange(count[k])) for k in (0, 1)), indexing="ij"
    )
    nodes = np.stack([along.ravel(), girth.ravel()], axis=1)
    near = np.isfinite(cKDTree(at).query(nodes, distance_upper_bound=reach_m)[0]).reshape(count)
    number = np.arange(nodes.shape[0]).reshape(count)
    whole = near[:-1, :-1] & near[1:, :-1] & near[:-1, 1:] & near[1:, 1:]
    a, b, c, d = (
        n[whole] for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    faces = np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)], axis=1).reshape(
        -1, 3
    )
    used, renumbered = np.unique(faces, return_inverse=True)
    vertices = np.hstack([nodes[used], np.zeros((len(used), 1))])
    return Mesh(vertices, renumbered.reshape(-1, 3).astype(np.int32))
