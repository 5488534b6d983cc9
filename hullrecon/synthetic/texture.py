# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The colour of bare steel over the chart: plates and welds, fouling at all scales, scratches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Floats32, Pixels

# RGB albedo
PAINT = np.array([0.42, 0.30, 0.27], np.float32)  # antifouling red under slime
SLIME = np.array([0.20, 0.23, 0.17], np.float32)
ALGAE = np.array([0.30, 0.46, 0.20], np.float32)
PALE = np.array([0.62, 0.64, 0.56], np.float32)
PLATE_M = (2.4, 1.3)  # along and over the girth
SEAM_M = 0.011  # half the width of a weld


def paint_steel(
    random: np.random.Generator,
    along_m: tuple[float, float],
    girth_m: tuple[float, float],
    texel_m: float,
) -> Pixels:
    """Paint a window of the chart without items: albedo x 255 (rows over girth, along, 3)."""
    shape = (int((girth_m[1] - girth_m[0]) / texel_m), int((along_m[1] - along_m[0]) / texel_m))
    origin = (along_m[0], girth_m[0])
    fouling = _draw_fouling(random, shape, texel_m)
    plates = _draw_plates(random, shape, origin, texel_m)
    image = np.empty((*shape, 3), np.uint8)
    # In strips: three colours in float32 of the whole window would not fit into memory.
    for k in range(0, shape[0], 256):
        strip = slice(k, k + 256)
        image[strip] = np.clip(
            255 * (_mix_colours(fouling, strip) * plates(strip)[..., None]), 0, 255
        ).astype(np.uint8)
    _specks(random, image, texel_m)
    _scratches(random, image, texel_m)
    return image


def value_noise(random: np.random.Generator, shape: tuple[int, int], cell_px: float) -> Floats32:
    """Draw smooth noise (rows, columns) of about -1..1.

    Random values on a grid with cells of cell_px are interpolated cubically.
    """
    import cv2

    rows, columns = (int(np.ceil(n / cell_px)) + 4 for n in shape)
    coarse = random.uniform(-1, 1, (rows, columns)).astype(np.float32)
    size = (round(columns * cell_px), round(rows * cell_px))
    fine = cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC)
    start = int(cell_px)
    return np.asarray(fine[start : start + shape[0], start : start + shape[1]], np.float32)


def _octaves(
    random: np.random.Generator,
    shape: tuple[int, int],
    cells_m: list[float],
    gains: list[float],
    texel_m: float,
) -> Floats32:
    """Sum noise (shape) of several cell sizes, each times its gain, as fouling has all scales.

    Cells smaller than two texels are left out. cells_m, gains: of equal length.
    """
    total = np.zeros(shape, np.float32)
    for cell, gain in zip(cells_m, gains, strict=True):
        if cell / texel_m >= 2.0:
            total += np.float32(gain) * value_noise(random, shape, cell / texel_m)
    return total


@dataclass(frozen=True)
class _Fouling:
    """What covers the steel."""

    paint: Floats32  # (rows, columns) share of bare paint
    # tone, and share (rows, columns), of algae and of pale spots
    patches: tuple[tuple[Floats32, Floats32], ...]


def _draw_fouling(random: np.random.Generator, shape: tuple[int, int], texel_m: float) -> _Fouling:
    """Draw where paint shows through the slime, where algae grow, and pale spots."""
    fine = _octaves(
        random,
        shape,
        [0.30, 0.12, 0.055, 0.026, 0.013, 0.0065],
        [0.45, 0.5, 0.6, 0.65, 0.5, 0.35],
        texel_m,
    )
    fine *= np.float32(1.6)
    patches = []
    # Tone, sizes of the noise's cells in m, their gains, and the noise from which on it grows
    for tone, cells, gains, level in (
        (ALGAE, [0.6, 0.2, 0.07, 0.02], [1.0, 0.6, 0.4, 0.35], 0.55),
        (PALE, [0.4, 0.1, 0.03, 0.011], [0.9, 0.6, 0.5, 0.4], 0.8),
    ):
        patch = _octaves(random, shape, cells, gains, texel_m)
        patch -= np.float32(level)
        patch *= np.float32(5)
        patches.append((tone, _squash(patch)))
    return _Fouling(_squash(fine), tuple(patches))


def _squash(x: Floats32) -> Floats32:
    """Map values to 0..1 by 0.5 + 0.5 tanh x, in place."""
    np.tanh(x, out=x)
    x *= np.float32(0.5)
    x += np.float32(0.5)
    return x


