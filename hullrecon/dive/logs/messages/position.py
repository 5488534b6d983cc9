# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Translate messages of position fixes (GNSS, USBL) to samples: one small function per type.

Arguments are those of `Translate` in samples.py.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.dive.logs.messages.covariance import FAR_M, UNKNOWN_SIGMA, sigma_of
from hullrecon.dive.logs.messages.decode import Fields, vector
from hullrecon.dive.logs.samples import LOST, PositionSample, Sample

HORIZONTAL = (0, 1)  # axes of a covariance
NO_FIX, UNKNOWN_COVARIANCE = -1, 0  # of sensor_msgs/NavSatStatus and NavSatFix


def satellite_fix(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read sensor_msgs/NavSatFix. The position is NaN where its status is -1, no fix."""
    place = np.array([message.latitude, message.longitude, message.altitude], float)
    sigma = UNKNOWN_SIGMA
    if message.position_covariance_type != UNKNOWN_COVARIANCE:
        sigma = sigma_of(message.position_covariance, HORIZONTAL)
    has_fix = message.status.status != NO_FIX
    return [
        _unless_lost(
            PositionSample(t_ns, place if has_fix else LOST, sigma, True, by_satellite=True)
        )
    ]


def geographic_point(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geographic_msgs/GeoPointStamped."""
    return [_geographic(message.position, t_ns, UNKNOWN_SIGMA)]


def geographic_pose(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geographic_msgs/GeoPoseStamped."""
    return [_geographic(message.pose.position, t_ns, UNKNOWN_SIGMA)]


def geographic_pose_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geographic_msgs/GeoPoseWithCovarianceStamped, whose covariance is in metres."""
    sigma = sigma_of(message.pose.covariance, HORIZONTAL)
    return [_unless_lost(_geographic(message.pose.pose.position, t_ns, sigma))]


def point(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geometry_msgs/PointStamped in a local frame, metres."""
    return [PositionSample(t_ns, vector(message.point), UNKNOWN_SIGMA, False)]


def pose(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the position of geometry_msgs/PoseStamped in a local frame, metres."""
    return [PositionSample(t_ns, vector(message.pose.position), UNKNOWN_SIGMA, False)]


def pose_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the position of geometry_msgs/PoseWithCovarianceStamped in a local frame, metres."""
    found = message.pose
    sigma = sigma_of(found.covariance, HORIZONTAL)
    return [_unless_lost(PositionSample(t_ns, vector(found.pose.position), sigma, False))]


def _geographic(point: Fields, t_ns: int, sigma_m: float) -> PositionSample:
    """Convert latitude, longitude and altitude to a position."""
    return PositionSample(
        t_ns, np.array([point.latitude, point.longitude, point.altitude], float), sigma_m, True
    )


def _unless_lost(sample: PositionSample) -> PositionSample:
    """Replace a position by NaN where its covariance marks it as lost."""
    lost = sample.sigma_m > FAR_M
    return replace(sample, place=LOST, sigma_m=UNKNOWN_SIGMA) if lost else sample
