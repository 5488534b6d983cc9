# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tiles of a mosaic for the page's map and 3-D view, where its picture in the page is reduced.

Level 0 has the mosaic's own pixels, each further level half as many a side, down to the last that
is finer than the picture in the page. Tiles of which nothing was seen are left out.

A tile is a script that hands a WebP picture to the page: when a page is opened from disk, a browser
lets it draw no picture file beside it in 3-D.
"""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from hullrecon.report.figures.map_pictures import (
    RASTERS,
    ContrastStretch,
    page_reduction,
    read_mosaic,
    webp_bytes,
)
from hullrecon.report.stream import Stream
from hullrecon.report.survey import Survey

FOLDER = "report/tiles"  # below deliver/
TILE_PX = 512
AT_ONCE = 8  # tiles that are read together: 8 MB of pixels
_FILE = re.compile(rf"{FOLDER}/(\w+)/(\d+)/(\d+)_(\d+)\.js")


@dataclass(frozen=True, kw_only=True)
class TileRun:
    """Neighbouring tiles of one row, which are made together."""

    level: int
    row: int  # from the top
    column: int  # of the first tile, from the left


@dataclass(frozen=True, kw_only=True)
class TileIndex:
    """Which tiles of a mosaic lie beside the page."""

    step_m: float  # side of a pixel of level 0
    # for each level rows of tiles from the top, each a text with 1 for a tile that is there
    levels: list[list[str]]


def stream_tiles(survey: Survey, stream: Stream) -> Iterator[tuple[str, bytes]]:
    """Make the tiles of all mosaics that the page shows reduced. Yields name and file of each."""
    for name in survey.mosaics.named():
        ortho = survey.provenance.copies.get(RASTERS[name])
        runs = [] if ortho is None else tile_runs(ortho)
        if ortho is None or not runs:
            continue
        stretch = ContrastStretch.of(*read_mosaic(ortho, page_reduction(ortho)))
        made = stream(partial(make_tiles, ortho, stretch), runs, f"{name} tiles of the map")
        for run, tiles in zip(runs, made, strict=True):
            for column, webp in tiles.items():
                yield f"{FOLDER}/{name}/{run.level}/{column}_{run.row}.js", tile_script(webp)


def tile_script(webp: bytes) -> bytes:
    """Wrap a tile into the script by which report/web/src/tiles.js takes it."""
    return b'hullreconTile("data:image/webp;base64,%s")\n' % b64encode(webp)


def tile_runs(ortho: Path) -> list[TileRun]:
    """List the tiles of a mosaic at all levels that are finer than its picture in the page.

    Up to AT_ONCE tiles side by side are one run, which is read at once.
    """
    import rasterio

    with rasterio.open(ortho) as source:
        width, height = source.width, source.height
    reduced, level, runs = page_reduction(ortho), 0, list[TileRun]()
    while 2**level < reduced:
        rows, columns = (-(-size // (TILE_PX * 2**level)) for size in (height, width))
        runs += [
            TileRun(level=level, row=row, column=column)
            for row in range(rows)
            for column in range(0, columns, AT_ONCE)
        ]
        level += 1
    return runs


def make_tiles(ortho: Path, stretch: ContrastStretch, run: TileRun) -> Mapping[int, bytes]:
    """Encode the tiles of a run in which something was seen as WebP, by their columns."""
    import rasterio
    from rasterio.windows import Window

    factor = 2**run.level
    side = TILE_PX * factor  # of a tile, in the mosaic's own pixels
    with rasterio.open(ortho) as source:
        left, top = run.column * side, run.row * side
        width = min(AT_ONCE * side, source.width - left)
        height = min(side, source.height - top)
    bands, seen = read_mosaic(ortho, factor, Window(left, top, width, height))
    if not seen.any():
        return {}
    rgba = stretch.apply(bands, seen)
    pieces = {
        run.column + k: rgba[:, k * TILE_PX : (k + 1) * TILE_PX]
        for k in range(-(-rgba.shape[1] // TILE_PX))
    }
    return {at: webp_bytes(piece) for at, piece in pieces.items() if piece[..., 3].any()}


def index_tiles(survey: Survey, files: Iterable[str]) -> dict[str, TileIndex]:
    """List the tiles among delivered files, by the name of their mosaic."""
    import rasterio

    found: dict[str, dict[int, set[tuple[int, int]]]] = {}
    for file in files:
        if match := _FILE.fullmatch(file):
            level, column, row = (int(number) for number in match.groups()[1:])
            found.setdefault(match[1], {}).setdefault(level, set()).add((row, column))
    index = dict[str, TileIndex]()
    for name, levels in found.items():
        with rasterio.open(survey.provenance.copies[RASTERS[name]]) as source:
            step_m = float(source.res[0])
        rows = [_rows(levels.get(k, set())) for k in range(max(levels) + 1)]
        index[name] = TileIndex(step_m=step_m, levels=rows)
    return index


def _rows(tiles: set[tuple[int, int]]) -> list[str]:
    """Write which (row, column) are there as a text of 0 and 1 for each row."""
    rows, columns = np.array(sorted(tiles)).reshape(-1, 2).T
    shape = (int(rows.max(initial=-1)) + 1, int(columns.max(initial=-1)) + 1)
    there = np.zeros(shape, np.uint8)
    there[rows, columns] = 1
    return ["".join(map(str, row)) for row in there.tolist()]
