# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Translate messages of GPS and USBL positions to samples: one small function per type."""

from __future__ import annotations

import numpy as np

from hullrecon.dive.logs.messages.decode import LOST, Fields, vector
from hullrecon.dive.logs.samples import PositionSample, Sample

NAN = float("nan")
NO_FIX, UNKNOWN_COVARIANCE = -1, 0  # of sensor_msgs/NavSatStatus and NavSatFix


def satellite_fix(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read sensor_msgs/NavSatFix, of an antenna above water. A status of -1 is no fix."""
    place = np.array([message.latitude, message.longitude, message.altitude], float)
    known = message.position_covariance_type != UNKNOWN_COVARIANCE
    sigma = _sigma(np.asarray(message.position_covariance, float).reshape(3, 3)) if known else NAN
    return [
        PositionSample(
            t_ns, place if message.status.status != NO_FIX else LOST, sigma, True, by_satellite=True
        )
    ]


def geographic_point(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geographic_msgs/GeoPointStamped."""
    return [_geographic(message.position, t_ns, NAN)]


def geographic_pose(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geographic_msgs/GeoPoseStamped."""
    return [_geographic(message.pose.position, t_ns, NAN)]


def geographic_pose_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geographic_msgs/GeoPoseWithCovarianceStamped, whose covariance is in metres."""
    return [
        _geographic(message.pose.pose.position, t_ns, _sigma(_six_by_six(message.pose.covariance)))
    ]


def point(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geometry_msgs/PointStamped in a local frame, metres."""
    return [PositionSample(t_ns, vector(message.point), NAN, False)]


def pose(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the position of geometry_msgs/PoseStamped in a local frame, metres."""
    return [PositionSample(t_ns, vector(message.pose.position), NAN, False)]


def pose_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the position of geometry_msgs/PoseWithCovarianceStamped in a local frame, metres."""
    found = message.pose
    return [
        PositionSample(
            t_ns, vector(found.pose.position), _sigma(_six_by_six(found.covariance)), False
        )
    ]


def _geographic(point: Fields, t_ns: int, sigma_m: float) -> PositionSample:
    return PositionSample(
        t_ns, np.array([point.latitude, point.longitude, point.altitude], float), sigma_m, True
    )


def _six_by_six(covariance: object) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    return np.asarray(covariance, float).reshape(6, 6)


def _sigma(covariance: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> float:
    """Average the variances of both horizontal axes into a sigma. NaN where they say nothing."""
    variance = 0.5 * (covariance[0, 0] + covariance[1, 1])
    return (
        float(np.sqrt(variance))
        if covariance[0, 0] > 0 and covariance[1, 1] > 0 and np.isfinite(variance)
        else NAN
    )
