# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull as built, of any length, made block by block as the vehicle comes by.

It is the CAD model's patch moved by a smooth random field of normal offsets, with items on it, in
finer cells where something stands out.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.spec import DiveSpec
from hullrecon.synthetic.world.hull_patch import HullPatch, HullSkin
from hullrecon.synthetic.world.items import Item, height_of
from hullrecon.synthetic.world.ray_casting import Rays
from hullrecon.typing import Array, Ints

FINER = 5  # 3 cm cells become 6 mm cells
KEPT_BLOCKS = 2  # cameras and sonar can stand in neighbouring ones


@dataclass(frozen=True, kw_only=True)
class AsBuilt:
    """The surface of a block."""

    mesh: Mesh  # in the hull's frame
    chart: NDArray[np.float32]  # (n, 2) along and girth by vertex
    normal: NDArray[np.float32]  # (n, 3) by vertex
    steel: Array  # (a, g, 3) the patch's points moved by the deviation alone
    busy: NDArray[np.bool_]  # (a, g) grid nodes near something that stands out


def build(spec: DiveSpec, patch: HullPatch, items: tuple[Item, ...]) -> AsBuilt:
    """Move a patch of the CAD model by its deviation, and put the items on it.

    Around items the mesh has cells FINER times smaller, so that their edges are sharp.
    """
    a, g = np.meshgrid(patch.along_m, patch.girth_m, indexing="ij")
    steel = patch.point + deviation_m(spec, a, g)[..., None] * patch.normal
    busy = _busy(patch, items, 0.12)
    key, faces = _lattice(_busy(patch, items, 0.04))
    width = FINER * (len(patch.girth_m) - 1) + 1
    step = (patch.along_m[1] - patch.along_m[0]) / FINER
    along, girth = patch.along_m[0] + key // width * step, patch.girth_m[0] + key % width * step
    height = np.zeros(len(key))
    for item in items:
        height += height_of(item, along, girth)
    vertices = patch.sample(steel, along, girth) + height[:, None] * patch.sample(
        patch.normal, along, girth
    )
    mesh = Mesh(vertices, faces)
    chart = np.stack([along, girth], 1).astype(np.float32)
    return AsBuilt(
        mesh=mesh,
        chart=chart,
        normal=_vertex_normals(mesh).astype(np.float32),
        steel=steel,
        busy=busy,
    )


def crop(built: AsBuilt, along_m: tuple[float, float], girth_m: tuple[float, float]) -> Mesh:
    """Cut out the part of the mesh within a window of the chart."""
    a, g = built.chart.T
    inside = (a >= along_m[0]) & (a <= along_m[1]) & (g >= girth_m[0]) & (g <= girth_m[1])
    faces = built.mesh.faces[inside[built.mesh.faces].all(axis=1)]
    used, renumbered = np.unique(faces, return_inverse=True)
    return Mesh(built.mesh.vertices[used], renumbered.reshape(-1, 3).astype(np.int32))


def _busy(patch: HullPatch, items: tuple[Item, ...], margin_m: float) -> NDArray[np.bool_]:
    """Mark the grid nodes (a, g) that an item with relief covers, or that lie next to it."""
    out = np.zeros((len(patch.along_m), len(patch.girth_m)), bool)
    for item in (i for i in items if i.height_m != 0):
        reach = item.reach_m() + margin_m
        a, g = patch.along_m - item.along_m, patch.girth_m - item.girth_m
        out |= np.hypot(a[:, None], g[None]) < reach
    return out


def _lattice(busy: NDArray[np.bool_]) -> tuple[Ints, NDArray[np.int32]]:
    """List vertices as keys on the fine lattice, and faces, counter-clockwise from outside.

    Fine cells share their corners.
    """
    columns = busy.shape[1]
    width = FINER * (columns - 1) + 1
    fine = busy[:-1, :-1] | busy[1:, :-1] | busy[1:, 1:] | busy[:-1, 1:]
    coarse_cell = np.argwhere(~fine) * FINER
    sub = np.argwhere(np.ones((FINER, FINER)))[None]
    fine_cell = (np.argwhere(fine)[:, None] * FINER + sub).reshape(-1, 2)
    quads = np.concatenate([_quads(coarse_cell, FINER, width), _quads(fine_cell, 1, width)])
    key, corner = np.unique(quads, return_inverse=True)
    a, b, c, d = corner.reshape(-1, 4).T
    faces = np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)])
    return key.astype(np.int64), faces.astype(np.int32)


