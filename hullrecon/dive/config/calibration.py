# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the calibration of a camera: the YAML of ROS's camera_calibration, OpenCV or Kalibr."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from hullrecon.dive.config.camchain import (
    camera_info_of,
    cameras_of,
    choose_camera,
    pose_in_top,
)
from hullrecon.dive.config.camera_matrix import read_pinhole
from hullrecon.dive.config.config_errors import shorten, show_value
from hullrecon.dive.config.foreign_calibrations import name_foreign
from hullrecon.dive.config.lens_models import (
    PLUMB_BOB_COUNT,
    convert_rational,
)
from hullrecon.dive.config.yaml_files import LARGEST_YAML, read_yaml
from hullrecon.dive.files import read_regular, read_text
from hullrecon.dive.images.encoded import fits
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera

READ_MODELS = ("plumb_bob", "radtan", "none", "rational_polynomial", "")  # radtan: of Kalibr
# the names of a camera_info YAML, those of the message and those of OpenCV's samples
FISHEYES = ("fisheye", "equidistant")  # whose coefficients mean something else than plumb_bob's
NAMES = {
    "image_width": ("width", "imageWidth"),
    "image_height": ("height", "imageHeight"),
    "camera_matrix": ("k", "K", "cameraMatrix", "Camera_Matrix"),
    "distortion_coefficients": ("d", "D", "distCoeffs", "Distortion_Coefficients"),
}
RADIAL_COUNT = 3  # coefficients of a radial distortion; OpenCV's third is no radial one
WIDEST_RAY = np.tan(np.radians(80.0))  # x/z of rays on which a distortion is looked at
CAMERA_INFO = (
    "give a camera_info YAML: image_width, image_height, camera_matrix (fx 0 cx, 0 fy cy, 0 0 1) "
    "and distortion_coefficients (k1 k2 p1 p2 k3)"
)
LEAST_BENT_PX = 1.0  # at the corners of an image; calibrations are wrong by less
REGION_KEYS = ("binning_x", "binning_y", "roi")


def read_camera(path: Path, camera: Camera = Camera.TOP, topic: str = "") -> CameraModel:
    """Read a pinhole camera from a camera_info YAML or a camchain of Kalibr.

    Raises InputError, with the key, for any other camera, and for one with distortion whose images
    are rectified by the name of their topic.

    Parameters
    ----------
    path : the YAML file
    camera : which camera of the rig, to choose its entry of a camchain
    topic : name of the topic of its images, "" where unknown. It tells whether they are rectified,
        and also chooses the entry of a camchain
    """
    where = str(path)
    _refuse_foreign(path, where)
    data = read_yaml(path)
    if cameras_of(data):
        data = camera_info_of(data, choose_camera(data, camera, topic), where)
    found = camera_of(data, where)
    if is_rectified(topic) and _bends(found):
        raise InputError(
            f"{topic} holds rectified pictures by its name, from which this calibration's "
            "distortion would be taken once more",
            where=where,
            remedy="give the calibration of the rectified pictures",
        )
    return found


def is_rectified(topic: str) -> bool:
    """Tell whether a topic's name is one that image_proc gives rectified pictures."""
    return "rect" in topic.rpartition("/image")[2]


