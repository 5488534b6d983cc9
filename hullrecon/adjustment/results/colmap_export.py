# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write the adjusted dive as a sparse COLMAP model: rigid rig, frames, images, points with tracks.

The centre of the first pixel lies at (0.5, 0.5) in COLMAP and at (0, 0) in OpenCV, so half a pixel
is added to principal points and observations. The observations of a long dive do not fit into
memory, and are written block by block.
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

TOP, BOTTOM = 1, 2  # camera ids; the rig has id 1. The image of a node has id 2 node + camera id
# COLMAP's binary records: the head of a point and one element of its track, a keypoint of an image
POINT = np.dtype(
    [("id", "<u8"), ("xyz", "<f8", 3), ("rgb", "u1", 3), ("error", "<f8"), ("views", "<u8")]
)
ELEMENT = np.dtype([("image", "<u4"), ("keypoint", "<u4")])
KEYPOINT = np.dtype([("pixel", "<f8", 2), ("point", "<u8")])
IMAGE_BYTES = 4 + 7 * 8 + 4  # id, pose and camera, before the name
Rows = NDArray[np.void]


@dataclass(frozen=True, kw_only=True)
class SparseModel:
    """All that a COLMAP model of the adjusted dive is made of."""

    tracks: Tracks
    top: Mask  # (m,) rows of the tracks whose observation in the top camera entered
    bottom: Mask  # (m,) rows whose observation in the bottom camera entered
    hull_from_top: Poses  # (n,) poses of the top camera at the nodes, in the frame of the results
    top_from_bottom: Poses | None  # None for a single camera
    cameras: tuple[CameraModel, CameraModel | None]  # top and bottom
    stamps: Ints  # (n, 2) ns of the image of each camera at each node, -1 without an image
    position: Array  # (L, 3) m; NaN where a landmark is not in the model


def write_model(model: SparseModel, folder: Path) -> None:
    """Write the model as COLMAP's binary files into an existing folder."""
    _build_without_points(model).write_binary(str(folder))
    views = _write_points(model, folder / "points3D.bin")
    _write_images(model, views, folder / "images.bin")


def _build_without_points(model: SparseModel) -> Any:
    """Build a pycolmap.Reconstruction of cameras, rig, frames and images, without observations."""
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
    """Convert a camera model to COLMAP's, with the principal point moved by half a pixel."""
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
    """Add a frame with its images for each node that has an image.

    An image without observations is kept, as its pose is known.
    """
    import pycolmap

    for node in np.flatnonzero((model.stamps >= 0).any(1)):
        # Of each image its id, its camera's id, and its stamp
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
class _Observations:
    """Observations (k,) of a block of landmarks, sorted by (landmark, image)."""

    landmark: Ints  # number in the dive's tracks
    image: Ints  # id in the model
    keypoint: Ints  # number within the image
    row: Ints  # row of `tracks`
    tracks: Tracks  # of the block

    def of_camera(self, top: Array, bottom: Array) -> Array:
        """Select for each observation the value of its camera.

        top, bottom (m, ...): values of the rows of `tracks` for each camera.
        """
        is_top = (self.image % 2 == TOP % 2).reshape(-1, *[1] * (top.ndim - 1))
        return np.where(is_top, top[self.row], bottom[self.row])


def _read_observations(model: SparseModel) -> Iterator[_Observations]:
    """Read the observations of the model's landmarks in blocks.

    Keypoints of an image are numbered in the order in which they are read. Every pass over the
    observations therefore gives the same numbers.
    """
    # Keypoints of each image, by id, in the blocks before
    counted = np.zeros(2 * len(model.stamps) + BOTTOM, np.int64)
    for block in read_tracks(model.tracks, np.isfinite(model.position[:, 0])):
        tracks = block.tracks
        top, below = (np.flatnonzero(use[block.rows]) for use in (model.top, model.bottom))
        image = np.r_[2 * tracks.node[top] + TOP, 2 * tracks.node[below] + BOTTOM]
        row = np.r_[top, below]
        landmark = tracks.landmark[row]
        order = np.lexsort((image, landmark))
        # Rank of each observation within its image in this block, after those of earlier blocks
        keypoint = np.empty(len(order), np.int64)
        by_image = order[np.argsort(image[order], kind="stable")]
        count = np.bincount(image, minlength=len(counted))
        first = np.cumsum(count) - count
        keypoint[by_image] = np.arange(len(order)) - (first - counted)[image[by_image]]
        counted += count
        yield _Observations(landmark[order], image[order], keypoint[order], row[order], tracks)


