# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The picture of an object: the best view among its images, cropped, with its outline."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.poses import Poses, tray_poses
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.report.content.survey import Eye
from hullrecon.typing import Array, Ints


@dataclass(frozen=True)
class Crop:
    """A cut of one image: data URI, size and outline (n, 2) in its pixels, pixels per metre there, and where it is from."""

    data: str
    width: int
    height: int
    outline: Array
    pixels_per_m: float
    camera: str
    row: int
    t_ns: int


def camera_poses(track: VehicleTrack, eye: Eye, nodes: Ints, tray_origin_m: Sequence[float]) -> Poses:
    """T_M_c (T_g_c without a CAD model) at those nodes."""
    return track.poses[nodes] @ tray_poses(tray_origin_m, track.tray[nodes]) @ eye.tray_from_camera


def best_crop(
    found: Mapping[str, Any], track: VehicleTrack, eyes: Sequence[Eye], tray_origin_m: Sequence[float]
) -> Crop | None:
    """The view among the object's images (all, when it names none) that has its centre nearest to the image's middle."""
    center = np.asarray(found["center"], float)
    choices = [
        (score, k, int(node)) for k, eye in enumerate(eyes) for node, score in _scores(found, center, track, eye, tray_origin_m)
    ]
    for _, k, node in sorted(choices)[:5]:
        crop = _cut(found, center, track, eyes[k], node, tray_origin_m)
        if crop is not None:
            return crop
    return None


def _scores(
    found: Mapping[str, Any], center: Array, track: VehicleTrack, eye: Eye, tray_origin_m: Sequence[float]
) -> list[tuple[int, float]]:
    """Nodes that see the centre inside the image, with its distance from the middle in half diagonals."""
    rows = track.image[:, 0 if eye.name == "camera_top" else 1]
    wanted = _rows_named(found.get("images") or [], eye)
    nodes = np.flatnonzero((rows >= 0) & (np.isin(rows, wanted) if wanted is not None else True))
    if not len(nodes):
        return []
    poses = camera_poses(track, eye, nodes, tray_origin_m)
    pixel = eye.camera.project(poses.inverse().apply(np.tile(center, (len(nodes), 1))))
    size = np.array([eye.camera.width, eye.camera.height])
    inside = np.all((pixel > 0) & (pixel < size), axis=1)
    score = np.linalg.norm(pixel - size / 2, axis=1) / np.linalg.norm(size / 2)
    return [(int(n), float(s)) for n, s, good in zip(nodes, score, inside, strict=True) if good]


def _rows_named(images: Sequence[Any], eye: Eye) -> Ints | None:
    """Rows of the camera's index for names like camera_top/1777887000468241234.jpg; None when the object names no image."""
    if not images:
        return None
    names = [str(i.get("image", "")) if isinstance(i, Mapping) else str(i) for i in images]
    stamps = [int(n.split("/")[1].split(".")[0]) for n in names if n.startswith(eye.name + "/")]
    return np.flatnonzero(np.isin(eye.index.t_ns, stamps))


def _cut(
    found: Mapping[str, Any], center: Array, track: VehicleTrack, eye: Eye, node: int, tray_origin_m: Sequence[float]
) -> Crop | None:
    row = int(track.image[node, 0 if eye.name == "camera_top" else 1])
    if not eye.index.usable[row]:
        return None
    pose = camera_poses(track, eye, np.array([node]), tray_origin_m).inverse()
    outline = np.asarray(found.get("outline") or [center], float).reshape(-1, 3)
    pixels = eye.camera.project(pose.apply(outline))
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    middle = eye.camera.project(pose.apply(center))[0]
    distance = float(np.linalg.norm(pose.apply(center)[0]))
    scale = eye.camera.fx / distance
    half = max(0.9 * float(np.abs(pixels - middle).max(initial=0)) + 0.12 * scale, 0.18 * scale)
    picture = eye.read(row)
    if picture is None:
        return None
    reach = np.array([1.35 * half, half])
    low = np.clip(np.floor(middle - reach), 0, [eye.camera.width - 2, eye.camera.height - 2]).astype(int)
    high = np.clip(np.ceil(middle + reach), low + 2, [eye.camera.width, eye.camera.height]).astype(int)
    cut = picture[low[1] : high[1], low[0] : high[0]]
    return Crop(
        jpeg_uri(stretched(cut)), cut.shape[1], cut.shape[0], pixels - low, scale, eye.name, row, int(eye.index.t_ns[row])
    )


def stretched(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Contrast stretched between the 1st and 99th percentile: underwater pictures use a third of the range."""
    low, high = np.percentile(picture, (1, 99))
    return np.asarray(np.clip((picture - low) * (245 / max(high - low, 20)) + 5, 0, 255), np.uint8)


def jpeg_uri(picture: NDArray[np.uint8], least_width: int = 560, quality: int = 88) -> str:
    """A data URI; small cuts are enlarged so that a browser's smoothing does not blur them."""
    import cv2

    factor = max(1.0, least_width / picture.shape[1])
    if factor > 1:
        picture = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
    ordered = picture[..., ::-1] if picture.ndim == 3 else picture
    done, data = cv2.imencode(".jpg", np.ascontiguousarray(ordered), [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise ValueError("the picture could not be encoded")
    return "data:image/jpeg;base64," + b64encode(data.tobytes()).decode()
