# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from navigation.instruments import SIGMAS

from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import roll_pitch_yaw
from hullrecon.navigation.dead_reckoning.dead_reckon import dead_reckon, usable_frames
from hullrecon.navigation.dead_reckoning.image_walk import ImageWalk
from hullrecon.records.sensors import ImuSamples

START_NS, SECOND = 1_777_887_000_000_000_000, 10**9


@pytest.fixture(scope="session")
def found(perfect, rig):
    return dead_reckon(perfect, rig, SIGMAS)


def test_a_return_carries_the_vehicle_from_its_node_to_its_ping(simulated, found, rig):
    """Hung on the true nodes, the beam's start is where the true instrument was at the ping."""
    r, t = found.returns, found.trajectory
    seconds = (r.t_ns - t.t_ns[0]) * 1e-9 + (t.t_ns[0] - START_NS) * 1e-9
    node_s = (t.t_ns - START_NS) * 1e-9
    at_ping = simulated.poses(node_s)[r.node] @ Poses(r.quaternion, r.translation)
    angle = simulated.tray(node_s)[r.node] + r.tray_offset
    instrument = at_ping @ poses.tray_poses(rig.tray_origin, angle) @ rig.tray_from_dvl
    assert np.abs(instrument.translation - simulated.instrument(seconds).translation).max() < 1e-3


def test_returns_hang_on_the_nearest_node(found):
    r, t = found.returns, found.trajectory
    gap = np.abs(r.t_ns - t.t_ns[r.node])
    assert (gap == np.abs(r.t_ns[:, None] - t.t_ns[None]).min(axis=1)).all()
    assert len(r.t_ns) == 4 * 800


def test_attitude_record_has_depth_of_sensor_not_of_vehicle(simulated, found, rig):
    t = (found.trajectory.t_ns - START_NS) * 1e-9
    sensor = simulated.poses(t).apply(rig.pressure_origin)[:, 2]
    assert np.abs(found.attitude.depth - sensor).max() < 3e-3
    rpy = roll_pitch_yaw(simulated.attitude(t))
    assert np.allclose(
        np.stack([found.attitude.roll, found.attitude.pitch], 1), rpy[:, :2], atol=1e-3
    )
    assert found.attitude.sigma[0].tolist() == [SIGMAS.depth_m, SIGMAS.tilt_rad, SIGMAS.tilt_rad]


def test_an_image_that_does_not_decode_has_no_node(perfect, rig):
    usable = perfect.top.usable.copy()
    usable[3] = False
    gone = dead_reckon(replace(perfect, top=replace(perfect.top, usable=usable)), rig, SIGMAS)
    assert 3 not in gone.trajectory.image[:, 0]
    assert {2, 4} <= set(gone.trajectory.image[:, 0].tolist())


def test_a_dive_without_cameras_has_nodes_at_its_pings(perfect, rig):
    blind = dead_reckon(replace(perfect, top=None), rig, SIGMAS)
    assert (blind.trajectory.image == -1).all()
    assert np.isin(blind.trajectory.t_ns, perfect.dvl.t_ns).all()
    assert len(blind.odometry.first) == len(blind.trajectory.t_ns) - 1


def test_neighbouring_edges_compose_to_the_path_in_the_plane(found):
    edge = Poses(found.odometry.quaternion, found.odometry.translation)
    end = poses.identity()
    for k in range(len(edge)):
        end = end @ edge[k]
    whole = found.trajectory.poses()[[0]].inverse() @ found.trajectory.poses()[[-1]]
    # the pressure holds z of the path alone
    assert np.allclose(end.translation, whole.translation, atol=5e-3)


def heard_only(logs, begin_s, end_s):
    """The logs of a DVL that is heard from one time to another alone, s after the dive's start."""
    dvl, start = logs.dvl, START_NS
    silent = (dvl.t_ns < start + begin_s * 1e9) | (dvl.t_ns > start + end_s * 1e9)
    velocity = dvl.velocity.copy()
    velocity[silent] = np.nan
    return replace(logs, dvl=replace(dvl, velocity=velocity))


def walk(logs, goes_on=lambda first, second: True):
    """The upper camera's images, each of which goes on from the other where goes_on says so, by
    their rows.
    """
    return ImageWalk(frames=usable_frames(logs.top), goes_on=goes_on)


def test_images_beyond_dvl_get_nodes_as_far_as_they_overlap(perfect, rig):
    asked = []

    def goes_on(first, second):
        asked.append((first, second))
        return 10 <= second < 70

    silent = heard_only(perfect, 15, 25)
    found = dead_reckon(silent, rig, SIGMAS, walk(silent, goes_on))
    assert found.trajectory.image[0, 0] == 10
    assert found.trajectory.image[-1, 0] == 69
    assert (np.diff(found.trajectory.image[:, 0]) == 1).all()
    assert all(abs(first - second) == 1 for first, second in asked)
    assert {9, 70} <= {second for _, second in asked}
    assert not {8, 71} & {second for _, second in asked}
    (sentence,) = [remark for remark in found.remarks if "silent" in remark]
    assert "the first 9.8 s and the last 9.8 s" in sentence
    without = dead_reckon(silent, rig, SIGMAS)
    assert without.trajectory.image[0, 0] > 25
    assert without.trajectory.image[-1, 0] < 55


def test_images_are_not_followed_across_a_blank(perfect, rig):
    usable = perfect.top.usable.copy()
    usable[60:66] = False
    logs = replace(heard_only(perfect, 0, 25), top=replace(perfect.top, usable=usable))
    found = dead_reckon(logs, rig, SIGMAS, walk(logs))
    assert found.trajectory.image[:, 0].max() == 59


