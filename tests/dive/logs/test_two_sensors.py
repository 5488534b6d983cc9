# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two sensors on one topic are told from one sensor by their readings."""

import numpy as np
import pytest

from hullrecon.dive.logs.samples import DepthSample, DvlSample, ImuSample, JointSample
from hullrecon.dive.logs.streams.dvl import dvl_pings
from hullrecon.dive.logs.streams.imu import imu_samples
from hullrecon.dive.logs.streams.joints import joint_samples
from hullrecon.dive.logs.streams.pressure import PressureModel, pressure_samples
from hullrecon.errors import InputError

COUNT = 400
RANDOM = np.random.default_rng(5)
NOISE = RANDOM.standard_normal(COUNT)
SINKING = np.linspace(0.3, 2.3, COUNT)
MODEL = PressureModel(density=1025.0, gravity=9.81, atmosphere=101325.0)
ANY = np.zeros(3)


def depths(values):
    return [DepthSample(10**8 * k, float(value), is_up=False) for k, value in enumerate(values)]


ONE = {
    "of noise": 1.0 + 0.02 * NOISE,
    "sinking": SINKING + 0.01 * NOISE,
    "in waves": 1.0 + np.sin(np.arange(COUNT) / 3),
    "coarse": np.round(10 * (SINKING + 0.03 * NOISE)) / 10,
    "written thrice": np.repeat(SINKING[::3], 3)[:COUNT] + 0.0,
    "with a few outliers": np.where(np.arange(COUNT) % 90 == 7, 9.0, SINKING + 0.01 * NOISE),
}


@pytest.mark.parametrize("values", ONE.values(), ids=ONE)
def test_depths_of_one_sensor_are_taken(values):
    assert len(pressure_samples(depths(values), MODEL, [])) >= 0.98 * COUNT


TURNS = {"every other": 2, "one of seven": 7}


@pytest.mark.parametrize("every", TURNS.values(), ids=TURNS)
def test_depths_of_two_sensors_are_refused_and_one_of_them_is_taken(every):
    own = SINKING + 0.01 * NOISE
    is_other = np.arange(COUNT) % every == 0
    mixed = np.where(is_other, 0.16 + 1e-3 * NOISE, own)
    with pytest.raises(InputError, match="two sensors") as caught:
        pressure_samples(depths(mixed), MODEL, [])
    assert "a topic or a table of its own" in caught.value.remedy
    assert pressure_samples(depths(mixed[~is_other]), MODEL, []) is not None


def test_two_imus_two_servos_and_two_velocities_are_refused():
    tilt = 0.05 * NOISE[:, None] * [1.0, 0.0, 0.0]
    quaternion = np.column_stack([tilt / 2, np.ones(COUNT)])
    quaternion[::2] = quaternion[::2, [1, 2, 3, 0]]  # turned by half a turn
    quaternion /= np.linalg.norm(quaternion, axis=1)[:, None]
    turned = [ImuSample(k, q, ANY + np.nan, ANY + np.nan) for k, q in enumerate(quaternion)]
    with pytest.raises(InputError, match="two sensors"):
        imu_samples(turned, "ned", [])
    angle = np.where(np.arange(COUNT) % 2, 0.0, SINKING / 10)
    servos = [JointSample(k, "tray", float(a)) for k, a in enumerate(angle)]
    with pytest.raises(InputError, match="joint tray"):
        joint_samples(servos, "tray", "tray", [])
    water = 0.2 * (np.arange(COUNT) % 3 == 0)
    pings = [
        DvlSample(10**8 * k, np.array([0.3 + w, n, 0.0]), np.nan, np.zeros(0), None)
        for k, (w, n) in enumerate(zip(water, 0.002 * NOISE, strict=True))
    ]
    with pytest.raises(InputError, match="m/s to and fro"):
        dvl_pings(pings, None, 0.01, [])
