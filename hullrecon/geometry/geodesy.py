# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Latitude and longitude as metres on a plane that touches the ellipsoid of WGS 84."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array

SEMI_MAJOR_M, FLATTENING = 6378137.0, 1 / 298.257223563  # of WGS 84
SQUARED_ECCENTRICITY = FLATTENING * (2 - FLATTENING)


def earth_fixed(latitude_deg: Array, longitude_deg: Array) -> Array:
    """Convert positions on the ellipsoid to earth-centred, earth-fixed points (n, 3), m."""
    latitude, longitude = np.radians(latitude_deg), np.radians(longitude_deg)
    # Length of the normal from the ellipsoid to the polar axis
    normal = SEMI_MAJOR_M / np.sqrt(1 - SQUARED_ECCENTRICITY * np.sin(latitude) ** 2)
    across = normal * np.cos(latitude)
    z = normal * (1 - SQUARED_ECCENTRICITY) * np.sin(latitude)
    return np.stack([across * np.cos(longitude), across * np.sin(longitude), z], axis=-1)


def north_east(latitude_deg: Array, longitude_deg: Array) -> Array:
    """Compute how far positions lie north and east of the first, (n, 2) m, in its tangent plane."""
    # Unit vectors north and east at the first position, in earth-fixed axes
    at = earth_fixed(latitude_deg, longitude_deg)
    latitude, longitude = np.radians(latitude_deg[0]), np.radians(longitude_deg[0])
    north = [
        -np.sin(latitude) * np.cos(longitude),
        -np.sin(latitude) * np.sin(longitude),
        np.cos(latitude),
    ]
    east = [-np.sin(longitude), np.cos(longitude), 0.0]
    return np.asarray((at - at[0]) @ np.array([north, east]).T)
