# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Faults are what they are called, and outcomes are judged by who is named."""

import numpy as np
import pytest

from benchmarks.faulty_inputs import KINDS, NAMES, Seen, outcome
from benchmarks.input_faults import faults
from hullrecon.synthetic.logs import make, vector


def seen(error_mm: float = 5.0, code: int = 0, sigmas: float = 1.0, told: str = "") -> Seen:
    return Seen(
        check_code=code,
        run_code=code,
        sentences=["4 of 977 DVL ranges rejected as outliers", *([told] if told else [])],
        error_mm=error_mm,
        sigmas=sigmas,
    )


@pytest.mark.parametrize(
    ("found", "judged"),
    [
        (seen(), "right"),
        (seen(error_mm=100.0), "silent"),
        (seen(sigmas=9.0), "unsure"),
        (seen(sigmas=9.0, told="the pressure does not follow the DVL"), "unsure"),
        (seen(error_mm=100.0, told="The trim of the hull is uncertain by 1.00 degrees"), "silent"),
        (seen(told="dvl.mount is off"), "blamed"),
        (seen(code=3, told="camera: f is 1.3 times off (by the pressure's depths)"), "blamed"),
        (
            seen(
                code=3,
                told="DVL and IMU contradict each other, and which of them is wrong is not "
                "known: in 3 s the depth by pressure changes",
            ),
            "blamed",
        ),
        (seen(error_mm=100.0, told="the pressure does not follow the DVL"), "named"),
        (seen(error_mm=100.0, told="dvl.mount is off"), "blamed"),
        (seen(code=3, told="the pressure stays constant"), "refused"),
        (seen(code=4, told="too few images match"), "blamed"),
    ],
)
def test_outcome_depends_on_error_and_on_who_is_named(found: Seen, judged: str):
    assert outcome(found, seen(), "pressure") == judged


@pytest.mark.parametrize("kind", KINDS)
def test_every_fault_has_a_sensor_and_changes_something(kind: str):
    drawn = faults(kind, np.random.default_rng(1))
    assert {fault.sensor for fault in drawn.values()} <= NAMES.keys()
    assert all(fault.edits or fault.files for fault in drawn.values())
    assert ("camera-medium" in drawn) == (kind != "none")
    assert ("camera-bottom-late" in drawn) == (kind == "stereo")


def test_what_says_how_well_something_is_known_accuses_nobody():
    assert seen().accusations == []
    assert seen(told="the sigmas hold for a model that is to scale.").accusations == []
    assert seen(told="they hold for a speed of sound that is right to 1 %").accusations == []
    assert seen(told="DVL: wrong (by the images)").accusations == ["DVL: wrong "]


def test_rates_in_degrees_are_57_times_those_in_radians():
    edit = faults("none", np.random.default_rng(1))["imu-rates-deg"].edits["/imu"]
    message = make_imu((0.1, 0.0, -0.2))
    edit(message, 0.0)
    assert message.angular_velocity.x == pytest.approx(5.7296, abs=1e-4)
    assert message.angular_velocity.z == pytest.approx(-11.459, abs=1e-3)


def test_inverse_attitude_undoes_the_attitude():
    edit = faults("none", np.random.default_rng(1))["imu-inverse"].edits["/imu"]
    message = make_imu((0.0, 0.0, 0.0))
    edit(message, 0.0)
    q = message.orientation
    assert np.allclose([q.x, q.y, q.z, q.w], [0, 0, -0.6, 0.8])


def make_imu(rates: tuple[float, float, float]):
    return make(
        "sensor_msgs/msg/Imu",
        header=None,
        orientation=make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.6, w=0.8),
        orientation_covariance=np.zeros(9),
        angular_velocity=vector(rates),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector((0, 0, 9.8)),
        linear_acceleration_covariance=np.zeros(9),
    )
