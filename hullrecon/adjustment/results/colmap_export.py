# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The adjusted dive as a sparse COLMAP model: a rigid rig, frames, images, points with tracks.

COLMAP's pixel centres lie at 0.5, 0.5, OpenCV's at 0, 0: half a pixel is added to principal points
and observations. Those of a long dive do not fit into memory: they are written block by block.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.adjustment.problem.observations import read_tracks
from hullrecon.adjustment.problem.triangulation import reprojection_errors
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.records.tracks import Tracks
from hullrecon.typing import Array, Ints, Mask

TOP, BOTTOM = 1, 2  # camera ids; the rig has id 1
# COLMAP's binary records
POINT = np.dtype(
    [("id", "<u8"), ("xyz", "<f8", 3), ("rgb", "u1", 3), ("error", "<f8"), ("views", "<u8")]
)
ELEMENT = np.dtype([("image", "<u4"), ("keypoint", "<u4")])
KEYPOINT = np.dtype([("pixel", "<f8", 2), ("point", "<u8")])
IMAGE_BYTES = 4 + 7 * 8 + 4  # id, pose and camera, before the name
Rows = NDArray[np.void]


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
    _build(model).write_binary(str(folder))
    views = _write_points(model, folder / "points3D.bin")
    _write_images(model, views, folder / "images.bin")


def _build(model: SparseModel) -> Any:
    """Build a pycolmap.Reconstruction without observations."""
    import pycolmap

    reconstruction = pycolmap.Reconstruction()
    _add_rig(reconstruction, model)
    _add_images(reconstruction, model)
    return reconstruction


def _rigid(pose: Poses) -> Any:
    import pycolmap

    return pycolmap.Rigid3d(pycolmap.Rotation3d(pose.quaternion[0]), pose.translation[0])


def _add_rig(reconstruction: Any, model: SparseModel) -> None:
    """Add the cameras, and the rig in which the top camera is the reference."""
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
    """Convert a camera to COLMAP's, whose pixel centres lie at 0.5, 0.5."""
    import pycolmap

    values = camera.parameters()
    values[2:4] += 0.5
    name, params = "OPENCV", values[:8]
    if camera.k3 != 0.0:
        name, params = "FULL_OPENCV", np.r_[values[:8], values[8], 0, 0, 0]
    return pycolmap.Camera(
        camera_id=number, model=name, width=camera.width, height=camera.height, params=params
    )


def _add_images(reconstruction: Any, model: SparseModel) -> None:
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
            name = f"{(Camera.TOP if camera_id == TOP else Camera.BOTTOM).key}/{stamp}.jpg"
            image = pycolmap.Image(name=name, camera_id=camera_id, image_id=image_id)
            image.frame_id = int(node) + 1
            reconstruction.add_image(image)
        reconstruction.register_frame(int(node) + 1)


@dataclass(frozen=True)
class _Seen:
    """Observations (n,) of a block of landmarks, sorted by (landmark, image)."""

    landmark: Ints
    image: Ints  # id
    keypoint: Ints  # number within the image
    row: Ints  # of the block's tracks
    tracks: Tracks  # of the block

    def of_camera(self, top: Array, bottom: Array) -> Array:
        """Select values by the camera that sees, from those of the block's rows in either."""
        is_top = (self.image % 2 == TOP % 2).reshape(-1, *[1] * (top.ndim - 1))
        return np.where(is_top, top[self.row], bottom[self.row])


def _read_seen(model: SparseModel) -> Iterator[_Seen]:
    """Read the observations of the model's landmarks, those of an image numbered as they come."""
    counted = np.zeros(2 * len(model.stamps) + BOTTOM, np.int64)
    for block in read_tracks(model.tracks, np.isfinite(model.position[:, 0])):
        tracks = block.tracks
        top, below = (np.flatnonzero(use[block.rows]) for use in (model.top, model.bottom))
        image = np.r_[2 * tracks.node[top] + TOP, 2 * tracks.node[below] + BOTTOM]
        row = np.r_[top, below]
        landmark = tracks.landmark[row]
        order = np.lexsort((image, landmark))
        keypoint = np.empty(len(order), np.int64)
        by_image = order[np.argsort(image[order], kind="stable")]
        count = np.bincount(image, minlength=len(counted))
        first = np.cumsum(count) - count
        keypoint[by_image] = np.arange(len(order)) - (first - counted)[image[by_image]]
        counted += count
        yield _Seen(landmark[order], image[order], keypoint[order], row[order], tracks)


