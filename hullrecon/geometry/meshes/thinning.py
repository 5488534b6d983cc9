# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Thinning a mesh to what a viewer turns smoothly."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.open3d_import import import_open3d
from hullrecon.memory import return_free_memory


def thin_mesh(mesh: Mesh, most: int) -> Mesh:
    """Thin a mesh to about `most` triangles by collapsing edges, the flattest first.

    One that has no more is returned as it is.
    """
    if len(mesh.faces) <= most:
        return mesh
    o3d = import_open3d()
    full = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices), o3d.utility.Vector3iVector(mesh.faces)
    )
    thin = full.simplify_quadric_decimation(target_number_of_triangles=most)
    out = Mesh(np.array(thin.vertices), np.array(thin.triangles, np.int32))
    del full, thin
    return_free_memory()
    return out
