# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read a log's descriptions of its sensors: CameraInfo, and the fixed frames of tf_static."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.messages.decode import Fields, vector
from hullrecon.geometry.poses import Poses, identity

CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
COMPRESSED = "/compressed"  # what image_transport adds to a topic's name
BASE_FRAMES = ("base_link", "base_footprint")  # REP 105: on the vehicle, x forward, y to port, z up
FRD_FROM_FLU = Poses(Rotation.from_euler("x", 180, degrees=True).as_quat()[None], np.zeros((1, 3)))
MOST_FRAMES, DEEPEST = 1000, 20  # frames that are kept, and that lie within each other
SAME_M, SAME_RAD = 1e-3, 2e-3  # by which two poses of a frame may differ and still be one
BINNING = ("binning_x", "binning_y")  # fields of a CameraInfo, and of its roi
REGION = ("x_offset", "y_offset", "width", "height")

Tree = Mapping[str, tuple[str, Poses]]  # by child frame: its parent, and parent_from_child


def frame_tree(messages: Iterable[Fields]) -> dict[str, tuple[str, Poses]]:
    """Collect the fixed frames of tf_static messages, by child: its parent, and its pose there.

    The last pose of a frame holds. Frames without a rotation are left out, as are those whose
    logged type lacks a part, and those beyond MOST_FRAMES.
    """
    tree: dict[str, tuple[str, Poses]] = {}
    for child, parent, pose in _transforms(messages):
        if pose is not None and len(tree) < MOST_FRAMES:
            tree[child] = parent, pose
    return tree


def frame_doubts(messages: Iterable[Fields]) -> dict[str, str]:
    """Say why the pose of a frame is not known, by frame. Empty where all are known.

    Frames are listed that have two parents, two poses in one parent, or no rotation.
    """
    doubts: dict[str, str] = {}
    first_poses: dict[str, tuple[str, Poses]] = {}  # by child: parent, and parent_from_child
    for child, parent, pose in _transforms(messages):
        if pose is None:
            doubts[child] = f"tf_static gives {child} no rotation (x, y, z, w of no unit length)"
            continue
        first_parent, first_pose = first_poses.setdefault(child, (parent, pose))
        apart = first_pose.inverse() @ pose
        if first_parent != parent:
            doubts[child] = f"tf_static gives {child} two parents, {first_parent} and {parent}"
        elif np.linalg.norm(apart.translation) > SAME_M or apart.rotation.magnitude() > SAME_RAD:
            mounts = [
                ", ".join(f"{value:g}" for value in mount_of(one)) for one in (first_pose, pose)
            ]
            places = " and ".join(f"[{mount}]" for mount in mounts)
            doubts[child] = f"tf_static gives {child} two places in {parent}, {places}"
    return doubts


def _transforms(messages: Iterable[Fields]) -> Iterator[tuple[str, str, Poses | None]]:
    """Yield child, parent and parent_from_child of each transform of tf_static messages.

    The pose is None where its quaternion is not of unit length, or its shift not finite. Transforms
    that lack a part are left out.
    """
    for transform in (t for message in messages for t in getattr(message, "transforms", ())):
        try:
            r, child, parent = (
                transform.transform.rotation,
                transform.child_frame_id,
                transform.header.frame_id,
            )
            quaternion = np.array([r.x, r.y, r.z, r.w], float)
            shift = vector(transform.transform.translation)
        except AttributeError:
            continue
        is_whole = abs(np.linalg.norm(quaternion) - 1) < 0.05 and np.isfinite(shift).all()
        yield (
            _frame(child),
            _frame(parent),
            Poses(quaternion[None], shift[None]) if is_whole else None,
        )


@dataclass(frozen=True, kw_only=True)
class LocatedFrame:
    """The poses of a frame in the vehicle and on a servo."""

    vehicle: Poses | None  # vehicle_from_frame; None where tf_static does not lead to base_link
    servo: Poses | None = None  # servo_from_frame, of the nearest servo that it hangs on
    vehicle_from_servo: Poses | None = None


def names_above(frame: str, tree: Tree) -> list[str]:
    """List a frame and its parents up to base_link, the frame itself first."""
    names = [_frame(frame)]
    while names[-1] in tree and names[-1].rpartition("/")[2] not in BASE_FRAMES:
        if len(names) > DEEPEST:
            break
        names.append(tree[names[-1]][0])
    return names


