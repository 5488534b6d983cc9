# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A heading that steps while the vehicle goes on: found, taken off, and told from turns, biases and
scales of the rates.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from hullrecon.navigation.sensors.attitude import attitude_history
from hullrecon.records.sensors import ImuSamples

RATE_HZ = 25


def imu(yaw: np.ndarray, stepped: np.ndarray, scale: float = 1.0, seed: int = 1) -> ImuSamples:
    """An IMU of a vehicle that truly yaws so (rad, at 25 Hz), whose heading is logged with steps;
    its rates have a scale.
    """
    random, n = np.random.default_rng(seed), len(yaw)
    tilt = 0.05 * np.sin(np.arange(n) / 60)
    true = Rotation.from_euler("xyz", np.column_stack([tilt, -tilt, yaw]))
    rates = np.zeros((n, 3))
    rates[1:-1] = (true[:-2].inv() * true[2:]).as_rotvec() * (0.5 * RATE_HZ)
    logged = Rotation.from_euler("z", (stepped + 4e-4 * random.standard_normal(n))[:, None]) * true
    noisy = scale * rates + 0.002 * random.standard_normal((n, 3)) + [0.001, 0.0, 0.002]
    t_ns = np.round(1e9 * np.arange(n) / RATE_HZ).astype(np.int64)
    return ImuSamples(
        t_ns=t_ns,
        quaternion=logged.as_quat(),
        angular_velocity=noisy,
        acceleration=np.zeros((n, 3)),
    )


def heading(quaternion: np.ndarray) -> np.ndarray:
    return Rotation.from_quat(quaternion).as_euler("ZYX")[:, 0]


T = np.arange(3000) / RATE_HZ
SWING = 0.3 * np.sin(0.2 * T)


@pytest.mark.parametrize("step_deg", [3.0, -1.5])
def test_a_step_is_found_measured_and_taken_off(step_deg: float) -> None:
    step = np.radians(step_deg) * (T >= 60)
    found = attitude_history(imu(SWING, step), 0.002)
    assert found.steps.row.tolist() == [1500]
    assert found.steps.size == pytest.approx([np.radians(step_deg)], abs=np.radians(0.1))
    assert np.abs(heading(found.quaternion) - SWING).max() < np.radians(0.15)


def test_the_error_that_a_step_leaves_is_within_its_sigma() -> None:
    errors = []
    for seed in range(12):
        found = attitude_history(imu(SWING, 0.05 * (T >= 60), seed=seed), 0.002)
        turned = (
            np.diff(heading(found.quaternion)[[1450, 1550]])[0] - np.diff(SWING[[1450, 1550]])[0]
        )
        variance = found.turn_variance(found.t_ns[[1450]], found.t_ns[[1550]])[0]
        errors.append(turned / np.sqrt(variance))
    assert 0.3 < float(np.sqrt(np.mean(np.square(errors)))) < 1.5


def test_slow_heading_disagreement_widens_turn_variance() -> None:
    slow = np.radians(3) * np.clip((T - 60) / 0.8, 0, 1)
    found = attitude_history(imu(SWING, slow), 0.002)
    assert len(found.steps.row) == 0
    assert len(found.steps.disagreement) > 0
    at = np.round(1e9 * np.array([20, 40, 58, 64])).astype(np.int64)
    still, across = np.sqrt(found.turn_variance(at[[0, 2]], at[[1, 3]]))
    assert np.radians(2.5) < across < np.radians(5)
    assert still < np.radians(0.2)


def test_turns_of_vehicle_are_no_steps_despite_rate_scale() -> None:
    sharp = gaussian_filter1d(
        np.interp(T, [0, 40, 41.5, 90, 91, 120], [0, 0, 1.5, 1.5, 0.5, 0.5]), 0.2 * RATE_HZ
    )
    for scale in (1.0, 0.98):
        assert len(attitude_history(imu(sharp, np.zeros(len(T)), scale), 0.002).steps.row) == 0


def test_turn_faster_than_vehicle_is_a_step_without_rates() -> None:
    def silent(yaw: np.ndarray, step: np.ndarray) -> ImuSamples:
        found = imu(yaw, step)
        return replace(found, angular_velocity=np.full_like(found.angular_velocity, np.nan))

    found = attitude_history(silent(SWING, 0.06 * (T >= 60)), 0.002)
    assert found.steps.row.tolist() == [1500]
    assert np.abs(heading(found.quaternion) - SWING).max() < 5 * found.steps.sigma_rad
    sharp = gaussian_filter1d(np.interp(T, [0, 40, 41.5, 120], [0, 0, 1.2, 1.2]), 0.2 * RATE_HZ)
    assert len(attitude_history(silent(sharp, np.zeros(len(T))), 0.002).steps.row) == 0


def test_several_steps_are_each_found() -> None:
    step = 0.05 * (T >= 20) - 0.1 * (T >= 60) + 0.02 * (T >= 100)
    assert attitude_history(imu(SWING, step), 0.002).steps.row.tolist() == [500, 1500, 2500]