@pytest.mark.parametrize(
    ("blind", "last"), [((), 99), ((40,), 99), (range(40, 44), 99), (range(40, 47), 39)]
)
def test_dense_images_are_followed_in_strides_then_singly(blind, last):
    """At 10 Hz: five at a time, and around those that show nothing."""
    asked = []

    def goes_on(first, second):
        asked.append(second)
        return second not in blind and second - first <= 5

    t_ns = np.arange(100) * SECOND // 10
    dense = ImageWalk(frames=(t_ns, np.arange(100)), goes_on=goes_on)
    assert dense.widened((0, SECOND)) == (0, int(t_ns[last]))
    assert len(asked) < 40


@pytest.mark.parametrize(
    ("lasts_s", "shown", "gone"),
    [
        (20, range(0), range(20, 60)),
        (20, range(30, 41), range(20, 60)),
        (20, range(15, 30), range(30, 60)),
        (1, range(0), ()),
    ],
    ids=["nothing", "an island", "one side", "a short outage"],
)
def test_images_in_outage_linked_to_neither_side_have_no_pose(perfect, rig, lasts_s, shown, gone):
    """The DVL is silent from 9.9 s; images 20 to 59 lie in the longer outage. A second leaves the
    way known to centimetres.
    """
    dvl, start = perfect.dvl, START_NS
    velocity = dvl.velocity.copy()
    velocity[(dvl.t_ns > start + 9.9e9) & (dvl.t_ns < start + (9.9 + lasts_s) * 1e9)] = np.nan
    logs = replace(perfect, dvl=replace(dvl, velocity=velocity))
    outside = set(range(20)) | set(range(60, 100))
    found = dead_reckon(
        logs,
        rig,
        SIGMAS,
        walk(
            logs,
            lambda first, second: (
                second in outside or (second in shown and first in {*outside, *shown})
            ),
        ),
    )
    every = set(perfect_images(perfect, rig))
    assert every - set(found.trajectory.image[:, 0].tolist()) == set(gone)
    told = [remark for remark in found.remarks if "no pose" in remark]
    assert bool(told) == bool(gone)


def perfect_images(perfect, rig):
    """Rows of the images that have a pose where the DVL is never silent."""
    return dead_reckon(perfect, rig, SIGMAS).trajectory.image[:, 0].tolist()


def test_beyond_the_dvl_the_path_is_off_by_no_more_than_it_says(simulated, perfect, rig):
    """And before it as after it: the walk counts from the first velocity both ways."""
    logs = heard_only(perfect, 15, 25)
    found = dead_reckon(logs, rig, SIGMAS, walk(logs))
    t = found.trajectory
    seconds = (t.t_ns - START_NS) * 1e-9
    start = np.flatnonzero(seconds >= 15)[0]
    error = (t.translation - t.translation[start]) - (
        simulated.place(seconds) - simulated.place(seconds)[start]
    )
    sigma = np.sqrt(np.diagonal(t.covariance, axis1=1, axis2=2)[:, :2])
    assert np.abs(error[[0, -1], :2]).max() > 0.5
    assert (np.abs(error[:, :2]) < 3 * sigma + 0.01).all()
    along_walk = found.error_model.walk[:, 0, 0]
    assert (np.diff(along_walk) > 0).all()
    assert along_walk[0] < 0 < along_walk[-1]
    assert np.abs(error[:, 2]).max() < 0.05  # the pressure was heard


@pytest.mark.parametrize(("begin_s", "end_s"), [(0, 20), (20, 40)])
def test_attitude_beyond_imu_is_within_its_sigma(simulated, perfect, rig, begin_s, end_s):
    """The DVL is heard throughout: the way is of the right length, and turned with the attitude."""
    read = (perfect.imu.t_ns >= START_NS + begin_s * SECOND) & (
        perfect.imu.t_ns <= START_NS + end_s * SECOND
    )
    logs = replace(
        perfect, imu=ImuSamples(**{name: value[read] for name, value in vars(perfect.imu).items()})
    )
    found = dead_reckon(logs, rig, SIGMAS, walk(logs))
    t = found.trajectory
    assert t.image[:, 0].tolist() == perfect_images(perfect, rig)
    seconds = (t.t_ns - START_NS) * 1e-9
    turn = (simulated.attitude(seconds).inv() * t.poses().rotation).magnitude()
    covariance = np.diagonal(t.covariance, axis1=1, axis2=2)
    assert turn.max() > 0.1
    assert (turn < 3 * np.sqrt(covariance[:, 3:].sum(axis=1)) + 0.01).all()
    start = np.argmin(np.abs(seconds - begin_s))
    error = (t.translation - t.translation[start]) - (
        simulated.place(seconds) - simulated.place(seconds)[start]
    )
    assert np.abs(error).max() > 0.3
    assert (np.abs(error[:, :2]) < 3 * np.sqrt(covariance[:, :2]) + 0.02).all()
    known = found.attitude.sigma[:, 1]
    assert known.min() == pytest.approx(SIGMAS.tilt_rad)
    assert known.max() == pytest.approx(0.05 * np.sqrt(4 * 19.7), rel=0.05)
    (sentence,) = [remark for remark in found.remarks if remark.startswith("IMU: silent")]
    assert f"the {'last' if begin_s == 0 else 'first'} 19." in sentence


def test_without_images_the_path_ends_with_the_imu(perfect, rig):
    read = perfect.imu.t_ns <= START_NS + 20 * SECOND
    imu = ImuSamples(**{name: value[read] for name, value in vars(perfect.imu).items()})
    found = dead_reckon(replace(perfect, imu=imu, top=None), rig, SIGMAS)
    assert found.trajectory.t_ns[-1] - imu.t_ns[-1] < 2 * SECOND
