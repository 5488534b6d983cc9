# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Motion from stereo images alone, pair after pair: what navigation leans on where there is no DVL."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.rig import SensorRig
from hullrecon.typing import Pixels
from hullrecon.vision.features.extraction import FeatureOptions, extract, no_features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import PairMatcher, Reason
from hullrecon.vision.stereo.camera_rig import CameraRig
from hullrecon.vision.stereo.node_view import NodeView, stereo_of_node, view_of_node
from hullrecon.vision.tracks.landmarks import NodeFeatures


@dataclass(frozen=True, kw_only=True)
class OdometryFrame:
    """A stereo pair: its number, from which random draws are seeded, and its features with their depths."""

    number: int
    view: NodeView


@dataclass(frozen=True, kw_only=True)
class MeasuredMotion:
    """first_from_second of the top cameras with its covariance, and the number of features that agree."""

    motion: Motion
    inliers: int


@dataclass(frozen=True, kw_only=True)
class StereoOdometer:
    """Measures the motion between two stereo pairs without any prior."""

    rig: CameraRig
    feature_options: FeatureOptions
    match_options: MatchOptions

    def frame(self, number: int, top: Pixels | None, bottom: Pixels | None) -> OdometryFrame:
        """Return the features of two images (h, w, 3) RGB; an image that is None has none."""
        sides = [no_features() if image is None else extract(image, self.feature_options) for image in (top, bottom)]
        return self.frame_of_features(number, NodeFeatures(top=sides[0], bottom=sides[1]))

    def frame_of_features(self, number: int, features: NodeFeatures) -> OdometryFrame:
        """Return a pair with its stereo matches; nothing is known about the depth of the scene."""
        stereo = stereo_of_node(self.rig, features.top, features.bottom, None, self.match_options)
        view = view_of_node(self.rig, features.top, features.bottom, stereo, None, self.match_options.sigma_px)
        return OdometryFrame(number=number, view=view)

    def motion(self, first: OdometryFrame, second: OdometryFrame) -> MeasuredMotion | None:
        """Return the motion from one pair to another; None where too few features agree or it has no length.

        Its covariance is that of the features' noise and of the cameras' model, which a thousand features do not average out:
        an angle of sigma_px, and that angle at the depth of the scene. Without it the steps of a simulated dive, 1.15 m from
        the hull and off by 0.7 mm and 0.03 deg, would be 40 sigma off.
        """
        if Camera.BOTTOM in (first.view.camera, second.view.camera):
            return None
        options = self.match_options
        matcher, seed = PairMatcher(self.rig, options), (options.seed, first.number, second.number)
        found = matcher.match(first.view, second.view, None, seed, True)
        if found.reason is not Reason.MATCHED or found.motion is None or not found.scaled:
            return None
        inverse = found.motion.inverse()
        angle = options.sigma_px / self.rig.focal_px(Camera.TOP)
        depth_m = float(np.nanmedian(first.view.depth))
        model = np.diag(np.repeat([(angle * depth_m) ** 2, angle**2], 3))
        return MeasuredMotion(motion=replace(inverse, covariance=inverse.covariance + model), inliers=len(found.first))


def stereo_odometer(rig: SensorRig, max_features: int, min_inliers: int, rig_sigma_rad: float) -> StereoOdometer:
    """Return the odometer of a rig; rig_sigma_rad: how well the bottom camera's rotation is known, which widens the lines on
    which its matches are sought by two sigmas."""
    cameras = CameraRig(rig)
    options = MatchOptions()
    widening_px = 2 * rig_sigma_rad * cameras.focal_px(Camera.TOP)
    return StereoOdometer(
        rig=cameras,
        feature_options=FeatureOptions(max_features=max_features),
        match_options=MatchOptions(min_inliers=min_inliers, column_px=options.column_px + widening_px),
    )