@dataclass(frozen=True)
class _Cameras:
    """The cameras as `reprojection_errors` takes them."""

    top: CameraModel
    bottom: CameraModel | None


def _write_points(model: SparseModel, path: Path) -> Ints:
    """Write points3D.bin: for each point a POINT, then its track, an ELEMENT for each observation.

    Returns the number of observations of each image, by its id.
    """
    bottom = None
    if model.top_from_bottom is not None:
        bottom = model.hull_from_top @ model.top_from_bottom
    cameras = _Cameras(*model.cameras)
    written, of_image = 0, np.zeros(2 * len(model.stamps) + BOTTOM, np.int64)
    with path.open("wb") as file:
        file.write(struct.pack("<Q", 0))  # number of points, which is written at the end
        for seen in _read_observations(model):
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
    """Make the bytes of heads, each followed by its entries.

    Parameters
    ----------
    heads
        (n,) records.
    entries
        Records of all heads, in the order of the heads.
    count
        (n,) number of entries of each head.
    """
    head, entry = heads.dtype.itemsize, entries.dtype.itemsize
    length = head + entry * count
    begin = np.cumsum(length) - length  # first byte of each head
    out = np.empty(int(length.sum()), np.uint8)
    out[begin[:, None] + np.arange(head)] = heads.view(np.uint8).reshape(-1, head)
    # Rank of each entry among those of its head
    rank = np.arange(len(entries)) - np.repeat(np.cumsum(count) - count, count)
    at = np.repeat(begin + head, count) + entry * rank
    out[at[:, None] + np.arange(entry)] = entries.view(np.uint8).reshape(-1, entry)
    return out.tobytes()


def _write_images(model: SparseModel, views: Ints, path: Path) -> None:
    """Insert the observations into an images.bin without any.

    The file is first laid out with room for them. Then each block of observations is written to its
    positions, through a memory map.

    views: number of observations of each image, by id.
    """
    given = path.read_bytes()
    begin = np.zeros(len(views), np.int64)  # position in the file of each image's observations
    with path.open("wb") as file:
        at = file.write(given[:8])
        for image_id, head in _images(given):
            at += file.write(head + struct.pack("<Q", views[image_id]))
            begin[image_id], at = at, at + int(views[image_id]) * KEYPOINT.itemsize
            file.seek(at)
        file.truncate(at)
    for seen in _read_observations(model):
        keypoints = np.zeros(len(seen.image), KEYPOINT)
        keypoints["pixel"] = seen.of_camera(seen.tracks.top, seen.tracks.bottom) + 0.5
        keypoints["point"] = seen.landmark + 1
        # The landmarks of a block are seen from few images. Closing the map frees their pages.
        pages = np.memmap(path, np.uint8, "r+")
        to = begin[seen.image] + KEYPOINT.itemsize * seen.keypoint
        pages[to[:, None] + np.arange(KEYPOINT.itemsize)] = keypoints.view(np.uint8).reshape(
            -1, KEYPOINT.itemsize
        )
        del pages


def _images(given: bytes) -> Iterator[tuple[int, bytes]]:
    """Read the images of an images.bin without observations.

    Yields each image's id, and the bytes of its record up to the number of observations.
    """
    (count,) = struct.unpack_from("<Q", given)
    at = 8
    for _ in range(count):
        (image_id,) = struct.unpack_from("<I", given, at)
        end = given.index(b"\0", at + IMAGE_BYTES) + 1
        yield image_id, given[at:end]
        at = end + 8  # behind the number of observations, which is zero
