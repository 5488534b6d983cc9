# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Cast the sections of a hull: choose the axis, cast rays, tell skin from jumps between parts."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hullrecon.errors import InputError
from hullrecon.geometry.charts.sections import Sections
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Mask

AXES = "xyz"
# Cosine of 83 degrees. A line between the hits of two neighbouring rays that is more oblique to
# them lies on the skin only if its middle is near the mesh.
GRAZING = 0.12
# Largest distance of that middle from the mesh, as a share of the line's length
OFF_SKIN = 0.1
SHORT_OFF_SKIN = 0.3  # the same of a line that is no longer than its rays' spacing explains
NEARLY_ALL = 0.995  # least share of the skin that an axis sees, of the largest that any sees


def hull_axes(vertices: Array, up: Array, bow: str | None = None) -> Array:
    """Choose the ship's axes: rows (3, 3) forward, port, up in the mesh's frame.

    vertices: (n, 3) m of the mesh. Up is the axis of the frame nearest to `up`. Forward is the
    longer of the other two axes, reversed if `bow` says so ("-x"). Raises InputError for a bow
    along another axis.
    """
    size = np.ptp(vertices, axis=0)
    vertical = int(np.argmax(np.abs(up)))
    level = [i for i in range(3) if i != vertical]
    forward = level[int(np.argmax(size[level]))]
    if bow is not None and bow[1] != AXES[forward]:
        raise _wrong_bow(bow, AXES[forward], dict(zip(AXES, size, strict=True)), AXES[vertical])
    rows = np.zeros((3, 3))
    rows[0, forward], rows[2, vertical] = (
        -1.0 if bow is not None and bow[0] == "-" else 1.0,
        1.0 if up[vertical] > 0 else -1.0,
    )
    rows[1] = np.cross(rows[2], rows[0])
    return rows


def first_station(vertices: Array, forward: Array, aft_perpendicular_m: float | None) -> float:
    """Find the coordinate, m, along `forward` (3,) from which stations count.

    vertices: (n, 3) m of the mesh. It is the aft perpendicular, which is given as a coordinate on
    the mesh's axis. If it is None, it is zero, or the aft end of the mesh where zero is farther
    from the ship than its length, as with map coordinates.
    """
    if aft_perpendicular_m is not None:
        return float(forward.sum()) * aft_perpendicular_m
    along = vertices @ forward
    aft, bow = float(along.min()), float(along.max())
    return aft if aft > bow - aft or -bow > bow - aft else 0.0


def _wrong_bow(bow: str, forward: str, size: Mapping[str, float], vertical: str) -> InputError:
    """Build the error for a bow along an axis that is not the ship's longitudinal axis.

    Parameters
    ----------
    bow
        As given, "+x" to "-z".
    forward, vertical
        Names of the ship's longitudinal and vertical axes.
    size
        Length of the CAD model along each axis, m.
    """
    other = bow[1]
    is_vertical = f"{other} is up or down by hull.pose, and " if other == vertical else ""
    what = f"the bow cannot lie at {bow}: {is_vertical}"
    what += f"the CAD model is {size[forward]:.1f} m along {forward}"
    shorter = "" if is_vertical else f", {size[other]:.1f} m along {other}"
    return InputError(
        what + shorter,
        where="hull.bow",
        remedy=f'give "+{forward}" or "-{forward}", or correct hull.pose, which says what is up',
    )


