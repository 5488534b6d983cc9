# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The ship's CAD model as glTF, shown together with the measurements."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.gltf_axes import gltf_from
from hullrecon.geometry.meshes.mesh import Mesh, vertex_normals

# triangles that a viewer still turns smoothly, to which a finer model is decimated
MAX_FACES = 200_000
# Foxglove turns glTF's y to the z of the frame, whichever axis of M is up
Z_UP = np.array([0.0, 0.0, 1.0])
STEEL = (150, 160, 170, 255)


def ship_glb(mesh: Mesh) -> bytes:
    """Encode a CAD model in M as a GLB of at most about MAX_FACES triangles."""
    import trimesh

    shown = _thinned(mesh)
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=STEEL,
        metallicFactor=0.0,
        roughnessFactor=1.0,
        doubleSided=True,
        name="cad_model",
    )
    ship = trimesh.Trimesh(
        shown.vertices,
        shown.faces,
        vertex_normals=vertex_normals(shown),
        visual=trimesh.visual.TextureVisuals(material=material),
        process=False,
    )
    scene = trimesh.Scene()
    scene.add_geometry(ship, node_name="ship", geom_name="ship", transform=gltf_from(Z_UP))
    return bytes(scene.export(file_type="glb", include_normals=True))


def _thinned(mesh: Mesh) -> Mesh:
    if len(mesh.faces) <= MAX_FACES:
        return mesh
    import open3d as o3d

    full = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices), o3d.utility.Vector3iVector(mesh.faces)
    )
    thin = full.simplify_quadric_decimation(target_number_of_triangles=MAX_FACES)
    return Mesh(np.asarray(thin.vertices), np.asarray(thin.triangles, np.int32))
