# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Attitude by readings whose stamps come unevenly."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.navigation.sensors.attitude import attitude_history
from hullrecon.records.sensors import ImuSamples

RATE_HZ, LATENCY_S = 200, 0.016


def bursts(t_s: np.ndarray) -> np.ndarray:
    """Return the stamps of readings that an adapter hands on every 16 ms, 50 us apart."""
    handed_on = np.ceil(t_s / LATENCY_S)
    first = np.searchsorted(handed_on, handed_on)
    return np.asarray(handed_on * LATENCY_S + 50e-6 * (np.arange(len(t_s)) - first))


def orientation(t_s: np.ndarray) -> Rotation:
    angles = np.stack(
        [0.3 * np.sin(2 * np.pi * t_s / 40), 0.05 * np.sin(2 * np.pi * t_s / 7), 0 * t_s], axis=1
    )
    return Rotation.from_euler("ZYX", angles)


def test_attitude_logged_in_bursts_is_smoothed_within_its_sigma():
    rng = np.random.default_rng(0)
    true_s = np.arange(60 * RATE_HZ) / RATE_HZ
    logged = orientation(true_s) * Rotation.from_rotvec(rng.normal(0, 0.001, (len(true_s), 3)))
    rates = (orientation(true_s - 1e-4).inv() * orientation(true_s + 1e-4)).as_rotvec() / 2e-4
    t_s = bursts(true_s)
    imu = ImuSamples(
        t_ns=np.round(t_s * 1e9).astype(np.int64),
        quaternion=logged.as_quat(),
        angular_velocity=rates + rng.normal(0, 0.002, rates.shape),
        acceleration=np.zeros_like(rates),
    )
    found = attitude_history(imu, 0.0017, 1.0)
    error = (orientation(t_s).inv() * Rotation.from_quat(found.quaternion)).as_rotvec()
    rms = float(np.sqrt(np.mean(np.square(error))))
    assert rms < 0.0004
    assert 0.5 < rms / found.sigma_rad < 1.5
    assert len(found.steps.row) == len(found.steps.disagreement) == 0
