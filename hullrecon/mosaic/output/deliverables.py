# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a mosaic is delivered as, apart from its rasters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.frames import Frame
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.output.preview import Caption, preview_png
from hullrecon.mosaic.output.textured_mesh import build_textured_mesh, encode_glb
from hullrecon.mosaic.output.tile_store import TileStore

PERCENT = (50, 90, 95, 99)
GAP_BRIDGE_M = 0.6  # narrower gaps at the rim are gaps of the mosaic, wider ones its shape
MIN_GAP_M2 = 0.005  # smaller ones are shadows at the foot of structures


@dataclass(frozen=True, kw_only=True)
class MosaicDeliverables:
    """The files of a mosaic, apart from its rasters."""

    document: dict[str, object]  # mosaic.json
    preview: bytes  # PNG
    textured_mesh: bytes | None  # GLB, None where too little was seen for a mesh


@dataclass(frozen=True, kw_only=True)
class Presentation:
    """How a mosaic is shown."""

    title: str
    frame: Frame
    outside: OutsideMap
    frame_spacing_m: float | None  # between the ship's frames, None where unknown
    max_faces: int
    # more for mosaic.json, among them `surface`: which surface it was draped on
    facts: Mapping[str, object]


def make_deliverables(
    surface: MosaicSurface, store: TileStore, presentation: Presentation
) -> MosaicDeliverables:
    """Make the documents and pictures of a mosaic whose tiles are complete."""
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
    """Describe the mosaic for programs and the report's page, as mosaic.json."""
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
    """Sum the area on the chart, m2, of gaps inside the outline of what was seen.

    Gaps of at least MIN_GAP_M2 count; those up to GAP_BRIDGE_M wide at the rim are inside.
    """
    from scipy import ndimage

    seen = np.pad(alpha > 0, 2)
    bridge = max(1, round(0.5 * GAP_BRIDGE_M / step_m))
    away = ndimage.distance_transform_edt(~np.pad(seen, bridge))
    grown = away <= bridge
    closed = ndimage.distance_transform_edt(grown) > bridge
    inside = ndimage.binary_fill_holes(closed | np.pad(seen, bridge))[
        bridge:-bridge, bridge:-bridge
    ]
    label, count = ndimage.label(inside & ~seen)
    sizes = np.bincount(label.ravel(), minlength=count + 1)[1:] * step_m**2
    return float(sizes[sizes >= MIN_GAP_M2].sum())
