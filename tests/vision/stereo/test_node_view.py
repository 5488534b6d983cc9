# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
from vision.scene import camera_rig

from hullrecon.geometry.frames import Camera
from hullrecon.vision.features.extraction import no_features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.stereo.matching import StereoMatches, no_matches
from hullrecon.vision.stereo.node_view import (
    DepthPrior,
    NodeFeatures,
    drop_isolated_depths,
    stereo_of_node,
    view_of_node,
)

OPTIONS = MatchOptions()
PRIOR = DepthPrior(mean=1.3, sigma=0.2, nearest=0.8, farthest=2.0)


def test_stereo_matches_are_one_point_and_triangulate_to_it(rig, wall, look):
    node = look([0.3, 0, 0, 0, 0, 0], noise_px=0.1)
    found = stereo_of_node(rig, node.top, node.bottom, PRIOR, OPTIONS)
    np.testing.assert_array_equal(node.top_id[found.top], node.bottom_id[found.bottom])
    assert len(found) > 0.9 * len(np.intersect1d(node.top_id, node.bottom_id))
    truth = node.pose.inverse().apply(wall.points[node.top_id[found.top]])
    # z^2 / (f b) times 0.14 px is 3.6 mm
    assert np.median(np.abs(found.point - truth)[:, 2]) < 0.005


def test_match_beyond_depths_that_dvl_allows_is_refused(rig, look):
    node = look([0, 0, 0, 0, 0, 0])
    assert (
        len(
            stereo_of_node(
                rig,
                node.top,
                node.bottom,
                DepthPrior(mean=2.6, sigma=0.1, nearest=2.4, farthest=3.0),
                OPTIONS,
            )
        )
        == 0
    )


def test_match_off_its_column_is_refused(rig, look):
    node = look([0, 0, 0, 0, 0, 0])
    node.bottom.keypoints[:, 0] += 5
    assert len(stereo_of_node(rig, node.top, node.bottom, PRIOR, OPTIONS)) < 10


def test_mono_rig_or_lost_image_has_no_stereo(rig, look):
    node = look([0, 0, 0, 0, 0, 0])
    assert (
        len(
            stereo_of_node(
                camera_rig(rig.model(Camera.TOP)), node.top, no_features(), PRIOR, OPTIONS
            )
        )
        == 0
    )
    assert len(stereo_of_node(rig, node.top, no_features(), PRIOR, OPTIONS)) == 0


def test_depth_like_none_of_its_neighbours_is_dropped():
    u, v = np.meshgrid(np.linspace(-0.4, 0.4, 12), np.linspace(-0.3, 0.3, 12))
    xy = np.column_stack([u.ravel(), v.ravel()])
    depth = 1.3 + 0.1 * xy[:, 0] + 0.002 * np.random.default_rng(0).standard_normal(144)
    depth[70] = 0.9
    points = np.column_stack([xy, np.ones(144)]) * depth[:, None]
    kept = drop_isolated_depths(
        StereoMatches(top=np.arange(144), bottom=np.arange(144), point=points), xy
    )
    assert 70 not in kept.top
    assert len(kept) > 135


def test_features_take_their_own_depth_or_their_neighbours(rig, wall, look):
    node = look([0.3, 0, 0, 0, 0, 0])
    stereo = stereo_of_node(rig, node.top, node.bottom, PRIOR, OPTIONS)
    half = StereoMatches(top=stereo.top[::2], bottom=stereo.bottom[::2], point=stereo.point[::2])
    view = view_of_node(
        rig, NodeFeatures(top=node.top, bottom=node.bottom, stereo=half), PRIOR, OPTIONS.sigma_px
    )
    truth = node.pose.inverse().apply(wall.points[node.top_id])[:, 2]
    assert (
        np.abs(view.depth - truth)[view.stereo] < 4 * view.depth_sigma[view.stereo]
    ).mean() > 0.95
    assert (
        np.abs(view.depth - truth)[~view.stereo] < 4 * view.depth_sigma[~view.stereo]
    ).mean() > 0.8
    np.testing.assert_array_equal(np.flatnonzero(view.stereo), np.sort(half.top))


def test_without_stereo_dvl_gives_depth_without_dvl_none(rig, look):
    node = look([0, 0, 0, 0, 0, 0])
    by_dvl = view_of_node(
        rig, NodeFeatures(top=node.top, bottom=no_features(), stereo=no_matches()), PRIOR, 0.4
    )
    assert (by_dvl.depth == 1.3).all()
    assert (by_dvl.depth_sigma == 0.2).all()
    assert np.isnan(
        view_of_node(
            rig, NodeFeatures(top=node.top, bottom=no_features(), stereo=no_matches()), None, 0.4
        ).depth
    ).all()


def test_bottom_camera_leads_where_top_has_no_image(rig, look):
    node = look([0, 0, 0, 0, 0, 0])
    view = view_of_node(
        rig, NodeFeatures(top=no_features(), bottom=node.bottom, stereo=no_matches()), PRIOR, 0.4
    )
    assert view.camera is Camera.BOTTOM
    np.testing.assert_allclose(
        view.xy, rig.model(Camera.BOTTOM).undistort(node.bottom.keypoints[:, :2])
    )
