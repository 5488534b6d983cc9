# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.hull_patch import Rays

FAR = np.array([1000.0, -2000.0, 50.0])
SQUARE = Mesh(
    np.add(FAR, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)


def test_ray_far_from_origin_hits_to_tenth_of_millimetre() -> None:
    hits = Rays(SQUARE).cast(np.add(FAR, [0.3, 0.2, 1.5]), np.array([[0.0, 0.0, -1.0]]))
    np.testing.assert_allclose(hits.range_m, 1.5, atol=1e-4)


def test_weights_give_point_back() -> None:
    origin = np.add(FAR, [0.3, 0.2, 1.5])
    hits = Rays(SQUARE).cast(origin, np.array([[0.0, 0.0, -1.0]]))
    point = (hits.weight[0][:, None] * SQUARE.vertices[SQUARE.faces[hits.face[0]]]).sum(0)
    np.testing.assert_allclose(point, np.add(FAR, [0.3, 0.2, 0.0]), atol=1e-4)


def test_miss_is_infinite_and_has_face_that_can_be_indexed() -> None:
    hits = Rays(SQUARE).cast(np.add(FAR, [0.5, 0.5, 1.0]), np.array([[0.0, 0.0, 1.0]]))
    assert not hits.hit[0]
    assert hits.face[0] == 0
    assert np.isinf(hits.range_m[0])


def test_each_ray_may_have_its_own_origin() -> None:
    origins = FAR + np.array([[0.5, 0.5, 1.0], [0.5, 0.5, 2.0]])
    hits = Rays(SQUARE).cast(origins, np.tile([0.0, 0.0, -1.0], (2, 1)))
    np.testing.assert_allclose(hits.range_m, [1, 2], atol=1e-4)


def test_blocked_within_reach_and_not_beyond() -> None:
    origins = FAR + np.array([[0.5, 0.5, 1.0], [0.5, 0.5, 1.0]])
    blocked = Rays(SQUARE).is_blocked(
        origins, np.tile([0.0, 0.0, -1.0], (2, 1)), np.array([1.5, 0.5])
    )
    assert blocked.tolist() == [True, False]
