# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.rotations import compose, cross, cross_matrix, roll_pitch_yaw


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


@pytest.mark.parametrize(("first", "second"), [(200, 200), (1, 200), (200, 1), (1, 1)])
def test_rotations_compose_as_those_of_scipy_to_the_last_bit(first: int, second: int) -> None:
    rng = np.random.default_rng(2)
    a, b = (Rotation.from_quat(rng.standard_normal((n, 4))) for n in (first, second))
    np.testing.assert_array_equal(compose(a, b).as_quat(), (a * b).as_quat())
    np.testing.assert_array_equal(compose(a.inv(), b).as_quat(), (a.inv() * b).as_quat())


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
