# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The pictures of the page's map: mosaics and fields of the hull, each filling a rectangle of the
map coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.report.figures.chart_map import ChartedSurface, Extent, Shading, seen_faces
from hullrecon.report.format_limits import WEBP_SIDE_PX, reduction
from hullrecon.typing import Array, Mask, Pixels

Bounds = tuple[float, float, float, float]  # left, bottom, right, top in map coordinates, m
# of a mosaic: 10 m2 at 1 mm a pixel in some 4 MB; the GeoTIFF beside has all of them
MOST_PIXELS = 12e6
FIELD_STEP_M = 0.005  # a pixel of a field, which is smooth over centimetres
MOST_FIELD_PIXELS = 2.5e6  # 10 m by 6 m at that; far below CANVAS_PIXELS, through which it is read


@dataclass(frozen=True, kw_only=True)
class MapLayer:
    """A picture on the map."""

    name: str  # stem of ids in the page
    title: str
    webp: bytes
    bounds: Bounds
    step_m: float  # side of a pixel
    legend: Shading | None = None  # None for a photograph
    note: str = ""  # sentences that a reader of the map needs


def mosaic_layer(name: str, title: str, ortho: Path, note: str = "") -> MapLayer:
    """Return an ortho (GeoTIFF) as a layer of at most MOST_PIXELS, its contrast stretched.

    It is transparent where nothing was seen.
    """
    import rasterio
    from rasterio.enums import Resampling

    with rasterio.open(ortho) as source:
        shrink = reduction(source.width, source.height, WEBP_SIDE_PX, MOST_PIXELS)
        step_m = float(source.res[0])
        shape = (max(1, round(source.height / shrink)), max(1, round(source.width / shrink)))
        bands = (1, 2, 3) if source.count >= 3 else (1, 1, 1)
        picture = source.read(bands, out_shape=(3, *shape), resampling=Resampling.average)
        seen = source.dataset_mask(out_shape=shape)
        left, bottom, right, top = (float(v) for v in source.bounds)
    rgba = np.dstack([*_stretched(np.asarray(picture, np.uint8), seen > 0), seen])
    return MapLayer(
        name=name,
        title=title,
        webp=webp_bytes(rgba),
        bounds=(left, bottom, right, top),
        step_m=step_m * shrink,
        note=note,
    )


def _stretched(picture: Pixels, seen: Mask) -> Pixels:
    """Return bands (3, h, w) with their brightness spread over the range: water leaves a third of
    it. Colour grows less, or it would glare.
    """
    level = picture.mean(axis=0, dtype=np.float32)
    if not seen.any():
        return picture
    low, high = np.percentile(level[seen], (0.5, 99.5))
    gain = 220 / max(high - low, 25.0)
    bands = [
        np.clip(15 + (level - low) * gain + (band - level) * min(gain, 1.25), 0, 255)
        for band in picture
    ]
    return np.stack([band.astype(np.uint8) for band in bands])


def field_layer(
    name: str,
    title: str,
    found: ChartedSurface,
    values: Array,
    shading: Shading,
    extent: Extent,
    note: str = "",
) -> MapLayer:
    """Return values at the vertices (n,) as a layer over what was seen. Pixels have the colours of
    the legend and no others, so that a page reads a value from its pixel.
    """
    step_m = field_step_m(extent)
    level, seen = _levels(found, values, shading, extent, step_m)
    rgba = np.dstack([palette(shading.colours)[level], np.where(seen, 255, 0).astype(np.uint8)])
    return MapLayer(
        name=name,
        title=title,
        webp=webp_bytes(rgba, lossless=True),
        bounds=bounds_of(extent),
        step_m=step_m,
        legend=shading,
        note=note,
    )


def field_step_m(extent: Extent) -> float:
    """Return the side of a pixel of a field's picture, m."""
    width, height = (span / FIELD_STEP_M for span in extent.size)
    return FIELD_STEP_M * reduction(width, height, WEBP_SIDE_PX, MOST_FIELD_PIXELS)


def bounds_of(extent: Extent) -> Bounds:
    """Return the rectangle of an extent in map coordinates."""
    x, y = (-1 if flip else 1 for flip in extent.flips)
    corners = OutsideMap(x_sign=x, y_sign=y, frame="").to_map(
        np.array([extent.along, extent.girth]).T
    )
    (left, bottom), (right, top) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return left, bottom, right, top


def palette(name: str) -> Pixels:
    """Return the colours (256, 3) of a legend, from its low to its high end."""
    from matplotlib import colormaps

    return np.asarray(np.rint(255 * colormaps[name](np.linspace(0, 1, 256))[:, :3]), np.uint8)


def _levels(
    found: ChartedSurface, values: Array, shading: Shading, extent: Extent, step_m: float
) -> tuple[Pixels, Mask]:
    """Return values as levels 0 to 255 of the shading, and where there are any: both (h, w).

    matplotlib draws them in grey, in square pixels of step_m.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width, height = (max(1.0, span / step_m) for span in extent.size)
    figure = Figure(figsize=(width / 100, height / 100), dpi=100, frameon=False)
    canvas = FigureCanvasAgg(figure)
    axis = figure.add_axes((0, 0, 1, 1))
    axis.set(xlim=extent.limits[0], ylim=extent.limits[1])
    axis.axis("off")
    faces = seen_faces(found)
    faces = faces[np.isfinite(values[faces]).all(axis=1)]
    if len(faces):
        at, shown = np.nan_to_num(found.at), np.nan_to_num(values)
        axis.tripcolor(
            *at.T, faces, shown, cmap="gray", vmin=shading.low, vmax=shading.high, shading="gouraud"
        )
    canvas.draw()
    drawn = np.asarray(canvas.buffer_rgba())
    return np.ascontiguousarray(drawn[..., 0]), np.asarray(drawn[..., 3] >= 128)


def webp_bytes(rgba: Pixels, lossless: bool = False) -> bytes:
    """Return a picture (h, w, 4) as WebP; lossless keeps every colour as it is."""
    from PIL import Image

    buffer = BytesIO()
    picture = Image.fromarray(np.ascontiguousarray(rgba, np.uint8), "RGBA")
    picture.save(
        buffer,
        format="WEBP",
        lossless=lossless,
        exact=lossless,
        quality=60 if lossless else 84,
        method=3,
    )
    return buffer.getvalue()
