# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the CAD model: its mesh in metres, cleaned, with outward normals."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from hullrecon.dive.check.messages import count_noun
from hullrecon.dive.config.config_errors import shorten
from hullrecon.dive.files import MIB, gunzip, read_regular
from hullrecon.dive.hull.cleaning import clean_mesh
from hullrecon.dive.hull.mirrors import ends_at_a_plane, find_boundary
from hullrecon.dive.hull.orientation import orient_outward
from hullrecon.dive.hull.parser_limits import check_instances, prepare
from hullrecon.errors import InputError
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.units import METRES_PER_UNIT, UNIT_NAMES
from hullrecon.typing import Array, Ints, Ints32

FORMATS = ("stl", "ply", "obj", "off", "glb")
LARGEST_BYTES = 2048 * MIB  # of a file, unpacked: 40 million triangles of a binary STL
# what any small file may unpack to, and how tightly; hulls pack by 2 to 15
FREE_BYTES, PACKED_BY = 64 * MIB, 50
SHORTEST_M, LONGEST_M = 5.0, 500.0  # of a ship hull


def read_hull(path: Path, units: str, messages: list[str]) -> Mesh:
    """Return the mesh, in metres with outward normals, of an STL, PLY, OBJ, OFF or GLB file,
    gzipped or not.

    What was found and repaired is added to messages. Raises InputError for a file that is no mesh
    or of a wrong size.
    """
    vertices, faces = _load(path)
    vertices = vertices * METRES_PER_UNIT[units]
    _check_extent(vertices[faces].reshape(-1, 3), units, path, messages)
    mesh = clean_mesh(Mesh(vertices, faces), messages)
    if not len(mesh.faces):
        raise InputError("the CAD model has no face with an area", where=str(path))
    mesh = orient_outward(mesh, messages)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = " x ".join(f"{s:.2f}" for s in high - low)
    messages.insert(
        0, f"{path.name}: {len(mesh.faces)} faces, {size} m, from {_point(low)} to {_point(high)}"
    )
    open_edges = len(find_boundary(mesh.faces))
    if open_edges:
        messages.append(f"the mesh is not watertight: {count_noun(open_edges, 'boundary edge')}")
        if ends_at_a_plane(mesh):
            messages.append(
                "the mesh ends open along a plane: what lies beyond, as a half hull's other half, is not added"
            )
    else:
        messages.append("the mesh is watertight")
    return mesh


def _load(path: Path) -> tuple[Array, Ints32]:
    name = path.name.lower().removesuffix(".gz")
    kind = name.rpartition(".")[2]
    if kind not in FORMATS:
        raise InputError(
            f"{path.name} is no CAD model that is read here",
            where="hull.mesh",
            remedy=f"give {', '.join(FORMATS)}",
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
    vertices, faces = _parse(data, kind, path)
    if not len(faces):
        raise InputError(f"the CAD model {path.name} holds no faces", where=str(path.parent))
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(
            f"faces of {path.name} name vertices that it does not have", where=str(path.parent)
        )
    return vertices, faces.astype(np.int32)


def _parse(data: bytes, kind: str, path: Path) -> tuple[Array, Ints]:
    """Return vertices (n, 3) and faces (m, 3) of a file's bytes. Raises InputError where they are
    none.
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
        reason = shorten(f"{type(error).__name__} {error}", 120)
        raise InputError(
            f"the CAD model {path.name} is no {kind.upper()}: {reason}", where=str(path.parent)
        ) from None
    return vertices, faces


def _check_extent(corners: Array, units: str, path: Path, messages: list[str]) -> None:
    if not np.isfinite(corners).all():
        raise InputError(
            f"the CAD model {path.name} has coordinates that are not finite", where=str(path.parent)
        )
    length = float(np.ptp(corners, axis=0).max())
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
        messages.append(
            f"{length_text}; a ship hull has {SHORTEST_M:.0f} to {LONGEST_M:.0f} m: is it a model?"
        )
        return
    guess = fits[0]
    raise InputError(
        f"{length_text}, which looks like {UNIT_NAMES[guess]} (it would be {in_file * METRES_PER_UNIT[guess]:.1f} m)",
        where="hull.units",
        remedy=f'set units = "{guess}" in [hull]',
    )


def _point(p: Array) -> str:
    return "(" + ", ".join(f"{c:.2f}" for c in p) + ")"
