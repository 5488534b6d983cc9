# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from vision.scene import follow_nodes

from hullrecon.geometry.frames import Camera
from hullrecon.vision.features.extraction import FeatureOptions, no_features
from hullrecon.vision.odometry import StereoOdometer, stereo_odometer
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.tracks.landmarks import NodeFeatures


def pairs(look, places, lost=()):
    nodes = [look([x, 0, 0, 0, 0, 0], seed=k) for k, x in enumerate(places)]
    none = NodeFeatures(top=no_features(), bottom=no_features())
    return lambda k: none if k in lost else NodeFeatures(top=nodes[k].top, bottom=nodes[k].bottom)


def test_each_step_has_its_length_and_a_covariance_that_covers_the_error(rig, look):
    found = follow_nodes(rig, range(4), pairs(look, [0.0, 0.2, 0.5, 0.6]))
    for step, length in zip(found, (0.2, 0.3, 0.1), strict=True):
        error = step.motion.second_from_first[:3, 3] - [length, 0, 0]  # the second pair in the first: forward
        sigma = np.sqrt(np.diag(step.motion.covariance)[:3])
        assert (np.abs(error) < 5 * sigma).all()
        assert sigma.max() < 0.005
        assert step.inliers > 100


def test_the_sigma_is_never_below_that_of_the_cameras_model(rig, look):
    [step] = follow_nodes(rig, range(2), pairs(look, [0.0, 0.2]))
    angle = MatchOptions().sigma_px / rig.focal_px(Camera.TOP)
    assert np.sqrt(np.linalg.eigvalsh(step.motion.covariance)[:3].min()) >= angle
    assert np.sqrt(np.diag(step.motion.covariance)[:3].min()) >= angle * 1.25  # at a depth of 1.3 m


def test_a_lost_image_breaks_two_links_and_no_more(rig, look):
    found = follow_nodes(rig, range(5), pairs(look, [0.0, 0.15, 0.3, 0.45, 0.6], lost=(2,)))
    assert [step is not None for step in found] == [True, False, False, True]


def test_nodes_are_taken_in_the_order_given(rig, look):
    read = pairs(look, [0.0, 0.15, 0.3])
    there, back = (follow_nodes(rig, order, read)[0].motion.second_from_first for order in ([0, 2], [2, 0]))
    np.testing.assert_allclose(there @ back, np.eye(4), atol=0.01)
    assert back[0, 3] < 0 < there[0, 3]


def test_a_pair_whose_top_image_is_lost_gives_no_motion(rig, look):
    read = pairs(look, [0.0, 0.15])
    blind = NodeFeatures(top=no_features(), bottom=read(1).bottom)
    assert follow_nodes(rig, range(2), lambda k: blind if k else read(k)) == [None]


def test_depth_comes_from_the_stereo_alone(rig, look):
    odometer = StereoOdometer(rig=rig, feature_options=FeatureOptions(), match_options=MatchOptions())
    seen = odometer.frame_of_features(0, pairs(look, [0.0])(0)).view
    assert seen.stereo.mean() > 0.6
    assert abs(np.median(seen.depth) - 1.3) < 0.03


def test_images_that_cannot_be_read_have_no_features(rig):
    odometer = stereo_odometer(rig.rig, 500, 15, 0.0)
    assert len(odometer.frame(0, None, None).view) == 0


def test_a_rig_that_is_known_less_well_searches_a_wider_band(rig):
    sharp, loose = (stereo_odometer(rig.rig, 500, 15, sigma).match_options.column_px for sigma in (0.0, 0.002))
    assert loose - sharp == pytest.approx(2 * 0.002 * rig.focal_px(Camera.TOP))
