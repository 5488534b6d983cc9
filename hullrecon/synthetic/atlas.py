# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull's texture: painted as a whole, or plate by plate when a camera first sees the plate.

Items that stand on the steel or are painted on it are part of the texture.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hullrecon.synthetic.items import Item, local
from hullrecon.synthetic.options import DiveSpec
from hullrecon.synthetic.texture import PAINT, PLATE_M, paint_steel
from hullrecon.typing import Floats32, Pixels

ROWS = 1 << 20  # more rows of plates than any hull has, to number plates by column and row
KEPT_PLATES = 24  # plates in memory; one of 2.4 m x 1.3 m at a millimetre a texel takes 9.4 MB
ITEM_TONES = (70.0, 150.0)  # range of a structure's grey level
PAINTS = {
    "digits": (205, 205, 195),
    "stripe": (200, 190, 70),
    "ring": (205, 205, 195),
    "barnacles": (185, 180, 160),
}


@dataclass(frozen=True)
class Atlas:
    """The albedo of a window of the chart as one image."""

    image: Pixels  # (rows over girth, columns along the hull, 3) albedo x 255, RGB
    origin_m: tuple[float, float]  # along and girth of the first texel's centre
    texel_m: float

    def look_up(self, along_m: Floats32, girth_m: Floats32, seen: NDArray[np.bool_]) -> Floats32:
        """Interpolate the albedo (h, w, 3), 0 to 1, at chart coordinates (h, w) that are `seen`."""
        import cv2

        x = (along_m - np.float32(self.origin_m[0])) / np.float32(self.texel_m)
        y = (girth_m - np.float32(self.origin_m[1])) / np.float32(self.texel_m)
        if not seen.any():
            return np.zeros((*seen.shape, 3), np.float32)
        left, right = _window(x[seen], self.image.shape[1])
        top, bottom = _window(y[seen], self.image.shape[0])
        part = np.ascontiguousarray(self.image[top:bottom, left:right])
        out = cv2.remap(
            part,
            x - np.float32(left),
            y - np.float32(top),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REFLECT,
        )
        return np.asarray(out, np.float32) / np.float32(255)


class Albedo(Protocol):
    """The colour of the hull."""

    def look_up(self, along_m: Floats32, girth_m: Floats32, seen: NDArray[np.bool_]) -> Floats32:
        """Look up the albedo (h, w, 3) at chart coordinates (h, w), where `seen` (h, w)."""
        ...


@dataclass(frozen=True, kw_only=True)
class PaintedHull:
    """A hull whose paint is hard for images."""

    albedo: Albedo
    start_m: float  # along the hull: where the first period of repeated colours begins
    bare_to_m: float | None  # along: aft of it the paint is bare, of one tone; None for nowhere
    repeats_m: float | None  # period of the colours along the hull; None: they do not repeat

    def look_up(self, along_m: Floats32, girth_m: Floats32, seen: NDArray[np.bool_]) -> Floats32:
        """Look up the albedo (h, w, 3), 0 to 1, at chart coordinates (h, w) that are `seen`.

        Along the hull it is that of the first period, and of one tone where the paint is bare.
        """
        within = along_m
        if self.repeats_m is not None:
            within = (np.mod(along_m - self.start_m, self.repeats_m) + self.start_m).astype(
                np.float32
            )
        out = self.albedo.look_up(within, girth_m, seen)
        if self.bare_to_m is not None:
            out[along_m < self.bare_to_m] = PAINT
        return out


def paint_atlas(
    spec: DiveSpec,
    items: tuple[Item, ...],
    along_m: tuple[float, float],
    girth_m: tuple[float, float],
    texel_m: float,
) -> Atlas:
    """Paint a window of the chart, given by its limits along and in girth, as one image.

    items: painted on the steel where they lie in the window. texel_m: side of a texel.
    """
    random = spec.hull_random("texture")
    image = paint_steel(random, along_m, girth_m, texel_m)
    atlas = Atlas(image, (along_m[0], girth_m[0]), texel_m)
    paint_items(atlas, items, random.uniform(*ITEM_TONES, len(items)))
    return atlas


