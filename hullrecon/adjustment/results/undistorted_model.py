# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make a sparse COLMAP model with pinhole cameras, for images whose distortion is removed.

Programs for multi-view stereo and Gaussian splatting take such a model.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.undistortion import Undistortion, undistortion
from hullrecon.typing import Array, Ints

if TYPE_CHECKING:
    import pycolmap

Reconstruction: TypeAlias = Any  # pycolmap's: it has no types


@dataclass(frozen=True, kw_only=True)
class ImageNames:
    """Names of an image in the delivered and in the undistorted model."""

    delivered: str
    # Without a folder, as programs that train Gaussian splats drop folders from names
    undistorted: str
    camera_id: int


@dataclass(frozen=True, kw_only=True)
class UndistortedModel:
    """A pinhole model with the maps that undistort its images."""

    reconstruction: Reconstruction
    undistortions: dict[int, Undistortion]  # by camera id
    images: list[ImageNames]  # in the order of their frames
    lost_observations: int  # of the delivered model, which lie outside the undistorted images


@dataclass(frozen=True)
class _Observations:
    """Observations (n,), sorted by image."""

    image: Ints  # id
    point: Ints  # id
    # (n, 2) px in the undistorted image, in COLMAP's convention (first pixel's centre at 0.5, 0.5)
    pixel: Array


def undistort_model(folder: Path) -> UndistortedModel:
    """Undistort the COLMAP model of a folder.

    Poses and points are kept. Observations outside the undistorted images are dropped, and then
    points with fewer than two observations. Raises InputError where a camera's distortion cannot be
    inverted.
    """
    import pycolmap

    delivered = pycolmap.Reconstruction(str(folder))
    undistortions = {
        number: undistortion(camera_of(camera)) for number, camera in delivered.cameras.items()
    }
    reconstruction = pycolmap.Reconstruction()
    for number, found in undistortions.items():
        pinhole = found.pinhole
        # The first pixel's centre lies at (0.5, 0.5) in COLMAP, at (0, 0) in the camera model
        params = [pinhole.fx, pinhole.fy, pinhole.cx + 0.5, pinhole.cy + 0.5]
        reconstruction.add_camera(
            pycolmap.Camera(
                camera_id=number,
                model="PINHOLE",
                width=pinhole.width,
                height=pinhole.height,
                params=params,
            )
        )
    for rig in delivered.rigs.values():
        reconstruction.add_rig(rig)
    seen = _undistort_observations(delivered, undistortions)
    images = _add_images(reconstruction, delivered, seen)
    _add_points(reconstruction, delivered, seen)
    reconstruction.update_point_3d_errors()
    lost = delivered.compute_num_observations() - len(seen.image)
    return UndistortedModel(
        reconstruction=reconstruction,
        undistortions=undistortions,
        images=images,
        lost_observations=lost,
    )


def camera_of(camera: pycolmap.Camera) -> CameraModel:
    """Convert a COLMAP camera, OPENCV or FULL_OPENCV, to a camera model.

    The principal point is moved by half a pixel, as OpenCV's first pixel has its centre at (0, 0).
    """
    values = np.array(camera.params)
    values[2:4] -= 0.5
    return CameraModel(
        camera.width,
        camera.height,
        *values[: 9 if camera.model.name == "FULL_OPENCV" else 8].tolist(),
    )


def _undistort_observations(
    delivered: Reconstruction, undistortions: dict[int, Undistortion]
) -> _Observations:
    """Compute the observations in the undistorted images.

    Observations that fall outside of an undistorted image are left out, and then those of points
    with fewer than two left.
    """
    parts: list[tuple[Ints, Ints, Array]] = []
    for number in sorted(delivered.images):
        image = delivered.images[number]
        found = [p for p in image.points2D if p.has_point3D()]
        pixel = np.array([p.xy for p in found]).reshape(-1, 2) - 0.5
        undistorted = undistortions[image.camera_id].pixels(pixel)
        inside = undistortions[image.camera_id].holds(undistorted)
        point = np.array([p.point3D_id for p in found], np.int64)[inside]
        parts.append((np.full(len(point), number), point, undistorted[inside] + 0.5))
    image_id, point, pixel = (np.concatenate([part[k] for part in parts]) for k in range(3))
    _, which, count = np.unique(point, return_inverse=True, return_counts=True)
    kept = count[which] >= 2
    return _Observations(image_id[kept], point[kept], pixel[kept])


def _add_images(
    reconstruction: Reconstruction, delivered: Reconstruction, seen: _Observations
) -> list[ImageNames]:
    """Add the delivered frames and images with their keypoints, and list the images' names.

    A frame is what both cameras took at one node. Its pose is that of the delivered model.
    """
    import pycolmap

    names = []
    for frame_id in sorted(delivered.frames):
        old = delivered.frames[frame_id]
        frame = pycolmap.Frame(frame_id=frame_id, rig_id=old.rig_id)
        ids = sorted(data.id for data in old.image_ids)
        for number in ids:
            sensor = pycolmap.sensor_t(
                pycolmap.SensorType.CAMERA, delivered.images[number].camera_id
            )
            frame.add_data_id(pycolmap.data_t(sensor, number))
        frame.rig_from_world = old.rig_from_world
        reconstruction.add_frame(frame)
        for number in ids:
            image = delivered.images[number]
            name = ImageNames(
                delivered=image.name,
                undistorted=image.name.replace("/", "_"),
                camera_id=image.camera_id,
            )
            # Observations are sorted by image
            rows = slice(*np.searchsorted(seen.image, [number, number + 1]))
            added = pycolmap.Image(
                name=name.undistorted,
                keypoints=seen.pixel[rows],
                camera_id=image.camera_id,
                image_id=number,
            )
            added.frame_id = frame_id
            reconstruction.add_image(added)
            names.append(name)
        reconstruction.register_frame(frame_id)
    return names


def _add_points(
    reconstruction: Reconstruction, delivered: Reconstruction, seen: _Observations
) -> None:
    """Add the delivered points, with tracks of the observations that were kept.

    Keypoints are numbered within their image, in the order in which `_add_images` adds them.
    """
    import pycolmap

    # Number of each observation within its image
    first = np.r_[True, np.diff(seen.image) > 0] if len(seen.image) else np.zeros(0, bool)
    start = np.maximum.accumulate(np.where(first, np.arange(len(first)), 0))
    keypoint = np.arange(len(first)) - start
    # Observations ordered by point
    order = np.lexsort((seen.image, seen.point))
    point, image, number = seen.point[order], seen.image[order].tolist(), keypoint[order].tolist()
    edges = np.r_[0, np.flatnonzero(np.diff(point)) + 1, len(point)].tolist()
    for low, high in pairwise(edges if len(point) else []):
        old = delivered.points3D[int(point[low])]
        elements = [
            pycolmap.TrackElement(i, k)
            for i, k in zip(image[low:high], number[low:high], strict=True)
        ]
        added = pycolmap.Point3D(
            xyz=old.xyz, color=old.color, track=pycolmap.Track(elements=elements)
        )
        reconstruction.add_point3D_with_id(int(point[low]), added)
