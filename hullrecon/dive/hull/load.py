# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the CAD model: its mesh in metres, cleaned, with outward normals."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hullrecon.dive.hull.hidden_faces import leave_out_hidden
from hullrecon.dive.hull.mesh_files import load_mesh
from hullrecon.dive.hull.mirrors import ends_at_a_plane, find_boundary
from hullrecon.dive.hull.orientation import orient_outward
from hullrecon.dive.hull.precision import stored_step
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.meshes.mesh import Mesh, face_areas
from hullrecon.geometry.meshes.units import LONGEST_M, METRES_PER_UNIT, SHORTEST_M, UNIT_NAMES
from hullrecon.typing import Array, Ints32, Mask

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


def read_hull(path: Path, units: str, notes: list[Finding]) -> Mesh:
    """Read an STL, PLY, OBJ, OFF or GLB file, gzipped or not, in metres with outward normals.

    Faces that are degenerate, there twice, or hidden inside the hull are left out. Defects and
    repairs are added to notes. Raises InputError for a file that is no mesh, one whose size is no
    ship's in this unit, and one whose coordinates are too coarse.

    units: of the file, a key of METRES_PER_UNIT.
    """
    stored, faces, is_single = load_mesh(path)
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

    Far from the origin, single precision has coarse steps. step_m: between stored coordinates.
    vertices: (n, 3) m. notes: to which the finding is added.
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
    """Merge vertices (n, 3) m that lie in one cell of a grid of the tolerance, m, into the first.

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