class PlateAtlas:
    """The texture of a large hull, painted plate by plate. The plates used last are kept in memory.

    Each plate has random draws of its own, so that it looks the same whenever it is painted. Plates
    meet at weld seams.
    """

    def __init__(self, spec: DiveSpec, items: tuple[Item, ...], texel_m: float) -> None:
        """Start without painted plates. items: painted on them. texel_m: side of a texel."""
        self._spec, self._items, self._texel_m = spec, items, texel_m
        self._tones: NDArray[np.float64] = spec.hull_random("item tones").uniform(
            *ITEM_TONES, len(items)
        )
        self._plates: OrderedDict[tuple[int, int], Atlas] = OrderedDict()

    def look_up(self, along_m: Floats32, girth_m: Floats32, seen: NDArray[np.bool_]) -> Floats32:
        """Look up the albedo (h, w, 3), 0 to 1, at chart points (h, w). Zero where not `seen`."""
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
        """Take a plate from memory, or paint it."""
        key = (column, row)
        if key not in self._plates:
            while len(self._plates) >= KEPT_PLATES:
                self._plates.popitem(last=False)
            self._plates[key] = self._paint(column, row)
        self._plates.move_to_end(key)
        return self._plates[key]

    def _paint(self, column: int, row: int) -> Atlas:
        """Paint a plate, with a rim that bilinear look-ups at its edge need, and its items."""
        rim = 2 * self._texel_m
        along_m = (column * PLATE_M[0] - rim, (column + 1) * PLATE_M[0] + 2 * rim)
        girth_m = (row * PLATE_M[1] - rim, (row + 1) * PLATE_M[1] + 2 * rim)
        random = self._spec.hull_random(f"plate {column} {row}")
        image = paint_steel(random, along_m, girth_m, self._texel_m)
        atlas = Atlas(image, (along_m[0], girth_m[0]), self._texel_m)
        paint_items(atlas, self._items, self._tones)
        return atlas


def paint_items(atlas: Atlas, items: tuple[Item, ...], tones: NDArray[np.float64]) -> None:
    """Paint marks white or yellow, structures in their tone, and barnacles pale."""
    for item, tone in zip(items, tones.tolist(), strict=True):
        _paint_item(atlas, item, tone)


def _paint_item(atlas: Atlas, item: Item, tone: float) -> None:
    """Blend an item's paint into the atlas: marks strongly, others as a tint.

    tone: gray 0..255 for kinds without a colour of their own.
    """
    row, column, mask = _place_mask(atlas, item)
    if mask.size == 0:
        return
    part = atlas.image[row : row + mask.shape[0], column : column + mask.shape[1]]
    paint = np.array(PAINTS.get(item.kind, (tone,) * 3))
    strength = 0.85 if item.kind in ("digits", "stripe", "ring") else 0.2
    weight = (strength * mask)[..., None]
    part[...] = np.clip(part * (1 - weight) + paint * weight, 0, 255).astype(np.uint8)


def _place_mask(atlas: Atlas, item: Item) -> tuple[int, int, Floats32]:
    """Find where an item's bounding box begins in the atlas (row, column), and its mask 0..1 there.

    The mask is empty if the box is outside the atlas.
    """
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
    return int(rows[0]), int(columns[0]), _item_mask(item, u, v).astype(np.float32)


def _item_mask(item: Item, u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Select the points of an item, given in its own axes: its box is -1..1 in u and v."""
    radius = np.hypot(u, v)
    inside = np.maximum(np.abs(u), np.abs(v)) <= 1
    if item.kind == "ring":
        return ((radius > 0.78) & (radius <= 1)) | ((np.abs(v) < 0.09) & (np.abs(u) <= 1))
    if item.kind == "digits":
        return inside & _digits(u, v)
    return np.asarray(inside if item.kind in ("stripe", "box") else radius <= 1)


def _digits(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Select the points of a draught mark "32" that is legible from outside on the port side.

    u (forward), v (up): its box is -1..1 in both.
    """
    import cv2

    board: Any = np.zeros((120, 200), np.uint8)
    cv2.putText(board, "32", (18, 104), cv2.FONT_HERSHEY_SIMPLEX, 4.2, 255, 18)
    x = np.clip((1 - u) * 100, 0, 199).astype(int)  # forward is to the left on the port side
    y = np.clip((1 - v) * 60, 0, 119).astype(int)
    return np.asarray(board[y, x] > 127)


def _window(x: Floats32, size: int) -> tuple[int, int]:
    """Find the first and last column that a bilinear look-up at x needs, within the image."""
    low, high = float(np.nanmin(x)), float(np.nanmax(x))
    first = int(np.clip(np.floor(low) - 1, 0, size - 2))
    return first, int(np.clip(np.ceil(high) + 2, first + 2, size))
