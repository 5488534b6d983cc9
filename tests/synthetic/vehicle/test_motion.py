# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.poses import from_mount, identity
from hullrecon.synthetic.vehicle import Motion, ticks, with_backlash


@pytest.fixture
def turning() -> Motion:
    """1 m/s forward along g's x, yaw at 0.2 rad/s, tray at 0.1 rad."""
    t = np.arange(0, 10, 0.02)
    zero = np.zeros_like(t)
    position, attitude = np.stack([t, zero, zero + 2], 1), np.stack([zero, zero, 0.2 * t], 1)
    return Motion(
        t_s=t,
        position=position,
        roll_pitch_yaw=attitude,
        encoder=zero + 0.1,
        tray=zero + 0.1,
        sonar_tray=zero - 0.6,
        global_from_hull=identity(),
    )


def test_load_stands_still_while_gear_crosses_its_backlash() -> None:
    command = np.array([0.0, 0.5, 1.0, 2.0, 1.5, 1.0, 0.5, -1.0])
    np.testing.assert_allclose(
        with_backlash(command, 0.5), [0.0, 0.0, 0.5, 1.5, 1.5, 1.5, 1.0, -0.5]
    )


def test_without_backlash_load_follows() -> None:
    command = np.sin(np.arange(50))
    np.testing.assert_array_equal(with_backlash(command, 0.0), command)


def test_pose_and_rates_are_those_of_path(turning: Motion) -> None:
    at = turning.vehicle(np.array([5.0]))
    np.testing.assert_allclose(at.translation[0], [5, 0, 2], atol=1e-9)
    assert at.rotation.as_euler("xyz")[0, 2] == pytest.approx(1.0)
    np.testing.assert_allclose(turning.rates(np.array([5.0]))[0], [0, 0, 0.2], atol=1e-9)


def test_straight_path_has_no_acceleration(turning: Motion) -> None:
    np.testing.assert_allclose(turning.acceleration(np.array([3.0, 4.0])), 0, atol=1e-6)


def test_something_on_tray_turns_with_it(turning: Motion) -> None:
    at = turning.on_tray(np.array([0.0]), from_mount([0.2, 0, 0, 0, 0, 0]), (0.45, 0.0, 0.1))
    expected = [0.45 + 0.2 * np.cos(0.1), 0, 2.1 - 0.2 * np.sin(0.1)]
    np.testing.assert_allclose(at.translation[0], expected, atol=1e-9)


def test_sonar_has_its_own_servo(turning: Motion) -> None:
    mount = from_mount([1.0, 0, 0, 0, 0, 0])
    at = turning.on_tray(np.array([0.0]), mount, (0.0, 0.0, 0.0), turning.sonar_tray)
    np.testing.assert_allclose(at.translation[0], [np.cos(0.6), 0, 2 + np.sin(0.6)], atol=1e-9)


@pytest.mark.parametrize("rate_hz", [2.0, 25.0])
def test_sensor_ticks_nearly_evenly_within_motion(turning: Motion, rate_hz: float) -> None:
    t = ticks(turning, rate_hz, np.random.default_rng(0), 0.3)
    assert t[0] == pytest.approx(0.3, abs=0.011)
    assert t[-1] < turning.t_s[-1]
    np.testing.assert_allclose(np.diff(t), 1 / rate_hz, atol=0.021 / max(1.0, rate_hz / 5))
