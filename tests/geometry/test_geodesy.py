# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Latitude and longitude against published values of WGS 84."""

import numpy as np
import pytest

from hullrecon.geometry.geodesy import earth_fixed, north_east


@pytest.mark.parametrize(
    ("latitude", "longitude", "expected"),
    [
        (0.0, 0.0, [6378137.0, 0, 0]),  # the semi-major axis
        (0.0, 90.0, [0, 6378137.0, 0]),
        (90.0, 0.0, [0, 0, 6356752.314245]),  # and the semi-minor one
        (-90.0, 12.0, [0, 0, -6356752.314245]),
        (45.0, 0.0, [4517590.878845, 0, 4487348.408866]),
    ],
)
def test_points_of_the_ellipsoid_lie_where_wgs_84_has_them(latitude, longitude, expected):
    np.testing.assert_allclose(
        earth_fixed(np.array([latitude]), np.array([longitude]))[0], expected, atol=1e-5
    )


@pytest.mark.parametrize(
    # a degree of latitude and of longitude [NIMA TR8350.2; the usual table of WGS 84]
    ("latitude", "metres"),
    [(0.0, (110574.3, 111319.5)), (45.0, (111131.8, 78846.8)), (60.0, (111412.2, 55800.0))],
)
def test_a_thousandth_of_a_degree_is_as_long_as_tables_say(latitude, metres):
    at = north_east(latitude + np.array([0.0, 1e-3, 0.0]), np.array([9.0, 9.0, 9.001]))
    np.testing.assert_allclose(at[1:] * 1e3, np.diag(metres), rtol=2e-5, atol=2.0)
    np.testing.assert_array_equal(at[0], 0)


def test_north_east_holds_on_every_side_of_earth():
    for latitude, longitude in ((54.3, 10.1), (-33.9, 18.4), (37.8, -122.4), (-41.3, 174.8)):
        at = north_east(latitude + np.array([0, 1e-4, 0]), longitude + np.array([0, 0, 1e-4]))
        assert at[1, 0] > 10
        assert abs(at[1, 1]) < 1e-3
        assert at[2, 1] > 6
        assert abs(at[2, 0]) < 1e-3


def test_a_track_over_the_date_line_has_no_jump():
    at = north_east(np.zeros(2), np.array([179.9999, -179.9999]))
    assert np.linalg.norm(at[1]) == pytest.approx(22.26, abs=0.01)
