# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The optical mosaic on the hull's chart and on the surface."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from hullrecon.artifacts.graph.stage import Context, Stage
from hullrecon.dive.images.store import ImageStore
from hullrecon.errors import StageError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses, tray_poses
from hullrecon.mosaic.imagery.camera_views import CameraImages
from hullrecon.mosaic.optical import optical_mosaic
from hullrecon.mosaic.options import OpticalOptions
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.steps.cameras import cameras_file, mount_of
from hullrecon.steps.features import external
from hullrecon.steps.mosaics import MosaicInputs, scenery, write_mosaic

REMEDY = "check the alignment of the dive with its surface, or set mosaic-optical.resolution_m"


def applies(settings: Mapping[str, Any]) -> str | None:
    return None if settings["camera.top"] is not None else "no camera was carried"


def run(context: Context) -> None:
    options: OpticalOptions = context.parameters
    place = scenery(context, options.reach_m)
    cameras = stations_of(context, place)
    try:
        made = optical_mosaic(place.surface, cameras, options, context.progress)
    except ValueError as error:
        raise StageError(f"no optical mosaic: {error}", where="mosaic-optical", remedy=REMEDY) from error
    facts = {
        "images": sum(len(s.rows) for s in cameras),
        "ground_sample_distance_m": made.gsd_m,
        "remarks": ["lamp, vignetting and brightness of each image evened out"]
        if made.light_corrected
        else ["light left as it was"],
    }
    write_mosaic(context, place, made.store, "Optical mosaic", facts, (options.texture_px, options.faces))


def stations_of(context: Context, place: MosaicInputs) -> list[CameraImages]:
    """The cameras with their usable images and where each was taken."""
    cameras = json.loads(cameras_file(context.inputs).read_text(encoding="utf-8"))
    top, bottom = context.settings["camera.top"], context.settings["camera.bottom"]
    solution = place.solution
    tray_from_camera = mount_of(solution.mounts.tray_from_camera if solution else None, top.mount)
    cameras = [_station(context, place.track, 0, CameraModel(**cameras["top"]), tray_from_camera)]
    if bottom is not None and "bottom" in cameras:
        lower = tray_from_camera @ mount_of(solution.mounts.top_from_bottom if solution else None, bottom.pose_in_top)
        cameras.append(_station(context, place.track, 1, CameraModel(**cameras["bottom"]), lower))
    if not any(len(s.rows) for s in cameras):
        raise StageError("no usable image has a pose", where="mosaic-optical", remedy="see the remarks of ingest and navigate")
    return [s for s in cameras if len(s.rows)]


def _station(context: Context, track: VehicleTrack, side: int, camera: CameraModel, tray_from_camera: Poses) -> CameraImages:
    store = ImageStore(context.inputs["ingest"], context.source, ("camera_top", "camera_bottom")[side])
    nodes = np.flatnonzero(track.image[:, side] >= 0)
    nodes = nodes[store.index.usable[track.image[nodes, side]]]
    origin = context.settings["tray"].origin if context.settings["tray"] is not None else (0.0, 0.0, 0.0)
    poses = track.poses[nodes] @ tray_poses(origin, track.tray[nodes]) @ tray_from_camera
    return CameraImages(camera=camera, rows=track.image[nodes, side], poses=poses, read=store.read)


STAGE = Stage(
    name="mosaic-optical",
    summary="blend the images on the hull's surface",
    inputs=("ingest", "navigate", "surface"),
    optional=("adjust", "detect"),
    parameters=OpticalOptions,
    version=3,
    run=run,
    uses=("camera.top", "camera.bottom", "tray", "logs", "hull.frame_spacing"),
    external=external,
    applies=applies,
)