def _mix_colours(fouling: _Fouling, rows: slice) -> Floats32:
    """Mix the albedo (rows, columns, 3) of some rows: paint under slime, algae, pale spots."""
    share = fouling.paint[rows, :, None]
    out = PAINT * share + SLIME * (1 - share)
    for tone, patch in fouling.patches:
        part = patch[rows, :, None]
        out = out * (1 - 0.75 * part) + 0.75 * tone * part
    return np.asarray(out, np.float32)


def _draw_plates(
    random: np.random.Generator,
    shape: tuple[int, int],
    origin_m: tuple[float, float],
    texel_m: float,
) -> Callable[[slice], Floats32]:
    """Draw a tone for each plate, and the welds between plates.

    Returns a function that gives the brightness (rows, columns) of some rows, so that the whole
    never has to be in memory. origin_m: along and girth of the first texel.
    """
    girth_m = origin_m[1] + texel_m * np.arange(shape[0])
    along_m = origin_m[0] + texel_m * np.arange(shape[1])
    # the plate of each row and of each column
    row = np.floor(girth_m / PLATE_M[1]).astype(int)
    column = np.floor(along_m / PLATE_M[0]).astype(int)
    tone = random.uniform(0.85, 1.12, (np.ptp(row) + 1, np.ptp(column) + 1)).astype(np.float32)
    across, along = _seam(random, girth_m, PLATE_M[1]), _seam(random, along_m, PLATE_M[0])

    def brightness(rows: slice) -> Floats32:
        """Compute the brightness of some rows: the plates' tones, darker at the welds."""
        seam = np.minimum(across[rows, None], along)
        return np.asarray(
            tone[np.ix_(row[rows] - row.min(), column - column.min())] * seam, np.float32
        )

    return brightness


def _seam(random: np.random.Generator, x: NDArray[np.floating], every_m: float) -> Floats32:
    """Draw the brightness (n,) at x (n,), with a dark, uneven line at multiples of every_m."""
    near = np.abs((x + every_m / 2) % every_m - every_m / 2)
    return np.asarray(
        1 - 0.45 * np.exp(-((near / SEAM_M) ** 2)) * random.uniform(0.8, 1.0, len(x)), np.float32
    )


def _specks(random: np.random.Generator, image: Pixels, texel_m: float) -> None:
    """Draw dark and pale dots into the image, 350 on a square metre."""
    import cv2

    count = int(350 * image.shape[0] * image.shape[1] * texel_m**2)
    # In sixteenths of a texel.
    at = (random.uniform(0, 16, (count, 2)) * image.shape[1::-1]).astype(int)
    radius = (16 * random.gamma(3.0, 0.0011, count) / texel_m).astype(int) + 8
    tone = np.where(
        random.random(count) < 0.55, random.uniform(20, 70, count), random.uniform(130, 215, count)
    )
    tint = random.uniform(0.8, 1.0, (count, 3)) * tone[:, None]
    for (x, y), r, c in zip(at.tolist(), radius.tolist(), tint.tolist(), strict=True):
        cv2.circle(image, (x, y), r, c, -1, cv2.LINE_AA, 4)


def _scratches(random: np.random.Generator, image: Pixels, texel_m: float) -> None:
    """Draw bent scratches of a few centimetres into the image, five on a square metre."""
    import cv2

    count = int(5 * image.shape[0] * image.shape[1] * texel_m**2)
    start = random.uniform(0, 1, (count, 1, 2)) * image.shape[1::-1]
    angle = random.uniform(0, 2 * np.pi, count)
    length = random.uniform(0.02, 0.12, count)[:, None, None] / texel_m
    step = length * np.stack([np.cos(angle), np.sin(angle)], 1)[:, None]
    bend = random.uniform(-0.3, 0.3, (count, 1, 1)) * step[..., ::-1] * [1, -1]
    share = np.linspace(0, 1, 9)[None, :, None]
    # parabolas in sixteenths of a texel (the last argument below: 4 bits)
    lines = np.rint(16 * (start + step * 2 * share + bend * share**2)).astype(np.int32)
    for line, tone in zip(lines, random.uniform(60, 190, count).tolist(), strict=True):
        cv2.polylines(image, [line], False, (tone, tone, 0.9 * tone), 1, cv2.LINE_AA, 4)
