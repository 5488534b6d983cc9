# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull as built, of any length, made block by block when a sensor first needs the block.

It is the CAD model's patch moved by a smooth random field of normal offsets, with items on it. The
mesh has finer cells around items with relief.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hullrecon.errors import UsageError
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.hull_patch import HullPatch, HullSkin, Rays
from hullrecon.synthetic.items import MARKS, STRUCTURES, Item, Kind, height_of
from hullrecon.synthetic.options import DiveSpec
from hullrecon.typing import Array, Ints

FINER = 5  # factor of the finer cells: 3 cm become 6 mm
KEPT_BLOCKS = 2  # blocks in memory: cameras and sonar may be in neighbouring ones


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
    busy = _near_items(patch, items, 0.12)  # farther than the fine cells: items cast shadows
    key, faces = _refined_cells(_near_items(patch, items, 0.04))
    width = FINER * (len(patch.girth_m) - 1) + 1
    step = (patch.along_m[1] - patch.along_m[0]) / FINER
    # A vertex's key is its number, row by row, in a grid FINER times as fine as the patch
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


def _near_items(patch: HullPatch, items: tuple[Item, ...], margin_m: float) -> NDArray[np.bool_]:
    """Select the grid nodes (a, g) within margin_m of an item with relief."""
    out = np.zeros((len(patch.along_m), len(patch.girth_m)), bool)
    for item in (i for i in items if i.height_m != 0):
        reach = item.reach_m() + margin_m
        a, g = patch.along_m - item.along_m, patch.girth_m - item.girth_m
        out |= np.hypot(a[:, None], g[None]) < reach
    return out


def _refined_cells(busy: NDArray[np.bool_]) -> tuple[Ints, NDArray[np.int32]]:
    """Build a mesh of coarse cells, and of fine ones where a corner of the cell is busy.

    Fine vertices between the corners of a coarse cell lie on its edge, as points of the steel are
    interpolated linearly along it. So there is no gap.

    Parameters
    ----------
    busy
        Nodes (a, g) of the coarse grid near an item.

    Returns
    -------
    key
        (n,) vertices, as numbers on the fine lattice, row by row.
    faces
        (m, 3) counter-clockwise seen from outside. Neighbouring fine cells share vertices.
    """
    columns = busy.shape[1]
    width = FINER * (columns - 1) + 1
    fine = busy[:-1, :-1] | busy[1:, :-1] | busy[1:, 1:] | busy[:-1, 1:]
    coarse_cell = np.argwhere(~fine) * FINER
    # Of the fine cells in one coarse cell, row and column
    sub = np.argwhere(np.ones((FINER, FINER)))[None]
    fine_cell = (np.argwhere(fine)[:, None] * FINER + sub).reshape(-1, 2)
    quads = np.concatenate([_quads(coarse_cell, FINER, width), _quads(fine_cell, 1, width)])
    key, corner = np.unique(quads, return_inverse=True)
    a, b, c, d = corner.reshape(-1, 4).T
    faces = np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)])
    return key.astype(np.int64), faces.astype(np.int32)


def _quads(cell: Ints, size: int, width: int) -> Ints:
    """List the four corners (m, 4) of cells of `size` fine steps whose first corners are (m, 2).

    Corners are numbers on the fine lattice, of `width` columns.
    """
    first = cell[:, 0] * width + cell[:, 1]
    return np.stack([first, first + size * width, first + size * width + size, first + size], 1)


def _vertex_normals(mesh: Mesh) -> Array:
    """Compute unit normals (n, 3) of the vertices, the area-weighted mean of their faces'."""
    corner = mesh.vertices[mesh.faces]
    face = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    corner_of, count = mesh.faces.ravel(), len(mesh.vertices)
    total = np.stack([np.bincount(corner_of, np.repeat(f, 3), count) for f in face.T], 1)
    return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12))


def deviation_m(spec: DiveSpec, along_m: Array, girth_m: Array, waves: int = 300) -> Array:
    """Evaluate how far the steel is off the CAD model at chart points, m along its outward normal.

    It is a stationary Gaussian field with Matern 5/2 correlation, whose length in girth is half of
    that along the hull. It is drawn by its spectrum, as a sum of `waves` plane waves, so that it
    can be evaluated anywhere.
    """
    random = spec.hull_random("deviation")
    # The spectrum of a Matern 5/2 field is Student's t with five degrees of freedom
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
    """The hull as built, made block by block. The blocks used last are kept in memory."""

    def __init__(self, spec: DiveSpec, skin: HullSkin, items: tuple[Item, ...]) -> None:
        self.skin = skin
        self._spec, self._items = spec, items
        self._blocks: OrderedDict[int, Block] = OrderedDict()

    def near(self, along_m: float) -> Block:
        """Look up, or build, the block around a position along the hull."""
        return self._block(int(self.skin.block_of(np.array([along_m]))[0]))

    def ranges(self, origins: Array, directions: Array) -> Array:
        """Measure ranges (n, b), m, from points (n, 3) along unit directions (n, b, 3), both in M.

        NaN where a ray does not meet the hull.
        """
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
        """Take a block from memory, or build it."""
        if number not in self._blocks:
            while len(self._blocks) >= KEPT_BLOCKS:
                self._blocks.popitem(last=False)
            self._blocks[number] = self._make(number)
        self._blocks.move_to_end(number)
        return self._blocks[number]

    def _make(self, number: int) -> Block:
        """Build a block with the items on it or next to it."""
        patch = self.skin.patch(number)
        low, high = patch.along_m[0], patch.along_m[-1]
        items = tuple(
            i for i in self._items if low - i.reach_m() - 1.0 < i.along_m < high + i.reach_m() + 1.0
        )
        built = build(self._spec, patch, items)
        return Block(patch=patch, built=built, rays=Rays(built.mesh))


