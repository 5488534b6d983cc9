# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write the textured hull as OGC 3D Tiles 1.1: a quadtree over the mosaic's map, a GLB a tile.

The finest tiles have the mosaic's own texels. Each level above has half as many texels and vertices
to a metre. Tiles of one level share the vertices of their borders. Skirts, strips of mesh that go
inward from the borders, close the cracks between tiles of two levels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.meshes.gltf_axes import gltf_from
from hullrecon.mosaic.grid import Window
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.output.cog import Picture
from hullrecon.mosaic.output.raster import RasterLayout
from hullrecon.mosaic.output.textured_mesh import TexturedMesh, encode_glb
from hullrecon.threads import in_threads
from hullrecon.typing import Array, Ints, Mask

TILE_PX = 512  # texels along a tile
MARGIN_PX = 1  # texture around a tile, so that filtering at its border sees its neighbours
MESH_M = 0.03  # about the edge length of the finest mesh, that of the hull as found
MIN_CELL_PX = 4  # least texels along a cell of the mesh: a sonar's texels are longer than MESH_M
# Geometric error of a tile, in its texels. A viewer refines a tile whose error is longer than 16
# pixels on the screen (CesiumJS' default), which is where a texel is longer than a pixel.
ERROR_TEXELS = 16
UNSEEN_RGB = (233, 237, 241)  # of texels that no view saw, as in the PNG
# From glTF, which has y up, to 3D Tiles with z up: (x, y, z) becomes (x, -z, y)
_Z_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


@dataclass(frozen=True, kw_only=True)
class Pyramid:
    """A mosaic in all its sizes, and the surface on which it was laid."""

    pictures: Sequence[Picture]  # the full size first, each half as large as the one before
    layout: RasterLayout
    surface: MosaicSurface

    @property
    def cell_px(self) -> int:
        """Texels along a cell of the mesh, a power of two, at any level."""
        wanted = MESH_M / self.layout.grid.step_m
        return int(2 ** np.clip(np.rint(np.log2(wanted)), np.log2(MIN_CELL_PX), 6))

    @property
    def rotation_from_frame(self) -> Array:
        """Rotation (3, 3) from the surface's frame to that of the tiles, which has z up."""
        return np.asarray(_Z_UP @ gltf_from(self.surface.chart.ship_axes[2])[:3, :3])

    @property
    def top(self) -> int:
        """The finest level that is a single tile. Level 0 is the full size."""
        fits = (max(p.width, p.height) <= TILE_PX for p in self.pictures)
        return next(level for level, one in enumerate(fits) if one)

    def texel_m(self, level: int) -> float:
        """Compute the side of a texel of a level on the hull."""
        return float(self.layout.grid.step_m * 2**level)


Place = tuple[int, int, int]  # level, row and column of a tile


@dataclass(frozen=True, kw_only=True)
class _Tile:
    """A tile of tileset.json, with all finer tiles below it."""

    document: dict[str, object]  # the tile in tileset.json
    low: Array  # (3,) m, least corner of the box around it, in the tileset's frame
    high: Array  # (3,) m, largest corner


@dataclass(frozen=True, kw_only=True)
class _Content:
    """The GLB of a tile."""

    uri: str
    low: Array  # (3,) m, least corner of the box around it, in the tileset's frame
    high: Array  # (3,) m, largest corner


def write_tileset(
    pyramid: Pyramid, write: Callable[[str, bytes], None], frame: str
) -> dict[str, object] | None:
    """Write the tiles of a mosaic as GLB files, and describe them as tileset.json.

    The tileset's frame is that of the deliverables, rotated so that z points up as 3D Tiles wants
    it.

    Parameters
    ----------
    pyramid
        The mosaic in all its sizes.
    write
        Writes a file, given its name and bytes.
    frame
        Name of the frame of the surface, M or g.

    Returns
    -------
    dict or None
        tileset.json, None where too little was seen for a mesh.
    """
    level = pyramid.top
    root = _tree(pyramid, (level, 0, 0), _write_contents(pyramid, write))
    if root is None:
        return None
    return {
        "asset": {
            "version": "1.1",
            "extras": {"frame": frame, "rotation_from_frame": pyramid.rotation_from_frame.tolist()},
        },
        "geometricError": 2 * ERROR_TEXELS * pyramid.texel_m(level),
        "root": {"refine": "REPLACE", **root.document},
    }


