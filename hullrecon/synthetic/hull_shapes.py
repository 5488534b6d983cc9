# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Hulls: an analytic ship form, or any mesh.

The hull's frame: x forward from the aft end, y port, z up from the keel.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.config.config_errors import shorten
from hullrecon.errors import InputError
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.options import Ship
from hullrecon.typing import Array

STATIONS, POINTS = (
    64,
    44,
)  # number of sections of the analytic ship, and of points of half a section


def hull_shape(ship: Ship) -> Mesh:
    """Build the CAD model."""
    if ship.hull == "form":
        return ship_form(ship)
    return hull_from_mesh(Path(ship.hull), ship.length_m)


def ship_form(ship: Ship) -> Mesh:
    """Build a closed hull with a parallel midbody, round bilges, and curved ends."""
    x = _stations(ship, STATIONS)
    port = np.stack([_section(ship, xi, POINTS) for xi in x])  # (stations, points, 3), keel to deck
    # From the deck down, without the point at the keel, which port has
    starboard = port[:, :0:-1] * [1, -1, 1]
    rings = np.concatenate([starboard, port], axis=1)
    faces = np.vstack([_side_faces(*rings.shape[:2]), _cap_faces(*rings.shape[:2])])[:, ::-1]
    return Mesh(rings.reshape(-1, 3), np.ascontiguousarray(faces, np.int32))


def hull_from_mesh(path: Path, length_m: float | None = None) -> Mesh:
    """Read a mesh as hull, with its aft end at x = 0 and its lowest point at z = 0.

    It is scaled to length_m, if given. Raises InputError if there is no such file, or if the mesh
    has no triangles or no length along x.
    """
    import trimesh

    if not os.path.isfile(path):  # False, too, for names that no file can have
        raise InputError("there is no such hull mesh", where=str(path), remedy="correct --hull")
    remedy = "give an STL, PLY, OBJ or OFF file"
    try:
        loaded = trimesh.load(path, force="mesh", process=True)
    except Exception as error:  # trimesh's parsers raise errors of any type for damaged files
        reason = shorten(f"{type(error).__name__} {error}", 120)
        raise InputError(
            f"the hull mesh cannot be read, {reason}", where=str(path), remedy=remedy
        ) from None
    if not isinstance(loaded, trimesh.Trimesh) or len(loaded.faces) == 0:
        raise InputError("the hull mesh holds no triangles", where=str(path), remedy=remedy)
    vertices = np.asarray(loaded.vertices, float)
    low, high = vertices.min(0), vertices.max(0)
    if not high[0] > low[0]:
        raise InputError(
            "the hull mesh has no length along x",
            where=str(path),
            remedy="give one with the bow towards +x",
        )
    scale = 1.0 if length_m is None else length_m / (high[0] - low[0])
    return Mesh((vertices - [low[0], 0.0, low[2]]) * scale, np.asarray(loaded.faces, np.int32))


def write_stl(path: Path, mesh: Mesh) -> None:
    """Write a binary STL with an empty header, the same bytes for the same mesh."""
    triangles = mesh.vertices[mesh.faces]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    row = np.zeros(
        len(triangles),
        np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("attribute", "<u2")]),
    )
    row["normal"], row["corner"] = normal, triangles
    path.write_bytes(bytes(80) + np.uint32(len(row)).tobytes() + row.tobytes())


def _stations(ship: Ship, count: int) -> Array:
    """Choose the positions (n,) of the sections along the ship, denser at the curved ends."""
    end = ship.entrance * ship.length_m
    share = np.linspace(0, 1, count * 2 // 5)
    aft, fore = end * share**1.2, ship.length_m - end * share[::-1] ** 1.2
    middle = np.linspace(end, ship.length_m - end, count - 2 * len(share) + 2)[1:-1]
    return np.concatenate([aft, middle, fore])


def _section(ship: Ship, x: float, count: int) -> Array:
    """Compute half a section (count, 3) m on port, from keel to deck: flat, bilge arc, side.

    x: of the section from the aft end, m. Towards the ends it becomes narrower and rounder, leans
    and rises.
    """
    end = ship.entrance * ship.length_m
    # 0 on the parallel midbody, 1 at the very end.
    s = max(0.0, 1 - min(x, ship.length_m - x) / end)
    half = 0.5 * ship.beam_m * (1 - 0.97 * s**2.2)
    radius = min(
        ship.bilge_radius_m + (ship.depth_m - ship.bilge_radius_m) * 0.8 * s,
        0.98 * half,
        0.9 * ship.depth_m,
    )
    turn = np.linspace(0, np.pi / 2, count - 16)
    flat = np.linspace(0, half - radius, 7)[:-1]
    arc_y, arc_z = half - radius + radius * np.sin(turn), radius * (1 - np.cos(turn))
    side = np.linspace(radius, ship.depth_m, 11)[1:]
    y = np.concatenate([flat, arc_y, np.full(10, half)])
    z = np.concatenate([np.zeros(6), arc_z, side])
    lean = 0.12 * s * half * (z / ship.depth_m - 1)
    rise = 0.25 * ship.depth_m * s**3 * (1 - z / ship.depth_m)
    return np.stack(
        [np.full(count, x), np.maximum(0.0, y + lean * (y / max(half, 1e-9))), z + rise], axis=1
    )


def _side_faces(rings: int, points: int) -> NDArray[np.int64]:
    """List the triangles between `rings` sections of `points` vertices each, in order."""
    node = np.arange(rings * points).reshape(rings, points)
    a, b, c, d = node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]
    return np.concatenate(
        [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
    )


def _cap_faces(rings: int, points: int) -> NDArray[np.int64]:
    """Close the deck between both sheer lines, and the two ends.

    rings: stations of the hull. points: of a station, from sheer line over the keel to the other.
    """
    node = np.arange(rings * points).reshape(rings, points)
    first, last = node[:, 0], node[:, -1]
    deck = [
        np.stack([first[:-1], last[1:], first[1:]], -1),
        np.stack([first[:-1], last[:-1], last[1:]], -1),
    ]
    fan = [
        np.stack([np.full(points - 2, r[0]), r[1:-1], r[2:]], -1) for r in (node[0], node[-1, ::-1])
    ]
    return np.concatenate([*deck, *fan])
