# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from vision.scene import follow_nodes

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import exp
from hullrecon.vision.features.extraction import no_features
from hullrecon.vision.odometry import (
    MeasuredMotion,
    StereoOdometer,
    _with_disagreement,
    stereo_odometer,
)
from hullrecon.vision.options import FeatureOptions, MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.stereo_adjustment import CalibrationEvidence
from hullrecon.vision.stereo.node_view import NodeFeatures


def pairs(look, places, lost=()):
    nodes = [look([x, 0, 0, 0, 0, 0], seed=k) for k, x in enumerate(places)]
    none = NodeFeatures(top=no_features(), bottom=no_features())
    return lambda k: none if k in lost else NodeFeatures(top=nodes[k].top, bottom=nodes[k].bottom)


def test_step_has_its_length_and_covariance_covers_error(rig, look):
    found = follow_nodes(rig, range(4), pairs(look, [0.0, 0.2, 0.5, 0.6]))
    for step, length in zip(found, (0.2, 0.3, 0.1), strict=True):
        # the second pair in the first: forward
        error = step.motion.second_from_first[:3, 3] - [length, 0, 0]
        sigma = np.sqrt(np.diag(step.motion.covariance)[:3])
        assert (np.abs(error) < 5 * sigma).all()
        assert sigma.max() < 0.005
        assert step.inliers > 100


def test_steps_of_many_pairs_scatter_as_their_covariance_says(rig, look):
    chi2 = []
    for seed in range(12):
        nodes = [look([x, 0, 0, 0, 0, 0], seed=2 * seed + k) for k, x in enumerate((0.0, 0.25))]
        [step] = follow_nodes(
            rig, range(2), lambda k, n=nodes: NodeFeatures(top=n[k].top, bottom=n[k].bottom)
        )
        found = step.motion.second_from_first
        gap = np.r_[found[:3, 3] - [0.25, 0, 0], Rotation.from_matrix(found[:3, :3]).as_rotvec()]
        chi2.append(gap @ np.linalg.solve(step.motion.covariance, gap) / 6)
    assert 0.75 < np.sqrt(np.mean(chi2)) < 1.3


def test_two_ways_that_disagree_widen_covariance_by_as_much():
    def measured(shift):
        motion = exp([[shift, 0, 0, 0, 0, 0.02]]).matrix()[0]
        evidence = CalibrationEvidence(
            by_calibration=np.zeros((6, 12)), information=np.zeros((12, 12)), gradient=np.zeros(12)
        )
        return MeasuredMotion(
            motion=Motion(motion, 1e-6 * np.eye(6)), calibration=evidence, inliers=100
        )

    there, back = measured(0.30), measured(0.31)
    found = _with_disagreement(there, replace(back, motion=back.motion.inverse())).motion
    np.testing.assert_array_equal(found.second_from_first, there.motion.second_from_first)
    assert found.covariance[0, 0] == pytest.approx(1e-6 + 0.5 * 0.01**2)
    assert found.covariance[1, 1] == pytest.approx(1e-6)


def test_lost_image_breaks_two_links_and_no_more(rig, look):
    found = follow_nodes(rig, range(5), pairs(look, [0.0, 0.15, 0.3, 0.45, 0.6], lost=(2,)))
    assert [step is not None for step in found] == [True, False, False, True]


def test_nodes_are_taken_in_order_given(rig, look):
    read = pairs(look, [0.0, 0.15, 0.3])
    there, back = (
        follow_nodes(rig, order, read)[0].motion.second_from_first for order in ([0, 2], [2, 0])
    )
    np.testing.assert_allclose(there @ back, np.eye(4), atol=0.01)
    assert back[0, 3] < 0 < there[0, 3]


def test_pair_whose_top_image_is_lost_gives_no_motion(rig, look):
    read = pairs(look, [0.0, 0.15])
    blind = NodeFeatures(top=no_features(), bottom=read(1).bottom)
    assert follow_nodes(rig, range(2), lambda k: blind if k else read(k)) == [None]


def test_depth_comes_from_stereo_alone(rig, look):
    odometer = StereoOdometer(
        rig=rig, feature_options=FeatureOptions(), match_options=MatchOptions()
    )
    seen = odometer.frame_of_features(0, pairs(look, [0.0])(0)).view
    assert seen.stereo.mean() > 0.6
    assert abs(np.median(seen.depth) - 1.3) < 0.03


def test_images_that_cannot_be_read_have_no_features(rig):
    odometer = stereo_odometer(rig, 500, 15, 0.0)
    assert len(odometer.frame(0, None, None).view) == 0


def test_rig_that_is_known_less_well_searches_wider_band(rig):
    sharp, loose = (
        stereo_odometer(rig, 500, 15, sigma).match_options.column_px for sigma in (0.0, 0.002)
    )
    assert loose - sharp == pytest.approx(2 * 0.002 * rig.focal_px(Camera.TOP))