def _quads(cell: Ints, size: int, width: int) -> Ints:
    first = cell[:, 0] * width + cell[:, 1]
    return np.stack([first, first + size * width, first + size * width + size, first + size], 1)


def _vertex_normals(mesh: Mesh) -> Array:
    corner = mesh.vertices[mesh.faces]
    face = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    corner_of, count = mesh.faces.ravel(), len(mesh.vertices)
    total = np.stack([np.bincount(corner_of, np.repeat(f, 3), count) for f in face.T], 1)
    return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12))


def deviation_m(spec: DiveSpec, along_m: Array, girth_m: Array, waves: int = 300) -> Array:
    """Evaluate how far the steel leaves the CAD model (...) along its outward normal.

    A stationary Gaussian field with Matern 5/2 correlation, half as long over the girth as along,
    drawn by its spectrum: a sum of plane waves, so that it can be asked anywhere.
    """
    random = spec.hull_random("deviation")
    stretch = np.sqrt(5.0 / random.chisquare(5.0, waves))
    length = np.array([spec.deviation.length_m, 0.5 * spec.deviation.length_m])
    wave = random.standard_normal((waves, 2)) * stretch[:, None] / length
    phase = random.uniform(0, 2 * np.pi, waves)
    total = np.zeros(np.broadcast(along_m, girth_m).shape)
    for k, p in zip(wave, phase, strict=True):
        total += np.cos(k[0] * along_m + k[1] * girth_m + p)
    return np.asarray(spec.deviation.mean_m + spec.deviation.sigma_m * np.sqrt(2.0 / waves) * total)


@dataclass(frozen=True, kw_only=True)
class Block:
    """A part of the hull along its length."""

    patch: HullPatch  # of the CAD model
    built: AsBuilt
    rays: Rays  # to cast at the surface as built


class BuiltHull:
    """The hull as built, which keeps the last blocks that were asked for."""

    def __init__(self, spec: DiveSpec, skin: HullSkin, items: tuple[Item, ...]) -> None:
        self.skin = skin
        self._spec, self._items = spec, items
        self._blocks: OrderedDict[int, Block] = OrderedDict()

    def near(self, along_m: float) -> Block:
        """Build the block around a position along the hull."""
        return self._block(int(self.skin.block_of(np.array([along_m]))[0]))

    def ranges(self, origins: Array, directions: Array) -> Array:
        """Measure ranges (n, b) from points (n, 3) along unit directions (n, b, 3), NaN if none."""
        count, out = directions.shape[1], np.empty(directions.shape[:2])
        block = self.skin.block_of(origins[:, 0])
        for k in np.unique(block).tolist():
            rows = block == k
            hits = self._block(k).rays.cast(
                np.repeat(origins[rows], count, axis=0), directions[rows].reshape(-1, 3)
            )
            out[rows] = np.where(hits.hit, hits.range_m, np.nan).reshape(-1, count)
        return out

    def window(self, along_m: tuple[float, float], girth_m: tuple[float, float]) -> Iterator[Mesh]:
        """Yield the surface within a window of the chart, in pieces that join without a gap."""
        for k in range(len(self.skin)):
            low, high = self.skin.core_m(k)
            if high > along_m[0] and low < along_m[1]:
                # A millimetre, as the chart is float32.
                part = (max(along_m[0], low - 1e-3), min(along_m[1], high + 1e-3))
                yield crop(self._block(k).built, part, girth_m)

    def _block(self, number: int) -> Block:
        if number not in self._blocks:
            while len(self._blocks) >= KEPT_BLOCKS:
                self._blocks.popitem(last=False)
            self._blocks[number] = self._make(number)
        self._blocks.move_to_end(number)
        return self._blocks[number]

    def _make(self, number: int) -> Block:
        patch = self.skin.patch(number)
        low, high = patch.along_m[0], patch.along_m[-1]
        items = tuple(
            i for i in self._items if low - i.reach_m() - 1.0 < i.along_m < high + i.reach_m() + 1.0
        )
        built = build(self._spec, patch, items)
        return Block(patch=patch, built=built, rays=Rays(built.mesh))