# Height, and size along and across, m, of the items of each kind. Items of a kind take them in
# turn.
SHAPES: dict[Kind, tuple[tuple[float, float, float], ...]] = {
    "cylinder": ((0.11, 0.16, 0.16), (0.09, 0.2, 0.2)),
    "dome": ((0.12, 0.3, 0.3), (0.1, 0.24, 0.24)),
    "box": ((0.10, 0.26, 0.2), (0.13, 0.18, 0.3)),
    "lump": ((0.14, 0.42, 0.3), (0.07, 0.26, 0.22)),
    "recess": ((-0.04, 0.25, 0.25), (-0.06, 0.2, 0.2)),
    "digits": ((0.0, 0.5, 0.3),),
    "stripe": ((0.0, 0.8, 0.09),),
    "ring": ((0.0, 0.34, 0.34),),
    "barnacles": ((0.016, 0.6, 0.4), (0.018, 0.5, 0.35)),
}
CLEAR_M = 0.05  # least distance between the circles around two items


def place_items(
    spec: DiveSpec, along_m: tuple[float, float], girth_m: tuple[float, float]
) -> tuple[Item, ...]:
    """Place the dive's items at random within a window of the chart, clear of each other.

    Structures are drawn first, then marks and barnacles. Then come the changes since a first dive
    that the spec asks for: structures added, one grown, and others removed. Items that the spec
    places itself are returned as they are. along_m, girth_m: limits of the window.

    Raises UsageError if they do not fit, or if more structures are to be changed than there are.
    """
    if spec.items.placed is not None:
        return spec.items.placed
    wanted = spec.items
    if wanted.structures < wanted.removed + (wanted.grown_m != 0):
        raise UsageError(
            f"{wanted.structures} structures are too few to change so many",
            remedy="ask for more --structures",
        )
    kinds = [STRUCTURES[k % len(STRUCTURES)] for k in range(wanted.structures)]
    kinds += [MARKS[k % len(MARKS)] for k in range(wanted.marks)]
    kinds += ["barnacles"] * wanted.barnacles
    window = (along_m, girth_m)
    before = _draw_items(spec.hull_random("items"), kinds, [], *window)
    since = [
        STRUCTURES[k % len(STRUCTURES)]
        for k in range(wanted.structures, wanted.structures + wanted.added)
    ]
    # Drawn by a generator of its own, so that a dive without them has the same other items
    added = _draw_items(spec.hull_random("added items"), since, before, *window)
    if wanted.grown_m:
        before[0] = _grow(before[0], wanted.grown_m)
    del before[wanted.structures - wanted.removed : wanted.structures]
    return (*before, *added)


def _draw_items(
    random: np.random.Generator,
    kinds: list[Kind],
    taken: list[Item],
    along_m: tuple[float, float],
    girth_m: tuple[float, float],
) -> list[Item]:
    """Draw items of the given kinds, clear of each other and of the items already `taken`.

    Returned are the new ones alone. along_m, girth_m: the window in which their middles lie.
    """
    out = list(taken)
    for kind in kinds:
        sizes = SHAPES[kind]
        height, *size = sizes[sum(item.kind == kind for item in out) % len(sizes)]
        turn = float(random.uniform(-0.3, 0.3))
        item = Item(kind, 0.0, 0.0, height, (size[0], size[1]), turn)
        out.append(_place_clear(random, item, out, along_m, girth_m))
    return out[len(taken) :]


def _grow(item: Item, by_m: float) -> Item:
    """Raise an item by `by_m` off the steel. A recess goes deeper."""
    return replace(item, height_m=item.height_m + (by_m if item.height_m > 0 else -by_m))


def _place_clear(
    random: np.random.Generator,
    item: Item,
    taken: list[Item],
    along_m: tuple[float, float],
    girth_m: tuple[float, float],
) -> Item:
    """Place an item at a random position of the window that is clear of the others.

    Raises UsageError if none is found.
    """
    for _ in range(4000):
        a, g = float(random.uniform(*along_m)), float(random.uniform(*girth_m))
        if all(
            np.hypot(a - o.along_m, g - o.girth_m) > item.reach_m() + o.reach_m() + CLEAR_M
            for o in taken
        ):
            return Item(item.kind, a, g, item.height_m, item.size_m, item.turn_rad)
    raise UsageError(
        f"no room for {len(taken) + 1} items on the surveyed part",
        remedy="ask for fewer structures and marks, or longer legs",
    )
