# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""JSON Schemas of the Foxglove messages that are written here, and of a message of our own.

Foxglove knows a message by its schema's name and decodes its fields by the schema: a `time` and a
`duration` by their titles, bytes by contentEncoding.
"""

from __future__ import annotations

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
