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
from hullrecon.navigation.dead_reckoning.dead_reckon import dead_reckon
from hullrecon.navigation.options import NavigateOptions


@pytest.fixture(scope="session")
def found(perfect, rig):
    return dead_reckon(perfect, rig, SIGMAS, NavigateOptions())


def test_a_return_carries_the_vehicle_from_its_node_to_its_ping(simulated, found, rig):
    """Hung on the true nodes, the beam's start is where the true instrument was at the ping."""
    r, t = found.returns, found.trajectory
    seconds = (r.t_ns - t.t_ns[0]) * 1e-9 + (t.t_ns[0] - 1_777_887_000_000_000_000) * 1e-9
    node_s = (t.t_ns - 1_777_887_000_000_000_000) * 1e-9
    at_ping = simulated.poses(node_s)[r.node] @ Poses(r.quaternion, r.translation)
    angle = simulated.tray(node_s)[r.node] + r.tray_offset
    instrument = at_ping @ poses.tray_poses(rig.tray_origin, angle) @ rig.tray_from_dvl
    assert np.abs(instrument.translation - simulated.instrument(seconds).translation).max() < 1e-3


def test_returns_hang_on_the_nearest_node(found):
    r, t = found.returns, found.trajectory
    gap = np.abs(r.t_ns - t.t_ns[r.node])
    assert (gap == np.abs(r.t_ns[:, None] - t.t_ns[None]).min(axis=1)).all()
    assert len(r.t_ns) == 4 * 800


def test_attitude_has_the_depth_of_the_sensor_and_not_of_the_vehicle(simulated, found, rig):
    t = (found.trajectory.t_ns - 1_777_887_000_000_000_000) * 1e-9
    sensor = simulated.poses(t).apply(rig.pressure_origin)[:, 2]
    assert np.abs(found.attitude.depth - sensor).max() < 3e-3
    rpy = roll_pitch_yaw(simulated.attitude(t))
    assert np.allclose(np.stack([found.attitude.roll, found.attitude.pitch], 1), rpy[:, :2], atol=1e-3)
    assert found.attitude.sigma[0].tolist() == [SIGMAS.depth_m, SIGMAS.tilt_rad, SIGMAS.tilt_rad]


def test_an_image_that_does_not_decode_has_no_node(perfect, rig):
    usable = perfect.top.usable.copy()
    usable[3] = False
    gone = dead_reckon(replace(perfect, top=replace(perfect.top, usable=usable)), rig, SIGMAS, NavigateOptions())
    assert 3 not in gone.trajectory.image[:, 0]
    assert {2, 4} <= set(gone.trajectory.image[:, 0].tolist())


def test_a_dive_without_cameras_has_nodes_at_its_pings(perfect, rig):
    blind = dead_reckon(replace(perfect, top=None), rig, SIGMAS, NavigateOptions())
    assert (blind.trajectory.image == -1).all()
    assert np.isin(blind.trajectory.t_ns, perfect.dvl.t_ns).all()
    assert len(blind.odometry.first) == len(blind.trajectory.t_ns) - 1


def test_neighbouring_edges_compose_to_the_path_in_the_plane(found):
    edge = Poses(found.odometry.quaternion, found.odometry.translation)
    end = poses.identity()
    for k in range(len(edge)):
        end = end @ edge[k]
    whole = found.trajectory.poses()[[0]].inverse() @ found.trajectory.poses()[[-1]]
    assert np.allclose(end.translation, whole.translation, atol=5e-3)  # the pressure holds z of the path alone
