# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Headings by the rates of an IMU whose compass swings near the ship's steel."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.samples import ImuSample
from hullrecon.dive.logs.streams.imu import imu_samples
from hullrecon.errors import InputError

HZ, SECONDS = 10, 600
BIAS_RAD_S = np.radians(0.02)
T_S = np.arange(0, SECONDS, 1 / HZ)
TRUE = Rotation.from_euler(
    "ZYX", np.column_stack([0.5 * np.sin(0.1 * T_S), 0.05 * np.sin(T_S), 0.1 * np.cos(0.7 * T_S)])
)
SWING = np.radians(15.0) * np.sin(0.21 * T_S)


def read(heading: str, bias: float = BIAS_RAD_S, notes=None):
    """Readings of an IMU whose orientation swings about the vertical, and whose rates do not."""
    swung = Rotation.from_euler("z", SWING[:, None]) * TRUE
    rates = (TRUE[:-1].inv() * TRUE[1:]).as_rotvec() * HZ
    rates = 0.5 * (np.vstack([rates[:1], rates]) + np.vstack([rates, rates[-1:]]))
    rates = rates + bias * TRUE.inv().apply([0.0, 0.0, 1.0])
    samples = [
        ImuSample(round(t * 1e9), quaternion, rate, np.full(3, np.nan))
        for t, quaternion, rate in zip(T_S, swung.as_quat(), rates, strict=True)
    ]
    return imu_samples(samples, "ned", [] if notes is None else notes, heading=heading)


def heading_error(imu) -> np.ndarray:
    turned = (Rotation.from_quat(imu.quaternion) * TRUE.inv()).as_rotvec()
    return turned[:, 2] - turned[:, 2].mean()


def test_heading_by_rates_follows_the_vehicle_and_not_the_compass():
    by_orientation, by_rates = (
        heading_error(read(heading)) for heading in ("orientation", "rates")
    )
    assert np.degrees(by_orientation.std()) > 10
    assert np.degrees(by_rates.std()) < 0.6


def test_the_drift_that_check_tells_is_that_of_the_rates():
    notes = []
    read("rates", notes=notes)
    (values,) = (note.values for note in notes if note.code == "heading-of-rates")
    assert values["swing_deg"] == pytest.approx(15 / np.sqrt(2), rel=0.1)
    off_deg_h = values["drift_deg_h"] - 3600 * np.degrees(BIAS_RAD_S)
    assert abs(off_deg_h) < 3 * values["sigma_deg_h"] < 180


def test_without_rates_the_heading_stays_the_orientations():
    with pytest.raises(InputError, match="angular velocities were not logged") as caught:
        read("rates", bias=np.nan)
    assert 'imu.heading = "orientation"' in caught.value.remedy
    assert len(read("orientation", bias=np.nan).t_ns) == len(T_S)
