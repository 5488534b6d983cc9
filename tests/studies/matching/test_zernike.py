# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.studies.matching.corners import (
    ORDER,
    basis,
    disc_points,
    orders,
    radial,
    weights,
    zernike_magnitudes,
    zernike_moments,
)


@pytest.fixture
def polar():
    u, v = disc_points().T
    return np.hypot(u, v), np.arctan2(v, u)


def moment(patch, n, m):
    return zernike_moments(patch[None].astype(np.float32))[0, (orders() == (n, m)).all(1).argmax()]


def test_functions_are_orthonormal_on_disc():
    gram = (basis() * weights()) @ basis().conj().T
    np.testing.assert_allclose(gram, np.eye(len(orders())), atol=1e-12)


def test_functions_take_nothing_of_uniform_patch():
    assert np.abs(zernike_moments(np.full((1, len(weights())), 200, np.float32))).max() < 1e-4


def test_there_are_48_of_them_and_area_is_that_of_disc():
    assert len(orders()) == 48
    assert orders().max() == ORDER
    assert weights().sum() == pytest.approx(np.pi)
    assert np.hypot(*disc_points().T).max() < 1


@pytest.mark.parametrize(
    ("n", "m", "by_hand"),
    [
        (2, 0, lambda r: 2 * r**2 - 1),
        (3, 1, lambda r: 3 * r**3 - 2 * r),
        (4, 2, lambda r: 4 * r**4 - 3 * r**2),
        (6, 0, lambda r: 20 * r**6 - 30 * r**4 + 12 * r**2 - 1),
    ],
)
def test_radial_polynomials_are_those_of_tables(n, m, by_hand):
    r = np.linspace(0, 1, 9)
    np.testing.assert_allclose(radial(n, m, r), by_hand(r), atol=1e-12)


def test_moments_of_ramp_and_bowl_are_those_by_hand(polar):
    r, angle = polar
    # r cos(angle) = (V_11 + its conjugate) / 2 sqrt(pi / 2); r^2 = (R_20 + 1) / 2
    assert moment(r * np.cos(angle), 1, 1) == pytest.approx(0.5 * np.sqrt(np.pi / 2), abs=1e-6)
    assert moment(r**2, 2, 0) == pytest.approx(0.5 * np.sqrt(np.pi / 3), abs=1e-6)
    for n, m in orders().tolist():
        if (n, m) != (1, 1):
            assert abs(moment(r * np.cos(angle), n, m)) < 1e-6


def test_turned_patch_has_moments_turned_by_m_times_angle(polar):
    r, angle = polar
    turn = 0.7
    patches = np.array(
        [r**2 * np.cos(2 * (angle - t)) + r**3 * np.sin(3 * (angle - t)) for t in (0, turn)],
        np.float32,
    )
    still, turned = zernike_moments(patches)
    np.testing.assert_allclose(turned, still * np.exp(-1j * orders()[:, 1] * turn), atol=1e-5)


def test_magnitudes_hold_energy_of_patch_that_they_can_describe(polar):
    r, angle = polar
    patch = 3 * r**4 * np.cos(4 * angle + 0.3) + (2 * r**2 - 1)
    assert (zernike_magnitudes(patch[None].astype(np.float32)) ** 2).sum() == pytest.approx(
        (weights() * patch**2).sum(), rel=1e-5
    )