def _write_contents(pyramid: Pyramid, write: Callable[[str, bytes], None]) -> dict[Place, _Content]:
    """Write the GLB of every tile in which something was seen. The others have none."""

    def make(place: Place) -> tuple[TexturedMesh, bytes] | None:
        """Make the mesh of a tile, and its GLB. None where nothing was seen."""
        level, row, column = place
        texture = _texture(pyramid.pictures[level], row, column)
        mesh = _mesh(pyramid, level, row, column, np.asarray(texture[..., -1] > 0))
        if not len(mesh.faces):
            return None
        return mesh, encode_glb(mesh, _paint_unseen(texture), pyramid.surface.chart.ship_axes[2])

    contents, places = {}, _places(pyramid)
    for (level, row, column), made in zip(places, in_threads(make, places), strict=True):
        if made is not None:
            mesh, glb = made
            uri = f"{pyramid.top - level}/{column}-{row}.glb"
            write(uri, glb)
            placed = mesh.vertices @ pyramid.rotation_from_frame.T
            low, high = placed.min(axis=0), placed.max(axis=0)
            contents[level, row, column] = _Content(uri=uri, low=low, high=high)
    return contents


def _places(pyramid: Pyramid) -> list[Place]:
    """List the tiles of all levels, the finest first."""
    return [
        (level, row, column)
        for level, picture in enumerate(pyramid.pictures[: pyramid.top + 1])
        for row in range(-(-picture.height // TILE_PX))
        for column in range(-(-picture.width // TILE_PX))
    ]


def _tree(pyramid: Pyramid, place: Place, contents: Mapping[Place, _Content]) -> _Tile | None:
    """Describe a tile and all finer tiles below it. None if nothing was seen in any of them.

    place: level, row and column. contents: of all tiles in which something was seen.
    """
    level, row, column = place
    picture = pyramid.pictures[level]
    if row * TILE_PX >= picture.height or column * TILE_PX >= picture.width:
        return None
    # The four tiles of the next finer level that cover this one, as far as something was seen there
    below = [
        _tree(pyramid, (level - 1, 2 * row + i, 2 * column + j), contents)
        for i in (0, 1)
        for j in (0, 1)
        if level > 0
    ]
    children, content = [tile for tile in below if tile is not None], contents.get(place)
    boxes = [(tile.low, tile.high) for tile in children]
    if content is not None:
        boxes.append((content.low, content.high))
    if not boxes:
        return None
    document: dict[str, object] = {} if content is None else {"content": {"uri": content.uri}}
    low, high = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
    # A tile without finer ones has no error: a viewer need not refine it
    document["geometricError"] = ERROR_TEXELS * pyramid.texel_m(level) if children else 0
    document["boundingVolume"] = {"box": _box(low, high)}
    if children:
        document["children"] = [tile.document for tile in children]
    return _Tile(document=document, low=low, high=high)


def _box(low: Array, high: Array) -> list[float]:
    """Make the 12 numbers of a box in 3D Tiles: centre and three half axes.

    The box is a millimetre wider on each side, as vertices are in single precision.
    """
    half = 0.5 * (high - low) + 0.001
    return [*(0.5 * (low + high)).tolist(), *np.diag(half).ravel().tolist()]


def _texture(picture: Picture, row: int, column: int) -> NDArray[np.uint8]:
    """Read the texture of a tile with its margin."""
    top, left = row * TILE_PX - MARGIN_PX, column * TILE_PX - MARGIN_PX
    side = TILE_PX + 2 * MARGIN_PX
    return picture.read(Window(top, top + side, left, left + side)).astype(np.uint8)


def _paint_unseen(texture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Give texels that no view saw the colour UNSEEN_RGB, and make the texture RGBA."""
    rgb = texture[..., :3] if texture.shape[2] == 4 else np.repeat(texture[..., :1], 3, axis=2)
    rgb = np.where(texture[..., -1:] > 0, rgb, np.array(UNSEEN_RGB, np.uint8))
    return np.concatenate([rgb, texture[..., -1:]], axis=2)


def _mesh(pyramid: Pyramid, level: int, row: int, column: int, seen: Mask) -> TexturedMesh:
    """Mesh the seen part of the surface under a tile, with skirts. Empty if nothing was seen.

    seen: whether each texel of the tile, with its margin, was seen.
    """
    cell_px, count = pyramid.cell_px, TILE_PX // pyramid.cell_px
    points, normals, outward = _vertices(pyramid, level, row * count, column * count, count)
    inner = seen[MARGIN_PX:-MARGIN_PX, MARGIN_PX:-MARGIN_PX]
    # A cell has faces if any of its texels was seen, and there is surface at its four corners
    cells = np.asarray(inner.reshape(count, cell_px, count, cell_px).any(axis=(1, 3)))
    good = np.asarray(np.isfinite(points).all(axis=2))
    cells &= good[:-1, :-1] & good[1:, :-1] & good[:-1, 1:] & good[1:, 1:]
    index = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    # Corners of each cell: upper left, upper right, lower left, lower right
    a, b, c, d = (
        index[s][cells] for s in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1], np.s_[1:, 1:])
    )
    faces = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
    at = (np.arange(count + 1) * cell_px + MARGIN_PX) / (TILE_PX + 2 * MARGIN_PX)
    uv = np.stack(np.meshgrid(at, 1 - at), axis=-1).reshape(-1, 2)
    edges = _border(cells, seen, index)
    # The mesh of the level above may be off this one by about its own error
    depth = ERROR_TEXELS * pyramid.texel_m(level)
    # The lower vertices of the skirts follow all vertices of the surface, in the same order
    hung = index.size
    skirt = np.concatenate(
        [
            np.stack([edges[:, 0], edges[:, 1], edges[:, 0] + hung], axis=1),
            np.stack([edges[:, 1], edges[:, 1] + hung, edges[:, 0] + hung], axis=1),
        ]
    )
    flat = points.reshape(-1, 3)
    vertices = np.concatenate([flat, flat - depth * outward.reshape(-1, 3)])
    used, faces = np.unique(np.concatenate([faces, skirt]), return_inverse=True)
    return TexturedMesh(
        vertices=vertices[used],
        faces=faces.reshape(-1, 3),
        uv=np.tile(uv, (2, 1))[used],
        normals=np.tile(normals.reshape(-1, 3), (2, 1))[used],
    )


def _border(cells: Mask, seen: Mask, index: Ints) -> Ints:
    """List the edges (n, 2) along the tile's border beyond which the neighbouring tile was seen.

    They run against the direction of the faces. A skirt goes inward from each.

    Parameters
    ----------
    cells
        Whether each cell of the tile has faces.
    seen
        Whether each texel of the tile, with its margin, was seen.
    index
        Number of each vertex of the tile.
    """
    count = len(cells)
    above, left, below, right = (
        line[MARGIN_PX:-MARGIN_PX].reshape(count, -1).any(axis=1)
        for line in (seen[0], seen[:, 0], seen[-1], seen[:, -1])
    )
    return np.concatenate(
        [
            np.stack([index[0, :-1], index[0, 1:]], axis=1)[cells[0] & above],
            np.stack([index[1:, 0], index[:-1, 0]], axis=1)[cells[:, 0] & left],
            np.stack([index[-1, 1:], index[-1, :-1]], axis=1)[cells[-1] & below],
            np.stack([index[:-1, -1], index[1:, -1]], axis=1)[cells[:, -1] & right],
        ]
    )


def _vertices(
    pyramid: Pyramid, level: int, row: int, column: int, count: int
) -> tuple[Array, Array, Array]:
    """Compute the vertices of a tile's mesh.

    Normals are central differences of the neighbouring vertices, beyond the tile's border too, so
    that neighbouring tiles have equal normals at a common border.

    Parameters
    ----------
    pyramid, level
        The mosaic, and the level of the tile.
    row, column
        Row and column of the tile's first vertex among the vertices of the level.
    count
        Cells of the tile along a side.

    Returns
    -------
    points, normals, outward
        (count + 1, count + 1, 3) each: vertices in m, NaN without surface, their normals, and the
        chart's normals.
    """
    # Chart coordinates of the vertices, with one more row and column on each side.
    surface, layout = pyramid.surface, pyramid.layout
    step_m = pyramid.cell_px * pyramid.texel_m(level)
    steps = np.arange(-1, count + 2)
    west, north = layout.corner
    xy = np.stack(
        np.meshgrid(west + (column + steps) * step_m, north - (row + steps) * step_m), axis=-1
    )
    base, outward = surface.chart.from_chart(layout.outside.to_chart(xy.reshape(-1, 2)))
    # Rays along the chart's normals, from outside, meet the surface.
    # A hit farther than reach_m from the chart does not count
    start = base + surface.reach_m * outward
    distance = np.full(len(start), np.nan)
    known = np.isfinite(start).all(axis=1)
    distance[known] = surface.scene.cast(start[known], -outward[known])
    distance[~(distance <= 2 * surface.reach_m)] = np.nan
    points = (start - distance[:, None] * outward).reshape(*xy.shape[:2], 3)
    outward = outward.reshape(points.shape)
    # Normals by central differences; the chart's where the surface has none. On a map seen from
    # outside, down x right points at the viewer.
    right, down = points[1:-1, 2:] - points[1:-1, :-2], points[2:, 1:-1] - points[:-2, 1:-1]
    normals = np.cross(down, right)
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    inner = outward[1:-1, 1:-1]
    normals = np.where(length > 0, normals / np.maximum(length, 1e-15), inner)
    return points[1:-1, 1:-1], normals, inner
