# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Foxglove's messages as JSON values, each by a function that is named after it."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.poses import Poses
from hullrecon.report.export.geometry import pack_rows
from hullrecon.typing import Array

Schema = dict[str, object]

NUMBER: Schema = {"type": "number"}
TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}
COUNT: Schema = {"type": "integer", "minimum": 0}
BYTES: Schema = {"type": "string", "contentEncoding": "base64"}
NANOSECONDS: Schema = {"type": "integer", "minimum": 0, "maximum": 999_999_999}


def record(title: str, **fields: Schema) -> Schema:
    """Make the schema of an object that requires all of those fields."""
    return {"title": title, "type": "object", "properties": fields, "required": list(fields)}


def listed(items: Schema) -> Schema:
    """Make the schema of a list."""
    return {"type": "array", "items": items}


def choice(title: str, *names: str) -> Schema:
    """Make the schema of a number that stands for one of those names, counted from 0."""
    return {"title": title, "oneOf": [{"title": name, "const": k} for k, name in enumerate(names)]}


TIME = record("time", sec=COUNT, nsec=NANOSECONDS)
DURATION = record("duration", sec={"type": "integer"}, nsec=NANOSECONDS)
VECTOR = record("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
POINT = record("foxglove.Point3", x=NUMBER, y=NUMBER, z=NUMBER)
QUATERNION = record("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
POSE = record("foxglove.Pose", position=VECTOR, orientation=QUATERNION)
COLOR = record("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
NUMERIC_TYPES = (
    "UNKNOWN",
    "UINT8",
    "INT8",
    "UINT16",
    "INT16",
    "UINT32",
    "INT32",
    "FLOAT32",
    "FLOAT64",
)
PACKED_FIELD = record(
    "foxglove.PackedElementField",
    name=TEXT,
    offset=COUNT,
    type=choice("foxglove.NumericType", *NUMERIC_TYPES),
)
LINE = record(
    "foxglove.LinePrimitive",
    type=choice("foxglove.LineType", "LINE_STRIP", "LINE_LOOP", "LINE_LIST"),
    pose=POSE,
    thickness=NUMBER,
    scale_invariant=FLAG,
    points=listed(POINT),
    color=COLOR,
    colors=listed(COLOR),
    indices=listed(COUNT),
)
LABEL = record(
    "foxglove.TextPrimitive",
    pose=POSE,
    billboard=FLAG,
    font_size=NUMBER,
    scale_invariant=FLAG,
    color=COLOR,
    text=TEXT,
)
MODEL = record(
    "foxglove.ModelPrimitive",
    pose=POSE,
    scale=VECTOR,
    color=COLOR,
    override_color=FLAG,
    url=TEXT,
    media_type=TEXT,
    data=BYTES,
)
# primitives that an entity has none of
NEVER_WRITTEN = ("arrows", "cubes", "spheres", "cylinders", "triangles")
ENTITY = record(
    "foxglove.SceneEntity",
    timestamp=TIME,
    frame_id=TEXT,
    id=TEXT,
    lifetime=DURATION,
    frame_locked=FLAG,
    metadata=listed(record("foxglove.KeyValuePair", key=TEXT, value=TEXT)),
    lines=listed(LINE),
    texts=listed(LABEL),
    models=listed(MODEL),
    **{name: listed(record("none")) for name in NEVER_WRITTEN},
)
SCENE_UPDATE = record(
    "foxglove.SceneUpdate", deletions=listed(record("none")), entities=listed(ENTITY)
)
POINT_CLOUD = record(
    "foxglove.PointCloud",
    timestamp=TIME,
    frame_id=TEXT,
    pose=POSE,
    point_stride=COUNT,
    fields=listed(PACKED_FIELD),
    data=BYTES,
)
FRAME_TRANSFORM = record(
    "foxglove.FrameTransform",
    timestamp=TIME,
    parent_frame_id=TEXT,
    child_frame_id=TEXT,
    translation=VECTOR,
    rotation=QUATERNION,
)
POSE_IN_FRAME = record("foxglove.PoseInFrame", timestamp=TIME, frame_id=TEXT, pose=POSE)
POSES_IN_FRAME = record("foxglove.PosesInFrame", timestamp=TIME, frame_id=TEXT, poses=listed(POSE))
POSE_SIGMA = record(
    "hullrecon.PoseSigma",
    timestamp=TIME,
    x=NUMBER,
    y=NUMBER,
    z=NUMBER,
    roll=NUMBER,
    pitch=NUMBER,
    yaw=NUMBER,
    tray=NUMBER,
)


Message = dict[str, object]
Rgba = tuple[float, float, float, float]
LINE_LOOP = 1
WITHOUT_END: Message = {"sec": 0, "nsec": 0}  # lifetime of an entity without an end
ORIGIN: Message = {
    "position": {"x": 0.0, "y": 0.0, "z": 0.0},
    "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
}


def time(t_ns: int) -> Message:
    """Split a time in nanoseconds since 1970 into seconds and nanoseconds."""
    return {"sec": int(t_ns) // 10**9, "nsec": int(t_ns) % 10**9}


def vector(values: Array) -> Message:
    """Name the parts of a vector or point (3,), or of a quaternion x y z w (4,)."""
    return dict(zip("xyzw", np.asarray(values, float).tolist(), strict=False))


def pose(poses: Poses, row: int = 0) -> Message:
    """Write one pose of a batch."""
    return {
        "position": vector(poses.translation[row]),
        "orientation": vector(poses.quaternion[row]),
    }


def frame_transform(t_ns: int, parent: str, child: str, poses: Poses, row: int = 0) -> Message:
    """Write the pose of a child frame in its parent."""
    return {
        "timestamp": time(t_ns),
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": vector(poses.translation[row]),
        "rotation": vector(poses.quaternion[row]),
    }


def point_cloud(t_ns: int, frame: str, columns: Mapping[str, NDArray[np.generic]]) -> Message:
    """Pack columns (n,), among them x, y, z, into a point cloud.

    Raises ValueError for a type that is not one of numpy's uint8 to float64.
    """
    rows = pack_rows(columns)
    members: Mapping[str, Any] = rows.dtype.fields or {}
    fields = [
        {
            "name": name,
            "offset": members[name][1],
            "type": NUMERIC_TYPES.index(values.dtype.name.upper()),
        }
        for name, values in columns.items()
    ]
    return {
        "timestamp": time(t_ns),
        "frame_id": frame,
        "pose": ORIGIN,
        "point_stride": rows.dtype.itemsize,
        "fields": fields,
        "data": base64.b64encode(rows.tobytes()).decode(),
    }


def scene_update(entities: Sequence[Message]) -> Message:
    """Add entities to a scene."""
    return {"deletions": [], "entities": list(entities)}


def entity(
    t_ns: int,
    frame: str,
    name: str,
    *,
    facts: Mapping[str, object] | None = None,
    lines: Sequence[Message] = (),
    texts: Sequence[Message] = (),
    models: Sequence[Message] = (),
) -> Message:
    """Make a visual element of a scene, without an end. Its facts are shown when it is selected."""
    return {
        "timestamp": time(t_ns),
        "frame_id": frame,
        "id": name,
        "lifetime": WITHOUT_END,
        "frame_locked": True,
        "metadata": [{"key": key, "value": str(value)} for key, value in (facts or {}).items()],
        "lines": list(lines),
        "texts": list(texts),
        "models": list(models),
        **{none: [] for none in NEVER_WRITTEN},
    }


def color(rgba: Rgba) -> Message:
    """Name the four parts of a colour, each from 0 to 1."""
    return dict(zip("rgba", rgba, strict=True))


def line_loop(points: Array, rgba: Rgba, thickness_px: float) -> Message:
    """Draw a closed line through points (n, 3)."""
    return {
        "type": LINE_LOOP,
        "pose": ORIGIN,
        "thickness": thickness_px,
        "scale_invariant": True,
        "points": [vector(point) for point in points],
        "color": color(rgba),
        "colors": [],
        "indices": [],
    }


def label(text: str, at: Array, rgba: Rgba, size_px: float) -> Message:
    """Write a text at a point (3,) that turns to the viewer."""
    place = {**ORIGIN, "position": vector(at)}
    shown = {"billboard": True, "font_size": size_px, "scale_invariant": True}
    return {"pose": place, **shown, "color": color(rgba), "text": text}


def model(glb: bytes) -> Message:
    """Embed a glTF model in its own colours. Foxglove turns glTF's y, which is up, to z."""
    return {
        "pose": ORIGIN,
        "scale": vector(np.ones(3)),
        "color": color((1, 1, 1, 1)),
        "override_color": False,
        "url": "",
        "media_type": "model/gltf-binary",
        "data": base64.b64encode(glb).decode(),
    }
