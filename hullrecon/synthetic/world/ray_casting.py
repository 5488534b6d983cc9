# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Ray casts against a triangle mesh.

Coordinates are about the mesh's own middle, as float32 is too coarse far from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Floats32


@dataclass(frozen=True)
class Hits:
    """What n rays hit."""

    range_m: Floats32  # (n,) infinite where nothing was hit
    face: NDArray[np.int64]  # (n,)
    weight: Floats32  # (n, 3) barycentric weights of the face's corners

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Rays (n,) that hit."""
        return np.asarray(np.isfinite(self.range_m))


class Rays:
    """A mesh to cast rays at. `middle` is taken off every origin."""

    def __init__(self, mesh: Mesh) -> None:
        import open3d as o3d

        self.middle: Array = mesh.vertices.mean(0)
        self._tensor = cast(Any, o3d.core.Tensor)
        self._scene = cast(Any, o3d.t.geometry.RaycastingScene(nthreads=2))
        self._scene.add_triangles(
            self._tensor(np.ascontiguousarray(mesh.vertices - self.middle, np.float32)),
            self._tensor(np.ascontiguousarray(mesh.faces, np.uint32)),
        )

    def cast(self, origins: Array, directions: NDArray[Any]) -> Hits:
        """Find the nearest hits from origins (n, 3) or (3,) along unit directions (n, 3)."""
        answer = self._scene.cast_rays(self._pack(origins, directions))
        uv = answer["primitive_uvs"].numpy()
        weight = np.stack([1 - uv[:, 0] - uv[:, 1], uv[:, 0], uv[:, 1]], axis=1)
        face = answer["primitive_ids"].numpy().astype(np.int64)
        return Hits(answer["t_hit"].numpy(), np.where(face == 0xFFFFFFFF, 0, face), weight)

    def is_blocked(
        self, origins: Array, directions: NDArray[Any], reach_m: NDArray[Any]
    ) -> NDArray[np.bool_]:
        """Test whether something stands within `reach_m` (n,) along each ray."""
        answer = self._scene.cast_rays(self._pack(origins, directions))["t_hit"].numpy()
        return np.asarray(answer < reach_m)

    def _pack(self, origins: Array, directions: NDArray[Any]) -> Any:
        rows = np.empty((len(directions), 6), np.float32)
        rows[:, :3], rows[:, 3:] = origins - self.middle, directions
        return self._tensor(rows)
