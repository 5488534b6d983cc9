# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Keep mesh files from taking more memory or time to parse than their size warrants: trimesh
believes what some claim.
"""

from __future__ import annotations

import json
import re
import struct
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from trimesh import Scene

# magic, version, length; length and type of the first chunk, which is JSON
GLB_HEAD = struct.Struct("<4sIIII")
ROOM = 1_000_000  # values or faces beyond one a byte
MOST_PROPERTIES = 200  # and elements of a PLY; its parser takes the square of their number
PROPERTY = re.compile(rb"^[ \t]*(?:property|element)\b", re.MULTILINE)
# of an OBJ, solids of an STL; each becomes a mesh of its own, at the square of their number
MOST_GROUPS = 1000
GROUPS = {
    "obj": re.compile(rb"^[ \t]*(?:o|g|usemtl)\b[^\n]*", re.MULTILINE),
    "stl": re.compile(rb"^[ \t]*(?:end)?solid\b[^\n]*", re.MULTILINE | re.IGNORECASE),
}


def prepare(data: bytes, kind: str) -> bytes:
    """Return the bytes of a mesh file as they may be parsed: those of very many groups or solids
    with all in one.

    Raises ValueError for a file that claims far more than it holds, and whatever damaged JSON of a
    GLB leads to.
    """
    if kind == "glb":
        _check_accessors(data)
    if kind == "ply" and len(PROPERTY.findall(data.partition(b"end_header")[0])) > MOST_PROPERTIES:
        raise ValueError(f"its header has more than {MOST_PROPERTIES} properties")
    if kind == "obj" or (kind == "stl" and data[:5].lower() == b"solid"):
        return _join_groups(data, kind)
    return data


def check_instances(scene: Scene, size: int) -> None:
    """Raise ValueError for a scene whose meshes, each as often as it is placed, have more faces
    than such a file has.
    """
    placed = [scene.graph[name][1] for name in scene.graph.nodes_geometry]
    faces = sum(len(getattr(scene.geometry.get(name), "faces", ())) for name in placed)
    if faces > size + ROOM:
        raise ValueError(f"it places meshes of {faces} faces in all")


def _check_accessors(data: bytes) -> None:
    """Raise ValueError where accessors without bytes of their own, which are zeros, are more than
    the file has bytes.
    """
    if len(data) < GLB_HEAD.size:
        raise ValueError("it ends in its header")
    length = GLB_HEAD.unpack_from(data)[3]
    accessors = json.loads(data[GLB_HEAD.size : GLB_HEAD.size + length]).get("accessors", [])
    zeros = sum(max(0, accessor["count"]) for accessor in accessors if "bufferView" not in accessor)
    if zeros > len(data) + ROOM:
        raise ValueError(f"it claims {zeros} values that it does not hold")


def _join_groups(data: bytes, kind: str) -> bytes:
    groups = GROUPS[kind]
    if sum(1 for _ in groups.finditer(data)) <= MOST_GROUPS:
        return data
    joined = groups.sub(b"", data)
    return b"solid\n" + joined + b"\nendsolid\n" if kind == "stl" else joined
