# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""features: find features in every image, stored as one mappable .npy per kind and camera."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.artifacts.stage import Context
from hullrecon.dive.images.store import ImageStore
from hullrecon.errors import InputError, StageError
from hullrecon.findings.package import DVL_ALONE, WITHOUT_CAMERAS
from hullrecon.geometry.frames import Camera
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.typing import Array, Ints, Mask, Pixels
from hullrecon.vision.features.extraction import (
    Features,
    extract,
    local_saliency,
)
from hullrecon.vision.features.store import GrowingArray
from hullrecon.vision.options import FeatureOptions

FindFeatures = Callable[[Pixels, FeatureOptions], Features]


@dataclass(frozen=True, kw_only=True)
class Extract:
    """Finds the features of one image, by its row in the camera's index. Picklable."""

    ingest: Path
    source: Path
    camera: Camera
    options: FeatureOptions
    find: FindFeatures

    def __call__(self, image: int) -> Features | None:
        """Find the features. None if the image cannot be read, although ingest found it usable."""
        picture = self._images.read(image)
        return None if picture is None else self.find(picture, self.options)

    def depends(self, image: int) -> tuple[str, int, FindFeatures]:
        """List what a kept result depends on: the image's bytes, their bit depth, the function."""
        data = self._images.bytes(image)
        return hashlib.sha256(data).hexdigest(), int(self._images.index.bits), self.find

    @property
    def _images(self) -> ImageStore:
        return ImageStore(self.ingest, self.source, self.camera.key)


def run(context: Context[FeatureOptions], find: FindFeatures = extract) -> None:
    """Write the features of each camera, and index.npz, which tells where those of an image begin.

    Parameters
    ----------
    context
        Settings, inputs and writer of the step.
    find
        Finds the features of an image. hullrecon/studies has a published variant.

    Raises
    ------
    InputError
        The top camera has no image.
    StageError
        No image has a feature.
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
            count, saliency = _write_camera(context, camera, images.usable, find)
            start = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
            index[f"{camera.key}_start"], index[f"{camera.key}_saliency"] = start, saliency
    if not any(index[name][-1] for name in index if name.endswith("_start")):
        raise StageError("no image has a feature", where="features", remedy=DVL_ALONE)
    context.out.arrays("index.npz", index)


def _write_camera(
    context: Context[FeatureOptions], camera: Camera, usable: Mask, find: FindFeatures
) -> tuple[Ints, Array]:
    """Write the features of one camera's images, one after another.

    Images that are not usable, or cannot be read after all, have none. Returns the number of
    features and the saliency of each image (n,), 0 for unusable ones.
    """
    work = Extract(
        ingest=context.inputs["ingest"],
        source=context.source,
        camera=camera,
        options=context.parameters,
        find=find,
    )
    count, saliency = np.zeros(len(usable), np.int64), np.zeros(len(usable))
    with ExitStack() as stack:

        def grow(kind: str, width: int, dtype: type[np.generic]) -> GrowingArray:
            """Open the file to which the rows (n, width) of each image are added."""
            path = stack.enter_context(context.out.path(f"{kind}_{camera.key}.npy"))
            return stack.enter_context(GrowingArray(path, width, dtype))

        keypoints = grow("keypoints", 4, np.float32)
        descriptors = grow("descriptors", 128, np.uint8)
        color = grow("color", 3, np.uint8)
        rows = [int(row) for row in np.flatnonzero(usable)]
        seen = context.stream(work, rows, f"images of {camera.key}", depends=work.depends)
        for row, found in zip(rows, seen, strict=True):
            if found is None:
                context.warn(f"image {row} of {camera.key} could not be read: it has no features")
                continue
            count[row] = len(found)
            saliency[row] = local_saliency(found.descriptors[found.scored])
            keypoints.append(found.keypoints)
            descriptors.append(found.descriptors)
            color.append(found.color)
    return count, saliency
