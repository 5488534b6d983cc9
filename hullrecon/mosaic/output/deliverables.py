# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a finished mosaic is handed over as, apart from its rasters: mosaic.json, the preview and the textured mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.viewing_side import UP, flips
from hullrecon.geometry.frames import Frame
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.output.preview import Caption, preview_png
from hullrecon.mosaic.output.textured_mesh import build_textured_mesh, encode_glb
from hullrecon.mosaic.output.tile_store import TileStore

PERCENT = (50, 90, 95, 99)


@dataclass(frozen=True, kw_only=True)
class MosaicDeliverables:
    """document: mosaic.json; preview: PNG; textured_mesh: GLB, None where too little was seen for a mesh."""

    document: dict[str, object]
    preview: bytes
    textured_mesh: bytes | None


@dataclass(frozen=True, kw_only=True)
class Presentation:
    """How a mosaic is shown. frame_spacing_m: between the ship's frames, None where unknown; facts: more for mosaic.json, among
    them `surface`: which surface it was laid on."""

    title: str
    frame: Frame
    frame_spacing_m: float | None
    max_faces: int
    facts: Mapping[str, object]


def make_deliverables(surface: MosaicSurface, store: TileStore, presentation: Presentation) -> MosaicDeliverables:
    """Return the documents and pictures of a mosaic whose tiles are complete."""
    frame, grid = presentation.frame, store.grid
    document = mosaic_document(store, frame, presentation.facts)
    caption = Caption(
        title=presentation.title,
        legend=f"{document['caption']} Seen from outside; contrast stretched; light gray: not seen.",
        frame=frame,
        frame_spacing_m=presentation.frame_spacing_m if frame is Frame.HULL else None,
        flips=_flips_seen_from_outside(surface, store, frame),
    )
    mesh = build_textured_mesh(surface, grid, store.small[..., -1], store.reduction, presentation.max_faces)
    return MosaicDeliverables(
        document=document,
        preview=preview_png(store.small, grid.west, grid.north, grid.step_m * store.reduction, caption),
        textured_mesh=encode_glb(mesh, store.small, upright=frame is Frame.HULL) if len(mesh.faces) else None,
    )


def mosaic_document(store: TileStore, frame: Frame, facts: Mapping[str, object]) -> dict[str, object]:
    """Return mosaic.json: what the mosaic is, for programs and for the report's page."""
    grid = store.grid
    seen = int(store.views[1:].sum())
    area = seen * grid.step_m**2
    spread = dict(zip((f"p{p}" for p in PERCENT), store.variance_percentiles(PERCENT), strict=True))
    caption = (
        f"{area:.1f} m² at {1000 * grid.step_m:.1f} mm a pixel, at most four best views a pixel, "
        f"laid on the surface {facts['surface']}."
    )
    known = facts.get("position_sigma_m")
    if isinstance(known, float):
        caption += f" A pixel's place on the hull is known to {1000 * known:.0f} mm (one sigma)."
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
        "texels_by_views": {str(k): int(n) for k, n in enumerate(store.views)},
        "variance_gray_levels_squared": spread if seen else {},
        "caption": caption,
        **facts,
    }


def _flips_seen_from_outside(surface: MosaicSurface, store: TileStore, frame: Frame) -> tuple[bool, bool]:
    """Return whether along grows to the left, and girth downwards, for a viewer outside the hull."""
    grid = store.grid
    rows, columns = (np.linspace(0, n - 1, 12) for n in (grid.height, grid.width))
    return flips(surface.chart, grid.centers(rows, columns).reshape(-1, 2), UP[frame])
