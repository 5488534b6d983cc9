# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""3D Tiles of a small hull, as a viewer reads them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from io import BytesIO
from typing import Any

import numpy as np
import pytest
import trimesh
from mosaic.conftest import FlatChart

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.mosaic_surface import MosaicSurface, build_mosaic_surface
from hullrecon.mosaic.output.cog import Picture
from hullrecon.mosaic.output.raster import RasterLayout
from hullrecon.mosaic.output.tile_store import CompressedTiles
from hullrecon.mosaic.output.tiles_3d import UNSEEN_RGB, Pyramid, write_tileset

GRID = TexelGrid(west=-0.8, north=0.6, step_m=0.002, height=600, width=800)
Tree = tuple[dict[str, Any], dict[str, bytes]]


def wavy_surface() -> MosaicSurface:
    """A plate whose height is 5 cm times a wave along both axes."""
    x, y = np.meshgrid(np.linspace(-1, 1, 81), np.linspace(-1, 1, 81))
    vertices = np.stack([x, y, 0.05 * np.sin(3 * x) * np.cos(3 * y)], axis=-1).reshape(-1, 3)
    index = np.arange(81 * 81).reshape(81, 81)
    a, b, c, d = (
        index[s].ravel() for s in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1], np.s_[1:, 1:])
    )
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    return build_mosaic_surface(Mesh(vertices, faces.astype(np.int32)), FlatChart(), 0.5)


