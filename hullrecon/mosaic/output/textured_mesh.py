# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make a mesh of the surface with the mosaic as its texture, and encode it as GLB."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.meshes.gltf_axes import gltf_from
from hullrecon.geometry.meshes.local_origin import local_origin
from hullrecon.geometry.meshes.mesh import Mesh, face_cross_products, vertex_normals
from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.mosaic_surface import MosaicSurface, SurfacePatch, sample_surface
from hullrecon.typing import Array, Ints, Mask

# Slices that select the four corners of each cell of a grid of vertices
_CORNERS = (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1], np.s_[1:, 1:])


@dataclass(frozen=True, kw_only=True)
class TexturedMesh:
    """A mesh with the texture's coordinates."""

    vertices: Array  # (n, 3) m
    faces: Ints  # (m, 3), counter-clockwise seen from outside
    uv: Array  # (n, 2), v upwards
    normals: Array  # (n, 3), unit length, without which a viewer shades each triangle flat


def build_textured_mesh(
    surface: MosaicSurface,
    grid: TexelGrid,
    alpha: NDArray[np.uint8],
    reduction: int,
    max_faces: int,
) -> TexturedMesh:
    """Mesh the seen part of the surface on a regular grid of the chart.

    Without a cell of the grid that was seen at all its corners, the mesh is empty.

    Parameters
    ----------
    surface
        The surface on which the mosaic was laid.
    grid
        Texels of the mosaic.
    alpha
        (h, w) opacity of the reduced mosaic, which is the texture: 0 where nothing was seen.
    reduction
        Texels of the mosaic along a pixel of the reduced one.
    max_faces
        About the number of triangles.
    """
    # The step with which the seen area, m2, has about max_faces triangles
    seen = int((alpha > 0).sum()) * reduction**2 * grid.step_m**2
    step = max(grid.step_m * reduction, np.sqrt(2 * max(seen, 1e-6) / max_faces))
    height, width = (max(1, round(n * grid.step_m / step)) for n in (grid.height, grid.width))
    coarse = TexelGrid(grid.west, grid.north, step, height, width)
    patch = sample_surface(surface, coarse, Window(0, height, 0, width))
    # The pixels of the reduced mosaic at the vertices
    rows, columns = (
        (np.arange(n) + 0.5) * step / (grid.step_m * reduction) for n in (height, width)
    )
    row = np.minimum(rows.astype(int), alpha.shape[0] - 1)
    column = np.minimum(columns.astype(int), alpha.shape[1] - 1)
    good = (alpha[row][:, column] > 0) & np.isfinite(patch.point).all(axis=2)
    faces = _outward(_faces(good), patch)
    used, faces = np.unique(faces, return_inverse=True)
    uv = np.stack(
        np.meshgrid(columns / alpha.shape[1], 1 - rows / alpha.shape[0]), axis=-1
    ).reshape(-1, 2)
    vertices, faces = patch.point.reshape(-1, 3)[used], faces.reshape(-1, 3)
    return TexturedMesh(
        vertices=vertices,
        faces=faces,
        uv=uv[used],
        normals=vertex_normals(Mesh(vertices, faces.astype(np.int32))),
    )


def _faces(good: Mask) -> Ints:
    """Triangulate the cells of a grid (h, w) whose four corners are good: faces (m, 3).

    All triangles have the same orientation. Rows run against the girth, columns along.
    """
    height, width = good.shape
    index = np.arange(height * width).reshape(height, width)
    cell = good[:-1, :-1] & good[1:, :-1] & good[:-1, 1:] & good[1:, 1:]
    a, b, c, d = (index[s][cell] for s in _CORNERS)
    return np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])


def _outward(faces: Ints, patch: SurfacePatch) -> Ints:
    """Orient triangles (m, 3) counter-clockwise seen from outside.

    Whether (along, girth) is left- or right-handed about the outward normal depends on the chart.
    """
    across = face_cross_products(Mesh(patch.point.reshape(-1, 3), faces.astype(np.int32)))
    outward = np.einsum("ni,ni->n", across, patch.normal.reshape(-1, 3)[faces[:, 0]])
    return faces if outward.sum() >= 0 else faces[:, ::-1]


def encode_glb(mesh: TexturedMesh, texture: NDArray[np.uint8], up: Array) -> bytes:
    """Encode a textured mesh as a GLB file, with y up as in glTF.

    Vertices are in single precision relative to a local origin, to which the node's matrix moves
    them.

    Parameters
    ----------
    mesh
        The mesh, in the frame of the results.
    texture
        (h, w, 4) RGBA, or (h, w, 2) gray and alpha.
    up
        (3,) unit vector of the frame that points up.
    """
    import trimesh
    from PIL import Image

    rgb = texture[..., :3] if texture.shape[2] == 4 else np.repeat(texture[..., :1], 3, axis=2)
    picture = Image.fromarray(np.ascontiguousarray(rgb))
    picture.format = "JPEG"  # in which it is written
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=picture,
        metallicFactor=0.0,
        roughnessFactor=1.0,
        doubleSided=True,
        name="mosaic",
    )
    origin = local_origin(mesh.vertices)
    place = gltf_from(up)
    place[:3, 3] = place[:3, :3] @ origin
    shape = trimesh.Trimesh(
        mesh.vertices - origin,
        mesh.faces,
        vertex_normals=mesh.normals,
        visual=trimesh.visual.TextureVisuals(uv=mesh.uv, material=material),
        process=False,
    )
    scene = trimesh.Scene()
    scene.add_geometry(shape, node_name="hull", geom_name="hull", transform=place)
    data: bytes = scene.export(file_type="glb", include_normals=True)
    return bytes(data)