def outward_faces(mesh: Mesh, sections: Sections) -> Mesh:
    """Orient each connected piece of a mesh so that the sections' rays meet its outer side.

    Pieces that no ray meets are left unchanged.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    # The connected piece of each face. Vertices at equal positions are one.
    _, corner = np.unique(mesh.vertices, axis=0, return_inverse=True)
    a, b = np.hstack([corner[mesh.faces[:, [0, 1]]].T, corner[mesh.faces[:, [1, 2]]].T])
    size = int(corner.max()) + 1
    _, piece = connected_components(
        coo_array((np.ones(len(a), bool), (a, b)), shape=(size, size)), directed=False
    )
    piece = piece[corner[mesh.faces[:, 0]]]
    # The rays that meet a piece vote whether its normals point along them
    origin, inward = sections.rays(*_pairs(sections))
    hit = mesh.index.cast(origin, inward)
    met = hit.range < sections.reach
    vote = np.bincount(
        piece[hit.face[met]],
        np.einsum("ni,ni->n", hit.normal, inward)[met],
        minlength=int(piece.max()) + 1,
    )
    faces = np.where((vote[piece] > 0)[:, None], mesh.faces[:, ::-1], mesh.faces)
    return Mesh(mesh.vertices, np.ascontiguousarray(faces))


def choose_axis_height(mesh: Mesh) -> float:
    """Choose the height of the axis, m: of nine, the highest that sees nearly all of the skin.

    From a higher axis, rays meet the bottom at less grazing angles. Raises InputError where no ray
    meets the mesh.
    """
    low, high = mesh.vertices[:, 2].min(), mesh.vertices[:, 2].max()
    heights = low + (high - low) * np.linspace(0.1, 0.9, 9)
    seen = [_seen_area(mesh, height) for height in heights]
    if max(seen) <= 0:
        raise InputError("no ray from inside meets the CAD model", where="hull.mesh")
    good = np.asarray(seen) >= NEARLY_ALL * max(seen)
    return float(heights[good].max())


def _seen_area(mesh: Mesh, height: float) -> float:
    """Sum the area of skin that rays from an axis meet well, without decks, to compare axes.

    Rays meet it well within 78 degrees of its normal. Decks have normals that point up, by more
    than 30 degrees. height: z of the axis, m. Areas are m2 but for a factor common to all axes.
    """
    sections = _empty_sections(mesh, height, stations=60, angles=91)
    origin, inward = sections.rays(*_pairs(sections))
    hit = mesh.index.cast(origin, inward)
    met = hit.range < sections.reach
    slope = np.abs(np.einsum("ni,ni->n", hit.normal, inward))
    # How far the normal, turned outward, points up, and the skin that one ray stands for
    facing = np.where(np.einsum("ni,ni->n", hit.normal, inward) > 0, -1.0, 1.0) * hit.normal[:, 2]
    cell = (sections.reach - hit.range) / np.maximum(slope, 0.2)
    return float(cell[met & (slope > 0.2) & (facing < 0.5)].sum())


def cast_sections(mesh: Mesh, height: float) -> Sections:
    """Cast the sections of a mesh in the ship's axes about an axis at the given height, m.

    The radius is where a ray from outside first meets the mesh. Stations are a few decimetres
    apart, angles a degree.
    """
    size = np.ptp(mesh.vertices, axis=0)
    # at least 400 stations, at most 2000
    step = float(np.clip(size[0] / 400, size[0] / 2000, 0.3 if size[0] > 60 else 0.25))
    empty = _empty_sections(mesh, height, int(np.ceil(size[0] / step)) + 1, 361)
    origin, inward = empty.rays(*_pairs(empty))
    hit = mesh.index.cast(origin, inward)
    # Rays that go through to the axis have met no skin
    radius = np.where(hit.range < empty.reach, empty.reach - hit.range, np.nan).reshape(
        empty.radius.shape
    )
    filled = _bridge_gaps(radius)
    return Sections(
        axis_y=empty.axis_y,
        axis_z=height,
        reach=empty.reach,
        station=empty.station,
        angle=empty.angle,
        radius=filled,
        girth=_girth(empty, filled),
        whole=_cells_on_skin(empty, filled, mesh),
    )


def _empty_sections(mesh: Mesh, height: float, stations: int, angles: int) -> Sections:
    """Make a grid of stations and angles about an axis, with radius and girth still NaN.

    height: z of the axis, m. stations, angles: size of the grid. The axis is at y = 0, also for a
    half hull, whose mesh ends near y = 0. For any other mesh to one side of the middle plane it is
    in the middle of the mesh's beam.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    beam = high[1] - low[1]
    half = min(abs(low[1]), abs(high[1])) < 0.05 * beam
    axis_y = 0.0 if half or low[1] < 0 < high[1] else 0.5 * (low[1] + high[1])
    # Rays start outside of all vertices. Stations are a little inside of both ends, where a plane
    # would touch the mesh only
    reach = 1.05 * float(
        np.hypot(max(high[1] - axis_y, axis_y - low[1]), max(high[2] - height, height - low[2]))
    )
    inset = 1e-6 * (high[0] - low[0])
    shape = (stations, angles)
    return Sections(
        axis_y=float(axis_y),
        axis_z=height,
        reach=reach,
        station=np.linspace(low[0] + inset, high[0] - inset, stations),
        angle=np.linspace(-np.pi, np.pi, angles),
        radius=np.full(shape, np.nan),
        girth=np.full(shape, np.nan),
        whole=np.zeros((stations - 1, angles - 1), bool),
    )


