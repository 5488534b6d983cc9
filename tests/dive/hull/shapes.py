# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Toy hulls, and what yards put inside them."""

from __future__ import annotations

import numpy as np
import trimesh

from hullrecon.geometry.meshes.mesh import Mesh


def spindle(arc: tuple[float, float] = (0.0, 2 * np.pi), inset_m: float = 0.0) -> Mesh:
    """A blunt hull of 40 m x 8 m along x, with flat ends 1.5 m wide.

    Parameters
    ----------
    arc
        The part of the girth that is plated, rad from y to z.
    inset_m
        How far inside the outer skin it lies: the inner side of a plate.
    """
    sections, around, length = 30, 24, 40.0
    x = np.linspace(-length / 2, length / 2, sections)
    radius = np.maximum(0.75, 4.0 * (1 - (2 * x / length) ** 2)) - inset_m
    radius = np.r_[0.0, radius, 0.0]
    x = np.clip(np.r_[x[0], x, x[-1]], inset_m - length / 2, length / 2 - inset_m)
    angle = np.linspace(*arc, around + 1)
    points = np.stack(
        [
            np.broadcast_to(x[:, None], (len(x), around + 1)),
            radius[:, None] * np.cos(angle),
            radius[:, None] * np.sin(angle),
        ],
        axis=-1,
    ).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(len(x) - 1), np.arange(around), indexing="ij")
    a = (i * (around + 1) + j).ravel()
    b, c, d = a + around + 1, a + 1, a + around + 2
    faces = np.vstack([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    return Mesh(points, faces.astype(np.int32))


def box(low, high) -> Mesh:
    """A closed box between two corners."""
    solid = trimesh.creation.box(bounds=[low, high])
    return Mesh(np.asarray(solid.vertices, float), np.asarray(solid.faces, np.int32))


def barge(length_m: float = 40.0) -> Mesh:
    """A closed hull along x, z up, 9 m wide on deck and 6 m at the bottom, of 5 m depth."""
    solid = box([0.0, -4.5, 0.0], [length_m, 4.5, 5.0])
    at_bottom = solid.vertices[:, 2] == 0
    narrower = np.c_[np.ones(8), np.where(at_bottom, 2 / 3, 1.0), np.ones(8)]
    return Mesh(solid.vertices * narrower, solid.faces)


def joined(*meshes: Mesh) -> Mesh:
    """All in one, in their order."""
    shift = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = np.vstack([mesh.faces + n for mesh, n in zip(meshes, shift, strict=False)])
    return Mesh(np.vstack([mesh.vertices for mesh in meshes]), faces.astype(np.int32))


def moved(mesh: Mesh, by) -> Mesh:
    """The same elsewhere."""
    return Mesh(mesh.vertices + np.asarray(by, float), mesh.faces)
