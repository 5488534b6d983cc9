# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the CAD model: its mesh in metres, cleaned, with outward normals.

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
from hullrecon.dive.files import (
    LFS_POINTER,
    LFS_WORDS,
    MIB,
    gunzip,
    marked_coding,
    read_regular,
)
from hullrecon.dive.hull.hidden_faces import leave_out_hidden
from hullrecon.dive.hull.mirrors import ends_at_a_plane, find_boundary
from hullrecon.dive.hull.orientation import orient_outward
from hullrecon.dive.hull.precision import stored_step
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.meshes.mesh import Mesh, face_areas
from hullrecon.geometry.meshes.units import LONGEST_M, METRES_PER_UNIT, SHORTEST_M, UNIT_NAMES
from hullrecon.typing import Array, Ints, Ints32, Mask

if TYPE_CHECKING:
    from trimesh import Scene

FORMATS = ("stl", "ply", "obj", "off", "glb")
LARGEST_BYTES = 2048 * MIB  # of a file, unpacked: 40 million triangles of a binary STL
# bytes that any file may unpack to, and how many times its size; hulls pack by 2 to 15
FREE_BYTES, PACKED_BY = 64 * MIB, 50
STRAY_PERCENT = 1.0  # of the corners, at either end of an axis, that may not be of the ship
NARROWEST = 0.01  # second largest extent over the largest; plates of a hull have 0.05 and more
MERGE = 2e-7  # of the largest extent: two steps of single precision, in which STL stores corners
# gap between two bodies, as a share of the whole length; size of the smaller body, as a share of
# the larger one's, from which on it may be a ship
LEAST_GAP, LEAST_BODY = 0.01, 0.3
FINEST_M = 1e-6  # no CAD model is finer
# Steps in which coordinates are stored. The first makes an error of 3 mm (step / sqrt(12)), beside
# the 20 mm by which hulls deviate from their CAD model. The second is not seen in any deviation
COARSEST_STEP_M, FINE_STEP_M = 0.01, 0.001
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


def read_hull(path: Path, units: str, notes: list[Finding]) -> Mesh:
    """Read an STL, PLY, OBJ, OFF or GLB file, gzipped or not, in metres with outward normals.

    Faces that are degenerate, there twice, or hidden inside the hull are left out. Defects and
    repairs are added to notes. Raises InputError for a file that is no mesh, one whose size is no
    ship's in this unit, and one whose coordinates are too coarse.

    units: of the file, a key of METRES_PER_UNIT.
    """
    stored, faces, is_single = _load_mesh(path)
    vertices = stored * METRES_PER_UNIT[units]
    _check_extent(vertices[faces].reshape(-1, 3), units, path, notes)
    step = stored_step(stored[np.unique(faces)], is_single)
    _check_step(METRES_PER_UNIT[units] * step, vertices, path, notes)
    mesh = clean_mesh(Mesh(vertices, faces), notes)
    if not len(mesh.faces):
        raise InputError("the CAD model has no face with an area", where=str(path))
    mesh = orient_outward(leave_out_hidden(mesh, notes), notes)
    notes += find_bodies_apart(mesh)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    values = {"file": path.name, "faces": len(mesh.faces)}
    corners = {"low_m": low.tolist(), "high_m": high.tolist()}
    notes.insert(0, Finding("mesh-read", {**values, **corners}))
    open_edges = len(find_boundary(mesh.faces))
    if open_edges:
        notes.append(Finding("mesh-open", {"edges": open_edges}))
        if ends_at_a_plane(mesh):
            notes.append(Finding("mesh-cut"))
    else:
        notes.append(Finding("mesh-closed"))
    return mesh


def _load_mesh(path: Path) -> tuple[Array, Ints32, bool]:
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


def _check_extent(corners: Array, units: str, path: Path, notes: list[Finding]) -> None:
    """Raise InputError for a CAD model whose size is no ship's, with the units in which it is.

    One that is a ship in no unit is only noted: it may be a model of a ship.

    Parameters
    ----------
    corners : (3 m, 3) corners of all faces, metres
    units : key of METRES_PER_UNIT by which they were converted
    path : of the file
    notes : a finding is added for one that is a ship in no unit
    """
    if not np.isfinite(corners).all():
        raise InputError(
            f"the CAD model {path.name} has coordinates that are not finite", where=str(path.parent)
        )
    narrow, length = np.sort(np.ptp(corners, axis=0))[1:].tolist()
    _refuse_stray(corners, length, path)
    if narrow < NARROWEST * length:
        raise InputError(
            f"the CAD model {path.name} is {length:.4g} m in one direction and at most "
            f"{narrow:.2g} m in the others: its axes are not in one unit (longitude and latitude "
            "in degrees?), or it is no surface",
            where="hull.mesh",
            remedy="export it with all axes in metres",
        )
    if SHORTEST_M <= length <= LONGEST_M:
        return
    length_text = (
        f"the CAD model {path.name} is {length:.4g} m long when read in {UNIT_NAMES[units]}"
    )
    in_file = length / METRES_PER_UNIT[units]
    fits = [
        unit
        for unit, metres in METRES_PER_UNIT.items()
        if SHORTEST_M <= in_file * metres <= LONGEST_M
    ]
    if not fits:
        values = {"file": path.name, "length_m": length, "units": UNIT_NAMES[units]}
        limits = {"shortest_m": SHORTEST_M, "longest_m": LONGEST_M}
        notes.append(Finding("mesh-small", {**values, **limits}))
        return
    looks_like = " or ".join(
        f"{UNIT_NAMES[unit]} (it would be {in_file * METRES_PER_UNIT[unit]:.1f} m)" for unit in fits
    )
    named = " or ".join(f'units = "{unit}"' for unit in fits)
    raise InputError(
        f"{length_text}, which looks like {looks_like}",
        where="hull.units",
        remedy=f"set {named} in [hull]",
    )


