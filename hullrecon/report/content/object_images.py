# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The picture of an object: the best view among its images, cropped, with its outline."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.sensors import ImageIndex
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.report.survey import ImageSource, Survey
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Pixels


@dataclass(frozen=True, kw_only=True)
class Crop:
    """A part of one image with its contrast stretched: picture (h, w, 3) RGB, outline (n, 2) in its
    pixels, pixels per metre there, and where it is from.
    """

    picture: Pixels
    outline: Array
    pixels_per_m: float
    camera: Camera
    row: int
    t_ns: int

    @property
    def width(self) -> int:
        """Return the picture's width, px."""
        return int(self.picture.shape[1])

    @property
    def height(self) -> int:
        """Return the picture's height, px."""
        return int(self.picture.shape[0])

    @property
    def data(self) -> str:
        """Return the picture as a data URI."""
        return jpeg_uri(self.picture)


def object_crops(survey: Survey) -> dict[int, Crop]:
    """Return the picture of each object by its number; objects that no image shows have none."""
    found = {
        o.id: best_crop(o, survey.track, survey.facts.rig, survey.facts.images)
        for o in survey.findings.objects or ()
    }
    return {number: crop for number, crop in found.items() if crop is not None}


def photo_jpeg(crop: Crop, min_width: int = 800) -> bytes:
    """Return an object's picture as a file: enlarged, with its outline drawn in."""
    import cv2

    factor = _enlargement(crop.width, crop.height, min_width)
    size = (round(factor * crop.width), round(factor * crop.height))
    picture = np.ascontiguousarray(cv2.resize(crop.picture, size, interpolation=cv2.INTER_CUBIC))
    # in sixteenths of a pixel
    line = np.rint(16 * (factor * (crop.outline + 0.5) - 0.5)).astype(np.int32)
    for color, width in (((0, 0, 0), 5), ((255, 255, 255), 2)):
        cv2.polylines(
            picture,
            [line[:, None]],
            isClosed=True,
            color=color,
            thickness=width,
            lineType=cv2.LINE_AA,
            shift=4,
        )
    return _jpeg(np.asarray(picture, np.uint8), 90)


@dataclass(frozen=True, kw_only=True)
class ObjectView:
    """One image of a camera at a node of the track: camera_from_result T_c_M (T_c_g without a CAD
    model), the image's row.
    """

    camera: Camera
    model: CameraModel
    camera_from_result: Poses
    row: int


def best_crop(
    found: ReportedObject, track: VehicleTrack, rig: Rig, images: Mapping[Camera, ImageSource]
) -> Crop | None:
    """Return the picture of an object; None when no image shows it.

    The view is that among the object's images (all, when it names none) whose middle lies nearest
    to the object's centre.
    """
    views = [
        view
        for camera, source in images.items()
        for view in _ranked_views(found, track, rig, camera, source.index)
    ]
    for _, view in sorted(views, key=lambda item: item[0])[:5]:
        crop = _cut_image(found, view, images[view.camera])
        if crop is not None:
            return crop
    return None


def _ranked_views(
    found: ReportedObject, track: VehicleTrack, rig: Rig, camera: Camera, index: ImageIndex
) -> list[tuple[float, ObjectView]]:
    """Return views that have the centre inside the image, with its distance from the middle in half
    diagonals.
    """
    rows = track.image[:, camera.column]
    wanted = _rows_named(found.images, camera, index)
    nodes = np.flatnonzero((rows >= 0) & (np.isin(rows, wanted) if wanted is not None else True))
    if not len(nodes):
        return []
    model = rig.camera_models[camera]
    camera_from_result = rig.poses_along(track.path[nodes], camera).inverse()
    pixel = model.project(
        camera_from_result.apply(np.tile(np.array(found.center), (len(nodes), 1)))
    )
    size = np.array([model.width, model.height])
    inside = np.all((pixel > 0) & (pixel < size), axis=1)
    score = np.linalg.norm(pixel - size / 2, axis=1) / np.linalg.norm(size / 2)
    return [
        (
            float(score[k]),
            ObjectView(
                camera=camera,
                model=model,
                camera_from_result=camera_from_result[[k]],
                row=int(rows[nodes[k]]),
            ),
        )
        for k in np.flatnonzero(inside)
    ]


def _rows_named(images: Sequence[str], camera: Camera, index: ImageIndex) -> Ints | None:
    """Return rows of the camera's index for names like camera_top/1777887000468241234.jpg; None
    when no image is named.
    """
    if not images:
        return None
    stamps = [
        int(name.split("/")[1].split(".")[0])
        for name in images
        if name.startswith(camera.key + "/")
    ]
    return np.flatnonzero(np.isin(index.t_ns, stamps))


def _cut_image(found: ReportedObject, view: ObjectView, source: ImageSource) -> Crop | None:
    """Return the part of an image around the object; None where the image cannot be read."""
    picture = source.read(view.row) if source.index.usable[view.row] else None
    if picture is None:
        return None
    center, outline = np.array([found.center]), np.array(found.outline or [found.center], float)
    pixels = view.model.project(view.camera_from_result.apply(outline))
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    in_camera = view.camera_from_result.apply(center)
    middle = view.model.project(in_camera)[0]
    scale = view.model.fx / float(np.linalg.norm(in_camera[0]))
    half = max(0.9 * float(np.abs(pixels - middle).max(initial=0)) + 0.12 * scale, 0.18 * scale)
    reach, size = np.array([1.35 * half, half]), np.array([view.model.width, view.model.height])
    low = np.clip(np.floor(middle - reach), 0, size - 2).astype(int)
    high = np.clip(np.ceil(middle + reach), low + 2, size).astype(int)
    cut = picture[low[1] : high[1], low[0] : high[0]]
    return Crop(
        picture=stretch_contrast(cut),
        outline=pixels - low,
        pixels_per_m=scale,
        camera=view.camera,
        row=view.row,
        t_ns=int(source.index.t_ns[view.row]),
    )


def stretch_contrast(picture: Pixels) -> Pixels:
    """Return the picture with its contrast stretched between the 1st and 99th percentile:
    underwater pictures use a third of the range.
    """
    low, high = np.percentile(picture, (1, 99))
    return np.asarray(np.clip((picture - low) * (245 / max(high - low, 20)) + 5, 0, 255), np.uint8)


def jpeg_uri(picture: Pixels, min_width: int = 560, quality: int = 88) -> str:
    """Return a data URI; small cuts are enlarged so that a browser's smoothing does not blur them."""
    import cv2

    factor = _enlargement(picture.shape[1], picture.shape[0], min_width)
    if factor > 1:
        picture = np.asarray(
            cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC), np.uint8
        )
    return (
        "data:image/jpeg;base64,"
        + b64encode(_jpeg(np.asarray(picture, np.uint8), quality)).decode()
    )


def _enlargement(width: int, height: int, min_width: int) -> float:
    """Factor, at least 1, that widens a picture to min_width and keeps its height below four times
    that: an object at an image's border leaves a sliver.
    """
    return max(1.0, min(min_width / width, 4 * min_width / height))


def _jpeg(picture: Pixels, quality: int) -> bytes:
    import cv2

    ordered = picture[..., ::-1] if picture.ndim == 3 else picture
    done, data = cv2.imencode(
        ".jpg", np.ascontiguousarray(ordered), [cv2.IMWRITE_JPEG_QUALITY, quality]
    )
    if not done:
        raise ValueError("the picture could not be encoded")
    return bytes(data.tobytes())
