# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether two CAD models are of one hull."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh

SAME_CAD_M = 0.002  # CAD models nowhere farther apart than this are of one hull


def cad_model_gap(first: Mesh, second: Mesh) -> float:
    """Return how far apart the surfaces of two CAD models lie at most, in metres, however they are
    meshed.
    """
    return max(_farthest_vertex(first, second), _farthest_vertex(second, first))


def _farthest_vertex(mesh: Mesh, other: Mesh, most: int = 20_000) -> float:
    """Return the greatest distance in metres of a vertex of a mesh (of some `most` of them) from
    another mesh.
    """
    some = mesh.vertices[:: max(1, len(mesh.vertices) // most)]
    return float(np.abs(Scene(other).closest(some).distance).max(initial=0.0))
