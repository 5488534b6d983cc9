# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A flat hull seen by cameras above it: everything can be worked out by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.mosaic_surface import MosaicSurface, build_mosaic_surface

Array = NDArray[np.float64]
# quaternion of a camera that looks along -z, its x along x, its y against y
DOWN = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True)
class FlatChart:
    """along is x, girth is y, outward is z."""

    ship_axes = np.eye(3)

    def to_chart(self, points: Array) -> Array:
        return np.asarray(points, float).copy()

    def from_chart(self, along_girth: Array) -> tuple[Array, Array]:
        at = np.asarray(along_girth, float)
        return np.column_stack([at, np.zeros(len(at))]), np.tile([0.0, 0.0, 1.0], (len(at), 1))

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        return {"kind": np.array("flat")}


def box(low: list[float], high: list[float]) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and outward faces of a block."""
    corners = np.array([[(low, high)[(k >> a) & 1][a] for a in range(3)] for k in range(8)], float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)


@pytest.fixture
def flat_surface() -> Callable[..., MosaicSurface]:
    """A plate z = 0 from -1 to 1 m, with a block on it when asked: (low, high) corners."""

    def make(block: tuple[list[float], list[float]] | None = None) -> MosaicSurface:
        vertices = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
        faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
        if block is not None:
            more, cells = box(*block)
            vertices, faces = np.vstack([vertices, more]), np.vstack([faces, cells + 4])
        return build_mosaic_surface(Mesh(vertices, faces.astype(np.int32)), FlatChart(), 0.5)

    return make


@pytest.fixture
def camera() -> CameraModel:
    """A pixel is 1 mm wide at 1 m."""
    return CameraModel(width=400, height=320, fx=1000.0, fy=1000.0, cx=199.5, cy=159.5)


@pytest.fixture
def above() -> Callable[[float, float], Poses]:
    """One pose of a camera 1 m above (x, y) that looks straight down."""

    def make(x: float, y: float) -> Poses:
        return Poses(DOWN[None], np.array([[x, y, 1.0]]))

    return make
