# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the camera_info YAML that ROS's camera_calibration writes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from hullrecon.dive.config.config_errors import shorten, show_value
from hullrecon.dive.config.yaml_files import read_yaml
from hullrecon.dive.images.encoded import fits
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel

PINHOLE = ("plumb_bob", "none", "rational_polynomial", "")


def read_camera(path: Path) -> CameraModel:
    """Read a pinhole camera with plumb_bob distortion.

    Raises InputError, with the key, for any other camera.
    """
    return camera_of(read_yaml(path), str(path))


def camera_of(data: Mapping[str, object], where: str) -> CameraModel:
    """Build the camera from the keys of such a YAML. where: their place, for errors."""
    width, height = (_whole(data, key, where) for key in ("image_width", "image_height"))
    if not fits((width, height)):
        raise InputError(
            f"images of {width} x {height} pixels are too large to be read", where=where
        )
    matrix = _numbers(data, "camera_matrix", 9, where)
    fx, fy, cx, cy = matrix[0], matrix[4], matrix[2], matrix[5]
    if not (0 < fx < 1e6 and 0 < fy < 1e6):
        raise InputError(f"camera_matrix has focal lengths {fx:g} and {fy:g}", where=where)
    if abs(matrix[1]) > 1e-6 * fx:
        raise InputError(
            f"camera_matrix has a skew of {matrix[1]:g}, which is not modelled", where=where
        )
    k1, k2, p1, p2, k3 = _distortion(data, where)
    return CameraModel(width, height, fx, fy, cx, cy, k1, k2, p1, p2, k3)


def _distortion(data: Mapping[str, object], where: str) -> list[float]:
    model = data.get("distortion_model", "plumb_bob")
    if model not in PINHOLE:
        shown = shorten(model) if isinstance(model, str) else show_value(model)
        raise InputError(
            f"the distortion model {shown} is not read",
            where=where,
            remedy="calibrate with plumb_bob",
        )
    if "distortion_coefficients" not in data:
        return [0.0] * 5
    values = _numbers(data, "distortion_coefficients", None, where)
    if any(values[5:]):
        raise InputError(
            "more than five distortion coefficients", where=where, remedy="calibrate with plumb_bob"
        )
    return (values + [0.0] * 5)[:5]


def _numbers(data: Mapping[str, object], key: str, count: int | None, where: str) -> list[float]:
    """Read the `data` of a matrix, or a list.

    Raises InputError unless it is `count` finite numbers.
    """
    found = data.get(key)
    found = found.get("data") if isinstance(found, Mapping) else found
    try:
        values = [float(v) for v in found] if isinstance(found, list | tuple) else None
    except (TypeError, ValueError, OverflowError):
        values = None
    if values is None:
        raise InputError(f"{key} holds no numbers", where=where) from None
    if (count is not None and len(values) != count) or not np.isfinite(values).all():
        raise InputError(f"{key} is not {count or 'some'} finite numbers", where=where)
    return values


def _whole(data: Mapping[str, object], key: str, where: str) -> int:
    value = data.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 < value < 100_000:
        raise InputError(f"{key} is {show_value(value)}, not a number of pixels", where=where)
    return value
