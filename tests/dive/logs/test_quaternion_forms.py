# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Orientations of which only x, y and z were logged."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.quaternion_forms import complete_quaternions
from hullrecon.errors import InputError

T_S = np.arange(0.0, 20.0, 0.04)
T_NS = np.round(T_S * 1e9).astype(np.int64)
# roll, pitch and yaw of a vehicle that turns by more than a right angle, rad
ANGLES = np.column_stack([0.05 * np.sin(T_S), 0.1 * np.cos(T_S), 0.1 * T_S])
TRUE = Rotation.from_euler("ZYX", ANGLES[:, ::-1])
RATES = np.gradient(ANGLES, T_S, axis=0)  # those about the body's axes, but for the small tilt
PARTS = {
    "vector part, w zero": np.c_[TRUE.as_quat()[:, :3], np.zeros(len(T_S))],
    "vector part, w one": np.c_[TRUE.as_quat()[:, :3], np.ones(len(T_S))],
    "radians": np.c_[ANGLES, np.zeros(len(T_S))],
    "degrees": np.c_[np.degrees(ANGLES), np.ones(len(T_S))],
}


@pytest.mark.parametrize("part", PARTS)
def test_what_is_logged_of_an_orientation_is_told_by_its_rates(part):
    notes = []
    read = complete_quaternions(T_NS, PARTS[part], RATES, notes)
    assert (Rotation.from_quat(read) * TRUE.inv()).magnitude().max() < 1e-6
    assert [note.code for note in notes] == ["quaternions-completed"]


def test_parts_of_quaternions_without_rates_are_refused_until_whole():
    no_rates = np.full_like(RATES, np.nan)
    with pytest.raises(InputError, match="is 0 in all 500") as refused:
        complete_quaternions(T_NS, PARTS["radians"], no_rates, [])
    assert refused.value.remedy == "log an IMU that gives orientation as a quaternion x, y, z, w"
    whole = complete_quaternions(T_NS, TRUE.as_quat(), no_rates, [])
    np.testing.assert_array_equal(whole, TRUE.as_quat())


def test_a_w_that_is_one_by_rounding_alone_is_no_part():
    small = np.round(Rotation.from_euler("ZYX", 0.1 * ANGLES[:, ::-1] * [0, 1, 1]).as_quat(), 3)
    assert (small[:, 3] == 1).all()
    notes = []
    np.testing.assert_array_equal(complete_quaternions(T_NS, small, RATES, notes), small)
    assert notes == []
