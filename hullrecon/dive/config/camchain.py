# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the camchain YAML that Kalibr writes: all cameras of a rig, each with its pose."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.config.config_errors import show_value
from hullrecon.dive.logs.messages.descriptions import COMPRESSED, mount_of
from hullrecon.errors import InputError
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses

NAME = re.compile(r"cam\d{1,2}")
DISTORTIONS = {"radtan": "plumb_bob", "none": "none"}
POSE = "T_cn_cnm1"  # from the camera before to this one
ROTATION = 1e-4  # by which R R^T may differ from the identity, as it does by rounded numbers
REMEDY = "calibrate with pinhole-radtan"


def cameras_of(data: Mapping[str, object]) -> list[str]:
    """List the cameras of a camchain, in its order. Empty for any other YAML."""
    return sorted(
        (
            name
            for name, entry in data.items()
            if isinstance(name, str) and NAME.fullmatch(name) and isinstance(entry, Mapping)
        ),
        key=lambda name: int(name[3:]),
    )


def choose_camera(data: Mapping[str, object], camera: Camera, topic: str) -> str:
    """Choose the entry of a camera in a camchain.

    It is the one with the camera's rostopic, else the first entry for the upper camera and the
    second for the lower one. The only entry of a camchain is that of either camera.

    Parameters
    ----------
    data : the camchain
    camera : which camera of the rig
    topic : name of the topic of its images, "" where unknown
    """
    names = cameras_of(data)
    for name in names:
        rostopic = _entry(data, name).get("rostopic")
        if topic and isinstance(rostopic, str) and _bare(rostopic) == _bare(topic):
            return name
    return names[min(camera.column, len(names) - 1)]


def camera_info_of(data: Mapping[str, object], name: str, where: str) -> dict[str, object]:
    """Convert one camera of a camchain to the keys of camera_calibration's YAML.

    Raises InputError for a model of camera or distortion that is not read, and for missing numbers.
    where: the file, for errors.
    """
    entry = _entry(data, name)
    model, distortion = entry.get("camera_model"), entry.get("distortion_model")
    if model != "pinhole":
        raise InputError(
            f"{name} has the camera model {show_value(model)}, which is not read",
            where=where,
            remedy=REMEDY,
        )
    if distortion not in DISTORTIONS:
        raise InputError(
            f"{name} has the distortion model {show_value(distortion)}, which is not read",
            where=where,
            remedy=REMEDY,
        )
    size, lens = _list(entry.get("resolution")), _list(entry.get("intrinsics"))
    if len(size) != 2 or len(lens) != 4:
        raise InputError(f"{name} has no resolution of two or intrinsics of four", where=where)
    (width, height), (fx, fy, cx, cy) = size, lens
    return {
        "image_width": width,
        "image_height": height,
        "camera_matrix": [fx, 0, cx, 0, fy, cy, 0, 0, 1],
        "distortion_model": DISTORTIONS[str(distortion)],
        "distortion_coefficients": entry.get("distortion_coeffs", []),
    }


def pose_in_top(data: Mapping[str, object], top: str, bottom: str) -> tuple[float, ...] | None:
    """Compute the lower camera's pose in the upper one: m and degrees, as in dive.toml.

    None where the two are not neighbours in the chain, or it holds no pose.

    top, bottom: names of the two cameras in the chain.
    """
    names = cameras_of(data)
    first, second = names.index(top), names.index(bottom)
    if abs(first - second) != 1:
        return None
    # the chain states the pose of each camera relative to the one before
    rows = _entry(data, names[max(first, second)]).get(POSE)
    try:
        later_from_earlier = np.array(rows, float)
    except (TypeError, ValueError):
        return None
    if later_from_earlier.shape != (4, 4) or not np.isfinite(later_from_earlier).all():
        return None
    rotation = later_from_earlier[:3, :3]
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > ROTATION or np.linalg.det(rotation) < 0:
        return None
    pose = Poses(Rotation.from_matrix(rotation).as_quat()[None], later_from_earlier[None, :3, 3])
    top_from_bottom = pose.inverse() if second > first else pose
    return tuple(mount_of(top_from_bottom, digits=7))


def _entry(data: Mapping[str, object], name: str) -> Mapping[str, object]:
    """Look up what the chain states of a camera. Empty where that is no table."""
    entry = data[name]
    return entry if isinstance(entry, Mapping) else {}


def _bare(topic: str) -> str:
    """Drop what image_transport adds to a topic's name."""
    return "/" + topic.strip("/").removesuffix(COMPRESSED)


def _list(value: object) -> list[object]:
    return list(value) if isinstance(value, list | tuple) else []
