# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.meshes.mesh import Mesh, face_areas, vertex_areas, vertex_normals

FLOOR = Mesh(np.array([[0.0, 0, 0], [8, 0, 0], [8, 8, 0], [0, 8, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32))
ROOF = Mesh(
    np.array([[0.0, 0, 0], [1, 0, 1], [2, 0, 0], [0, 1, 0], [1, 1, 1], [2, 1, 0]]),
    np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]], np.int32),
)


def test_areas_add_up() -> None:
    assert face_areas(FLOOR).tolist() == [32, 32]
    assert vertex_areas(FLOOR).sum() == pytest.approx(64)
    assert np.allclose(vertex_areas(FLOOR), [64 / 3, 32 / 3, 64 / 3, 32 / 3])


def test_a_vertex_inside_has_a_third_of_all_faces_around_it() -> None:
    tent = Mesh(np.vstack([FLOOR.vertices, [[4.0, 4, 0]]]), np.array([[k, (k + 1) % 4, 4] for k in range(4)], np.int32))
    assert vertex_areas(tent)[4] == pytest.approx(64 / 3)


def test_a_vertex_of_no_face_has_no_area() -> None:
    more = Mesh(np.vstack([FLOOR.vertices, [[9.0, 9, 9]]]), FLOOR.faces)
    assert vertex_areas(more)[4] == 0.0


def test_normals_at_a_ridge_point_up_between_its_sides() -> None:
    normal = vertex_normals(ROOF)
    assert np.allclose(normal[4], [0, 0, 1], atol=0.2)
    assert np.allclose(normal[0], [-np.sqrt(0.5), 0, np.sqrt(0.5)])
    assert np.allclose(np.linalg.norm(normal, axis=1), 1)
