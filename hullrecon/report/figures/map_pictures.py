# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures on the hull's chart: layers of the page's map, the background of the plan, the form.

A layer fills a rectangle of the map coordinates. `survey_layers` makes all of them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hullrecon.native import draw_triangles
from hullrecon.records.surface import DeviationSplit
from hullrecon.report.figures.hull_map import (
    Bounds,
    ChartedSurface,
    Extent,
    HullMap,
    MapField,
    Shading,
    form_shadings,
    survey_fields,
)
from hullrecon.report.figures.style import encode_png, new_figure, png_bytes
from hullrecon.report.format_limits import WEBP_SIDE_PX, reduction
from hullrecon.report.stream import Drawing
from hullrecon.report.survey import Survey
from hullrecon.typing import Array, Floats32, Mask, Pixels

if TYPE_CHECKING:
    from rasterio.windows import Window

# Pixels of a mosaic's layer: 10 m² at 1 mm a pixel, some 4 MB. The delivered GeoTIFF has all
# pixels.
MOST_PIXELS = 12e6
FIELD_STEP_M = 0.005  # side of a pixel of a field, which is smooth over centimetres
# Pixels of a field's layer: 10 m by 6 m at FIELD_STEP_M, far below the limit of a browser's canvas
MOST_FIELD_PIXELS = 2.5e6
FORM_PX = 1200  # longer side of a map of the form, before it is drawn into its frame
MOST_NARROW = 12.0  # largest ratio of the sides of a map of the form, as drawn
BLACK = 15  # the darkest of a stretched picture, so that it stands out from what is not there
MOSAIC_TITLES = {"optical": "Camera mosaic", "sonar": "Sonar mosaic"}
RASTERS = {  # the delivered raster of a layer
    "optical": "ortho_optical.tif",
    "sonar": "ortho_sonar.tif",
    "form": "form.tif",
    "form_sigma": "form_sigma.tif",
    "coverage": "support.tif",
}


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


def survey_layers(survey: Survey, view: HullMap, tiled: Collection[str] = ()) -> list[MapLayer]:
    """Draw the layers of a dive, the first shown first: mosaics, form, sigma, coverage.

    `tiled` names the mosaics of which tiles at full resolution lie beside the page.
    """
    rasters, layers = survey.provenance.copies, list[MapLayer]()
    for name, mosaic in survey.mosaics.named().items():
        if RASTERS[name] in rasters:
            note = f"{mosaic.facts.caption} Contrast stretched."
            layers.append(mosaic_layer(name, MOSAIC_TITLES[name], rasters[RASTERS[name]], note))
    if view.found is not None and survey.surfaces.as_found is not None:
        fields = survey_fields(survey, view.found)
        layers += [field_layer(view.found, field, view.extent) for field in fields]
    return [
        replace(layer, note=f"{layer.note} {_resolution(layer, rasters, layer.name in tiled)}")
        for layer in layers
    ]


def _resolution(layer: MapLayer, rasters: Mapping[str, Path], has_tiles: bool) -> str:
    """Say at what resolution a layer is shown, and where it is finer."""
    shown, raster = f"Shown at {_millimetres(layer.step_m)} a pixel", RASTERS.get(layer.name)
    if raster is None or raster not in rasters:
        return f"{shown}."
    import rasterio

    with rasterio.open(rasters[raster]) as source:
        full_m = float(source.res[0])
    if full_m >= 0.999 * layer.step_m:
        return f"{shown}."
    if has_tiles:
        full = _millimetres(full_m)
        return f"{shown}, closer up at {full} where the folder tiles is beside this page."
    return f"{shown}; {raster} has {_millimetres(full_m)}."


def _millimetres(step_m: float) -> str:
    return f"{1000 * step_m:.1f} mm" if step_m < 0.01 else f"{1000 * step_m:.0f} mm"


