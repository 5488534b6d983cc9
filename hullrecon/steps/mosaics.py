# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the two mosaic steps share: the surface under them, and the files they leave."""

from __future__ import annotations

import logging
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import BinaryIO

from hullrecon.artifacts.stage import Context
from hullrecon.errors import HullreconError
from hullrecon.geometry.charts.outside_map import OutsideMap, outside_map
from hullrecon.geometry.frames import Frame
from hullrecon.memory import return_free_memory
from hullrecon.mosaic.mosaic_surface import MosaicSurface, build_mosaic_surface
from hullrecon.mosaic.options import OpticalOptions, SonarOptions
from hullrecon.mosaic.output.cog import Picture
from hullrecon.mosaic.output.deliverables import Presentation, make_deliverables
from hullrecon.mosaic.output.raster import (
    RasterBands,
    RasterLayout,
    surface_bands,
    surface_values,
    write_raster,
)
from hullrecon.mosaic.output.tile_store import TileStore
from hullrecon.mosaic.output.tiles_3d import Pyramid, write_tileset
from hullrecon.records.solution import Mounts
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.steps.artifacts import InputArtifacts

log = logging.getLogger(__name__)
TILES, TILESET = "tiles", "tileset.json"  # folder and head of the 3D Tiles
REACH_M = 0.6  # largest distance from the chart at which the surface is searched
MosaicContext = Context[OpticalOptions] | Context[SonarOptions]


@dataclass(frozen=True, kw_only=True)
class MosaicInputs:
    """The surface with its chart and the vehicle over it, in one frame."""

    surface: MosaicSurface  # with the values of the hull as found, if detect left one
    # map coordinates of the hull as it is seen from outside, in which rasters are written
    outside: OutsideMap
    by_images: bool  # the hull as found was made from images, else from the DVL's returns
    track: VehicleTrack
    mounts: Mounts | None  # as adjusted, None before the adjustment
    surface_name: str  # which surface it is, for captions


def read_mosaic_inputs(inputs: InputArtifacts) -> MosaicInputs:
    """Read the surface as found, else the one of the step surface, and the best path available.

    The best path is the adjusted one, else the dead-reckoned one.
    """
    as_found = inputs.detect.as_found if inputs.detect is not None else None
    solution = inputs.adjust.solution if inputs.adjust is not None else None
    surface = inputs.surface.surface if as_found is None else as_found
    track, chart = inputs.track, inputs.surface.chart
    deviation = inputs.detect.deviation if inputs.detect is not None else None
    values = {} if as_found is None else surface_values(as_found, deviation)
    return MosaicInputs(
        surface=build_mosaic_surface(surface.mesh(), chart, REACH_M, values),
        outside=outside_map(chart, inputs.surface.surface.vertices, track.frame),
        by_images=inputs.detect is not None and inputs.detect.is_found_by_images,
        track=track,
        mounts=None if solution is None else solution.mounts,
        surface_name="of the survey" if as_found is None else "as found",
    )


def write_mosaic(
    context: MosaicContext,
    inputs: MosaicInputs,
    store: TileStore,
    title: str,
    facts: dict[str, object],
    scratch: BinaryIO,
) -> None:
    """Write ortho.tif, the rasters on its grid, ortho.png, mosaic.glb, mosaic.json and tiles/.

    The textured mesh (mosaic.glb) is left out, with a warning, where too little was seen.

    Parameters
    ----------
    context
        Settings and writer of the step.
    inputs
        The surface and the vehicle's track.
    store
        The blended tiles of the mosaic.
    title
        For captions.
    facts
        Figures of the mosaic for mosaic.json.
    scratch
        A temporary file for rasters while they are written.
    """
    frame = Frame(inputs.track.frame)
    layout = RasterLayout(grid=store.grid, size=store.size, outside=inputs.outside)
    presentation = Presentation(
        title=title,
        frame=frame,
        outside=inputs.outside,
        frame_spacing_m=context.settings.read_optional("hull.frame_spacing", float),
        max_faces=context.parameters.max_faces,
        facts={**facts, "surface": inputs.surface_name},
    )
    # Preview and textured mesh take one core, and the rasters what is left of the others.
    return_free_memory()  # which the allocator keeps of the tiles, before more is allocated
    with ThreadPoolExecutor(1) as beside:
        written = beside.submit(_write_mosaic_rasters, context, layout, store, title, scratch)
        made = context.once(
            lambda: make_deliverables(inputs.surface, store, presentation), "textured mesh"
        )
        _write_surface_rasters(context, layout, store, scratch, by_images=inputs.by_images)
        pictures = written.result()
    context.out.bytes("ortho.png", made.preview)
    if made.textured_mesh is not None:
        context.out.bytes("mosaic.glb", made.textured_mesh)
    else:
        context.warn("too little was seen for a textured mesh")
    context.out.json("mosaic.json", made.document)
    pyramid = Pyramid(pictures=pictures, layout=layout, surface=inputs.surface)
    _write_tiles(context, pyramid, frame)


def _write_tiles(context: MosaicContext, pyramid: Pyramid, frame: Frame) -> None:
    """Write the mosaic as 3D Tiles below tiles/, which viewers load piece by piece.

    An internal error gives a warning, and the mosaic is delivered without them.
    """
    try:
        tileset = write_tileset(
            pyramid, lambda name, data: context.out.bytes(f"{TILES}/{name}", data), frame
        )
    except (HullreconError, MemoryError, OSError):
        raise
    except Exception as error:
        log.exception("3D Tiles")
        context.warn(f"the 3D Tiles could not be written: {type(error).__name__}: {error}")
        return
    if tileset is not None:  # last, as it names the others
        context.out.json(f"{TILES}/{TILESET}", tileset)


def _write_mosaic_rasters(
    context: MosaicContext, layout: RasterLayout, store: TileStore, title: str, scratch: BinaryIO
) -> list[Picture]:
    """Write the ortho, and rasters of the variance and number of its views.

    Returns the ortho as written, at its full size and reduced ones: textures for the 3D Tiles.
    """
    colors = ("red", "green", "blue", "alpha") if store.channels == 3 else ("intensity", "alpha")
    rasters = (
        ("ortho.tif", store.color, RasterBands(names=colors, unit="", dtype="uint8", title=title)),
        (
            "variance.tif",
            store.variance,
            RasterBands(
                names=("variance",),
                unit="grey levels squared",
                dtype="float32",
                title=f"{title}: variance of the intensities blended in a pixel",
                nodata=float("nan"),
            ),
        ),
        (
            "views.tif",
            store.counts,
            RasterBands(
                names=("views",),
                unit="",
                dtype="uint8",
                title=f"{title}: views blended in a pixel",
                nodata=0,
            ),
        ),
    )
    pictures = {}
    for name, tiles, bands in rasters:
        with context.out.path(name) as path:
            pictures[name] = write_raster(path, tiles, layout, bands, scratch)
    return pictures["ortho.tif"]


def _write_surface_rasters(
    context: MosaicContext,
    layout: RasterLayout,
    store: TileStore,
    scratch: BinaryIO,
    *,
    by_images: bool,
) -> None:
    """Write rasters of the hull as found on the mosaic's pixels, so that both lie over each other.

    Nothing is written where detect left no hull as found. by_images: as of `MosaicInputs`.
    """
    for name, tiles in store.of_surface.items():
        with context.out.path(f"{name}.tif") as path:
            bands = surface_bands(name, by_images=by_images)
            write_raster(path, tiles, layout, bands, scratch)
