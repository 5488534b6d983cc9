# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What an outage leaves of a log."""

import pytest

from benchmarks.outage import outage

LOST = outage(-20.0, 40.0)


@pytest.mark.parametrize(
    "topic", ["/dvl", "/camera/top/image_raw/compressed", "/camera/bottom/image_raw/compressed"]
)
def test_neither_the_dvl_nor_a_camera_is_logged_during_an_outage(topic):
    kept = [
        since
        for since in (-20.1, -20.0, 0.0, 39.9, 40.0)
        if LOST(topic, since, b"message") is not None
    ]
    assert kept == [-20.1, 40.0]


@pytest.mark.parametrize("topic", ["/imu", "/pressure", "/joint_states"])
def test_what_knows_the_attitude_and_the_depth_goes_on(topic):
    assert LOST(topic, 0.0, b"message") == b"message"