def _bends(camera: CameraModel) -> bool:
    """Tell whether the distortion moves a corner of the image by more than LEAST_BENT_PX."""
    corner = np.array([[0.0, 0.0], [camera.width - 1.0, camera.height - 1.0]])
    ideal = (corner - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    return bool(np.abs(camera.distort(ideal) - corner).max() > LEAST_BENT_PX)


def _refuse_foreign(path: Path, where: str) -> None:
    """Raise InputError for a calibration of another program, with what to write in its place."""
    try:
        text = read_regular(path, LARGEST_YAML).decode("utf-8", "replace")
    except (OSError, ValueError):
        return  # read_yaml says so
    foreign = name_foreign(text)
    if foreign is not None:
        whose, remedy = foreign
        raise InputError(
            f"this calibration is {whose}, which is not read", where=where, remedy=remedy
        )


def is_camchain(path: Path) -> bool:
    """Tell whether a file looks like a camchain of Kalibr."""
    try:
        text = read_text(path, LARGEST_YAML)
    except (OSError, ValueError):
        return False
    return text.startswith("cam0:") or "\ncam0:" in text


def read_pose_in_top(path: Path, topics: Mapping[str, str]) -> tuple[float, ...] | None:
    """Read the lower camera's pose in the upper one from a camchain. None from any other YAML.

    topics: of the images, by camera ("camera_top").
    """
    data = read_yaml(path)
    if not cameras_of(data):
        return None
    top, bottom = (choose_camera(data, camera, topics.get(camera.key, "")) for camera in Camera)
    return pose_in_top(data, top, bottom)


def camera_of(data: Mapping[str, object], where: str) -> CameraModel:
    """Build the camera of the images as they are logged: cropped and binned as the file says.

    Three sets of key names are understood (NAMES): those of a camera_info YAML (image_width,
    camera_matrix), of the ROS message CameraInfo (width, K), and of OpenCV's sample programs
    (cameraMatrix). Raises InputError for keys that are missing or wrong, and for images too large
    to be read.

    data: the parsed file. where: its name, for errors.
    """
    for name, others in NAMES.items():
        found = next((data[other] for other in others if other in data), None)
        data = data if name in data or found is None else {**data, name: found}
    width, height = (_whole(data, key, where) for key in ("image_width", "image_height"))
    if not fits((width, height)):
        raise InputError(
            f"images of {width} x {height} pixels are too large to be read", where=where
        )
    pinhole = read_pinhole(_read_numbers(data, "camera_matrix", 9, where), (width, height), where)
    camera = _crop_to_region(pinhole, data, where)
    return _add_distortion(camera, data, where)


def has_region(data: Mapping[str, object]) -> bool:
    """Tell whether binning or a region of interest is given, other than the whole sensor."""
    found = data.get("roi")
    region = found.values() if isinstance(found, Mapping) else ()
    binning = (data.get(name) for name in ("binning_x", "binning_y"))
    return any(region) or any(value not in (None, 0, 1) for value in binning)


def _crop_to_region(camera: CameraModel, data: Mapping[str, object], where: str) -> CameraModel:
    """Crop and bin the camera of a whole sensor, as REP 104 defines roi and binning.

    Images of a part of the sensor, or of merged pixels, have another size and principal point than
    the calibration. Pixel centres have whole coordinates, hence the half pixels: with a binning of
    two, the centre of the first binned pixel is at 0.5 of the unbinned ones. Raises InputError for
    a region that lies outside of the sensor.
    """
    found = data.get("roi")
    region: Mapping[str, object] = found if isinstance(found, Mapping) else {}
    x, y, width, height = (
        _count(region.get(name), f"roi.{name}", where)
        for name in ("x_offset", "y_offset", "width", "height")
    )
    width, height = width or camera.width, height or camera.height
    if x + width > camera.width or y + height > camera.height:
        raise InputError(
            f"its roi, {width} x {height} pixels from {x}, {y} on, lies outside of the "
            f"{camera.width} x {camera.height} pixels that its calibration is for: one of the two "
            "is not what sensor_msgs/CameraInfo says",
            where=where,
            remedy="give the YAML of the camera at the size of its images",
        )
    across, down = (_count(data.get(name), name, where) or 1 for name in ("binning_x", "binning_y"))
    return replace(
        camera,
        width=width // across,
        height=height // down,
        fx=camera.fx / across,
        fy=camera.fy / down,
        cx=(camera.cx - x + 0.5) / across - 0.5,
        cy=(camera.cy - y + 0.5) / down - 0.5,
    )


def _add_distortion(camera: CameraModel, data: Mapping[str, object], where: str) -> CameraModel:
    """Add the distortion to a pinhole. Raises InputError for a model that is not read.

    More than five coefficients are OpenCV's rational model, which is converted to plumb_bob.
    """
    lens = data.get("camera_model")  # camera_calibration of ROS 1 names a fisheye by this alone
    model = lens if lens in FISHEYES else data.get("distortion_model", "plumb_bob")
    if not isinstance(model, str) or re.sub(r"[ -]", "_", model.lower()) not in READ_MODELS:
        shown = shorten(model) if isinstance(model, str) else show_value(model)
        raise InputError(
            f"the distortion model {shown} is not read",
            where=where,
            remedy="calibrate with plumb_bob (radtan in Kalibr)",
        )
    if "distortion_coefficients" not in data:
        return camera
    values = _read_numbers(data, "distortion_coefficients", None, where)
    if any(values[PLUMB_BOB_COUNT:]):
        return convert_rational(camera, values, where)
    if len(values) == RADIAL_COUNT and values[-1]:
        raise InputError(
            f"it has {RADIAL_COUNT} distortion coefficients, which may be k1 k2 p1 or k1 k2 k3",
            where=where,
            remedy="give k1 k2 p1 p2 k3, with 0 for what it does not have",
        )
    k1, k2, p1, p2, k3 = (values + [0.0] * PLUMB_BOB_COUNT)[:PLUMB_BOB_COUNT]
    bent = replace(camera, k1=k1, k2=k2, p1=p1, p2=p2, k3=k3)
    _refuse_folded(bent, where)
    return bent


@np.errstate(all="ignore")  # coefficients of any size
def _refuse_folded(camera: CameraModel, where: str) -> None:
    """Raise InputError for a distortion that folds the picture before an edge of it is reached.

    Coefficients of coordinates in pixels or millimetres do, and so do those of another order. A
    fold in the corners, where few calibrations have points, is accepted.
    """
    r = np.linspace(0.0, WIDEST_RAY, 500)
    radial = r * (1 + r**2 * (camera.k1 + r**2 * (camera.k2 + r**2 * camera.k3)))
    grows = np.diff(radial) > 0
    reached = float(radial[np.argmin(grows)]) if not grows.all() else np.inf
    if reached < 0.5 * min(camera.width / camera.fx, camera.height / camera.fy):
        raise InputError(
            f"its distortion folds the picture {reached * camera.fx:.0f} px from the middle",
            where=where,
            remedy="give k1 k2 p1 p2 k3 in this order, of coordinates x/z and y/z, as OpenCV has "
            "them",
        )


def _read_numbers(
    data: Mapping[str, object], key: str, count: int | None, where: str
) -> list[float]:
    """Read the numbers of a matrix with `data`, of a list, or of a list of rows.

    Raises InputError unless these are `count` finite numbers, or any count where that is None.
    """
    found = _require(data, key, where)
    found = found.get("data") if isinstance(found, Mapping) else found
    if isinstance(found, list):
        found = [v for row in found for v in (row if isinstance(row, list) else [row])]
    try:
        values = [float(v) for v in found] if isinstance(found, list) else None
    except (TypeError, ValueError, OverflowError):
        values = None
    if values is None:
        raise InputError(f"{key} holds no numbers", where=where, remedy=CAMERA_INFO) from None
    if (count is not None and len(values) != count) or not np.isfinite(values).all():
        what = f"{key} is not {count or 'some'} finite numbers"
        raise InputError(what, where=where, remedy=CAMERA_INFO)
    return values


def _require(data: Mapping[str, object], key: str, where: str) -> object:
    """Get the value of a key of a calibration. Raises InputError where the key is missing."""
    if key not in data:
        raise InputError(f"it has no {key}", where=where, remedy=CAMERA_INFO)
    return data[key]


def _whole(data: Mapping[str, object], key: str, where: str) -> int:
    """Read a number of pixels, at least one. Raises InputError for anything else."""
    value = _require(data, key, where)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 < value < 100_000:
        raise InputError(f"{key} is {show_value(value)}, not a number of pixels", where=where)
    return value


def _count(value: object, key: str, where: str) -> int:
    """Read a number of pixels that may be left out."""
    return 0 if value in (None, 0) else _whole({key: value}, key, where)
