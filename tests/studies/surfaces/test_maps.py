# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.studies.surfaces.maps import longest_edge_m, merge_cells, roughness_deg

FOLD = Mesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [1, 1, np.sqrt(2)]]),
    np.array([[0, 1, 2], [1, 3, 2]], np.int32),
)


def test_points_are_merged_by_their_median_where_there_are_enough() -> None:
    cell = np.array([[0.31, 0.72]])
    many = np.column_stack([np.repeat(cell, 21, axis=0), np.r_[np.full(20, 0.05), 0.9]])
    few = np.column_stack([np.repeat(cell + 1.0, 3, axis=0), np.full(3, 0.4)])
    found = merge_cells(np.vstack([few, many]), cell_m=0.1, least=20)
    np.testing.assert_allclose(found.at, [[0.35, 0.75]])
    np.testing.assert_allclose(found.off_m, [0.05])


def test_a_flat_mesh_does_not_turn_and_a_fold_does() -> None:
    flat = Mesh(FOLD.vertices * [1, 1, 0], FOLD.faces)
    assert roughness_deg(flat) == pytest.approx(0.0, abs=1e-5)
    assert roughness_deg(FOLD) > 30


def test_the_longest_edge_is_found() -> None:
    assert longest_edge_m(FOLD) == pytest.approx(np.sqrt(5))
