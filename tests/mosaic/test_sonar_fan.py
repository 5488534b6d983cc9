# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.mosaic.sonar import build_fan

# numbered from port to starboard, as a driver may have it
BEARING = np.radians(np.linspace(14, -14, 57))
DIRECTIONS = np.stack([np.zeros(57), np.sin(BEARING), np.cos(BEARING)], axis=1)
FAN = build_fan(DIRECTIONS, np.linspace(1.0, 5.0, 201), np.radians(14))


def test_point_ahead_is_on_middle_beam_at_its_range() -> None:
    pixel, ratio = FAN.locate(np.array([[0.0, 0.0, 3.0]]))
    np.testing.assert_allclose(pixel, [[100.0, 28.0]], atol=1e-9)
    assert np.isfinite(ratio[0])


def test_bins_and_beams_are_those_of_the_image() -> None:
    bearing = BEARING[10]
    pixel, _ = FAN.locate(np.array([[0.0, 1.5 * np.sin(bearing), 1.5 * np.cos(bearing)]]))
    np.testing.assert_allclose(pixel, [[25.0, 10.0]], atol=1e-9)


def test_beam_by_range_and_bin_by_bearing_as_printed_are_outside_the_image() -> None:
    """[Ozog2016 3.2.3] prints n_b by the range and n_r by the bearing."""
    bearing, distance = BEARING[10], 4.5
    point = distance * np.array([[0.0, np.sin(bearing), np.cos(bearing)]])
    (found,), _ = FAN.locate(point)
    np.testing.assert_allclose(found, [175.0, 10.0], atol=1e-9)
    printed_beam = (distance - 1.0) * (201 - 1) / (5.0 - 1.0)
    assert round(printed_beam) == round(found[0]) > len(BEARING)


def test_four_coefficients_of_beams_are_of_third_degree_not_of_fourth_as_printed() -> None:
    """[Ozog2016 3.2.3] calls (1, psi, psi^2, psi^3) of fourth degree."""
    bearing, missed = np.linspace(-0.24, 0.24, 20001), []
    for degree in (3, 4):
        number = 28 + 100 * bearing + 4 * (bearing / 0.24) ** degree
        psi = np.interp(np.arange(9.0, 52.0), number, bearing)
        directions = np.stack([0 * psi, np.sin(psi), np.cos(psi)], axis=1)
        fan = build_fan(directions, np.linspace(1.0, 5.0, 201), np.radians(14))
        beam = fan.locate(2.0 * directions)[0][:, 1]
        basis = np.vander(psi, 4)
        missed.append(np.abs(basis @ np.linalg.lstsq(basis, beam, rcond=None)[0] - beam).max())
    assert missed[0] < 1e-3
    assert missed[1] > 0.1


def test_elevation_does_not_change_range_and_beam_of_an_arc() -> None:
    theta = np.radians([-6.9, 0.0, 6.9])
    arc = 2.0 * np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1)
    pixel, ratio = FAN.locate(arc)
    np.testing.assert_allclose(pixel, np.tile([50.0, 28.0], (3, 1)), atol=1e-9)
    assert np.isfinite(ratio).all()


def test_points_beyond_range_bearing_or_aperture_are_not_held() -> None:
    theta, psi = np.radians(7.1), np.radians(14.2)
    points = [
        [0, 0, 0.9],
        [0, 0, 5.1],
        [2 * np.sin(theta), 0, 2 * np.cos(theta)],
        [0, 2 * np.sin(psi), 2 * np.cos(psi)],
    ]
    assert np.isnan(FAN.locate(np.array(points))[1]).all()


def test_the_best_place_is_three_quarters_down_the_display() -> None:
    near = np.cos(np.radians(14))  # where the display ends, 1 m range at the outermost beam
    best = 5.0 - 0.75 * (5.0 - near)
    ratio = FAN.locate(np.array([[0.0, 0.0, best], [0.0, 0.0, best + 0.5], [0.0, 0.0, 4.99]]))[1]
    np.testing.assert_allclose(ratio[0], 0, atol=1e-12)
    assert ratio[0] < ratio[1] < ratio[2] <= 1


def test_rays_fill_the_aperture_with_unit_vectors() -> None:
    rays = FAN.rays(bearings=5, elevations=3)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1)
    assert np.isfinite(FAN.locate(0.999999 * 2.0 * rays[[7]])[1]).all()
    np.testing.assert_allclose(np.degrees(np.arcsin(rays[:, 0].max())), 7.0)
