# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of every image, one mappable .npy a kind and camera."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.artifacts.graph.stage import Context, Stage, load_arrays
from hullrecon.dive.images.store import ImageStore
from hullrecon.errors import StageError
from hullrecon.vision.features.extraction import FeatureOptions, Features, extract
from hullrecon.vision.features.saliency import local_saliency
from hullrecon.vision.features.store import CAMERAS, GrowingArray

BLOCK = 128  # images whose features are in memory at a time
SUFFIXES = frozenset((".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff"))


@dataclass(frozen=True)
class Extract:
    """Picklable: the features of one image, by its row in the camera's index."""

    ingest: Path
    source: Path
    camera: str
    options: FeatureOptions

    def __call__(self, image: int) -> Features | None:
        """None when the image cannot be read after all."""
        picture = ImageStore(self.ingest, self.source, self.camera).read(image)
        return None if picture is None else extract(picture, self.options)


def applies(settings: Mapping[str, Any]) -> str | None:
    return None if settings["camera.top.calibration"] is not None else "no camera was carried"


def external(settings: Mapping[str, Any], package: Path) -> list[Path]:
    """Images that lie in the package as files, which this step reads again."""
    folders = [package / file for file in settings["logs"].files]
    return sorted(p for folder in folders if folder.is_dir() for p in folder.rglob("*") if p.suffix.lower() in SUFFIXES)


def run(context: Context) -> None:
    index: dict[str, NDArray[np.generic]] = {}
    for camera in CAMERAS:
        images = context.inputs["ingest"] / f"images_{camera}.npz"
        if images.exists():
            count, saliency = _write_camera(context, camera, load_arrays(images)["usable"])
            index[f"{camera}_start"] = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
            index[f"{camera}_saliency"] = saliency
    if not any(index[name][-1] for name in index if name.endswith("_start")):
        raise StageError(
            "no image has a feature", where="features", remedy="lower features.contrast_threshold, or check the images"
        )
    context.out.arrays("index.npz", index)


def _write_camera(context: Context, camera: str, usable: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Writes one camera's arrays block by block; returns number of features and saliency of each image."""
    work = Extract(context.inputs["ingest"], context.source, camera, context.parameters)
    count, saliency = np.zeros(len(usable), np.int64), np.zeros(len(usable))
    with ExitStack() as opened:

        def grow(kind: str, width: int, dtype: type[np.generic]) -> GrowingArray:
            return opened.enter_context(
                GrowingArray(opened.enter_context(context.out.path(f"{kind}_{camera}.npy")), width, dtype)
            )

        keypoints, descriptors = grow("keypoints", 4, np.float32), grow("descriptors", 128, np.uint8)
        color = grow("color", 3, np.uint8)
        for start in range(0, len(usable), BLOCK):
            rows = [int(row) for row in start + np.flatnonzero(usable[start : start + BLOCK])]
            for row, found in zip(rows, context.map(work, rows, camera), strict=True):
                if found is None:
                    context.warn(f"image {row} of {camera} could not be read: it has no features")
                    continue
                count[row], saliency[row] = len(found), local_saliency(found.descriptors)
                keypoints.append(found.keypoints)
                descriptors.append(found.descriptors)
                color.append(found.color)
    return count, saliency


STAGE = Stage(
    name="features",
    summary="find features in every image",
    inputs=("ingest",),
    parameters=FeatureOptions,
    version=1,
    run=run,
    uses=("camera.top.calibration", "logs"),
    external=external,
    applies=applies,
)
