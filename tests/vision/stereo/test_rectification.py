# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from vision.scene import camera_rig

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_rpy, identity
from hullrecon.vision.stereo.matching import rectify, triangulate

POINTS = np.array([[0.1, -0.2, 1.5], [-0.4, 0.3, 1.1], [0.0, 0.0, 4.0]])


@pytest.mark.parametrize(
    "baseline", [[0.0, 0.1, 0.0], [0.3, 0.02, -0.03], [-0.3, 0.0, 0.0], [0.01, -0.2, 0.0]]
)
def test_point_lies_on_one_column_whatever_way_rig_is_built(baseline):
    top_from_bottom = from_rpy(baseline, [0.02, -0.03, 0.05])
    turned = rectify(top_from_bottom)
    below = top_from_bottom.inverse().apply(POINTS)
    top, bottom = (
        turned.rectify_top(POINTS[:, :2] / POINTS[:, 2:]),
        turned.rectify_bottom(below[:, :2] / below[:, 2:]),
    )
    np.testing.assert_allclose(top[:, 0], bottom[:, 0], atol=1e-12)
    assert (top[:, 1] > bottom[:, 1]).all()
    np.testing.assert_allclose(triangulate(turned, top, bottom), POINTS, atol=1e-10)


def test_disparity_is_baseline_over_depth():
    turned = rectify(from_rpy([0.0, 0.1, 0.0], [0.0, 0.0, 0.0]))
    np.testing.assert_allclose(turned.disparity(2.0), 0.05)
    np.testing.assert_allclose(turned.rotation_top, np.eye(3), atol=1e-15)


def test_point_with_no_disparity_has_no_depth():
    turned = rectify(from_rpy([0.0, 0.1, 0.0], [0.0, 0.0, 0.0]))
    assert np.isnan(triangulate(turned, np.zeros((1, 2)), np.zeros((1, 2)))).all()


def test_ray_that_points_backwards_after_turn_is_nan():
    # a horizontal rig is turned by 90 degrees about z
    turned = rectify(from_rpy([0.1, 0.0, 0.0], [0.0, 0.0, 0.0]))
    assert np.isfinite(turned.rectify_top(np.array([[0.5, 0.5]]))).all()
    aside = rectify(from_rpy([0.0, 0.1, 0.0], [0.0, 1.2, 0.0]))
    assert np.isnan(aside.rectify_top(np.array([[-3.0, 0.0]]))).all()


def test_two_cameras_at_one_place_are_refused():
    with pytest.raises(ValueError, match="no stereo"):
        rectify(identity())


def test_mono_rig_has_no_bottom_camera_and_says_so():
    rig = camera_rig(CameraModel(10, 10, 5.0, 7.0, 5.0, 5.0))
    assert rig.stereo_mount is None
    assert rig.focal_px(Camera.TOP) == 6.0
    assert rig.baseline_m == 1.0
    with pytest.raises(ValueError, match="no bottom camera"):
        rig.model(Camera.BOTTOM)


def test_points_go_from_top_to_bottom_camera(rig):
    want = rig.top_from_bottom.inverse().apply(POINTS)
    np.testing.assert_allclose(
        POINTS @ rig.from_top(Camera.BOTTOM)[:3, :3].T + rig.from_top(Camera.BOTTOM)[:3, 3], want
    )
    np.testing.assert_array_equal(rig.from_top(Camera.TOP), np.eye(4))
