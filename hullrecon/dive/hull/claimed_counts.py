# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Refuse a GLB that claims more than it holds. In the other formats a parser meets the end of the bytes before a false count."""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from trimesh import Scene

HEAD = struct.Struct("<4sIIII")  # magic, version, length; length and type of the first chunk, which is JSON
ROOM = 1_000_000  # values or faces beyond one a byte


def check_counts(data: bytes, kind: str) -> None:
    """Raise ValueError for a GLB whose accessors ask for more zeros than there are bytes in the file."""
    if kind != "glb" or len(data) < HEAD.size:
        return
    length = HEAD.unpack_from(data)[3]
    accessors = json.loads(data[HEAD.size : HEAD.size + length]).get("accessors", [])
    zeros = sum(max(0, accessor["count"]) for accessor in accessors if "bufferView" not in accessor)
    if zeros > len(data) + ROOM:
        raise ValueError(f"it claims {zeros} values that it does not hold")


def check_instances(scene: Scene, size: int) -> None:
    """Raise ValueError for a scene whose meshes, each as often as it is placed, have more faces than such a file has."""
    placed = [scene.graph[name][1] for name in scene.graph.nodes_geometry]
    faces = sum(len(getattr(scene.geometry.get(name), "faces", ())) for name in placed)
    if faces > size + ROOM:
        raise ValueError(f"it places meshes of {faces} faces in all")
