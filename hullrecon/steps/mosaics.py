# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the two mosaic steps share: the surface they are laid on, and the files they leave."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.artifacts.graph.stage import Context
from hullrecon.geometry.frames import Frame
from hullrecon.mosaic.mosaic_surface import MosaicSurface, build_mosaic_surface
from hullrecon.mosaic.options import OpticalOptions, SonarOptions
from hullrecon.mosaic.output.deliverables import Presentation, make_deliverables
from hullrecon.mosaic.output.raster import write_raster
from hullrecon.mosaic.output.tile_store import TileStore
from hullrecon.records.solution import Mounts
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.steps.artifacts import InputArtifacts

MosaicContext = Context[OpticalOptions] | Context[SonarOptions]


@dataclass(frozen=True, kw_only=True)
class MosaicInputs:
    """The surface with its chart, and the vehicle over it, in one frame (M, or g without a CAD model).

    mounts: as adjusted, None before the adjustment; surface_name: which surface it is, for captions.
    """

    surface: MosaicSurface
    track: VehicleTrack
    mounts: Mounts | None
    surface_name: str


def read_mosaic_inputs(inputs: InputArtifacts, reach_m: float) -> MosaicInputs:
    """Return the surface as found where there is one, else that of the DVL, and the best path that there is."""
    as_found = inputs.detect.as_found if inputs.detect is not None else None
    solution = inputs.adjust.solution if inputs.adjust is not None else None
    surface = inputs.surface.surface if as_found is None else as_found
    return MosaicInputs(
        surface=build_mosaic_surface(surface.mesh(), inputs.surface.chart, reach_m),
        track=inputs.navigate.trajectory.track() if solution is None else solution.track(),
        mounts=None if solution is None else solution.mounts,
        surface_name="of the survey" if as_found is None else "as found",
    )


def write_mosaic(context: MosaicContext, inputs: MosaicInputs, store: TileStore, title: str, facts: dict[str, object]) -> None:
    """Write ortho.tif, variance.tif, ortho.png, mosaic.glb and mosaic.json."""
    grid, frame = store.grid, Frame(inputs.track.frame)
    with context.out.path("ortho.tif") as path:
        write_raster(path, store.color_tiles(), grid, store.size, store.channels + 1, "uint8", frame)
    with context.out.path("variance.tif") as path:
        write_raster(path, store.variance_tiles(), grid, store.size, 1, "float32", frame)
    presentation = Presentation(
        title=title,
        frame=frame,
        frame_spacing_m=context.settings.read_optional("hull.frame_spacing", float),
        max_faces=context.parameters.max_faces,
        facts={**facts, "surface": inputs.surface_name},
    )
    made = make_deliverables(inputs.surface, store, presentation)
    context.out.bytes("ortho.png", made.preview)
    if made.textured_mesh is not None:
        context.out.bytes("mosaic.glb", made.textured_mesh)
    else:
        context.warn("too little was seen for a textured mesh")
    context.out.json("mosaic.json", made.document)
