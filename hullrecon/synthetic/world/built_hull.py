# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull as built, of any length, made block by block as the vehicle comes by."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.spec import DiveSpec
from hullrecon.synthetic.world.as_built import AsBuilt, build, crop
from hullrecon.synthetic.world.hull_patch import HullPatch, HullSkin
from hullrecon.synthetic.world.items import Item
from hullrecon.synthetic.world.ray_casting import Rays
from hullrecon.typing import Array

KEPT_BLOCKS = 2  # cameras and sonar can stand in neighbouring ones


@dataclass(frozen=True, kw_only=True)
class Block:
    """Hold a stretch of the hull: the CAD model's patch, the surface as built upon it, and that
    surface to cast rays at.
    """

    patch: HullPatch
    built: AsBuilt
    rays: Rays


class BuiltHull:
    """Give the hull as built at any place, keeping the last blocks that were asked for."""

    def __init__(self, spec: DiveSpec, skin: HullSkin, items: tuple[Item, ...]) -> None:
        self.skin = skin
        self._spec, self._items = spec, items
        self._blocks: OrderedDict[int, Block] = OrderedDict()

    def near(self, along_m: float) -> Block:
        """Return the block around a position along the hull."""
        return self._block(int(self.skin.block_of(np.array([along_m]))[0]))

    def ranges(self, origins: Array, directions: Array) -> Array:
        """Return the distances (n, b) from points (n, 3) to the hull along unit directions (n, b,
        3), all in M; NaN where it is missed.
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
        """Yield the surface within a window of the chart in pieces that join without gap or
        overlap.
        """
        for k in range(len(self.skin)):
            low, high = self.skin.core_m(k)
            if high > along_m[0] and low < along_m[1]:
                # a millimetre: the chart is float32
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
