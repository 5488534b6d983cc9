# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Export the undistorted images of a finished run with their COLMAP model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.machine import usable_cores
from hullrecon.artifacts.progress import Progress
from hullrecon.dive.images.store import ImageStore
from hullrecon.errors import InputError
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.undistortion import Undistortion
from hullrecon.new_folder import new_folder
from hullrecon.steps.artifacts import IngestArtifact
from hullrecon.steps.finished_run import finished_steps, workspace_of

if TYPE_CHECKING:
    from hullrecon.adjustment.results.undistorted_model import ImageNames, UndistortedModel

JPEG_QUALITY = 95
# Folders of the model: for COLMAP and OpenMVS, and for trainers of Gaussian splats
SPARSE = ("sparse", "sparse/0")
# folders that COLMAP's stereo fills but does not create
STEREO = ("depth_maps", "normal_maps", "consistency_graphs")
SOURCES = "__auto__, 20"  # COLMAP's default: for each image the 20 that share most points


@dataclass(frozen=True, kw_only=True)
class ExportedModel:
    """What was written, in numbers."""

    folder: Path
    images: int
    points: int
    observations: int
    lost_observations: (
        int  # that lie outside the undistorted images, whose field of view is smaller
    )


@dataclass(frozen=True, kw_only=True)
class ImageWork:
    """One image to resample."""

    store: ImageStore
    row: int  # in the camera's index
    undistortion: Undistortion
    name: str  # of the undistorted image

    def encoded(self) -> bytes:
        """Undistort the image and encode it as JPEG. Raises InputError if it does not decode."""
        import cv2

        image = self.store.read(self.row)
        if image is None:
            raise InputError(
                f"image {self.row} of {self.store.camera} does not decode",
                remedy="run the dive again",
            )
        _, data = cv2.imencode(
            ".jpg",
            cv2.cvtColor(self.undistortion.resample(image), cv2.COLOR_RGB2BGR),
            [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY],
        )
        return data.tobytes()


def export_colmap(
    run: Path | str,
    folder: Path | str,
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> ExportedModel:
    """Write a COLMAP workspace of a finished run (RUNS/<dive>) into a new or empty folder.

    It holds undistorted images, the model with pinhole cameras, and the files that COLMAP's stereo
    needs. The folder appears once all of it is written. `jobs`: worker processes, one a core if
    None.

    Raises
    ------
    InputError
        The run is not finished, has no camera, or its images are gone.
    StorageError
        The folder is not empty or cannot be written.
    """
    from hullrecon.adjustment.results.undistorted_model import undistort_model

    workspace, out = workspace_of(Path(run)), Path(folder)
    finished_steps(workspace, ("ingest", "adjust"))
    delivered = workspace.artifact("adjust") / "colmap"
    if not delivered.is_dir():
        raise InputError(
            "the run has no COLMAP model: no camera was carried", where=str(workspace.root)
        )
    with new_folder(out) as partial:
        model = undistort_model(delivered)
        work = _image_work(IngestArtifact(workspace.artifact("ingest")), workspace.package, model)
        (partial / "images").mkdir()
        with choose_executor(jobs or usable_cores()) as executor:
            encoded = executor.map(ImageWork.encoded, work)
            for item, data in zip(
                work, (progress or Progress()).track(encoded, "images", len(work)), strict=True
            ):
                (partial / "images" / item.name).write_bytes(data)
        for sparse in SPARSE:
            (partial / sparse).mkdir()
            model.reconstruction.write_binary(str(partial / sparse))
        _write_stereo(partial / "stereo", [item.name for item in work])
    return ExportedModel(
        folder=out,
        images=len(work),
        points=model.reconstruction.num_points3D(),
        observations=model.reconstruction.compute_num_observations(),
        lost_observations=model.lost_observations,
    )


def _image_work(
    ingest: IngestArtifact, package: Path | None, model: UndistortedModel
) -> list[ImageWork]:
    """Prepare the resampling of each image of the model, sorted by name."""
    stores = {
        camera.key: ingest.images(camera, package)
        for camera in Camera
        if ingest.image_index(camera) is not None
    }
    return sorted(
        (_work_of(stores, image, model) for image in model.images), key=lambda work: work.name
    )


def _work_of(
    stores: dict[str, ImageStore], image: ImageNames, model: UndistortedModel
) -> ImageWork:
    """Find the logged image behind an image of the model: its camera and stamp are in the name."""
    camera, _, stamp = image.delivered.removesuffix(".jpg").partition("/")
    index = stores[camera].index
    usable = np.flatnonzero(index.usable)
    return ImageWork(
        store=stores[camera],
        row=int(usable[np.searchsorted(index.t_ns[usable], int(stamp))]),
        undistortion=model.undistortions[image.camera_id],
        name=image.undistorted,
    )


def _write_stereo(folder: Path, names: Sequence[str]) -> None:
    """Write the files that COLMAP's patch_match_stereo and stereo_fusion need, and their folders.

    names: of all images.
    """
    for name in STEREO:
        (folder / name).mkdir(parents=True)
    (folder / "patch-match.cfg").write_text("".join(f"{name}\n{SOURCES}\n" for name in names))
    (folder / "fusion.cfg").write_text("".join(f"{name}\n" for name in names))
