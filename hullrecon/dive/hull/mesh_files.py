# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the faces of a mesh file of any form.

trimesh does not check the sizes that a file claims. Files that claim far more than they hold, or on
which its parsers take quadratic time, are refused or rewritten before it sees them.
"""

from __future__ import annotations

import io
import json
import re
import struct
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hullrecon.dive.config.config_errors import shorten
from hullrecon.dive.files import LFS_POINTER, LFS_WORDS, MIB, gunzip, marked_coding, read_regular
from hullrecon.errors import InputError
from hullrecon.typing import Array, Ints, Ints32

if TYPE_CHECKING:
    from trimesh import Scene

FORMATS = ("stl", "ply", "obj", "off", "glb")
LARGEST_BYTES = 2048 * MIB  # of a file, unpacked: 40 million triangles of a binary STL
# bytes that any file may unpack to, and how many times its size; hulls pack by 2 to 15
FREE_BYTES, PACKED_BY = 64 * MIB, 50
# magic, version, length; length and type of the first chunk, which is JSON
GLB_HEAD = struct.Struct("<4sIIII")
STL_HEAD, STL_FACE = 84, 50  # bytes of a binary STL: before its faces, and of each
# .gltf names further files, which may lie anywhere
IN_ONE_FILE = "save it as GLB, which is glTF in one file"
COPY_AGAIN = "copy or export it again"
TAIL = 1 << 10  # bytes, in which an STL of text ends
_SAY_SO = "name it by what it is"
# by the first bytes of a file: what it is, and what to do
OTHER_KINDS = (
    (re.compile(re.escape(LFS_POINTER)), LFS_WORDS),
    (
        re.compile(rb"\s*ISO-10303-21"),
        ("a STEP file", f"export a mesh of its surface as {', '.join(FORMATS)}"),
    ),
    (  # 72 columns of a card, then the section's letter and the card's number
        re.compile(rb"[^\r\n]{72}S +1\r?\n"),
        ("an IGES file", f"export a mesh of its surface as {', '.join(FORMATS)}"),
    ),
    (re.compile(rb"PK\x03\x04|7z\xbc\xaf"), ("a packed archive", "unpack it")),
    (re.compile(rb"\x1f\x8b"), ("packed by gzip", "add .gz to its name")),
    (re.compile(rb"\s*<"), ("a page of the web or XML", "fetch the file itself")),
    (re.compile(rb"(\s*#[^\n]*\n)*\s*(mtllib|o|g|v)\s"), ("an obj file", _SAY_SO)),
    (re.compile(rb"ply\s"), ("a ply file", _SAY_SO)),
    (re.compile(rb"glTF"), ("a glb file", _SAY_SO)),
)
DECIMAL_COMMA = re.compile(rb"^\s*(?:vertex|v)\s+[-+]?\d+,\d", re.MULTILINE)
ZERO_INDEX = re.compile(rb"(?m)^f[ \t](?:[^\n]*[ \t])?0(?:/|[ \t\r]|$)")  # of a face's vertex
# as Fortran writes numbers of double precision
FORTRAN_EXPONENT = re.compile(rb"(\d)[Dd]([-+]?\d)")
ROOM = 1_000_000  # values or faces that a file may claim beyond one for each of its bytes
MOST_PROPERTIES = 200  # and elements of a PLY: its parser's time grows with their square
PROPERTY = re.compile(rb"^[ \t]*(?:property|element)\b", re.MULTILINE)
# groups of an OBJ or solids of an STL: each becomes a mesh of its own, in time that grows with the
# square of their number
MOST_GROUPS = 1000
GROUPS = {
    "obj": re.compile(rb"^[ \t]*(?:o|g|usemtl)\b[^\n]*", re.MULTILINE),
    "stl": re.compile(rb"^[ \t]*(?:end)?solid\b[^\n]*", re.MULTILINE | re.IGNORECASE),
}


def load_mesh(path: Path) -> tuple[Array, Ints32, bool]:
    """Read vertices (n, 3) in the file's unit, faces (m, 3), and whether it has single precision.

    Raises InputError for a file that is missing, damaged, no mesh, or of another kind than its name
    says.
    """
    name = path.name.lower().removesuffix(".gz")
    kind = name.rpartition(".")[2]
    if kind not in FORMATS:
        raise InputError(
            f"{path.name} is no CAD model that is read here",
            where="hull.mesh",
            remedy=IN_ONE_FILE
            if kind == "gltf"
            else f"export a mesh of its surface as {', '.join(FORMATS)}",
        )
    try:
        data = read_regular(path, LARGEST_BYTES)
        if path.suffix.lower() == ".gz":
            data = gunzip(data, min(LARGEST_BYTES, max(FREE_BYTES, PACKED_BY * len(data))))
    except FileNotFoundError:
        raise InputError(
            f"the CAD model {path.name} is missing",
            where=str(path.parent),
            remedy="correct hull.mesh",
        ) from None
    except (OSError, ValueError) as error:
        why = shorten(getattr(error, "strerror", None) or str(error), 160)
        raise InputError(
            f"the CAD model {path.name} cannot be read: {why}", where=str(path.parent)
        ) from None
    data = recode(data)
    _refuse_other_kind(data, kind, path)
    vertices, faces = _parse_mesh(data, kind, path)
    if not len(faces):
        raise InputError(
            f"the CAD model {path.name} holds no faces",
            where=str(path.parent),
            remedy="export a mesh of triangles: points, curves and STEP are not read",
        )
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(
            f"faces of {path.name} name vertices that it does not have", where=str(path.parent)
        )
    return vertices, faces.astype(np.int32), kind == "stl" and is_binary_stl(data)


def recode(data: bytes) -> bytes:
    """Convert a text that begins with the mark of its coding to UTF-8 without a mark.

    All other bytes are returned unchanged.
    """
    coding = marked_coding(data)
    try:
        return data.decode(coding).encode() if coding else data
    except UnicodeDecodeError:  # a binary file may begin so
        return data


def _refuse_other_kind(data: bytes, kind: str, path: Path) -> None:
    """Raise InputError for a file that is not what its name says, or that is cut off.

    data: its bytes. kind: one of FORMATS, by its name.
    """
    if not data:
        raise InputError(
            f"the CAD model {path.name} is empty", where=str(path.parent), remedy=COPY_AGAIN
        )
    found = [words for magic, words in OTHER_KINDS if magic.match(data)]
    if found and kind not in found[0][0]:
        what, remedy = found[0]
        raise InputError(
            f"the CAD model {path.name} is {what}", where=str(path.parent), remedy=remedy
        )
    is_binary = kind == "stl" and is_binary_stl(data)
    if is_binary and len(data) >= STL_HEAD:
        claimed, held = claimed_faces(data), (len(data) - STL_HEAD) // STL_FACE
        if int.from_bytes(data[STL_HEAD - 4 : STL_HEAD], "big") == held != claimed:
            raise InputError(
                f"the numbers of {path.name} begin with their high bytes, as those of no STL do",
                where=str(path.parent),
                remedy=COPY_AGAIN,
            )
        if claimed > held:
            raise InputError(
                f"the CAD model {path.name} is cut off: it holds {held} of {claimed} faces",
                where=str(path.parent),
                remedy=COPY_AGAIN,
            )
    if kind == "stl" and not is_binary and b"endsolid" not in data[-TAIL:].lower():
        raise InputError(
            f"the CAD model {path.name} is cut off: it has no endsolid",
            where=str(path.parent),
            remedy=COPY_AGAIN,
        )


def is_binary_stl(data: bytes) -> bool:
    """Tell a binary STL, whose header may begin with "solid" too, from one of text.

    Only the latter has no byte of zero up to the end of its first face.
    """
    is_text = data.lstrip()[: len("solid")].lower() == b"solid"
    return not is_text or b"\0" in data[: STL_HEAD + STL_FACE]


def claimed_faces(data: bytes) -> int:
    """Read the number of faces that a binary STL states."""
    return int.from_bytes(data[STL_HEAD - 4 : STL_HEAD], "little")


def _parse_mesh(data: bytes, kind: str, path: Path) -> tuple[Array, Ints]:
    """Parse a mesh file's bytes into vertices (n, 3), in its unit, and faces (m, 3).

    Raises InputError where the parser fails, in whatever way. kind: one of FORMATS.
    """
    import trimesh

    try:
        scene = trimesh.load_scene(
            io.BytesIO(prepare(data, kind)), file_type=kind, process=False, skip_materials=True
        )
        check_instances(scene, len(data))
        mesh = scene.to_mesh()
        vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
        if vertices.shape[1:] != (3,) or faces.shape[1:] != (3,) or faces.dtype.kind not in "iu":
            raise ValueError(
                f"it has vertices of {vertices.shape[1:]} and faces of {faces.shape[1:]} numbers"
            )
    except Exception as error:  # trimesh's parsers raise whatever damaged bytes lead them to
        said = f"{error}" if type(error) is ValueError else f"{type(error).__name__} {error}"
        reason = shorten(said, 120)
        raise InputError(
            f"the CAD model {path.name} is no {kind.upper()}, or damaged: {reason}",
            where=str(path.parent),
            remedy=COPY_AGAIN,
        ) from None
    return vertices, faces


def prepare(data: bytes, kind: str) -> bytes:
    """Check a mesh file's claims before it is parsed, and join very many groups or solids into one.

    Without that a small file takes the parser hours or all memory. Raises ValueError for a file
    that claims far more than it holds, and for decimal commas. Damaged JSON in a GLB may raise
    anything.

    kind: one of FORMATS.
    """
    if kind == "glb":
        _check_accessors(data)
    if kind == "ply" and len(PROPERTY.findall(data.partition(b"end_header")[0])) > MOST_PROPERTIES:
        raise ValueError(f"its header has more than {MOST_PROPERTIES} properties")
    if kind in ("stl", "obj") and DECIMAL_COMMA.search(data[:MIB]):
        raise ValueError("its numbers have decimal commas: export it with points")
    if kind == "obj" and ZERO_INDEX.search(data):
        raise ValueError("its faces count vertices from 0, and those of an OBJ count from 1")
    if kind == "stl" and is_binary_stl(data):
        return data[: STL_HEAD + STL_FACE * claimed_faces(data)]  # some programs write more behind
    if kind in ("stl", "obj", "off"):
        data = data.lstrip()
        if FORTRAN_EXPONENT.search(data[:MIB]):
            data = FORTRAN_EXPONENT.sub(rb"\1E\2", data)
    return _join_groups(data, kind) if kind in GROUPS else data


def check_instances(scene: Scene, size: int) -> None:
    """Raise ValueError for a scene that places its meshes so often that a small file is huge."""
    placed = [scene.graph[name][1] for name in scene.graph.nodes_geometry]
    faces = sum(len(getattr(scene.geometry.get(name), "faces", ())) for name in placed)
    if faces > size + ROOM:
        raise ValueError(f"it places meshes of {faces} faces in all")


def _check_accessors(data: bytes) -> None:
    """Raise ValueError for a GLB whose meshes are packed, or that claims more than it holds.

    An accessor without a buffer stands for zeros, as many as it states.
    """
    if len(data) < GLB_HEAD.size:
        raise ValueError("it ends in its header")
    length = GLB_HEAD.unpack_from(data)[3]
    scene = json.loads(data[GLB_HEAD.size : GLB_HEAD.size + length])
    packed = [name for name in scene.get("extensionsRequired", []) if "compression" in name]
    if packed:
        raise ValueError(f"its meshes are packed by {packed[0]}: export it without compression")
    accessors = scene.get("accessors", [])
    zeros = sum(max(0, accessor["count"]) for accessor in accessors if "bufferView" not in accessor)
    if zeros > len(data) + ROOM:
        raise ValueError(f"it claims {zeros} values that it does not hold")


def _join_groups(data: bytes, kind: str) -> bytes:
    """Drop the lines that begin groups of an OBJ or solids of an STL, where there are very many."""
    groups = GROUPS[kind]
    if sum(1 for _ in groups.finditer(data)) <= MOST_GROUPS:
        return data
    joined = groups.sub(b"", data)
    return b"solid\n" + joined + b"\nendsolid\n" if kind == "stl" else joined
