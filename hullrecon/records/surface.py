# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Ints, Ints32


@dataclass(frozen=True, kw_only=True)
class Surface:
    """A surface with its uncertainty."""

    vertices: Array  # (n, 3) m in M (g without a CAD model)
    faces: Ints32  # (m, 3)
    deviation: Array  # (n,) m against the CAD model, outward positive, NaN without
    sigma: Array  # (n,) m
    support: Ints  # (n,) returns (surface) or views (as found) behind a vertex, 0 = unseen

    def mesh(self) -> Mesh:
        """Select vertices and faces."""
        return Mesh(self.vertices, self.faces)


@dataclass(frozen=True, kw_only=True)
class DeviationSplit:
    """How a hull as found deviates from its CAD model, split by how well it is known.

    The hull's pose in the dive's frame is known to centimetres. Its error moves and tilts the whole
    surveyed patch.
    """

    offset: Array  # () m, the patch's mean distance to the CAD model, outward positive
    offset_sigma: Array
    tilt: Array  # (2,) m/m, slope along the hull and in girth
    tilt_sigma: Array
    # (n,) m, shape: each vertex's deviation without offset and tilt, NaN where unseen
    form: Array
    form_sigma: Array  # (n,) m; the error of the hull's position hardly enters
