# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rasters of the surface under a mosaic: deviation, form, their sigmas, support."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.mosaic.mosaic_surface import MosaicSurface, sample_surface
from hullrecon.mosaic.output.raster import RasterBands, RasterLayout
from hullrecon.mosaic.output.tile_store import CompressedTiles
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.typing import Array, Ints

QUANTUM_M = 0.0001  # metres are written in steps of it: finer is noise, and compresses badly

SURFACE_BANDS = {
    "deviation": "signed distance of the hull as found from its CAD model, outward positive",
    "deviation_sigma": "one sigma of the deviation, the hull's position included",
    "form": "deviation without the offset and the tilt of the surveyed patch",
    "form_sigma": "one sigma of the form, which the hull's position hardly enters",
    "support": "images that saw the surface where landmarks measured it",
}
SUPPORT_BY_RETURNS = "DVL returns within reach of the surface"


def surface_values(surface: Surface, split: DeviationSplit | None) -> dict[str, Array]:
    """Collect the values (n,) at the vertices by raster, NaN where unseen.

    Without a CAD model there is the support alone.
    """
    values = {"support": surface.support.astype(float)}
    if split is not None:
        values |= {
            "deviation": surface.deviation,
            "deviation_sigma": surface.sigma,
            "form": split.form,
            "form_sigma": split.form_sigma,
        }
    return {name: np.where(surface.support > 0, v, np.nan) for name, v in values.items()}


def surface_tiles(
    surface: MosaicSurface, values: Mapping[str, Array], layout: RasterLayout
) -> dict[str, CompressedTiles]:
    """Interpolate values (n,) of the vertices at the texels.

    Metres are linear on each face, counts those of the nearest corner; NaN, and 0 for counts, where
    there is none. The surface's horizon is not needed here.
    """
    shape = (layout.size, layout.size)
    tiles = {name: CompressedTiles(shape, surface_bands(name).dtype) for name in values}
    for window in layout.grid.tiles(layout.size):
        point = sample_surface(surface, layout.grid, window).point.reshape(-1, 3)
        rows = np.flatnonzero(np.isfinite(point[:, 0]))
        corners, share = face_shares(surface.mesh, surface.scene, point[rows])
        for name, value in values.items():
            tile = np.full(len(point), np.nan)
            if name == "support":
                tile[rows] = value[
                    np.take_along_axis(corners, share.argmax(axis=1)[:, None], axis=1)[:, 0]
                ]
                tile = np.nan_to_num(tile)
            else:
                tile[rows] = np.rint((value[corners] * share).sum(axis=1) / QUANTUM_M) * QUANTUM_M
            tiles[name].add(tile.reshape(shape))
    return tiles


def face_shares(mesh: Mesh, scene: Scene, points: Array) -> tuple[Ints, Array]:
    """Find the corners (n, 3) of faces under points (n, 3), with barycentric shares."""
    if not len(points):
        return np.zeros((0, 3), np.int64), np.zeros((0, 3))
    near = scene.closest(points)
    corners = mesh.faces[near.face].astype(np.int64)
    a, b, c = mesh.vertices[corners].transpose(1, 0, 2)
    whole = np.cross(b - a, c - a)
    size = np.maximum(np.einsum("ni,ni->n", whole, whole), 1e-30)
    of_b = np.einsum("ni,ni->n", np.cross(near.foot - a, c - a), whole) / size
    of_c = np.einsum("ni,ni->n", np.cross(b - a, near.foot - a), whole) / size
    return corners, np.clip(np.stack([1 - of_b - of_c, of_b, of_c], axis=1), 0.0, 1.0)


def surface_bands(name: str, *, by_images: bool = True) -> RasterBands:
    """Describe the raster of that name.

    `by_images`: whether the support counts images, else returns of the DVL.
    """
    counts = name == "support"
    return RasterBands(
        names=(name,),
        unit="" if counts else "m",
        dtype="uint16" if counts else "float32",
        title=SUPPORT_BY_RETURNS if counts and not by_images else SURFACE_BANDS[name],
        nodata=0 if counts else float("nan"),
    )
