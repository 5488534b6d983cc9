# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The optical mosaic on the hull's chart and on the surface."""

from __future__ import annotations

from functools import partial

from hullrecon.artifacts.stage import Context
from hullrecon.errors import StageError
from hullrecon.memory import keep_free_memory
from hullrecon.mosaic.imagery.camera_views import CameraImages, images_of_camera
from hullrecon.mosaic.optical import optical_mosaic
from hullrecon.mosaic.options import OpticalOptions
from hullrecon.rig import rig_from_settings
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.steps.keys import CAMERA_KEYS
from hullrecon.steps.mosaics import MosaicInputs, read_mosaic_inputs, write_mosaic
from hullrecon.threads import in_threads


def run(context: Context[OpticalOptions]) -> None:
    """Blend the images of all cameras on the surface, and write the mosaic.

    Raises StageError if no usable image has a pose, or none shows the surface.
    """
    keep_free_memory()  # every tile allocates the same large arrays
    options, artifacts = context.parameters, InputArtifacts(context.inputs)
    inputs = read_mosaic_inputs(artifacts)
    cameras = _usable_images(context, artifacts, inputs)
    stream = partial(context.stream, by=in_threads)
    with context.out.scratch() as scratch:
        try:
            mosaic = optical_mosaic(inputs.surface, cameras, options, stream, scratch)
        except ValueError as error:
            raise StageError(f"no optical mosaic: {error}", where="mosaic-optical") from error
        facts: dict[str, object] = {
            "images": sum(len(images.rows) for images in cameras),
            "ground_sample_distance_m": mosaic.gsd_m,
            "remarks": ["lamp, vignetting and brightness of each image evened out"]
            if mosaic.light_corrected
            else ["light left as it was"],
        }
        write_mosaic(context, inputs, mosaic.store, "Optical mosaic", facts, scratch)


def _usable_images(
    context: Context[OpticalOptions], artifacts: InputArtifacts, inputs: MosaicInputs
) -> list[CameraImages]:
    """Place the usable images of every camera, by the adjusted mounts if there are any.

    Cameras without a usable image that has a pose are left out. Raises StageError if none is left.
    """
    settings = artifacts.mounted(context.settings)
    rig = rig_from_settings({key: settings[key] for key in CAMERA_KEYS}, artifacts.camera_models)
    rig = rig if inputs.mounts is None else rig.with_mounts(inputs.mounts)
    cameras = []
    for camera in rig.cameras:
        store = artifacts.ingest.images(camera, context.source)
        cameras.append(images_of_camera(rig, inputs.track, camera, store.index.usable, store.read))
    cameras = [images for images in cameras if len(images.rows)]
    if not cameras:
        raise StageError("no usable image has a pose", where="mosaic-optical")
    return cameras
