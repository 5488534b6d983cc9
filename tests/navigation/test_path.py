# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The path of dead reckoning and its steps, on runs simple enough to work out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.dead_reckoning.nodes import Nodes
from hullrecon.navigation.dead_reckoning.odometry import LEAST_SIGMA_M, odometry, white_covariance
from hullrecon.navigation.dead_reckoning.reckoning import Reckoning, reckon
from hullrecon.navigation.dead_reckoning.remarks import remarks_of
from hullrecon.navigation.dead_reckoning.returns import returns
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.heading_steps import HeadingSteps
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.sensors.velocity import Agitation, Velocities
from hullrecon.records.sensors import DvlPings, JointSamples
from hullrecon.rig import Rig

SECOND = 1_000_000_000
NO_HOLES = np.zeros((0, 2), np.int64)
SIGMA_M_S, SIGMA_RAD = 0.003, 0.001


def stamps(t_s) -> np.ndarray:
    return np.round(np.asarray(t_s, float) * SECOND).astype(np.int64)


@pytest.fixture
def plain(rig: Rig) -> Rig:
    """The DVL's axes are the vehicle's; it sits 0.5 m ahead of it, on a tray that turns about the
    vehicle's origin.
    """
    ahead = poses.from_mount([0.5, 0.0, 0.0, 0.0, 0.0, 0.0])
    return replace(rig, tray_origin=np.zeros(3), tray_from_dvl=ahead)


def run(
    rig: Rig, velocity, turn_rad_s: float = 0.0, tray=None, outages: np.ndarray = NO_HOLES
) -> Reckoning:
    """Ten seconds at 20 Hz; velocity (3,) of the instrument in dvl, heading turn_rad_s t, tray (n,)
    rad at each ping.
    """
    t = np.arange(0, 10.001, 0.05)
    n = len(t)
    heading = Rotation.from_euler("z", (turn_rad_s * t)[:, None])
    attitude = AttitudeHistory(stamps(t), heading.as_quat(), SIGMA_RAD, 0.0, NO_HOLES, False)
    v = Velocities(
        t_ns=stamps(t),
        velocity=np.tile(np.asarray(velocity, float), (n, 1)),
        sigma=np.full(n, SIGMA_M_S),
        outages=outages,
        agitation=Agitation(lag_s=np.array([1.0]), rate=np.array([0.01])),
        outliers=np.zeros(0, np.int64),
    )
    joint = None if tray is None else JointSamples(t_ns=stamps(t), angle=np.full(n, tray))
    return reckon(v, attitude, servo(joint, 0), rig)


def test_a_vehicle_that_turns_on_the_spot_stays_there(plain) -> None:
    """The instrument, half a metre ahead, moves sideways at 0.05 m/s; the vehicle's own origin does
    not.
    """
    at = run(plain, [0.0, 0.05, 0.0], turn_rad_s=0.1).at(stamps([0, 3, 10]))
    assert np.allclose(at.poses().translation, [[-0.5, 0, 0]] * 3, atol=1e-5)
    assert np.linalg.norm(at.instrument[2]) == pytest.approx(2 * 0.5 * np.sin(0.5), abs=1e-5)


def test_a_circle_closes(plain) -> None:
    on_axis = replace(plain, tray_from_dvl=poses.identity())
    rate = 2 * np.pi / 10
    at = run(on_axis, [0.3, 0.0, 0.0], turn_rad_s=rate).at(stamps([0, 5, 10]))
    assert np.allclose(at.instrument[2], 0, atol=1e-9)
    # a diameter to starboard
    assert np.allclose(at.instrument[1], [0, 2 * 0.3 / rate, 0], atol=1e-3)


def test_a_tray_that_is_turned_down_turns_the_velocity(plain) -> None:
    at = run(plain, [0.2, 0.0, 0.0], tray=np.radians(90.0)).at(stamps([0, 10]))
    # +90 degrees about y: x becomes -z
    assert np.allclose(np.diff(at.instrument, axis=0), [[0, 0, -2.0]], atol=1e-9)
    assert np.allclose(at.lever[0], [0, 0, -0.5], atol=1e-12)


def test_steps_put_together_are_the_path(plain) -> None:
    path = run(plain, [0.2, 0.03, -0.01], turn_rad_s=0.2)
    at = path.at(stamps([0, 1, 2.5, 7, 10]))
    found = odometry(path, at)
    end = at.poses()[[0]]
    for k in range(4):
        end = end @ Poses(found.quaternion[[k]], found.translation[[k]])
    assert np.allclose(end.matrix(), at.poses()[[4]].matrix(), atol=1e-12)
    assert found.first.tolist() == [0, 1, 2, 3]
    assert found.second.tolist() == [1, 2, 3, 4]


def test_the_drift_of_a_straight_step_bends_it_by_half_its_time(plain) -> None:
    """0.2 m/s over 4 s with a drift c: sideways c * 0.2 * 16 / 2, less the lever's swing c * 4 *
    0.5.
    """
    path = run(plain, [0.2, 0.0, 0.0])
    step = odometry(path, path.at(stamps([3, 7])))
    assert np.allclose(step.by_navigation[0, :, 1], [0, 1.6 - 2.0, 0, 0, 0, 4.0], atol=1e-9)
    assert np.allclose(step.by_navigation[0, :, 0], [0.8, 0, 0, 0, 0, 0], atol=1e-9)


