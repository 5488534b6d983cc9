# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh

FLOOR = Mesh(np.array([[40.0, 0, 2], [41, 0, 2], [41, 1, 2], [40, 1, 2]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def test_the_distance_is_positive_on_the_side_of_the_normal() -> None:
    near = Scene(FLOOR).closest(np.array([[40.25, 0.5, 2.3], [40.25, 0.5, 1.9]]))
    assert np.allclose(near.distance, [0.3, -0.1], atol=1e-6)
    assert np.allclose(near.foot, [[40.25, 0.5, 2], [40.25, 0.5, 2]], atol=1e-6)
    assert np.allclose(near.normal, [[0, 0, 1], [0, 0, 1]])


def test_the_closest_point_beyond_the_rim_lies_on_the_rim() -> None:
    near = Scene(FLOOR).closest(np.array([[39.7, 0.5, 2.4]]))
    assert np.allclose(near.foot, [[40, 0.5, 2]], atol=1e-6)
    assert np.allclose(near.distance, 0.5, atol=1e-6)


def test_a_point_that_is_not_finite_has_no_distance() -> None:
    near = Scene(FLOOR).closest(np.array([[40.5, 0.5, 2.1], [np.nan, 0, 0]]))
    assert np.isfinite(near.distance).tolist() == [True, False]


def test_a_ray_that_misses_is_infinite() -> None:
    met = Scene(FLOOR).cast(np.array([40.5, 0.2, 3.0]), np.array([[0.0, 0, -1], [0, 0, 1], [0.6, 0, -0.8]]))
    assert np.isclose(met[0], 1.0, atol=1e-6)
    assert np.isinf(met[1:]).all()
