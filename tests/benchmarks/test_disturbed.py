# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How a log is disturbed."""

import numpy as np
import pytest

from benchmarks.disturbed import DVL_TYPE, FAST_SOUND, fast_sound
from hullrecon.synthetic.logs import header, make, store, vector


def test_fast_sound_stretches_velocities_and_ranges_only():
    lengths = {
        "velocity": vector(np.array([0.3, -0.1, 0.02])),
        "range": np.array([1.5, 0.0, 1.7, 1.8]),
    }
    rest = {
        "header": header(123, "dvl"),
        "velocity_mode": 1,
        "dvl_type": 0,
        "velocity_covar": np.zeros(9),
        "altitude": 1.2,
        "course_gnd": 0.1,
        "speed_gnd": 0.3,
        "num_good_beams": 3,
        "sound_speed": 1500.0,
        "beam_ranges_valid": True,
        "beam_velocities_valid": False,
        "beam_unit_vec": [vector(np.array([0.0, 0.0, 1.0]))] * 4,
        "range_covar": np.zeros(4, np.float32),
        "beam_quality": np.ones(4, np.float32),
        "beam_velocity": np.zeros(4, np.float32),
        "beam_velocity_covar": np.zeros(4, np.float32),
    }
    logged = bytes(store().serialize_cdr(make(DVL_TYPE, **rest, **lengths), DVL_TYPE))
    found = store().deserialize_cdr(fast_sound("/dvl", 0.0, logged), DVL_TYPE)
    assert [found.velocity.x, found.velocity.y, found.velocity.z] == pytest.approx(
        [0.3 * FAST_SOUND, -0.103, 0.0206]
    )
    np.testing.assert_allclose(found.range, np.array([1.5, 0.0, 1.7, 1.8]) * FAST_SOUND, rtol=1e-6)
    assert (found.header.stamp.nanosec, found.altitude, found.sound_speed) == (
        123,
        pytest.approx(1.2),
        1500.0,
    )
    assert fast_sound("/imu", 0.0, logged) == logged