def test_white_covariance_combines_velocity_noise_and_lever(
    plain,
) -> None:
    path = run(plain, [0.2, 0.0, 0.0])
    at = path.at(stamps([2, 6]))
    found = white_covariance(path, at, at.poses()[[0]].inverse() @ at.poses()[[1]])[0]
    shift = SIGMA_M_S**2 * 0.05 * 4 + LEAST_SIGMA_M**2
    turn = path.attitude.turn_variance(stamps([2]), stamps([6]))[0]
    assert np.allclose(np.diag(found)[:3], shift + turn * np.array([0, 0.25, 0.25]))
    assert np.allclose(found[3:, 3:], turn * np.eye(3))
    # a turn to starboard about the instrument moves the vehicle to port
    assert found[1, 5] == pytest.approx(-0.5 * turn)
    assert np.array_equal(found, found.T)


# remarks


def remarks_on(path: Reckoning, pings: DvlPings, nodes: Nodes, flagged: np.ndarray):
    hung = returns(pings, path, path.at(nodes.t_ns), flagged)
    return remarks_of(pings.t_ns, path, nodes, None, hung)


def pings_along(path: Reckoning, range_m: float) -> DvlPings:
    """Return pings of two beams that measure the path's velocities and one range."""
    return DvlPings(
        t_ns=path.velocities.t_ns,
        velocity=path.velocities.velocity,
        velocity_sigma=path.velocities.sigma,
        ranges=np.full((201, 2), range_m),
        beams=np.eye(3)[:2],
    )


def test_outages_and_rejections_are_reported_with_times(plain) -> None:
    path = run(plain, [0.2, 0, 0], outages=np.array([stamps([1.0, 2.0]), stamps([4.0, 7.5])]))
    pings = pings_along(path, range_m=1.5)
    nodes = Nodes(stamps([0, 5, 10]), np.full((3, 2), -1), 0, 2)
    flagged = np.zeros((201, 2), bool)
    flagged[100, 1] = True
    sentences, facts = remarks_on(path, pings, nodes, flagged)
    sigma_m = np.sqrt(0.01 * 3.5**3 / 12)
    across = f"navigation alone knows the way across it to {sigma_m:.2f} m (one sigma, each axis)"
    assert f"DVL: 2 outages bridged at constant velocity, the longest 3.5 s; {across}" in sentences
    assert "1 of 402 DVL ranges rejected as outliers" in sentences
    assert any(
        s.startswith("2 images have no pose: DVL and IMU did not both run then") for s in sentences
    )
    assert facts["outages_s"] == [[1.0, 2.0], [4.0, 7.5]]
    assert facts["flagged_returns_s"] == [5.0]
    assert facts["path_length_m"] == pytest.approx(2.0)
    assert facts["depth_white_sigma_m"] is None


def test_a_run_without_a_flaw_says_only_what_was_not_logged(plain) -> None:
    path = run(plain, [0.2, 0, 0], tray=0.0)
    pings = pings_along(path, range_m=np.nan)
    sentences, facts = remarks_on(
        path, pings, Nodes(stamps([0, 10]), np.full((2, 2), -1), 0, 0), np.zeros((201, 2), bool)
    )
    assert sentences == [
        "IMU: no rates; the attitude between readings is interpolated",
        "no pressure: the depth is counted from the start and drifts",
    ]
    assert facts["returns"] == 0


@pytest.mark.parametrize(
    ("outage", "way"), [(NO_HOLES, " and 1.3 m of way;"), (np.array([stamps([1.5, 8.0])]), ";")]
)
def test_span_without_images_is_named_with_time_and_distance(plain, outage, way) -> None:
    path = run(plain, [0.2, 0, 0], outages=outage)
    t_s = np.array([0, 0.5, 1, 1.5, 2, 4, 6, 8, 8.5, 9])
    image = np.full((10, 2), -1)
    image[[0, 1, 2, 3, 7, 8, 9], 0] = np.arange(7)
    pings = pings_along(path, range_m=np.nan)
    sentences, facts = remarks_on(
        path, pings, Nodes(stamps(t_s), image, 0, 0), np.zeros((201, 2), bool)
    )
    (named,) = [sentence for sentence in sentences if sentence.startswith("camera")]
    assert named.startswith(
        f"camera: 1 span without images that have a pose, the longest 6.5 s{way}"
    )
    assert facts["without_images_s"] == [[1.5, 8.0]]


def test_a_heading_that_steps_is_named_with_its_size_and_time(plain) -> None:
    path = run(plain, [0.2, 0, 0])
    stepped = replace(
        path.attitude,
        steps=HeadingSteps(
            np.array([1]), np.array([np.radians(3)]), 0.001, np.array([50]), np.array([0.02])
        ),
    )
    pings = pings_along(path, range_m=np.nan)
    nodes = Nodes(stamps([0, 10]), np.full((2, 2), -1), 0, 0)
    sentences, facts = remarks_on(
        replace(path, attitude=stepped), pings, nodes, np.zeros((201, 2), bool)
    )
    step, disagreement = [sentence for sentence in sentences if "heading" in sentence]
    assert step.startswith("IMU: 1 step in the heading, by +3.0 degrees at ")
    assert disagreement.startswith(
        "IMU: heading and rates part 1 time, at most by 1.1 degrees at 1970-01-01T00:00:02.500Z"
    )
    assert facts["heading_steps_deg"] == [3.0]
