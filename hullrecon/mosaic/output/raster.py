# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Writes tiles as a GeoTIFF in chart coordinates; BigTIFF when it would not fit into 4 GB."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.mosaic.grid import TexelGrid

_PIXEL_SCALE, _TIEPOINT = 33550, 33922  # GeoTIFF's ModelPixelScale and ModelTiepoint: metres a pixel, and where (0, 0) lies
_DOUBLE = 12


def write_raster(
    path: Path, tiles: Iterator[NDArray[Any]], grid: TexelGrid, size: int, channels: int, dtype: str, frame: str
) -> None:
    """Deflated tiles. The description is JSON: frame of the chart, metres per pixel, origin, directions."""
    import tifffile

    shape = (grid.height, grid.width) if channels == 1 else (grid.height, grid.width, channels)
    step = grid.step_m
    tags = [
        (_PIXEL_SCALE, _DOUBLE, 3, (step, step, 0.0), True),
        (_TIEPOINT, _DOUBLE, 6, (0.0, 0.0, 0.0, grid.west, grid.north, 0.0), True),
    ]
    with tifffile.TiffWriter(path, bigtiff=grid.height * grid.width * channels * np.dtype(dtype).itemsize > 3.5e9) as file:
        file.write(
            tiles,
            shape=shape,
            dtype=dtype,
            tile=(size, size),
            photometric="rgb" if channels >= 3 else "minisblack",
            extrasamples=["unassalpha"] if channels in (2, 4) else None,
            planarconfig="contig" if channels > 1 else None,
            compression="zlib",
            resolution=(0.01 / step, 0.01 / step),
            resolutionunit="CENTIMETER",
            description=json.dumps(description(grid, frame), sort_keys=True),
            software="hullrecon",
            metadata=None,
            extratags=tags,
        )


def description(grid: TexelGrid, frame: str) -> dict[str, Any]:
    return {
        "metres_per_pixel": grid.step_m,
        "origin_along_m": grid.west,
        "origin_girth_m": grid.north,
        "origin": "outer corner of the first pixel; along grows to the right, girth upwards: a hull is seen from inside",
        "chart_frame": frame,
    }
