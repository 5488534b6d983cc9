# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The deliverables of a mosaic besides its rasters: mosaic.json, a preview and a textured mesh."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.frames import Frame
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.output.textured_mesh import build_textured_mesh, encode_glb
from hullrecon.mosaic.output.tile_store import TileStore
from hullrecon.typing import Mask

PREVIEW_PX = 1760  # longer side of the picture in the preview: 11 inches at 160 dots an inch
PNG_LEVEL = 4  # zlib's level: the usual 6 takes three times as long for 8 % fewer bytes
INK, BACK, UNSEEN = "#1c2733", "#ffffff", "#e9edf1"


@dataclass(frozen=True, kw_only=True)
class Caption:
    """The text and axes around the picture of a preview."""

    title: str
    legend: str  # the lines under the picture
    frame: str  # M or g, of the coordinates
    frame_spacing_m: float | None = None  # between the ship's frames, numbered along the top
    # Whether along grows to the left, and girth downwards, where the hull is seen from outside
    flips: tuple[bool, bool] = (False, False)


def preview_png(
    picture: NDArray[np.uint8], west: float, north: float, step_m: float, caption: Caption
) -> bytes:
    """Draw a picture with axes, scale bar and legend, as PNG. The same input gives the same bytes.

    Parameters
    ----------
    picture
        (h, w, 4) RGBA, or (h, w, 2) gray and alpha.
    west, north
        Along and girth, m, of the upper left corner.
    step_m
        Side of a pixel.
    caption
        Texts and directions of the axes.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    height, width = picture.shape[:2]
    tall = 11.0 * height / width
    scale = min(1.0, 9.0 / tall)
    figure = Figure(
        figsize=(max(5.0, 11.0 * scale) + 1.1, tall * scale + 1.75), dpi=160, facecolor=BACK
    )
    axis = figure.add_subplot()
    axis.set_facecolor(UNSEEN)
    extent = (west, west + width * step_m, north - height * step_m, north)
    axis.imshow(
        stretch_contrast(_rgba(reduced_picture(picture))),
        extent=extent,
        interpolation="antialiased",
        aspect="equal",
    )
    axis.set_title(caption.title, loc="left", fontsize=12, color=INK, fontweight="bold")
    along, girth = _axis_names(caption)
    # some 13 characters of this size fit an inch
    legend = fill(caption.legend, int(13 * figure.get_figwidth()))
    axis.set_xlabel(f"{along}\n{legend}", fontsize=9, color=INK)
    axis.set_ylabel(girth, fontsize=9, color=INK)
    axis.tick_params(labelsize=8, colors=INK)
    if caption.frame_spacing_m:
        _frame_numbers(axis, caption.frame_spacing_m)
    _scale_bar(axis, extent, caption.flips)
    FigureCanvasAgg(figure)
    ConstrainedLayoutEngine().execute(figure)  # not by `layout`: savefig would draw twice for it
    buffer = BytesIO()
    effort = {"compress_level": PNG_LEVEL}
    figure.savefig(buffer, format="png", metadata={"Software": None}, pil_kwargs=effort)
    return buffer.getvalue()


def _axis_names(caption: Caption) -> tuple[str, str]:
    """Name the axes of the chart: that of the ship in frame M, that of the survey in g."""
    if caption.frame != "M":
        return "along the survey (m)", "across the survey (m)"
    side = "left" if caption.flips[0] else "right"
    return f"along the hull in M, forward to the {side} (m)", "girth from the keel (m)"


def stretch_contrast(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Stretch the brightness of the seen pixels of an RGBA picture to 15 to 235.

    Differences between the colours are stretched by a quarter at most, as more would glare.
    """
    bands = [picture[..., k].astype(np.float32) for k in range(3)]
    level = (bands[0] + bands[1] + bands[2]) / 3
    seen = level[picture[..., 3] > 0]
    if not len(seen):
        return picture
    low, high = np.percentile(seen, (0.5, 99.5), overwrite_input=True)
    gain = np.float32(220 / max(high - low, 25))
    bright, colorful = 15 + (level - np.float32(low)) * gain, min(gain, np.float32(1.25))
    out = picture.copy()
    for k, band in enumerate(bands):
        out[..., k] = np.clip(bright + (band - level) * colorful, 0, 255)
    return out


