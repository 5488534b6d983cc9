# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The textured mesh."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO

import numpy as np
import trimesh

from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.output.textured_mesh import TexturedMesh, build_textured_mesh, encode_glb

UP, DOWN = np.array([0.0, 0, 1]), np.array([0.0, 0, -1])
GRID = TexelGrid(west=-0.8, north=0.6, step_m=0.01, height=120, width=160)


def checks() -> np.ndarray:
    picture = np.zeros((120, 160, 4), np.uint8)
    picture[..., :3] = np.where((np.indices((120, 160)).sum(axis=0) // 20) % 2, 90, 140)[..., None]
    picture[:, 20:, 3] = 255
    return picture


def test_the_sheet_covers_what_was_seen_and_faces_outward(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    mesh = build_textured_mesh(flat_surface(), GRID, checks()[..., 3], 1, max_faces=5000)
    assert 2000 < len(mesh.faces) < 6000
    assert mesh.vertices[:, 0].min() > -0.62  # the first 20 columns were not seen
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    np.testing.assert_allclose(mesh.uv[:, 0], (mesh.vertices[:, 0] + 0.8) / 1.6, atol=0.01)
    np.testing.assert_allclose(mesh.uv[:, 1], (mesh.vertices[:, 1] + 0.6) / 1.2, atol=0.01)


class LeftHanded:
    """along is x, girth is against y, outward is z: as the charts of hulls are (geometry.chart)."""

    def to_chart(self, points: np.ndarray) -> np.ndarray:
        return points * [1, -1, 1]

    def from_chart(self, along_girth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.column_stack([along_girth * [1, -1], np.zeros(len(along_girth))]), np.tile(
            [0.0, 0.0, 1.0], (len(along_girth), 1)
        )


def test_on_a_left_handed_chart_the_sheet_faces_outward_too(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    mesh = build_textured_mesh(
        replace(flat_surface(), chart=LeftHanded()), GRID, checks()[..., 3], 1, max_faces=5000
    )
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    np.testing.assert_allclose(mesh.uv[:, 1], (0.6 - mesh.vertices[:, 1]) / 1.2, atol=0.01)


def test_glb_is_upright_textured_and_deterministic(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    mesh = build_textured_mesh(flat_surface(), GRID, checks()[..., 3], 1, max_faces=2000)
    data = encode_glb(mesh, checks(), UP)
    assert data == encode_glb(mesh, checks(), UP)
    scene = trimesh.load(BytesIO(data), file_type="glb")
    (mesh,) = scene.geometry.values()
    assert len(mesh.faces) == len(mesh.faces)
    assert mesh.visual.material.baseColorTexture.size == (160, 120)
    turn, _ = scene.graph[scene.graph.nodes_geometry[0]]
    # z, up, is y in glTF
    np.testing.assert_allclose(turn, [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


def test_the_glb_has_the_normals_of_its_surface(flat_surface: Callable[..., MosaicSurface]) -> None:
    data = encode_glb(
        build_textured_mesh(flat_surface(), GRID, checks()[..., 3], 1, max_faces=500), checks(), UP
    )
    size = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + size])
    accessor = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"]]
    view = document["bufferViews"][accessor["bufferView"]]
    start = 20 + size + 8 + view["byteOffset"] + accessor.get("byteOffset", 0)
    normals = np.frombuffer(data, "<f4", 3 * accessor["count"], start).reshape(-1, 3)
    np.testing.assert_allclose(normals, np.tile([0.0, 0.0, 1.0], (accessor["count"], 1)), atol=1e-6)


def test_the_mesh_keeps_to_its_number_of_faces(flat_surface: Callable[..., MosaicSurface]) -> None:
    alpha = np.full((120, 160), 255, np.uint8)
    few, many = (
        build_textured_mesh(flat_surface(), GRID, alpha, 1, max_faces=n) for n in (300, 3000)
    )
    assert 200 < len(few.faces) <= 320
    assert 2000 < len(many.faces) <= 3200


def test_a_mosaic_that_saw_nothing_has_a_mesh_without_faces(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    mesh = build_textured_mesh(
        flat_surface(), GRID, np.zeros((120, 160), np.uint8), 1, max_faces=300
    )
    assert mesh.faces.shape == (0, 3)
    assert mesh.uv.shape == (0, 2)


def test_a_mesh_in_g_is_turned_so_that_down_is_down() -> None:
    mesh = TexturedMesh(
        vertices=np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]]),
        faces=np.array([[0, 1, 2]]),
        uv=np.array([[0.0, 0], [1, 0], [0, 1]]),
        normals=np.tile([0.0, 0, 1], (3, 1)),
    )
    scene = trimesh.load(BytesIO(encode_glb(mesh, checks(), DOWN)), file_type="glb")
    turn, _ = scene.graph[scene.graph.nodes_geometry[0]]
    # z of g is down, y of glTF is up
    np.testing.assert_allclose(turn[:3, :3] @ [0, 0, 1], [0, -1, 0], atol=1e-12)
    assert np.linalg.det(turn[:3, :3]) > 0


def test_a_gray_mosaic_is_a_texture_too(flat_surface: Callable[..., MosaicSurface]) -> None:
    mesh = build_textured_mesh(flat_surface(), GRID, checks()[..., 3], 1, max_faces=300)
    scene = trimesh.load(BytesIO(encode_glb(mesh, checks()[..., 2:], UP)), file_type="glb")
    (loaded,) = scene.geometry.values()
    texture = np.asarray(loaded.visual.material.baseColorTexture.convert("RGB")).astype(int)
    assert np.abs(texture[..., 0] - texture[..., 2]).max() <= 2
    assert np.ptp(texture) > 30


def test_a_mesh_in_map_coordinates_keeps_tenths_of_a_millimetre() -> None:
    far = np.array([573_412.3, 6_020_155.7, -3.8])
    mesh = TexturedMesh(
        vertices=far + np.array([[0.0, 0, 0.0123], [1, 0, 0], [0, 1, 0]]),
        faces=np.array([[0, 1, 2]]),
        uv=np.array([[0.0, 0], [1, 0], [0, 1]]),
        normals=np.tile([0.0, 0, 1], (3, 1)),
    )
    scene = trimesh.load(BytesIO(encode_glb(mesh, checks(), UP)), file_type="glb")
    (stored,) = scene.geometry.values()
    assert np.abs(stored.vertices).max() < 2
    place, _ = scene.graph[scene.graph.nodes_geometry[0]]
    turned = stored.vertices @ place[:3, :3].T + place[:3, 3]
    upright = np.stack([turned[:, 0], -turned[:, 2], turned[:, 1]], axis=1)
    np.testing.assert_allclose(np.sort(upright, axis=0), np.sort(mesh.vertices, axis=0), atol=1e-4)
