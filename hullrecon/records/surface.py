# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Ints, Ints32


@dataclass(frozen=True, kw_only=True)
class Surface:
    """vertices (n, 3) in M (g without a CAD model), faces (m, 3); deviation (n,) m against the CAD
    model, outward positive, NaN without; sigma (n,) m; support (n,) int: returns (surface) or views
    (as found) behind a vertex, 0 = unseen.
    """

    vertices: Array
    faces: Ints32
    deviation: Array
    sigma: Array
    support: Ints

    def mesh(self) -> Mesh:
        """Return vertices and faces alone."""
        return Mesh(self.vertices, self.faces)


@dataclass(frozen=True, kw_only=True)
class DeviationSplit:
    """How a hull as found deviates from its CAD model, parted by how well it is known.

    Where the hull lies in the dive's frame is known to centimetres; an error of it moves and tilts
    the whole surveyed patch. offset (): m, the patch's mean distance to the CAD model, outward
    positive, and tilt (2,): its slope along the hull and in girth, m/m, each with such a sigma.
    form (n,): m, what is left of each vertex's deviation without offset and tilt, and its sigma,
    which the hull's position hardly enters; NaN where nothing was seen.
    """

    offset: Array
    offset_sigma: Array
    tilt: Array
    tilt_sigma: Array
    form: Array
    form_sigma: Array
