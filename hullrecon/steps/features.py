# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""features: those of every image, one mappable .npy a kind and camera."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.artifacts.stage import Context, Stage, StageSettings
from hullrecon.dive.config.schema import Logs
from hullrecon.dive.images.store import ImageStore
from hullrecon.dive.logs.summary import WITHOUT_CAMERAS
from hullrecon.dive.package_files import named_images
from hullrecon.errors import InputError, StageError
from hullrecon.geometry.frames import Camera
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.features.extraction import FeatureOptions, Features, extract
from hullrecon.vision.features.saliency import local_saliency
from hullrecon.vision.features.store import GrowingArray

BLOCK = 128  # images whose features are in memory at a time


@dataclass(frozen=True, kw_only=True)
class Extract:
    """Finds the features of one image, by its row in the camera's index; picklable."""

    ingest: Path
    source: Path
    camera: Camera
    options: FeatureOptions
    corners: bool

    def __call__(self, image: int) -> Features | None:
        """Return the features; None when the image cannot be read after all."""
        picture = ImageStore(self.ingest, self.source, self.camera.key).read(image)
        return None if picture is None else extract(picture, self.options, self.corners)


def applies(settings: Mapping[str, object], package: Path) -> str | None:
    """Return why a dive cannot have this step; None where it can."""
    return None if settings["camera.top.time_offset"] is not None else "no camera was carried"


def external(settings: StageSettings, package: Path) -> list[Path]:
    """Return the images that tables of the package name, relative to it, which this step reads
    again.
    """
    return named_images(package, settings.read("logs", Logs).files)


def run(context: Context[FeatureOptions]) -> None:
    """Leave the features of each camera and index.npz. Raises StageError where no image has one,
    InputError where the upper camera has no image.
    """
    top = InputArtifacts(context.inputs).ingest.image_index(Camera.TOP)
    if top is None or not len(top.t_ns):
        raise InputError(
            "dive.toml has a camera.top, but no image of it was logged",
            where="features",
            remedy=WITHOUT_CAMERAS,
        )
    index: dict[str, NDArray[np.generic]] = {}
    for camera in Camera:
        images = InputArtifacts(context.inputs).ingest.image_index(camera)
        if images is not None:
            written = _write_camera(context, camera, images.usable)
            index[f"{camera.key}_start"] = np.concatenate([[0], np.cumsum(written.count)]).astype(
                np.int64
            )
            index[f"{camera.key}_saliency"] = written.saliency
            if written.corners.any():
                index[f"{camera.key}_corners"] = written.corners
    if not any(index[name][-1] for name in index if name.endswith("_start")):
        raise StageError(
            "no image has a feature",
            where="features",
            remedy="lower features.contrast_threshold, or check the images",
        )
    context.out.arrays("index.npz", index)


@dataclass(frozen=True, kw_only=True)
class _Written:
    """Of each image (n,): the number of its features, how many of them are corners, and its
    saliency.
    """

    count: Ints
    corners: Ints
    saliency: Array


def _write_camera(context: Context[FeatureOptions], camera: Camera, usable: Mask) -> _Written:
    """Write one camera's arrays block by block; return what is known by image."""
    corners = context.settings.read("matches.harris_share", float) > 0
    work = Extract(
        ingest=context.inputs["ingest"],
        source=context.source,
        camera=camera,
        options=context.parameters,
        corners=corners,
    )
    n = len(usable)
    out = _Written(count=np.zeros(n, np.int64), corners=np.zeros(n, np.int64), saliency=np.zeros(n))
    with ExitStack() as stack:

        def grow(kind: str, width: int, dtype: type[np.generic]) -> GrowingArray:
            return stack.enter_context(
                GrowingArray(
                    stack.enter_context(context.out.path(f"{kind}_{camera.key}.npy")), width, dtype
                )
            )

        keypoints, descriptors = (
            grow("keypoints", 4, np.float32),
            grow("descriptors", 128, np.uint8),
        )
        color = grow("color", 3, np.uint8)
        for start in range(0, len(usable), BLOCK):
            rows = [int(row) for row in start + np.flatnonzero(usable[start : start + BLOCK])]
            for row, found in zip(rows, context.map(work, rows, camera.key), strict=True):
                if found is None:
                    context.warn(
                        f"image {row} of {camera.key} could not be read: it has no features"
                    )
                    continue
                out.count[row], out.corners[row] = len(found), found.corners
                out.saliency[row] = local_saliency(found.without_corners().descriptors)
                keypoints.append(found.keypoints)
                descriptors.append(found.descriptors)
                color.append(found.color)
    return out


STAGE = Stage(
    name="features",
    summary="find features in every image",
    inputs=("ingest",),
    parameters=FeatureOptions,
    version=3,
    run=run,
    uses=("camera.top.time_offset", "logs", "matches.harris_share"),
    external=external,
    applies=applies,
)
