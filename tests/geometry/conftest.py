# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from datasets import dataset

from hullrecon.geometry.meshes.mesh import Mesh


def barge(
    length: float = 20.0,
    radius: float = 3.0,
    rings: int = 41,
    corners: int = 72,
    half: bool = False,
) -> Mesh:
    """An open-ended half cylinder of steel along x, keel at z = 0, open on top at z = radius; faces
    outward.

    half: its port side only, as a CAD model of one half of a ship.
    """
    angle = np.linspace(0.0 if half else -np.pi / 2, np.pi / 2, corners + 1)
    x = np.linspace(0, length, rings)
    grid = np.stack(
        [
            np.repeat(x, len(angle)),
            np.tile(radius * np.sin(angle), rings),
            np.tile(radius - radius * np.cos(angle), rings),
        ],
        axis=1,
    )
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(corners), indexing="ij")
    a = (i * (corners + 1) + j).ravel()
    b = a + corners + 1
    faces = np.vstack([np.stack([a, a + 1, b], 1), np.stack([a + 1, b + 1, b], 1)])
    return Mesh(grid, faces.astype(np.int32))


@pytest.fixture(scope="session")
def steel() -> Mesh:
    return barge()


@pytest.fixture(scope="session")
def half_steel() -> Mesh:
    return barge(half=True)


@pytest.fixture(scope="session")
def data() -> Path:
    """The evaluation data; the test is skipped where it is absent."""
    return dataset("hulls").parent
