# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The adjusted dive as a sparse COLMAP model: a rigid rig, frames, images, points with tracks.

COLMAP's pixel centres lie at 0.5, 0.5, OpenCV's at 0, 0: half a pixel is added to principal points
and observations.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.records.tracks import Tracks
from hullrecon.typing import Array, Ints, Ints32, Mask

TOP, BOTTOM = 1, 2  # camera ids; the rig has id 1


@dataclass(frozen=True, kw_only=True)
class SparseModel:
    """The adjusted dive as COLMAP takes it."""

    tracks: Tracks
    top: Mask  # (m,) observations of the tracks that entered, of the top camera
    bottom: Mask  # (m,) and of the bottom camera
    hull_from_top: Poses  # (n,) poses of the top camera at the nodes, in the frame of the results
    top_from_bottom: Poses | None  # None for a single camera
    cameras: tuple[CameraModel, CameraModel | None]  # top and bottom
    stamps: Ints  # (n, 2) ns by camera, -1 for none
    position: Array  # (L, 3) m; NaN where a landmark is not in the model


def write_model(model: SparseModel, folder: Path) -> None:
    """Write the model as binary files of COLMAP into an existing folder."""
    reconstruction = build(model)
    reconstruction.write_binary(str(folder))


def build(model: SparseModel) -> Any:
    """Build a pycolmap.Reconstruction."""
    import pycolmap

    reconstruction = pycolmap.Reconstruction()
    _add_rig(reconstruction, model)
    observations = _observations(model)
    _add_images(reconstruction, model, observations)
    _add_points(reconstruction, model, observations)
    reconstruction.update_point_3d_errors()
    return reconstruction


def _rigid(pose: Poses) -> Any:
    import pycolmap

    return pycolmap.Rigid3d(pycolmap.Rotation3d(pose.quaternion[0]), pose.translation[0])


def _add_rig(reconstruction: Any, model: SparseModel) -> None:
    import pycolmap

    rig = pycolmap.Rig(rig_id=1)
    for number, camera in zip((TOP, BOTTOM), model.cameras, strict=True):
        if camera is None or (number == BOTTOM and model.top_from_bottom is None):
            continue
        reconstruction.add_camera(_camera(number, camera))
        sensor = pycolmap.sensor_t(pycolmap.SensorType.CAMERA, number)
        if number == TOP:
            rig.add_ref_sensor(sensor)
        else:
            assert model.top_from_bottom is not None
            rig.add_sensor(sensor, _rigid(model.top_from_bottom.inverse()))
    reconstruction.add_rig(rig)


def _camera(number: int, camera: CameraModel) -> Any:
    import pycolmap

    values = camera.parameters()
    values[2:4] += 0.5
    name, params = "OPENCV", values[:8]
    if camera.k3 != 0.0:
        name, params = "FULL_OPENCV", np.r_[values[:8], values[8], 0, 0, 0]
    return pycolmap.Camera(
        camera_id=number, model=name, width=camera.width, height=camera.height, params=params
    )


@dataclass(frozen=True)
class _Seen:
    """Observations, sorted by (image, landmark)."""

    image: Ints32  # id
    row: Ints32  # of the tracks
    keypoint: Ints32  # number within the image


def _observations(model: SparseModel) -> _Seen:
    tracks, known = model.tracks, np.isfinite(model.position[:, 0])
    top, bottom = (
        np.flatnonzero(use & known[tracks.landmark]).astype(np.int32)
        for use in (model.top, model.bottom)
    )
    image = np.r_[2 * tracks.node[top] + TOP, 2 * tracks.node[bottom] + BOTTOM].astype(np.int32)
    order = np.argsort(image, kind="stable")  # tracks are sorted by landmark
    image, row = image[order], np.r_[top, bottom][order]
    first = np.r_[0, np.flatnonzero(np.diff(image)) + 1] if len(image) else np.zeros(0, int)
    start = np.repeat(first.astype(np.int32), np.diff(np.r_[first, len(image)]))
    return _Seen(image, row, np.arange(len(image), dtype=np.int32) - start)


def _add_images(reconstruction: Any, model: SparseModel, seen: _Seen) -> None:
    """Add a frame for each node that has an image.

    An image without observations is kept: its pose is known all the same.
    """
    import pycolmap

    for node in np.flatnonzero((model.stamps >= 0).any(1)):
        ids = [
            (2 * int(node) + k, k, int(model.stamps[node, k - 1]))
            for k in (TOP, BOTTOM)
            if model.stamps[node, k - 1] >= 0
        ]
        ids = [entry for entry in ids if reconstruction.exists_camera(entry[1])]
        frame = pycolmap.Frame(frame_id=int(node) + 1, rig_id=1)
        for image_id, camera_id, _ in ids:
            frame.add_data_id(
                pycolmap.data_t(pycolmap.sensor_t(pycolmap.SensorType.CAMERA, camera_id), image_id)
            )
        frame.rig_from_world = _rigid(model.hull_from_top[int(node)].inverse())
        reconstruction.add_frame(frame)
        for image_id, camera_id, stamp in ids:
            rows = slice(*np.searchsorted(seen.image, [image_id, image_id + 1]))
            name = f"{(Camera.TOP if camera_id == TOP else Camera.BOTTOM).key}/{stamp}.jpg"
            pixels = model.tracks.top if camera_id == TOP else model.tracks.bottom
            image = pycolmap.Image(
                name=name,
                keypoints=pixels[seen.row[rows]] + 0.5,
                camera_id=camera_id,
                image_id=image_id,
            )
            image.frame_id = int(node) + 1
            reconstruction.add_image(image)
        reconstruction.register_frame(int(node) + 1)


def _add_points(reconstruction: Any, model: SparseModel, seen: _Seen) -> None:
    import pycolmap

    landmark = model.tracks.landmark[seen.row].astype(np.int32)
    order = np.lexsort((seen.image, landmark))
    landmark, image, keypoint = landmark[order], seen.image[order], seen.keypoint[order]
    edges = np.r_[0, np.flatnonzero(np.diff(landmark)) + 1, len(landmark)].tolist()
    for low, high in pairwise(edges):
        number = int(landmark[low])
        elements = [
            pycolmap.TrackElement(i, p)
            for i, p in zip(image[low:high].tolist(), keypoint[low:high].tolist(), strict=True)
        ]
        point = pycolmap.Point3D(
            xyz=model.position[number],
            color=model.tracks.color[number],
            track=pycolmap.Track(elements=elements),
        )
        reconstruction.add_point3D_with_id(number + 1, point)