def page_reduction(ortho: Path) -> float:
    """Compute the factor, at least 1, by which a mosaic is reduced for its picture in the page."""
    import rasterio

    with rasterio.open(ortho) as source:
        return reduction(source.width, source.height, WEBP_SIDE_PX, MOST_PIXELS)


def mosaic_layer(name: str, title: str, ortho: Path, note: str = "") -> MapLayer:
    """Read an ortho (GeoTIFF) as a layer of at most MOST_PIXELS, its contrast stretched.

    It is transparent where nothing was seen.
    """
    import rasterio

    shrink = page_reduction(ortho)
    with rasterio.open(ortho) as source:
        left, bottom, right, top = (float(v) for v in source.bounds)
        step_m = float(source.res[0]) * shrink
    bands, seen = read_mosaic(ortho, shrink)
    rgba = ContrastStretch.of(bands, seen).apply(bands, seen)
    del bands, seen  # a mosaic of MOST_PIXELS takes 100 MB more while it is encoded
    bounds = (left, bottom, right, top)
    return MapLayer(
        name=name, title=title, webp=webp_bytes(rgba), bounds=bounds, step_m=step_m, note=note
    )


def read_mosaic(ortho: Path, shrink: float, window: Window | None = None) -> tuple[Pixels, Pixels]:
    """Read an ortho (GeoTIFF), or a window of its pixels, reduced by averaging.

    shrink: pixels of the ortho, along either side, in one that is returned.

    Returns
    -------
    bands
        (3, h, w), red, green and blue. A mosaic of one band has it three times.
    seen
        (h, w), 0 where nothing was seen.
    """
    import rasterio
    from rasterio.enums import Resampling

    with rasterio.open(ortho) as source:
        sides = (source.height, source.width) if window is None else (window.height, window.width)
        shape = (max(1, round(sides[0] / shrink)), max(1, round(sides[1] / shrink)))
        numbers = (1, 2, 3) if source.count >= 3 else (1, 1, 1)
        bands = source.read(
            numbers, window=window, out_shape=(3, *shape), resampling=Resampling.average
        )
        seen = source.dataset_mask(out_shape=shape, window=window)
    return np.asarray(bands, np.uint8), np.asarray(seen, np.uint8)


@dataclass(frozen=True, kw_only=True)
class ContrastStretch:
    """Spreads the brightness of a picture over the range, as water leaves a third of it.

    Colour is amplified less, or it would glare.
    """

    low: float  # brightness that becomes BLACK
    gain: float

    @classmethod
    def of(cls, bands: Pixels, seen: Pixels) -> ContrastStretch:
        """Choose the stretch by the brightness of the seen pixels.

        bands: (3, h, w), red, green and blue. seen: (h, w), 0 where nothing was seen.
        """
        sums = np.zeros(3 * 255 + 1, np.int64)  # histogram of red + green + blue
        for row, alpha in enumerate(seen):
            total = bands[:, row].sum(axis=0, dtype=np.int64)
            sums += np.bincount(total[alpha > 0], minlength=len(sums))
        if not sums.any():
            return cls(low=BLACK, gain=1.0)  # changes nothing
        share = np.cumsum(sums) / sums.sum()
        low, high = (float(np.searchsorted(share, percent / 100)) / 3 for percent in (0.5, 99.5))
        return cls(low=low, gain=220 / max(high - low, 25.0))

    def apply(self, bands: Pixels, seen: Pixels) -> Pixels:
        """Stretch a picture's bands (3, h, w) to RGBA (h, w, 4), transparent where not seen (h, w).

        It works row by row, as a picture of floats would take 100 MB and more.
        """
        rgba = np.empty((*seen.shape, 4), np.uint8)
        rgba[..., 3] = seen
        low, gain = np.float32(self.low), np.float32(self.gain)
        for row in range(bands.shape[1]):
            picture = bands[:, row].astype(np.float32)
            gray = picture.mean(axis=0)
            # Brightness gets the whole gain, and what a colour differs from it by at most 1.25
            color = BLACK + (gray - low) * gain + (picture - gray) * min(gain, np.float32(1.25))
            rgba[row, :, :3] = np.clip(color, 0, 255).T
        return rgba