def _refuse_stray(corners: Array, length: float, path: Path) -> None:
    """Raise InputError where a few faces lie more than the ship's length away from all others.

    corners: (3 m, 3) of the m faces, metres. length: of the whole, with those faces, metres.
    """
    low, high = np.percentile(corners, [STRAY_PERCENT, 100 - STRAY_PERCENT], axis=0)
    size = float((high - low).max())
    is_stray = ((corners < low - size) | (corners > high + size)).any(axis=1).reshape(-1, 3)
    if not is_stray.any() or not SHORTEST_M <= size <= LONGEST_M:
        return
    place = ", ".join(f"{value:.1f}" for value in corners[int(np.argmax(is_stray.ravel()))])
    raise InputError(
        f"{int(is_stray.any(axis=1).sum())} of {len(is_stray)} faces of {path.name} lie or reach "
        f"far from all others, which are {size:.0f} m long: with them it is {length:.4g} m long "
        f"(one has a corner at {place})",
        where="hull.mesh",
        remedy="remove from it what is no hull, as a plane of water or a mark at the origin",
    )


def _check_step(step_m: float, vertices: Array, path: Path, notes: list[Finding]) -> None:
    """Refuse coordinates that are stored in steps too coarse for a hull, and note less coarse ones.

    Far from the origin, single precision has coarse steps.
    """
    farthest_m = float(np.abs(vertices).max())
    if step_m > COARSEST_STEP_M:
        raise InputError(
            f"the coordinates of {path.name} reach {farthest_m:.0f} m and are stored in steps of "
            f"{step_m:.2g} m there, too coarse for a hull",
            where="hull.mesh",
            remedy="export it about an origin near the ship (hull.pose is of that origin then), or "
            "as OBJ or PLY with double precision",
        )
    if step_m > FINE_STEP_M:
        notes.append(Finding("mesh-steps", {"step_m": step_m, "farthest_m": farthest_m}))


def clean_mesh(mesh: Mesh, notes: list[Finding]) -> Mesh:
    """Merge equal corners, and remove degenerate and duplicate faces and unused corners.

    What was removed is added to notes.
    """
    tolerance = max(FINEST_M, MERGE * float(np.ptp(mesh.vertices, axis=0).max()))
    vertices, faces = merge_corners(mesh.vertices, mesh.faces, tolerance)
    flat = find_degenerate(Mesh(vertices, faces), tolerance)
    faces = faces[~flat]
    first = np.sort(np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1])
    for count, name in ((int(flat.sum()), "degenerate"), (len(faces) - len(first), "duplicate")):
        if count:
            notes.append(Finding("mesh-faces-removed", {"count": count, "kind": name}))
    used, renumbered = np.unique(faces[first], return_inverse=True)
    return Mesh(vertices[used], renumbered.reshape(-1, 3).astype(np.int32))


def find_bodies_apart(mesh: Mesh) -> list[Finding]:
    """Report two bodies with a gap between them, each large enough to be a ship.

    Such a file may hold two ships. Gaps are sought along each axis, and one finding is returned at
    most.
    """
    corners = mesh.vertices[mesh.faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    length = float(np.ptp(mesh.vertices, axis=0).max())
    for axis, name in enumerate("xyz"):
        order = np.argsort(low[:, axis])
        reached = np.maximum.accumulate(high[order, axis])
        gap = low[order[1:], axis] - reached[:-1]
        for at in np.flatnonzero(gap > LEAST_GAP * length):
            parts = order[: at + 1], order[at + 1 :]
            sizes = [float((high[p].max(axis=0) - low[p].min(axis=0)).max()) for p in parts]
            if min(sizes) > LEAST_BODY * max(sizes):
                values = {"axis": name, "gap_m": float(gap[at]), "sizes_m": sizes}
                return [Finding("mesh-bodies", values)]
    return []


def merge_corners(vertices: Array, faces: Ints32, tolerance: float) -> tuple[Array, Ints32]:
    """Merge corners that lie in one cell of a grid of the tolerance, m, into the first of them.

    Faces are then connected: an STL stores each corner once for every face. Returns the corners
    that stay, in the order of the file, and the faces (m, 3) renumbered.
    """
    cells = np.round((vertices - vertices.min(axis=0)) / tolerance).astype(np.int64)
    _, first, number = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")  # corners keep the order of the file
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return vertices[first[order]], rank[number.ravel()][faces].astype(np.int32)


def find_degenerate(mesh: Mesh, tolerance: float) -> Mask:
    """Find the faces (m,) whose height over their longest side is below the tolerance, m."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    longest = np.max([np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=0)
    return np.asarray(2 * face_areas(mesh) <= tolerance * longest)


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