def _pairs(s: Sections) -> tuple[Array, Array]:
    """Pair every station with every angle, flat."""
    along, angle = np.meshgrid(s.station, s.angle, indexing="ij")
    return along.ravel(), angle.ravel()


def _bridge_gaps(radius: Array) -> Array:
    """Fill gaps (NaN) between two hits of a station linearly, in radii (k, m) by station and angle.

    So a small hole of the plating does not cut the girth off. Nothing is filled beyond the
    outermost hit of each side, except between it and the keel.
    """
    out = radius.copy()
    column = np.arange(radius.shape[1])
    keel = radius.shape[1] // 2
    for row in out:
        hit = np.isfinite(row)
        if hit.any():
            first, last = np.flatnonzero(hit)[[0, -1]]
            inside = (column >= min(first, keel)) & (column <= max(last, keel))
            row[inside] = np.interp(column[inside], column[hit], row[hit])
    return out


def _points(s: Sections, radius: Array) -> Array:
    """Compute points (k, m, 3) of radii (k, m)."""
    y = s.axis_y + radius * np.sin(s.angle)
    z = s.axis_z - radius * np.cos(s.angle)
    return np.stack([np.broadcast_to(s.station[:, None], radius.shape), y, z], axis=2)


def _girth(s: Sections, radius: Array) -> Array:
    """Compute the girth (k, m) m: arc length of a section from phi = 0, negative to starboard.

    NaN where the radius is, and beyond: the chords there have no length.
    """
    chord = np.linalg.norm(np.diff(_points(s, radius)[:, :, 1:], axis=1), axis=2)
    keel = radius.shape[1] // 2
    out = np.zeros_like(radius)
    out[:, keel + 1 :] = np.cumsum(chord[:, keel:], axis=1)
    out[:, :keel] = -np.cumsum(chord[:, :keel][:, ::-1], axis=1)[:, ::-1]
    out[np.isnan(radius)] = np.nan
    return out


def _cells_on_skin(s: Sections, radius: Array, mesh: Mesh) -> Mask:
    """Tell which cells (k - 1, m - 1) have their four sides on the skin.

    radius: (k, m) m, by station and angle. A cell that jumps from one part of the ship to another
    has not.
    """
    point = _points(s, radius)
    girthwise = _on_skin(point[:, :-1], point[:, 1:], radius[:, :-1], s.angle[1] - s.angle[0], mesh)
    reach = np.full(radius[1:].shape, s.station[1] - s.station[0])
    lengthwise = _on_skin(point[:-1], point[1:], reach, 1.0, mesh)
    return girthwise[:-1] & girthwise[1:] & lengthwise[:, :-1] & lengthwise[:, 1:]


def _on_skin(start: Array, stop: Array, radius: Array, turn: float, mesh: Mesh) -> Mask:
    """Tell which lines between the hits of neighbouring rays lie on the skin.

    The middle of a line must be near the mesh. The tolerance is tighter for a line that is much
    longer than the spacing of its rays explains.

    Parameters
    ----------
    start, stop
        Ends of the lines (a, b, 3) m. A line without an end (NaN) is not on the skin.
    radius, turn
        Their product is the spacing of the two rays at a line, m: radius (a, b) in m, and turn the
        angle between them. Along the ship, radius is the step of the stations and turn is 1.
    mesh
        The hull, near which the middle of a line must be.
    """
    length = np.linalg.norm(stop - start, axis=2)
    is_short = np.asarray(length * GRAZING <= radius * turn)
    has_ends = np.isfinite(length)
    middle = 0.5 * (start + stop)[has_ends]
    gap = np.abs(mesh.index.closest(middle).distance)
    short = is_short[has_ends]
    limit = np.where(short, SHORT_OFF_SKIN, OFF_SKIN) * length[has_ends]
    out = np.zeros(is_short.shape, bool)
    out[has_ends] = gap <= limit
    return out
