# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the two mosaic steps share: the surface they are laid on, and the files they leave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hullrecon.artifacts.graph.stage import Context, load_arrays
from hullrecon.geometry.charts.chart import chart_from_arrays
from hullrecon.geometry.charts.viewing_side import UP, flips
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.mosaic_surface import MosaicSurface, build_mosaic_surface
from hullrecon.mosaic.output.preview import Caption, preview_png
from hullrecon.mosaic.output.raster import write_raster
from hullrecon.mosaic.output.textured_mesh import build_textured_mesh, encode_glb
from hullrecon.mosaic.output.tile_store import TileStore
from hullrecon.records.serialisation import from_arrays
from hullrecon.records.solution import Solution
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Trajectory, VehicleTrack
from hullrecon.report.export.trajectory import track_of

PERCENT = (50, 90, 95, 99)


@dataclass(frozen=True, kw_only=True)
class MosaicInputs:
    """The surface with its chart, and the vehicle over it, in one frame (M, or g without a CAD model)."""

    surface: MosaicSurface
    track: VehicleTrack
    solution: Solution | None
    surface_name: str


def scenery(context: Context, reach_m: float) -> MosaicInputs:
    """The surface as found where there is one, else that of the DVL."""
    folder = context.inputs
    adjusted = folder["adjust"] / "solution.npz" if "adjust" in folder else None
    solution = from_arrays(Solution, load_arrays(adjusted)) if adjusted and adjusted.exists() else None
    trajectory = from_arrays(Trajectory, load_arrays(folder["navigate"] / "trajectory.npz"))
    found = folder["detect"] / "as_found.npz" if "detect" in folder else None
    name = "as found" if found and found.exists() else "of the survey"
    surface = from_arrays(Surface, load_arrays(found if found and found.exists() else folder["surface"] / "surface.npz"))
    chart = chart_from_arrays(load_arrays(folder["surface"] / "chart.npz"))
    return MosaicInputs(
        surface=build_mosaic_surface(surface.mesh(), chart, reach_m),
        track=track_of(trajectory, solution),
        solution=solution,
        surface_name=name,
    )


def write_mosaic(
    context: Context, place: MosaicInputs, store: TileStore, title: str, facts: Mapping[str, Any], sizes: tuple[int, int]
) -> None:
    """ortho.tif, variance.tif, ortho.png, mosaic.glb, mosaic.json. sizes: of the texture in pixels, of the mesh in faces."""
    grid, frame = store.grid, place.track.frame
    with context.out.path("ortho.tif") as path:
        write_raster(path, store.color_tiles(), grid, store.size, store.channels + 1, "uint8", frame)
    with context.out.path("variance.tif") as path:
        write_raster(path, store.variance_tiles(), grid, store.size, 1, "float32", frame)
    document = mosaic_document(store, frame, {**facts, "surface": place.surface_name})
    legend = f"{document['caption']} Seen from outside; contrast stretch_contrast; light gray: not seen."
    spacing = context.settings["hull.frame_spacing"]
    caption = Caption(
        title=title,
        legend=legend,
        frame=frame,
        frame_spacing_m=spacing if frame == "M" else None,
        flips=_seen_from_outside(place, grid),
    )
    context.out.bytes("ortho.png", preview_png(store.small, grid.west, grid.north, grid.step_m * store.reduction, caption))
    mesh = build_textured_mesh(place.surface, grid, store.small[..., -1], store.reduction, sizes[1])
    if len(mesh.faces):
        context.out.bytes("mosaic.glb", encode_glb(mesh, store.small, upright=frame == "M"))
    else:
        context.warn("too little was seen for a textured mesh")
    context.out.json("mosaic.json", document)


def _seen_from_outside(place: MosaicInputs, grid: TexelGrid) -> tuple[bool, bool]:
    rows, columns = (np.linspace(0, n - 1, 12) for n in (grid.height, grid.width))
    return flips(place.surface.chart, grid.centers(rows, columns).reshape(-1, 2), UP[place.track.frame])


def mosaic_document(store: TileStore, frame: str, facts: Mapping[str, Any]) -> dict[str, Any]:
    """mosaic.json: what the mosaic is, for programs and for the page."""
    grid = store.grid
    seen = int(store.views[1:].sum())
    area = seen * grid.step_m**2
    spread = dict(zip((f"p{p}" for p in PERCENT), store.variance_percentiles(PERCENT), strict=True))
    caption = (
        f"{area:.1f} m² at {1000 * grid.step_m:.1f} mm a pixel, at most four best views a pixel, "
        f"laid on the surface {facts['surface']}."
    )
    known = facts.get("position_sigma_m")
    if known is not None:
        caption += f" A pixel's place on the hull is known to {1000 * known:.0f} mm (one sigma)."
    return {
        "frame": frame,
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