def reduced_picture(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Reduce a picture by area means of its seen pixels to at most PREVIEW_PX a side.

    matplotlib takes 50 bytes for each pixel that it draws. A smaller picture stays as it is.
    """
    import cv2

    height, width = picture.shape[:2]
    shrink = max(height, width) / PREVIEW_PX
    if shrink <= 1:
        return picture
    size = (max(1, round(width / shrink)), max(1, round(height / shrink)))
    small = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
    seen = cv2.resize((picture[..., -1] > 0).astype(np.float32), size, interpolation=cv2.INTER_AREA)
    # Unseen pixels are black. They are taken out of the mean by the share of seen pixels.
    color = small[..., :-1] / np.maximum(seen, 1 / 255)[..., None]
    small[..., :-1] = np.minimum(np.rint(color), 255)
    return small


def _rgba(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Convert gray and alpha (h, w, 2) to RGBA. RGBA stays as it is."""
    return (
        np.concatenate([np.repeat(picture[..., :1], 3, axis=2), picture[..., 1:]], axis=2)
        if picture.shape[2] == 2
        else picture
    )


def _frame_numbers(axis: Any, spacing_m: float) -> None:
    """Draw the numbers of the ship's frames along the top. spacing_m: between two frames."""
    upper = axis.secondary_xaxis(
        "top", functions=(lambda x: x / spacing_m, lambda f: f * spacing_m)
    )
    upper.set_xlabel("frame", fontsize=8, color=INK)
    upper.tick_params(labelsize=8, colors=INK)


def _scale_bar(
    axis: Any, extent: tuple[float, float, float, float], flips: tuple[bool, bool]
) -> None:
    """Draw a scale bar: 1, 2 or 5 times a power of ten metres, at most a fifth of the width.

    The axes are turned where `flips` says so. extent: west, east, south and north, m.
    """
    # The bar is at the lower right corner as the axes are drawn
    span = extent[1] - extent[0]
    power = 10.0 ** math.floor(math.log10(span / 5))
    metres = max(m * power for m in (1.0, 2.0, 5.0) if m * power <= span / 5 + 1e-12)
    middle = (
        extent[0] + (0.025 if flips[0] else 0.975) * span + (0.5 if flips[0] else -0.5) * metres
    )
    low = extent[2] + (0.96 if flips[1] else 0.04) * (extent[3] - extent[2])
    ends = [middle - metres / 2, middle + metres / 2]
    if flips[0]:
        axis.invert_xaxis()
    if flips[1]:
        axis.invert_yaxis()
    box = {"facecolor": "white", "alpha": 0.85, "edgecolor": "none", "boxstyle": "square,pad=0.25"}
    axis.plot(ends, [low, low], color="white", linewidth=6, solid_capstyle="butt")
    axis.plot(ends, [low, low], color="black", linewidth=3, solid_capstyle="butt")
    text = f"{metres:g} m" if metres >= 1 else f"{100 * metres:g} cm"
    axis.annotate(
        text,
        (middle, low),
        (0, 7),
        textcoords="offset points",
        ha="center",
        fontsize=9,
        color=INK,
        bbox=box,
    )


PERCENT = (50, 90, 95, 99)  # percentiles of the variance in mosaic.json
GAP_BRIDGE_M = 0.6  # a narrower bay of the outline is a gap of the mosaic, a wider one its shape
MIN_GAP_M2 = 0.005  # smaller gaps are shadows at the foot of structures


@dataclass(frozen=True, kw_only=True)
class MosaicDeliverables:
    """The files of a mosaic, apart from its rasters."""

    document: dict[str, object]  # mosaic.json
    preview: bytes  # PNG
    textured_mesh: bytes | None  # GLB, None where too little was seen for a mesh


@dataclass(frozen=True, kw_only=True)
class Presentation:
    """What the deliverables of a mosaic say of it, and how they show it."""

    title: str
    frame: Frame  # of the coordinates
    outside: OutsideMap  # directions of the chart for a viewer outside the hull
    frame_spacing_m: float | None  # between the ship's frames, None where unknown
    max_faces: int  # of the textured mesh
    # More members of mosaic.json, among them `surface`: on which surface the mosaic was laid
    facts: Mapping[str, object]


def make_deliverables(
    surface: MosaicSurface, store: TileStore, presentation: Presentation
) -> MosaicDeliverables:
    """Make mosaic.json, preview and textured mesh of a mosaic whose tiles are complete.

    The last is None where too little was seen for a mesh.
    """
    frame, grid = presentation.frame, store.grid
    document = mosaic_document(store, frame, presentation.facts)
    caption = Caption(
        title=presentation.title,
        legend=f"{document['caption']} Seen from outside; contrast stretched; "
        "light gray: not seen.",
        frame=frame,
        frame_spacing_m=presentation.frame_spacing_m if frame is Frame.HULL else None,
        flips=presentation.outside.flips,
    )
    mesh = build_textured_mesh(
        surface, grid, store.small[..., -1], store.reduction, presentation.max_faces
    )
    return MosaicDeliverables(
        document={
            **document,
            "along_from_x": presentation.outside.x_sign,
            "girth_from_y": presentation.outside.y_sign,
        },
        preview=preview_png(
            store.small, grid.west, grid.north, grid.step_m * store.reduction, caption
        ),
        textured_mesh=encode_glb(mesh, store.small, surface.chart.ship_axes[2])
        if len(mesh.faces)
        else None,
    )


def mosaic_document(
    store: TileStore, frame: Frame, facts: Mapping[str, object]
) -> dict[str, object]:
    """Make the members of mosaic.json: extent, area, gaps, variances and a caption.

    facts: further members, as of `Presentation`.
    """
    grid = store.grid
    seen = int(store.views[1:].sum())
    area = seen * grid.step_m**2
    spread = dict(zip((f"p{p}" for p in PERCENT), store.variance_percentiles(PERCENT), strict=True))
    gaps = gap_area_m2(store.small[..., -1], grid.step_m * store.reduction)
    caption = (
        f"{1000 * grid.step_m:.1f} mm a pixel, at most four best views a pixel, "
        f"laid on the surface {facts['surface']}."
    )
    caption += f" Gaps inside its outline: {gaps:.2f} m²." if gaps else ""
    known = facts.get("position_sigma_m")
    if isinstance(known, float):
        caption += f" A pixel's position on the hull is known to {1000 * known:.0f} mm (one sigma)."
    return {
        "frame": str(frame),
        "resolution_m": grid.step_m,
        "width_px": grid.width,
        "height_px": grid.height,
        "origin_along_m": grid.west,
        "origin_girth_m": grid.north,
        "along_m": [grid.west, grid.west + grid.width * grid.step_m],
        "girth_m": [grid.north - grid.height * grid.step_m, grid.north],
        "area_m2": area,
        "gap_area_m2": gaps,
        "texels_by_views": {str(k): int(n) for k, n in enumerate(store.views)},
        "variance_gray_levels_squared": spread if seen else {},
        "caption": caption,
        **facts,
    }


def gap_area_m2(alpha: NDArray[np.uint8], step_m: float) -> float:
    """Sum the area on the chart, m2, of gaps in the mosaic.

    A gap is an unseen part inside the outline, of at least MIN_GAP_M2. A morphological closing by
    GAP_BRIDGE_M makes the outline, so that narrow bays of the rim count as gaps.

    alpha (h, w): 0 where nothing was seen. step_m: side of a pixel.
    """
    from scipy import ndimage

    # Closing: what was seen is grown by half of GAP_BRIDGE_M, and shrunk by as much
    seen = np.pad(alpha > 0, 2)
    bridge = max(1, round(0.5 * GAP_BRIDGE_M / step_m))
    grown = near_outside(~np.pad(seen, bridge), bridge)
    closed = ~near_outside(grown, bridge)
    inside = ndimage.binary_fill_holes(closed | np.pad(seen, bridge))[
        bridge:-bridge, bridge:-bridge
    ]
    label, count = ndimage.label(inside & ~seen)
    sizes = np.bincount(label.ravel(), minlength=count + 1)[1:] * step_m**2
    return float(sizes[sizes >= MIN_GAP_M2].sum())


def near_outside(inside: Mask, most_px: int) -> Mask:
    """Tell which pixels (h, w) are no farther than `most_px` from the nearest pixel outside.

    Distances are exact. The result equals that of scipy's distance_transform_edt, with a seventh
    of its memory. inside: (h, w), False for pixels outside.
    """
    import cv2

    distance = cv2.distanceTransform(inside.view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # Squared distances are whole numbers. OpenCV gives their roots, rounded by some 1e-7.
    # Without a pixel outside they may be as large as a number can be.
    near = np.minimum(distance, np.float32(most_px + 1))
    return np.asarray(np.rint(np.square(near)) <= most_px**2)
