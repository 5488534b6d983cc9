# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The colour of what stands on the steel or is painted on it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.synthetic.world.items import Item
from hullrecon.synthetic.world.relief import local
from hullrecon.synthetic.world.texture import Atlas
from hullrecon.typing import Floats32

ITEM_TONES = (70.0, 150.0)  # grey of a structure
PAINTS = {
    "digits": (205, 205, 195),
    "stripe": (200, 190, 70),
    "ring": (205, 205, 195),
    "barnacles": (185, 180, 160),
}


def paint_items(atlas: Atlas, items: tuple[Item, ...], tones: NDArray[np.float64]) -> None:
    """Paint the items that lie in the atlas: marks white or yellow, structures in their tone, the
    barnacles' patch pale.
    """
    for item, tone in zip(items, tones.tolist(), strict=True):
        _mark(atlas, item, tone)


def _mark(atlas: Atlas, item: Item, tone: float) -> None:
    row, column, mask = _stamp(atlas, item)
    if mask.size == 0:
        return
    part = atlas.image[row : row + mask.shape[0], column : column + mask.shape[1]]
    paint = np.array(PAINTS.get(item.kind, (tone,) * 3))
    strength = 0.85 if item.kind in ("digits", "stripe", "ring") else 0.2
    weight = (strength * mask)[..., None]
    part[...] = np.clip(part * (1 - weight) + paint * weight, 0, 255).astype(np.uint8)


def _stamp(atlas: Atlas, item: Item) -> tuple[int, int, Floats32]:
    """Return the first row and column of the item's box in the atlas, and its mask 0..1 there."""
    reach = int(np.ceil(item.reach_m() / atlas.texel_m)) + 2
    column = round((item.along_m - atlas.origin_m[0]) / atlas.texel_m)
    row = round((item.girth_m - atlas.origin_m[1]) / atlas.texel_m)
    rows = np.arange(max(0, row - reach), min(atlas.image.shape[0], row + reach))
    columns = np.arange(max(0, column - reach), min(atlas.image.shape[1], column + reach))
    if len(rows) == 0 or len(columns) == 0:
        return 0, 0, np.zeros((0, 0), np.float32)
    a, g = np.meshgrid(
        atlas.origin_m[0] + columns * atlas.texel_m, atlas.origin_m[1] + rows * atlas.texel_m
    )
    u, v = local(item, a, g)
    return int(rows[0]), int(columns[0]), _shape(item, u, v).astype(np.float32)


def _shape(item: Item, u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.bool_]:
    radius = np.hypot(u, v)
    inside = np.maximum(np.abs(u), np.abs(v)) <= 1
    if item.kind == "ring":
        return ((radius > 0.78) & (radius <= 1)) | ((np.abs(v) < 0.09) & (np.abs(u) <= 1))
    if item.kind == "digits":
        return inside & _digits(u, v)
    return np.asarray(inside if item.kind in ("stripe", "box") else radius <= 1)


def _digits(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the mask of a draught mark, as it reads from outside with the girth going up and the
    hull's port side before us.
    """
    import cv2

    board: Any = np.zeros((120, 200), np.uint8)
    cv2.putText(board, "32", (18, 104), cv2.FONT_HERSHEY_SIMPLEX, 4.2, 255, 18)
    x = np.clip((1 - u) * 100, 0, 199).astype(int)  # forward is to the left on the port side
    y = np.clip((1 - v) * 60, 0, 119).astype(int)
    return np.asarray(board[y, x] > 127)
