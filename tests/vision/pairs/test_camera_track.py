# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses

import numpy as np
import pytest
from vision.scene import camera_rig

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import from_mount, from_rpy, identity
from hullrecon.records.trajectory import Returns, Trajectory, TrajectoryErrorModel
from hullrecon.vision.pairs.camera_track import (
    RANGE_MARGIN,
    WHITE_ROTATION_RAD,
    WHITE_TRANSLATION_M,
    depth_priors,
    track_cameras,
)

CAMERA = CameraModel(640, 512, 640.0, 640.0, 319.5, 255.5)
FORWARD = from_mount([0.0, 0.0, -0.05, 90.0, 0.0, 90.0])  # looks along the vehicle's x


def path(n=10, image=None):
    """A straight run along y, position error growing as a random walk of 1 cm a node."""
    covariance = np.zeros((n, 6, 6))
    covariance[:, [0, 1], [0, 1]] = (0.01**2 * np.arange(n))[:, None]
    move = np.column_stack([np.zeros(n), 0.1 * np.arange(n), np.full(n, 2.0)])
    rows = np.column_stack([np.arange(n)] * 2) if image is None else np.array(image)
    return Trajectory(
        t_ns=np.arange(n) * 10**9,
        quaternion=np.tile([0, 0, 0, 1.0], (n, 1)),
        translation=move,
        covariance=covariance,
        tray=np.zeros(n),
        image=rows,
    )


def random_walk(covariance):
    """An error model of twists that accumulate, covariance (n, 6, 6)."""
    n = len(covariance)
    return TrajectoryErrorModel(
        by_error=np.zeros((n, 6, 0)),
        error_covariance=np.zeros((0, 0)),
        walk=covariance,
        white=np.zeros((n, 6, 6)),
    )


def cameras(top_from_bottom=None):
    bottom = None if top_from_bottom is None else CAMERA
    return camera_rig(CAMERA, bottom, top_from_bottom, (0.45, 0.0, 0.1), FORWARD)


def track(trajectory, sigma=0.0, top_from_bottom=None, errors=None, bottom=()):
    errors = random_walk(trajectory.covariance) if errors is None else errors
    leads = np.isin(np.arange(len(trajectory.t_ns)), bottom)
    return track_cameras(trajectory, errors, cameras(top_from_bottom), sigma, leads)


def test_camera_stands_where_tray_and_mount_put_it():
    found = track(path()).global_from_camera
    np.testing.assert_allclose(found.translation[3], [0.45, 0.3, 2.05], atol=1e-12)
    np.testing.assert_allclose(found.rotation.as_matrix()[3][:, 2], [1, 0, 0], atol=1e-12)


def test_bottom_camera_stands_where_it_leads():
    found = track(
        path(3), top_from_bottom=from_rpy([0.0, 0.1, 0.0], [0, 0, 0]), bottom=[1]
    ).global_from_camera
    # the camera's y points down
    np.testing.assert_allclose(found.translation[:, 2], [2.05, 2.15, 2.05])


def test_relative_pose_is_as_uncertain_as_error_gained_between():
    motion = track(path()).motion(2, 6)
    # the camera's x is starboard
    np.testing.assert_allclose(motion.second_from_first[:3, 3], [-0.4, 0, 0], atol=1e-12)
    want = 4 * 0.01**2 + WHITE_TRANSLATION_M**2
    np.testing.assert_allclose(np.diag(motion.covariance)[[0, 2]], want)
    np.testing.assert_allclose(motion.covariance[1, 1], WHITE_TRANSLATION_M**2)
    np.testing.assert_allclose(np.diag(motion.covariance)[3:], WHITE_ROTATION_RAD**2)


def test_order_of_two_nodes_does_not_make_variance_negative():
    assert (np.linalg.eigvalsh(track(path()).motion(6, 2).covariance) > 0).all()


def test_servos_backlash_turns_about_its_axis_alone():
    motion = track(path(), sigma=0.01).motion(0, 1)
    gained = np.diag(motion.covariance)[3:] - WHITE_ROTATION_RAD**2
    # vehicle's y is the camera's x
    np.testing.assert_allclose(gained, [2 * 0.01**2, 0, 0], atol=1e-12)


def returns(node, range_m, flagged=None):
    n = len(node)
    return Returns(
        t_ns=np.zeros(n, np.int64),
        node=np.array(node),
        quaternion=identity(n).quaternion,
        translation=np.zeros((n, 3)),
        tray_offset=np.zeros(n),
        beam=np.tile([0.0, 0.0, 1.0], (n, 1)),
        range_m=np.array(range_m, float),
        flagged=np.zeros(n, bool) if flagged is None else np.array(flagged),
    )


def priors(made, trajectory):
    # the DVL looks along the vehicle's x as well
    dvl = from_mount([0.0, 0.0, 0.08, 0.0, 90.0, 0.0])
    return depth_priors(
        track(trajectory),
        trajectory,
        made,
        dataclasses.replace(cameras(), tray_from_dvl=dvl),
    )


def test_depth_comes_from_returns_of_neighbouring_nodes():
    found = priors(returns([2, 3, 4], [1.2, 1.3, 1.4]), path(30))
    assert found[3].mean == pytest.approx(1.3)
    assert found[3].nearest == pytest.approx(1.2 / RANGE_MARGIN, rel=0.01)
    assert found[3].farthest == pytest.approx(1.4 * RANGE_MARGIN, rel=0.01)
    assert found[20] is None


def test_flagged_and_lost_returns_count_nothing():
    found = priors(returns([0, 1, 2], [1.2, np.nan, 9.0], [False, False, True]), path())
    assert found[1].mean == pytest.approx(1.2)


def spread_returns(shift):
    """Returns of nine beams about the forward axis on a wall x = 1.75 m of g, `shift` m farther a
    metre to starboard.
    """
    y, z = (v.ravel() for v in np.meshgrid([-0.3, 0.0, 0.3], [-0.3, 0.0, 0.3]))
    dvl = np.array([0.45 + 0.08, 0.0, 2.1])
    points = np.column_stack([1.75 + shift * y, y, 2.1 + z]) - dvl
    range_m = np.linalg.norm(points, axis=1)
    beam = from_mount([0, 0, 0, 0.0, 90.0, 0.0]).rotation.inv().apply(points / range_m[:, None])
    made = returns([0] * 9, range_m)
    return dataclasses.replace(made, beam=beam)


def normal_of(shift, rows=slice(None)):
    part = spread_returns(shift).take(rows)
    dvl = from_mount([0.08, 0.0, 0.0, 0.0, 90.0, 0.0])
    rig = dataclasses.replace(cameras(), tray_from_dvl=dvl)
    return depth_priors(track(path()), path(), part, rig)[0].normal


@pytest.mark.parametrize("shift", [0.0, 0.4])
def test_returns_give_surfaces_normal_in_cameras_axes(shift):
    # the camera's x is starboard, its z ahead
    want = np.array([-shift, 0.0, 1.0]) / np.hypot(shift, 1.0)
    np.testing.assert_allclose(normal_of(shift), want, atol=1e-9)


def test_returns_on_line_have_no_normal():
    assert normal_of(0.0, slice(0, 3)) is None
    assert normal_of(0.0, slice(0, 2)) is None
