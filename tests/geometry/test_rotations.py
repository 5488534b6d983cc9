# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.rotations import cross, cross_matrix, roll_pitch_yaw


def test_cross_matrix_equals_cross_product() -> None:
    rng = np.random.default_rng(0)
    v, w = rng.normal(size=(2, 4, 5, 3))
    np.testing.assert_allclose(
        np.einsum("...ij,...j->...i", cross_matrix(v), w), np.cross(v, w), atol=1e-15
    )
    np.testing.assert_allclose(
        cross_matrix(v[0, 0]) @ w[0, 0], np.cross(v[0, 0], w[0, 0]), atol=1e-15
    )


def test_the_cross_product_is_that_of_numpy_in_any_batch() -> None:
    v, w = np.random.default_rng(1).normal(size=(2, 4, 5, 3))
    np.testing.assert_array_equal(cross(v, w), np.cross(v, w))
    np.testing.assert_array_equal(cross(v[:, :1], w), np.cross(v[:, :1], w))
    np.testing.assert_array_equal(cross(v[0, 0], w[0, 0]), np.cross(v[0, 0], w[0, 0]))


def test_a_cross_matrix_is_skew() -> None:
    found = cross_matrix(np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(found, [[0, -3, 2], [3, 0, -1], [-2, 1, 0]])


def test_roll_pitch_yaw_compose_about_z_then_y_then_x() -> None:
    roll, pitch, yaw = 0.1, -0.2, 0.7
    rotation = (
        Rotation.from_rotvec([0, 0, yaw])
        * Rotation.from_rotvec([0, pitch, 0])
        * Rotation.from_rotvec([roll, 0, 0])
    )
    np.testing.assert_allclose(roll_pitch_yaw(rotation), [[roll, pitch, yaw]], atol=1e-15)