def pyramid(seen: bool = True) -> Pyramid:
    """Two sizes of a picture, all seen but its left quarter, red growing along."""
    pictures = []
    for halved in (1, 2):
        height, width = GRID.height // halved, GRID.width // halved
        tiles = CompressedTiles((1024, 1024, 4), "uint8", BytesIO())
        picture = np.zeros((1024, 1024, 4), np.uint8)
        picture[:height, width // 4 : width, 0] = np.linspace(40, 240, width - width // 4)
        picture[:height, width // 4 : width, 3] = 255 * seen
        tiles.add(picture)
        pictures.append(Picture(tiles=tiles, size=1024, width=width, height=height))
    outside = OutsideMap(x_sign=1, y_sign=1, frame="M")
    layout = RasterLayout(grid=GRID, size=1024, outside=outside)
    return Pyramid(pictures=pictures, layout=layout, surface=wavy_surface())


@pytest.fixture(scope="module")
def tree() -> Tree:
    files: dict[str, bytes] = {}
    tileset = write_tileset(pyramid(), files.__setitem__, "M")
    assert tileset is not None
    return tileset, files


def nodes(tile: dict[str, Any]) -> Iterator[dict[str, Any]]:
    yield tile
    for child in tile.get("children", []):
        yield from nodes(child)


def load(data: bytes) -> trimesh.Trimesh:
    (mesh,) = trimesh.load(BytesIO(data), file_type="glb", process=False).geometry.values()
    return mesh


def in_tileset(data: bytes) -> np.ndarray[Any, Any]:
    """Place a tile's vertices as a viewer does: by its node, then from y up to z up."""
    scene = trimesh.load(BytesIO(data), file_type="glb", process=False)
    place, _ = scene.graph[scene.graph.nodes_geometry[0]]
    (mesh,) = scene.geometry.values()
    x, y, z = (mesh.vertices @ place[:3, :3].T + place[:3, 3]).T
    return np.stack([x, -z, y], axis=1)


def test_every_file_is_named_by_one_tile(tree: Tree) -> None:
    tileset, files = tree
    named = [node["content"]["uri"] for node in nodes(tileset["root"])]
    assert sorted(named) == sorted(files)
    assert sorted(files) == ["0/0-0.glb", "1/0-0.glb", "1/0-1.glb", "1/1-0.glb", "1/1-1.glb"]
    assert tileset["asset"]["version"] == "1.1"
    assert tileset["asset"]["extras"]["rotation_from_frame"] == np.eye(3).tolist()


def test_errors_halve_down_to_zero_at_the_leaves(tree: Tree) -> None:
    tileset, _ = tree
    root = tileset["root"]
    assert tileset["geometricError"] == 2 * root["geometricError"] > 0
    assert root["geometricError"] == pytest.approx(16 * 0.004)
    assert [child["geometricError"] for child in root["children"]] == [0, 0, 0, 0]


def test_boxes_hold_their_tiles_and_those_below(tree: Tree) -> None:
    tileset, files = tree
    for node in nodes(tileset["root"]):
        box = np.array(node["boundingVolume"]["box"])
        center, half = box[:3], np.diag(box[3:].reshape(3, 3))
        for below in nodes(node):
            points = in_tileset(files[below["content"]["uri"]])
            assert (np.abs(points - center) <= half).all()


def test_vertices_lie_on_the_surface_or_hang_below_it(tree: Tree) -> None:
    for name, data in tree[1].items():
        x, y, z = in_tileset(data).T
        off = z - 0.05 * np.sin(3 * x) * np.cos(3 * y)
        depth = 16 * (0.002 if name.startswith("1/") else 0.004)
        hangs = off < -0.5 * depth
        assert np.abs(off[~hangs]).max() < 1e-3  # chords of the surface's own mesh
        np.testing.assert_allclose(off[hangs], -depth, atol=1e-3)
        assert hangs.any() == name.startswith("1/")  # the root has no neighbour


def test_neighbours_share_vertices_and_normals_of_their_border(tree: Tree) -> None:
    _, files = tree
    border = GRID.west + 512 * GRID.step_m
    sides = []
    for name in ("1/0-0.glb", "1/1-0.glb"):
        points, normals = in_tileset(files[name]), load(files[name]).vertex_normals
        on = np.abs(points[:, 0] - border) < 1e-6
        order = np.lexsort(points[on].T)
        sides.append((points[on][order], normals[on][order]))
    assert len(sides[0][0]) > 20
    np.testing.assert_array_equal(sides[0][0], sides[1][0])
    np.testing.assert_array_equal(sides[0][1], sides[1][1])


def test_faces_look_outward_and_what_was_not_seen_has_none(tree: Tree) -> None:
    mesh = load(tree[1]["0/0-0.glb"])
    assert (mesh.face_normals[:, 2] > 0.9).all()
    points = in_tileset(tree[1]["0/0-0.glb"])
    cell = 16 * 0.004
    assert points[:, 0].min() > -0.4 - cell - 1e-9
    assert points[:, 0].max() == pytest.approx(0.8, abs=cell)


def test_the_texture_lies_where_the_mosaic_says(tree: Tree) -> None:
    for data in tree[1].values():
        mesh, points = load(data), in_tileset(data)
        texture = np.asarray(mesh.visual.material.baseColorTexture.convert("RGB")).astype(int)
        side = texture.shape[0]
        column = mesh.visual.uv[:, 0] * side - 0.5
        row = (1 - mesh.visual.uv[:, 1]) * side - 0.5
        red = texture[
            np.clip(np.rint(row), 0, side - 1).astype(int),
            np.clip(np.rint(column), 0, side - 1).astype(int),
            0,
        ]
        share = (points[:, 0] + 0.4) / 1.2
        inner = (share > 0.03) & (share < 0.97) & (np.abs(points[:, 1]) < 0.55)
        np.testing.assert_allclose(red[inner], 40 + 200 * share[inner], atol=6)


def test_what_no_view_saw_is_gray(tree: Tree) -> None:
    texture = load(tree[1]["1/0-0.glb"]).visual.material.baseColorTexture.convert("RGB")
    np.testing.assert_allclose(np.asarray(texture)[100, 100], UNSEEN_RGB, atol=3)


def test_a_mosaic_that_saw_nothing_has_no_tiles() -> None:
    files: dict[str, bytes] = {}
    assert write_tileset(pyramid(seen=False), files.__setitem__, "M") is None
    assert not files


def test_a_frame_with_z_down_is_turned_up(flat_surface: Callable[..., MosaicSurface]) -> None:
    class Down(FlatChart):
        ship_axes = np.diag([1.0, -1.0, -1.0])

    one = pyramid()
    surface = replace(one.surface, chart=Down())
    files: dict[str, bytes] = {}
    tileset = write_tileset(replace(one, surface=surface), files.__setitem__, "g")
    assert tileset is not None
    asset: Any = tileset["asset"]
    turn = np.array(asset["extras"]["rotation_from_frame"])
    np.testing.assert_array_equal(turn @ [0, 0, 1], [0, 0, -1])
    assert np.linalg.det(turn) == pytest.approx(1)
