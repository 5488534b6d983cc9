# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell by its symmetry whether a CAD model lies on its side, as one exported with y up does.

A ship is symmetric from port to starboard, and her deck is not her bottom. A CAD model on its side
may still fit a survey: a patch of its deck is as plain as one of a ship's side.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.hull.mirrors import find_openings
from hullrecon.findings.finding import Finding
from hullrecon.geometry.charts.section_casting import AXES
from hullrecon.geometry.meshes.mesh import Mesh, face_areas
from hullrecon.geometry.poses import Poses, to_mount, up_in
from hullrecon.typing import Array, Ints

PLACES = 2000  # points on the skin that are reflected
NEAR = 1e-3  # of the largest extent: a reflected point that is nearer lies on the skin
# Shares of the skin that lie on it when it is reflected. Hulls of yards and of the simulation have
# 1.00 from port to starboard (triangulated alike or not), and 0.17 to 0.53 from deck to bottom.
SYMMETRIC, ASYMMETRIC = 0.98, 0.8


def find_lying_side(mesh: Mesh, ship_axes: Array, guess: Poses) -> Finding | None:
    """Report a CAD model that is symmetric about a level plane, and not from port to starboard.

    None for any other CAD model, and for a mesh that ends open at its side, which may be half of a
    body that is symmetric in both directions.

    Parameters
    ----------
    mesh
        In M.
    ship_axes
        Rows forward, port, up (3, 3) in M, along M's own axes, as the package's guess has them.
    guess
        Guess of the hull pose T_g_M, by hull.pose, a batch of one.
    """
    _, port, up = np.abs(ship_axes).argmax(axis=1).tolist()
    if mirrored_share(mesh, up) < SYMMETRIC or mirrored_share(mesh, port) > ASYMMETRIC:
        return None
    if any(axis == port for axis, _ in find_openings(mesh)):
        return None
    upright = _turned_up(guess, np.eye(3)[port])
    return Finding("hull-on-its-side", {"port": AXES[port], "pose": upright})


def _turned_up(guess: Poses, axis: Array) -> list[float]:
    """Turn a pose by a right angle about M's origin until an axis (3,) of M points up.

    Returns the six numbers of hull.pose.
    """
    turn = Rotation.from_rotvec(0.5 * np.pi * np.round(np.cross(axis, up_in(guess))))
    turned = Poses((guess.rotation * turn).as_quat(), guess.translation)
    return to_mount(turned)


def mirrored_share(mesh: Mesh, axis: int) -> float:
    """Measure which share of a mesh's area lies on it when it is reflected along an axis of M.

    It is reflected in the middle of its extent: 1 for a mesh that is symmetric there. axis: 0 to 2.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    at = mesh.vertices[mesh.faces[_faces_by_area(mesh)]].mean(axis=1)
    at[:, axis] = low[axis] + high[axis] - at[:, axis]
    distance = np.abs(mesh.index.closest(at).distance)
    return float(np.mean(distance < NEAR * (high - low).max()))


def _faces_by_area(mesh: Mesh) -> Ints:
    """Choose faces at even steps of the area."""
    area = np.cumsum(face_areas(mesh))
    steps = (np.arange(PLACES) + 0.5) / PLACES * area[-1]
    return np.asarray(np.minimum(np.searchsorted(area, steps), len(area) - 1))
