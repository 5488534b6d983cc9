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
from hullrecon.report.survey import ImageSource
from hullrecon.rig import SensorRig
from hullrecon.typing import Array, Ints, Pixels


@dataclass(frozen=True, kw_only=True)
class Crop:
    """A part of one image: data URI, size and outline (n, 2) in its pixels, pixels per metre there, and where it is from."""

    data: str
    width: int
    height: int
    outline: Array
    pixels_per_m: float
    camera: Camera
    row: int
    t_ns: int


@dataclass(frozen=True, kw_only=True)
class ObjectView:
    """One image of a camera at a node of the track: camera_from_result T_c_M (T_c_g without a CAD model), the image's row."""

    camera: Camera
    model: CameraModel
    camera_from_result: Poses
    row: int


def best_crop(found: ReportedObject, track: VehicleTrack, rig: SensorRig, images: Mapping[Camera, ImageSource]) -> Crop | None:
    """Return the picture of an object; None when no image shows it.

    The view is that among the object's images (all, when it names none) whose middle lies nearest to the object's centre.
    """
    views = [view for camera, source in images.items() for view in _ranked_views(found, track, rig, camera, source.index)]
    for _, view in sorted(views, key=lambda item: item[0])[:5]:
        crop = _cut_image(found, view, images[view.camera])
        if crop is not None:
            return crop
    return None


def _ranked_views(
    found: ReportedObject, track: VehicleTrack, rig: SensorRig, camera: Camera, index: ImageIndex
) -> list[tuple[float, ObjectView]]:
    """Return views that have the centre inside the image, with its distance from the middle in half diagonals."""
    rows = track.image[:, camera.column]
    wanted = _rows_named(found.images, camera, index)
    nodes = np.flatnonzero((rows >= 0) & (np.isin(rows, wanted) if wanted is not None else True))
    if not len(nodes):
        return []
    model = rig.camera_models[camera]
    camera_from_result = rig.camera_poses(track.path[nodes], camera).inverse()
    pixel = model.project(camera_from_result.apply(np.tile(np.array(found.center), (len(nodes), 1))))
    size = np.array([model.width, model.height])
    inside = np.all((pixel > 0) & (pixel < size), axis=1)
    score = np.linalg.norm(pixel - size / 2, axis=1) / np.linalg.norm(size / 2)
    return [
        (
            float(score[k]),
            ObjectView(camera=camera, model=model, camera_from_result=camera_from_result[[k]], row=int(rows[nodes[k]])),
        )
        for k in np.flatnonzero(inside)
    ]


def _rows_named(images: Sequence[str], camera: Camera, index: ImageIndex) -> Ints | None:
    """Return rows of the camera's index for names like camera_top/1777887000468241234.jpg; None when no image is named."""
    if not images:
        return None
    stamps = [int(name.split("/")[1].split(".")[0]) for name in images if name.startswith(camera.key + "/")]
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
        data=jpeg_uri(stretch_contrast(cut)),
        width=cut.shape[1],
        height=cut.shape[0],
        outline=pixels - low,
        pixels_per_m=scale,
        camera=view.camera,
        row=view.row,
        t_ns=int(source.index.t_ns[view.row]),
    )


def stretch_contrast(picture: Pixels) -> Pixels:
    """Return the picture with its contrast stretched between the 1st and 99th percentile: underwater
    pictures use a third of the range."""
    low, high = np.percentile(picture, (1, 99))
    return np.asarray(np.clip((picture - low) * (245 / max(high - low, 20)) + 5, 0, 255), np.uint8)


def jpeg_uri(picture: Pixels, min_width: int = 560, quality: int = 88) -> str:
    """Return a data URI; small cuts are enlarged so that a browser's smoothing does not blur them."""
    import cv2

    factor = max(1.0, min_width / picture.shape[1])
    if factor > 1:
        picture = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
    ordered = picture[..., ::-1] if picture.ndim == 3 else picture
    done, data = cv2.imencode(".jpg", np.ascontiguousarray(ordered), [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise ValueError("the picture could not be encoded")
    return "data:image/jpeg;base64," + b64encode(data.tobytes()).decode()
