# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.as_found.hull_as_found import affordable_edge, refine_near
from hullrecon.geometry.meshes.mesh import Mesh

FLOOR = Mesh(
    np.array([[0.0, 0, 0], [8, 0, 0], [8, 8, 0], [0, 8, 0]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)


def test_edges_are_short_near_the_points_and_long_elsewhere() -> None:
    mesh = refine_near(FLOOR, np.array([[2.0, 2.0, 0.0]]), 0.1, 0.3)
    corner = mesh.vertices[mesh.faces]
    length = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2).max(axis=1)
    distance = np.linalg.norm(corner.mean(axis=1) - [2, 2, 0], axis=1)
    assert length[distance < 0.3].max() <= 0.1
    assert length[distance > 4].min() > 0.5
    assert len(mesh.faces) < 4000


def test_without_points_the_mesh_stays() -> None:
    assert refine_near(FLOOR, np.zeros((0, 3)), 0.1, 0.3) is FLOOR


def test_a_large_survey_gets_a_coarser_mesh() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(0, 10, (20000, 3)) * [1, 1, 0]  # 100 m2
    assert affordable_edge(points, 0.03, 1_000_000) == 0.03
    assert affordable_edge(points, 0.03, 10_000) == pytest.approx(np.sqrt(100 / 4300), rel=0.05)