def field_layer(found: ChartedSurface, field: MapField, extent: Extent) -> MapLayer:
    """Draw a field over what was seen.

    Pixels have the colours of the legend and no others: the page reads a value from its pixel.
    """
    step_m = field_step_m(extent)
    level, seen = _levels(found, field.values, field.shading, extent, step_m)
    rgba = _with_alpha(palette(field.shading.colours)[level], seen)
    return MapLayer(
        name=field.name,
        title=field.title,
        webp=webp_bytes(rgba, lossless=True),
        bounds=extent.bounds,
        step_m=step_m,
        legend=field.shading,
        note=field.note,
    )


def field_step_m(extent: Extent) -> float:
    """Choose the side of a pixel of a field's picture, m."""
    width, height = (span / FIELD_STEP_M for span in extent.size)
    return FIELD_STEP_M * reduction(width, height, WEBP_SIDE_PX, MOST_FIELD_PIXELS)


def palette(name: str) -> Pixels:
    """Sample the colours (256, 3) of a legend, from its low to its high end."""
    from matplotlib import colormaps

    return np.asarray(np.rint(255 * colormaps[name](np.linspace(0, 1, 256))[:, :3]), np.uint8)


def _levels(
    found: ChartedSurface, values: Array, shading: Shading, extent: Extent, step_m: float
) -> tuple[Pixels, Mask]:
    """Draw values as levels 0 to 255 of the shading (h, w), with a mask (h, w) of pixels drawn.

    values: (n,) at the surface's vertices. extent: rectangle of the chart that is drawn. step_m:
    side of a pixel.
    """
    width, height = (span / step_m for span in extent.size)
    drawn = _draw(found, values, extent, width, height)
    seen = np.isfinite(drawn)
    share = (np.where(seen, drawn, shading.low) - shading.low) / (shading.high - shading.low)
    return np.rint(255 * np.clip(share, 0, 1)).astype(np.uint8), seen


def _draw(
    found: ChartedSurface, values: Array, extent: Extent, width_px: float, height_px: float
) -> Floats32:
    """Draw values (n,) at the vertices over the seen faces, interpolated within each face.

    Returns a picture (h, w) of the extent, at least one pixel a side. NaN where nothing was seen or
    a corner has no value.
    """
    size = np.maximum(1, np.rint([width_px, height_px]))
    (left, right), (bottom, top) = extent.limits
    faces = found.seen_faces()
    faces = faces[np.isfinite(values[faces]).all(axis=1)]
    # From the upper left corner, in pixels. Limits are turned as the picture is
    at = (found.at - [left, top]) / [right - left, bottom - top] * size
    shape = (int(size[1]), int(size[0]))
    return draw_triangles(at, faces, values[:, None], shape)[..., 0]


def _with_alpha(colours: Pixels, seen: Mask) -> Pixels:
    """Make what was not seen of a picture (h, w, 3) transparent (h, w, 4)."""
    return np.dstack([colours, np.where(seen, 255, 0).astype(np.uint8)])


def webp_bytes(rgba: Pixels, lossless: bool = False) -> bytes:
    """Encode an RGBA picture (h, w, 4) as WebP. Lossless keeps every colour as it is."""
    from PIL import Image

    buffer = BytesIO()
    picture = Image.fromarray(np.ascontiguousarray(rgba, np.uint8), "RGBA")
    # For a lossless picture "quality" is the effort: 60 takes 2.6 times as long for a sixth fewer
    # bytes. Method 3 takes twice the time of 2 for 4 % fewer bytes of a mosaic.
    quality = 20 if lossless else 84
    picture.save(
        buffer, format="WEBP", lossless=lossless, exact=lossless, quality=quality, method=2
    )
    return buffer.getvalue()


