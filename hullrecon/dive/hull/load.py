# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The CAD model: its mesh in metres, cleaned, with its normals outward, and in words what was found."""

from __future__ import annotations

import gzip
import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.hull.cleaning import cleaned
from hullrecon.dive.hull.mirrors import boundary
from hullrecon.dive.hull.orientation import outward
from hullrecon.errors import InputError
from hullrecon.geometry.meshes.mesh import Mesh

METRES = {"m": 1.0, "mm": 0.001, "cm": 0.01, "ft": 0.3048, "in": 0.0254}
NAMES = {"m": "metres", "mm": "millimetres", "cm": "centimetres", "ft": "feet", "in": "inches"}
FORMATS = ("stl", "ply", "obj", "off", "glb")
SHORTEST_M, LONGEST_M = 5.0, 500.0  # of a ship hull


def read_hull(path: Path, units: str, words: list[str]) -> Mesh:
    """The mesh of an STL, PLY, OBJ, OFF or GLB file, gzipped or not. InputError for one that is none or of a wrong size."""
    vertices, faces = _load(path)
    vertices = vertices * METRES[units]
    _check_extent(vertices[faces].reshape(-1, 3), units, path, words)
    mesh = cleaned(Mesh(vertices, faces), words)
    if not len(mesh.faces):
        raise InputError("the CAD model has no face with an area", where=str(path))
    mesh = outward(mesh, words)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = " x ".join(f"{s:.2f}" for s in high - low)
    words.insert(0, f"{path.name}: {len(mesh.faces)} faces, {size} m, from {_point(low)} to {_point(high)}")
    holes = len(boundary(mesh.faces))
    words.append(
        f"{holes} edges have a face on one side only: the CAD model is open there" if holes else "the CAD model is closed"
    )
    return mesh


def _load(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    name = path.name.lower().removesuffix(".gz")
    kind = name.rpartition(".")[2]
    if kind not in FORMATS:
        raise InputError(
            f"{path.name} is no CAD model that is read here", where="hull.mesh", remedy=f"give {', '.join(FORMATS)}"
        )
    try:
        data = path.read_bytes()
        data = gzip.decompress(data) if path.suffix.lower() == ".gz" else data
    except FileNotFoundError:
        raise InputError(f"the CAD model {path.name} is missing", where=str(path.parent), remedy="correct hull.mesh") from None
    except (OSError, EOFError, ValueError) as error:
        raise InputError(f"the CAD model {path.name} cannot be read: {error}", where=str(path.parent)) from None
    mesh = _parse(data, kind, path)
    vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
    if not len(faces):
        raise InputError(f"the CAD model {path.name} holds no faces", where=str(path.parent))
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(f"faces of {path.name} name vertices that it does not have", where=str(path.parent))
    return vertices, faces.astype(np.int32)


def _parse(data: bytes, kind: str, path: Path) -> Any:
    import trimesh

    try:
        return trimesh.load_scene(io.BytesIO(data), file_type=kind, process=False).to_mesh()
    except Exception as error:  # trimesh's parsers raise whatever damaged bytes lead them to
        reason = f"{type(error).__name__} {error}".splitlines()[0][:120]
        raise InputError(f"the CAD model {path.name} is no {kind.upper()}: {reason}", where=str(path.parent)) from None


def _check_extent(corners: NDArray[np.float64], units: str, path: Path, words: list[str]) -> None:
    if not np.isfinite(corners).all():
        raise InputError(f"the CAD model {path.name} has coordinates that are not finite", where=str(path.parent))
    length = float(np.ptp(corners, axis=0).max())
    if SHORTEST_M <= length <= LONGEST_M:
        return
    told = f"the CAD model {path.name} is {length:.4g} m long when read in {NAMES[units]}"
    fits = [other for other in METRES if SHORTEST_M <= length / METRES[units] * METRES[other] <= LONGEST_M]
    if not fits:
        words.append(f"{told}; a ship hull has {SHORTEST_M:.0f} to {LONGEST_M:.0f} m: is it a model?")
        return
    guess = fits[0]
    raise InputError(
        f"{told}, which looks like {NAMES[guess]} (it would be {length / METRES[units] * METRES[guess]:.1f} m)",
        where="hull.units", remedy=f'set units = "{guess}" in [hull]',
    )  # fmt: skip


def _point(p: NDArray[np.float64]) -> str:
    return "(" + ", ".join(f"{c:.2f}" for c in p) + ")"