def locate_frame(frame: str, tree: Tree, servos: Set[str] = frozenset()) -> LocatedFrame:
    """Compute the pose of a frame in the vehicle (axes forward, starboard, down).

    The parents are followed up to base_link, and their transforms multiplied. Where base_link is no
    parent of the frame, it may be a child of the frame or of one of its parents. Both poses are
    None where neither base_link nor a servo is found.

    Parameters
    ----------
    frame : its name
    tree : the transforms of tf_static
    servos : names of frames that a servo turns
    """
    pose, at = identity(), _frame(frame)
    servo = above = None  # the frame on the servo, and the servo in the frame reached so far
    passed: dict[str, Poses] = {}  # the frame in itself and in each of its parents
    for _ in range(DEEPEST):
        passed[at] = pose
        if servo is None and at.rpartition("/")[2] in servos:
            servo, above = pose, identity()
        if at.rpartition("/")[2] in BASE_FRAMES:
            turning = None if above is None else FRD_FROM_FLU @ above
            return LocatedFrame(
                vehicle=FRD_FROM_FLU @ pose, servo=servo, vehicle_from_servo=turning
            )
        if at not in tree:
            break
        at, step = tree[at]
        pose, above = step @ pose, None if above is None else step @ above
    return LocatedFrame(vehicle=None if servo else _by_common_parent(passed, tree), servo=servo)


def _by_common_parent(frame_from_sensor: Mapping[str, Poses], tree: Tree) -> Poses | None:
    """Compute vehicle_from_sensor where base_link lies below the sensor's frame or a parent of it.

    None where base_link and the sensor have no parent in common. frame_from_sensor: pose of the
    sensor in its own frame, the identity, and in each parent of that.
    """
    for base in (name for name in tree if name.rpartition("/")[2] in BASE_FRAMES):
        frame_from_base, frame = identity(), base
        for _ in range(DEEPEST):
            if frame in frame_from_sensor:
                return FRD_FROM_FLU @ frame_from_base.inverse() @ frame_from_sensor[frame]
            if frame not in tree:
                break
            frame, parent_from_frame = tree[frame]
            frame_from_base = parent_from_frame @ frame_from_base
    return None


def mount_of(pose: Poses, digits: int = 4) -> list[float]:
    """Convert a pose to x, y, z in m, roll, pitch, yaw in degrees, as in dive.toml.

    digits: decimals of the numbers.
    """
    matrix = pose.rotation.as_matrix()[0]
    pitch = np.arcsin(np.clip(-matrix[2, 0], -1, 1))
    # at a pitch of 90 degrees only the sum or difference of roll and yaw is known: yaw is set to 0
    if np.hypot(matrix[2, 1], matrix[2, 2]) < 1e-6:
        roll, yaw = np.arctan2(-np.sign(matrix[2, 0]) * matrix[0, 1], matrix[1, 1]), 0.0
    else:
        roll, yaw = np.arctan2(matrix[2, 1], matrix[2, 2]), np.arctan2(matrix[1, 0], matrix[0, 0])
    values = [*pose.translation[0], *np.degrees([roll, pitch, yaw])]
    return [round(float(v), digits) + 0.0 for v in values]


def lies_beside(topic: str, images: str) -> bool:
    """Tell whether a CameraInfo has the namespace of an image topic, as in image_transport."""
    return topic.rpartition("/")[0] == images.removesuffix(COMPRESSED).rpartition("/")[0]


def calibration_keys(info: Fields) -> dict[str, object]:
    """Convert a CameraInfo of ROS 1 or 2 to the keys of camera_calibration's YAML.

    Matrices are lists of their elements, row by row.
    """
    fields = info.__dataclass_fields__
    return {
        "image_width": int(info.width),
        "image_height": int(info.height),
        "camera_matrix": [float(v) for v in (info.k if "k" in fields else info.K)],
        "distortion_model": str(info.distortion_model),
        "distortion_coefficients": [float(v) for v in (info.d if "d" in fields else info.D)],
        **{name: int(getattr(info, name)) for name in BINNING},
        "roi": {name: int(getattr(info.roi, name)) for name in REGION},
    }


def calibration_yaml(info: Fields, topic: str) -> str | None:
    """Write camera_calibration's YAML for a CameraInfo, to be kept in a dive package.

    None where the message is not filled in. topic: of the message, for a remark on top.
    """
    keys = calibration_keys(info)
    matrix, distortion = np.array(keys["camera_matrix"]), np.array(keys["distortion_coefficients"])
    if not (
        info.width
        and info.height
        and np.isfinite([*matrix, *distortion]).all()
        and matrix[0] > 0
        and matrix[4] > 0
    ):
        return None
    model = str(info.distortion_model)
    return "\n".join(
        [
            f"# From the CameraInfo on {topic}. It has to be the calibration in water: see that it "
            "is.",
            f"image_width: {int(info.width)}",
            f"image_height: {int(info.height)}",
            f"camera_matrix: {{rows: 3, cols: 3, data: {matrix.tolist()}}}",
            f"distortion_model: {model if model.isidentifier() else 'plumb_bob'}",
            f"distortion_coefficients: {{rows: 1, cols: {len(distortion)}, "
            f"data: {distortion.tolist()}}}",
            *(f"{name}: {keys[name]}" for name in BINNING),
            f"roi: {keys['roi']}".replace("'", ""),
            "",
        ]
    )


def _frame(name: str) -> str:
    return str(name).lstrip("/")