def ground_png(found: ChartedSurface, extent: Extent, width_px: int = 1400) -> bytes:
    """Draw the seen faces tinted by views, transparent elsewhere: the background of the plan.

    The picture fills the extent without a frame. A tall picture is at most twice width_px high.
    """
    width, height = extent.size
    shrink = reduction(width_px, width_px * height / width, 2 * width_px)
    views = np.minimum(found.surface.support, 8).astype(float)
    shading = Shading(colours="GnBu", low=-4, high=12, label="views", extend="max")
    level, seen = _levels(found, views, shading, extent, width / width_px * shrink)
    return encode_png(_with_alpha(palette(shading.colours)[level], seen))


def form_drawing(survey: Survey, view: HullMap | None) -> Drawing | None:
    """Give the drawing of the deviation's form. None without a CAD model or a hull as found."""
    split = survey.surfaces.deviation
    if split is None or view is None or view.found is None or not survey.is_in_hull_frame:
        return None
    if not np.isfinite(split.form).any():
        return None
    return partial(form_png, form_map(view.found, split, view))


@dataclass(frozen=True, kw_only=True)
class FormMap:
    """What the maps of the form and of its sigma show."""

    fields: Sequence[tuple[Floats32, Shading]]  # pictures (h, w), mm, and how they are coloured
    limits: tuple[tuple[float, float], tuple[float, float]]  # along and girth, m
    objects: Sequence[tuple[float, float, int]]  # place on the map, m, and number


def form_map(found: ChartedSurface, split: DeviationSplit, view: HullMap) -> FormMap:
    """Lay the form and its sigma out on the map."""
    extent = view.extent
    width, height = extent.size
    shrink = max(width, height) / FORM_PX
    values, shadings = (1000 * split.form, 1000 * split.form_sigma), form_shadings(found, split)
    return FormMap(
        fields=[
            (_draw(found, value, extent, width / shrink, height / shrink), shading)
            for value, shading in zip(values, shadings or (), strict=False)
        ],
        limits=extent.limits,
        objects=[(float(o.at[0]), float(o.at[1]), o.found.id) for o in view.objects],
    )


def form_png(shown: FormMap) -> bytes:
    """Draw maps of form (blue inward, red outward) and its sigma, mm, with the objects' numbers.

    The maps of a tall hull are side by side, else one below the other.
    """
    along, girth = shown.limits
    width, height = along[1] - along[0], girth[1] - girth[0]
    if height > 1.5 * width:
        figure, axes = new_figure(7.6, min(9.0, max(4.0, 3.0 * height / width)), columns=2)
    else:
        figure, axes = new_figure(7.6, 2 * min(5.0, max(1.8, 6.0 * height / width + 0.6)), rows=2)
    for axis, (picture, shading) in zip(axes, shown.fields, strict=False):
        drawn = axis.imshow(
            picture,
            cmap=shading.colours,
            vmin=shading.low,
            vmax=shading.high,
            extent=(*along, *girth),
        )
        axis.grid(False)  # it would lie over the picture
        bar = figure.colorbar(drawn, ax=axis, shrink=0.9, pad=0.01, extend=shading.extend)
        bar.set_label(shading.label, size=9)
        bar.ax.tick_params(labelsize=8)
    # A narrow strip is drawn wider than it is: at true scale nothing of 330 m by 2 m would be seen.
    stretch = max(1.0, width / height / MOST_NARROW) / max(1.0, height / width / MOST_NARROW)
    for axis in axes:
        axis.set(
            xlim=along,
            ylim=girth,
            aspect="equal" if stretch == 1 else stretch,
            xlabel="along (m)" + (f", {1 / stretch:.0f} times as large" if stretch < 1 else ""),
            ylabel="girth (m)" + (f",\n{stretch:.0f} times as large" if stretch > 1 else ""),
        )
    style = {"boxstyle": "circle", "fc": "white", "lw": 0.8}
    for x, y, number in shown.objects:
        axes[0].annotate(str(number), (x, y), fontsize=8, ha="center", va="center", bbox=style)
    return png_bytes(figure)
