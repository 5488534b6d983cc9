# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which camera leads where one sends noise, on a flat ground 1 m before the cameras."""

import cv2
import numpy as np
import pytest
from vision.scene import camera_rig

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_rpy
from hullrecon.vision.features.extraction import extract, no_features
from hullrecon.vision.options import FeatureOptions, MatchOptions
from hullrecon.vision.pairs.matching import PairMatcher
from hullrecon.vision.pairs.pair_match import Reason
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import DepthPrior, NodeFeatures, stereo_of_node, view_of_node

MODEL = CameraModel(640, 512, 640.0, 640.0, 319.5, 255.5)
RIG = camera_rig(MODEL, MODEL, from_rpy([0.0, 0.1, 0.0], [0.0, 0.0, 0.0]))
OPTIONS = MatchOptions()
PRIOR = DepthPrior(mean=1.0, sigma=0.05, nearest=0.7, farthest=1.6)


@pytest.fixture(scope="module")
def ground():
    """Features of the ground, the camera so many pixels along it and across."""
    noise = np.random.default_rng(4).integers(30, 200, (90, 130), dtype=np.uint8)
    picture = cv2.resize(noise, (1040, 720), interpolation=cv2.INTER_CUBIC)

    def seen(along_px, across_px):
        return extract(
            picture[across_px : across_px + 512, along_px : along_px + 640], FeatureOptions()
        )

    return seen


def dark(seed, quality):
    """Features of a black image with the noise of its sensor, as a JPEG; of quality 80 it has as
    many as that of a hull.
    """
    image = np.clip(
        3 + 1.2 * np.random.default_rng(seed).standard_normal((512, 640)), 0, 255
    ).astype(np.uint8)
    return extract(
        cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], 0),
        FeatureOptions(),
    )


def view_of(top, bottom):
    stereo = stereo_of_node(RIG, top, bottom, PRIOR, OPTIONS)
    view = view_of_node(
        RIG, NodeFeatures(top=top, bottom=bottom, stereo=stereo), PRIOR, OPTIONS.sigma_px
    )
    node = NodeFeatures(top=top, bottom=bottom, stereo=stereo)
    assert node.bottom_leads == (view.camera is Camera.BOTTOM)
    assert len(node.leading) == len(view)
    return view


@pytest.mark.parametrize("quality", [95, 80])
def test_camera_that_sends_noise_leaves_lead_to_one_that_sees(ground, quality):
    views = [view_of(dark(k, quality), ground(40 * k, 100)) for k in range(2)]
    assert [view.camera for view in views] == [Camera.BOTTOM] * 2
    found = PairMatcher(RIG, OPTIONS).match(*views, None, (1, 0, 1), True)
    assert found.reason is Reason.MATCHED


@pytest.mark.parametrize("quality", [95, 80])
def test_what_noise_has_in_common_with_image_is_no_depth(ground, quality):
    top = ground(0, 100)
    view = view_of(top, dark(3, quality))
    assert view.camera is Camera.TOP
    assert not view.stereo.any()
    assert (view.depth == PRIOR.mean).all()


def test_two_cameras_that_see_have_depths_and_top_one_leads(ground):
    top, bottom = ground(0, 100), ground(0, 164)
    view = view_of(top, bottom)
    assert view.camera is Camera.TOP
    assert view.stereo.mean() > 0.3
    assert np.median(view.depth) == pytest.approx(1.0, abs=0.01)


def test_camera_that_sees_less_leads_as_long_as_both_see_same(ground):
    bottom = ground(0, 164)
    top = extract(np.zeros((512, 640), np.uint8), FeatureOptions())
    assert view_of(top, bottom).camera is Camera.BOTTOM
    assert view_of(bottom, top).camera is Camera.TOP
    assert view_of(no_features(), no_features()).camera is Camera.TOP
    some = ground(0, 100)
    rows = np.flatnonzero(some.keypoints[:, 0] < 200)
    few = type(some)(some.keypoints[rows], some.descriptors[rows], some.color[rows])
    assert len(few) < 0.4 * len(bottom)
    assert view_of(few, bottom).camera is Camera.TOP
    assert NodeFeatures(top=few, bottom=bottom, stereo=no_matches()).bottom_leads