@dataclass(frozen=True)
class _Cameras:
    """The cameras as `reprojection_errors` takes them."""

    top: CameraModel
    bottom: CameraModel | None


def _write_points(model: SparseModel, path: Path) -> Ints:
    """Write points3D.bin: of each point what POINT says, then its track as ELEMENT.

    Returns the observations of each image, by id.
    """
    bottom = None
    if model.top_from_bottom is not None:
        bottom = model.hull_from_top @ model.top_from_bottom
    cameras = _Cameras(*model.cameras)
    written, of_image = 0, np.zeros(2 * len(model.stamps) + BOTTOM, np.int64)
    with path.open("wb") as file:
        file.write(struct.pack("<Q", 0))
        for seen in _read_seen(model):
            number, first, views = np.unique(seen.landmark, return_index=True, return_counts=True)
            errors = reprojection_errors(
                seen.tracks, model.position, model.hull_from_top, bottom, cameras
            )
            points = np.zeros(len(number), POINT)
            points["id"], points["xyz"] = number + 1, model.position[number]
            points["rgb"], points["views"] = model.tracks.color[number], views
            points["error"] = (
                np.add.reduceat(seen.of_camera(*errors), first) / views if len(first) else 0
            )
            elements = np.zeros(len(seen.landmark), ELEMENT)
            elements["image"], elements["keypoint"] = seen.image, seen.keypoint
            file.write(_interleave(points, elements, views))
            written += len(number)
            of_image += np.bincount(seen.image, minlength=len(of_image))
        file.seek(0)
        file.write(struct.pack("<Q", written))
    return of_image


def _interleave(heads: Rows, entries: Rows, count: Ints) -> bytes:
    """Join each head with its entries, so many of them."""
    head, entry = heads.dtype.itemsize, entries.dtype.itemsize
    length = head + entry * count
    begin = np.cumsum(length) - length
    out = np.empty(int(length.sum()), np.uint8)
    out[begin[:, None] + np.arange(head)] = heads.view(np.uint8).reshape(-1, head)
    rank = np.arange(len(entries)) - np.repeat(np.cumsum(count) - count, count)
    at = np.repeat(begin + head, count) + entry * rank
    out[at[:, None] + np.arange(entry)] = entries.view(np.uint8).reshape(-1, entry)
    return out.tobytes()


def _write_images(model: SparseModel, views: Ints, path: Path) -> None:
    """Put the observations, so many of each image, into images.bin, which has none yet."""
    given = path.read_bytes()
    begin = np.zeros(len(views), np.int64)  # of the observations of each image
    with path.open("wb") as file:
        at = file.write(given[:8])
        for image_id, head in _images(given):
            at += file.write(head + struct.pack("<Q", views[image_id]))
            begin[image_id], at = at, at + int(views[image_id]) * KEYPOINT.itemsize
            file.seek(at)
        file.truncate(at)
    for seen in _read_seen(model):
        keypoints = np.zeros(len(seen.image), KEYPOINT)
        keypoints["pixel"] = seen.of_camera(seen.tracks.top, seen.tracks.bottom) + 0.5
        keypoints["point"] = seen.landmark + 1
        # A block's landmarks are seen from few images: their pages go when it is written.
        pages = np.memmap(path, np.uint8, "r+")
        to = begin[seen.image] + KEYPOINT.itemsize * seen.keypoint
        pages[to[:, None] + np.arange(KEYPOINT.itemsize)] = keypoints.view(np.uint8).reshape(
            -1, KEYPOINT.itemsize
        )
        del pages


def _images(given: bytes) -> Iterator[tuple[int, bytes]]:
    """Go through an images.bin without observations: id, and all that stands before their count."""
    (count,) = struct.unpack_from("<Q", given)
    at = 8
    for _ in range(count):
        (image_id,) = struct.unpack_from("<I", given, at)
        end = given.index(b"\0", at + IMAGE_BYTES) + 1
        yield image_id, given[at:end]
        at = end + 8
