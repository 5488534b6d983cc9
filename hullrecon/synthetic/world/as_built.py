# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull as it is: the CAD model's patch moved by its deviation, with what stands on it, finer
where something does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.spec import DiveSpec
from hullrecon.synthetic.world.deviation import deviation_m
from hullrecon.synthetic.world.hull_patch import HullPatch
from hullrecon.synthetic.world.items import Item
from hullrecon.synthetic.world.relief import height_of
from hullrecon.typing import Array, Ints

FINER = 5  # 3 cm cells become 6 mm cells


@dataclass(frozen=True, kw_only=True)
class AsBuilt:
    """Hold the surface. mesh in M; chart (n, 2) along and girth and normal (n, 3) by vertex; steel
    (a, g, 3): the patch's points moved by the deviation alone; busy (a, g) bool: grid nodes near
    something that stands out.
    """

    mesh: Mesh
    chart: NDArray[np.float32]
    normal: NDArray[np.float32]
    steel: Array
    busy: NDArray[np.bool_]


def build(spec: DiveSpec, patch: HullPatch, items: tuple[Item, ...]) -> AsBuilt:
    """Return the patch of the CAD model moved by its deviation, with the items on it."""
    a, g = np.meshgrid(patch.along_m, patch.girth_m, indexing="ij")
    steel = patch.point + deviation_m(spec, a, g)[..., None] * patch.normal
    busy = _busy(patch, items, 0.12)
    key, faces = _lattice(_busy(patch, items, 0.04))
    width = FINER * (len(patch.girth_m) - 1) + 1
    step = (patch.along_m[1] - patch.along_m[0]) / FINER
    along, girth = patch.along_m[0] + key // width * step, patch.girth_m[0] + key % width * step
    height = np.zeros(len(key))
    for item in items:
        height += height_of(item, along, girth)
    vertices = patch.sample(steel, along, girth) + height[:, None] * patch.sample(
        patch.normal, along, girth
    )
    mesh = Mesh(vertices, faces)
    chart = np.stack([along, girth], 1).astype(np.float32)
    return AsBuilt(
        mesh=mesh,
        chart=chart,
        normal=_vertex_normals(mesh).astype(np.float32),
        steel=steel,
        busy=busy,
    )


def crop(built: AsBuilt, along_m: tuple[float, float], girth_m: tuple[float, float]) -> Mesh:
    """Return the part of the mesh within a window of the chart."""
    a, g = built.chart.T
    inside = (a >= along_m[0]) & (a <= along_m[1]) & (g >= girth_m[0]) & (g <= girth_m[1])
    faces = built.mesh.faces[inside[built.mesh.faces].all(axis=1)]
    used, renumbered = np.unique(faces, return_inverse=True)
    return Mesh(built.mesh.vertices[used], renumbered.reshape(-1, 3).astype(np.int32))


def _busy(patch: HullPatch, items: tuple[Item, ...], margin_m: float) -> NDArray[np.bool_]:
    out = np.zeros((len(patch.along_m), len(patch.girth_m)), bool)
    for item in (i for i in items if i.height_m != 0):
        reach = item.reach_m() + margin_m
        far = np.hypot(
            *np.meshgrid(patch.along_m - item.along_m, patch.girth_m - item.girth_m, indexing="ij")
        )
        out |= far < reach
    return out


def _lattice(busy: NDArray[np.bool_]) -> tuple[Ints, NDArray[np.int32]]:
    """Return vertices as keys on the fine lattice, faces counter-clockwise seen from outside; fine
    cells share their corners.
    """
    columns = busy.shape[1]
    width = FINER * (columns - 1) + 1
    fine = busy[:-1, :-1] | busy[1:, :-1] | busy[1:, 1:] | busy[:-1, 1:]
    coarse_cell = np.argwhere(~fine) * FINER
    sub = np.stack(np.meshgrid(np.arange(FINER), np.arange(FINER), indexing="ij"), -1).reshape(
        1, -1, 2
    )
    fine_cell = (np.argwhere(fine)[:, None] * FINER + sub).reshape(-1, 2)
    quads = np.concatenate([_quads(coarse_cell, FINER, width), _quads(fine_cell, 1, width)])
    key, corner = np.unique(quads, return_inverse=True)
    a, b, c, d = corner.reshape(-1, 4).T
    return key.astype(np.int64), np.concatenate(
        [np.stack([a, c, b], 1), np.stack([a, d, c], 1)]
    ).astype(np.int32)


def _quads(cell: Ints, size: int, width: int) -> Ints:
    first = cell[:, 0] * width + cell[:, 1]
    return np.stack([first, first + size * width, first + size * width + size, first + size], 1)


def _vertex_normals(mesh: Mesh) -> Array:
    corner = mesh.vertices[mesh.faces]
    face = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    total = np.stack(
        [
            np.bincount(mesh.faces.ravel(), np.repeat(face[:, k], 3), len(mesh.vertices))
            for k in range(3)
        ],
        1,
    )
    return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12))
