# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The texture of the hull: painted as a whole, or for a large one plate by plate as the cameras
come by.
"""

from __future__ import annotations

from collections import OrderedDict

import numpy as np
from numpy.typing import NDArray

from hullrecon.synthetic.spec import DiveSpec
from hullrecon.synthetic.world.item_paint import ITEM_TONES, paint_items
from hullrecon.synthetic.world.items import Item
from hullrecon.synthetic.world.texture import PLATE_M, Atlas, paint_steel
from hullrecon.typing import Floats32

ROWS = 1 << 20  # more rows of plates than any hull has
KEPT_PLATES = 24  # 2.4 m x 1.3 m at a millimetre a texel are 9.4 MB


def paint_atlas(
    spec: DiveSpec,
    items: tuple[Item, ...],
    along_m: tuple[float, float],
    girth_m: tuple[float, float],
    texel_m: float,
) -> Atlas:
    """Return the texture of that window of the chart, painted as a whole."""
    random = spec.hull_random("texture")
    atlas = paint_steel(random, along_m, girth_m, texel_m)
    paint_items(atlas, items, random.uniform(*ITEM_TONES, len(items)))
    return atlas


class PlateAtlas:
    """Hold the texture of the last plates that were looked at; each has random draws of its own,
    its edges are weld seams.
    """

    def __init__(self, spec: DiveSpec, items: tuple[Item, ...], texel_m: float) -> None:
        self._spec, self._items, self._texel_m = spec, items, texel_m
        self._tones: NDArray[np.float64] = spec.hull_random("item tones").uniform(
            *ITEM_TONES, len(items)
        )
        self._plates: OrderedDict[tuple[int, int], Atlas] = OrderedDict()

    def look_up(self, along_m: Floats32, girth_m: Floats32, seen: NDArray[np.bool_]) -> Floats32:
        """Return the albedo (h, w, 3) at chart coordinates (h, w), bilinear, where `seen` (h, w);
        nothing elsewhere.
        """
        column = np.floor(along_m / np.float32(PLATE_M[0])).astype(np.int64)
        row = np.floor(girth_m / np.float32(PLATE_M[1])).astype(np.int64)
        number = column * ROWS + row + ROWS // 2  # rows have either sign
        out = np.zeros((*seen.shape, 3), np.float32)
        for plate in np.unique(number[seen]).tolist():
            inside = seen & (number == plate)
            c, r = divmod(plate, ROWS)
            out[inside] = self._plate(c, r - ROWS // 2).look_up(along_m, girth_m, inside)[inside]
        return out

    def _plate(self, column: int, row: int) -> Atlas:
        key = (column, row)
        if key not in self._plates:
            while len(self._plates) >= KEPT_PLATES:
                self._plates.popitem(last=False)
            self._plates[key] = self._paint(column, row)
        self._plates.move_to_end(key)
        return self._plates[key]

    def _paint(self, column: int, row: int) -> Atlas:
        rim = 2 * self._texel_m  # what a bilinear look-up at the edge needs
        along_m = (column * PLATE_M[0] - rim, (column + 1) * PLATE_M[0] + 2 * rim)
        girth_m = (row * PLATE_M[1] - rim, (row + 1) * PLATE_M[1] + 2 * rim)
        random = self._spec.hull_random(f"plate {column} {row}")
        atlas = paint_steel(random, along_m, girth_m, self._texel_m)
        paint_items(atlas, self._items, self._tones)
        return atlas
