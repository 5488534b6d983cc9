# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Motion from stereo images alone, pair after pair: what navigation leans on where there is no DVL."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Pixels
from hullrecon.vision.features.extraction import FeatureOptions, extract, no_features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pair_match import PairMatch
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import PairMatcher
from hullrecon.vision.pairs.stereo_adjustment import CalibrationEvidence
from hullrecon.vision.stereo.node_view import NodeView, stereo_of_node, view_of_node
from hullrecon.vision.tracks.landmarks import NodeFeatures

# Of a feature where another pair's points predict it. Points of a rig whose calibration is rough
# lie pixels off where they move (8 px on a real set): a narrow search keeps those that happen to
# agree, and the motion is theirs.
SEARCH_SIGMA_PX = 2.0
LOOSE = 5.0  # sigmas of a motion: how far from it the features are looked for again


@dataclass(frozen=True, kw_only=True)
class OdometryFrame:
    """A stereo pair: its number, from which random draws are seeded, and its features with their
    depths.
    """

    number: int
    view: NodeView


@dataclass(frozen=True, kw_only=True)
class MeasuredMotion:
    """first_from_second of the top cameras with its covariance, as far as features err
    independently; what errors of the calibration do to it; the number of features that agree.
    """

    motion: Motion
    calibration: CalibrationEvidence
    inliers: int


@dataclass(frozen=True, kw_only=True)
class StereoOdometer:
    """Measures the motion between two stereo pairs without any prior."""

    rig: Rig
    feature_options: FeatureOptions
    match_options: MatchOptions

    def frame(self, number: int, top: Pixels | None, bottom: Pixels | None) -> OdometryFrame:
        """Return the features of two images (h, w, 3) RGB; an image that is None has none."""
        sides = [
            no_features() if image is None else extract(image, self.feature_options)
            for image in (top, bottom)
        ]
        return self.frame_of_features(number, NodeFeatures(top=sides[0], bottom=sides[1]))

    def frame_of_features(self, number: int, features: NodeFeatures) -> OdometryFrame:
        """Return a pair with its stereo matches; nothing is known about the depth of the scene."""
        stereo = stereo_of_node(self.rig, features.top, features.bottom, None, self.match_options)
        view = view_of_node(
            self.rig, features.top, features.bottom, stereo, None, self.match_options.sigma_px
        )
        return OdometryFrame(number=number, view=view)

    def motion(self, first: OdometryFrame, second: OdometryFrame) -> MeasuredMotion | None:
        """Return the motion from one pair to another; None where too few features agree or it has
        no length.

        The pairs are matched twice: without a guess, then the other way round near what was found.
        Where features are few or the calibration is rough the two may settle on different ones; by
        as much the motion is uncertain.
        """
        if Camera.BOTTOM in (first.view.camera, second.view.camera):
            return None
        options = self.match_options
        matcher, seed = PairMatcher(self.rig, options), (options.seed, second.number, first.number)
        found = _measured_motion(matcher.match(second.view, first.view, None, seed, True))
        if found is None:
            return None
        near = replace(
            found.motion.inverse(), covariance=LOOSE**2 * found.motion.inverse().covariance
        )
        again = _measured_motion(matcher.match(first.view, second.view, near, seed, False))
        return found if again is None else _with_disagreement(found, again)


def _measured_motion(found: PairMatch) -> MeasuredMotion | None:
    if found.motion is None or found.calibration is None:
        return None
    return MeasuredMotion(
        motion=found.motion, calibration=found.calibration, inliers=len(found.first)
    )


def _with_disagreement(found: MeasuredMotion, again: MeasuredMotion) -> MeasuredMotion:
    """Return the motion with half the square of its difference from that of the other way added to
    its covariance: of two findings, either may be the one that is off.
    """
    there = again.motion.inverse().second_from_first
    turn = found.motion.second_from_first[:3, :3].T @ there[:3, :3]
    gap = np.concatenate(
        [
            there[:3, 3] - found.motion.second_from_first[:3, 3],
            Rotation.from_matrix(turn).as_rotvec(),
        ]
    )
    covariance = found.motion.covariance + 0.5 * np.outer(gap, gap)
    return replace(found, motion=replace(found.motion, covariance=covariance))


def stereo_odometer(
    rig: Rig, max_features: int, min_inliers: int, rig_sigma_rad: float
) -> StereoOdometer:
    """Return the odometer of a rig; rig_sigma_rad: how well the bottom camera's rotation is known,
    which widens the lines on which its matches are sought by two sigmas.
    """
    options = MatchOptions()
    widening_px = 2 * rig_sigma_rad * rig.focal_px(Camera.TOP)
    return StereoOdometer(
        rig=rig,
        feature_options=FeatureOptions(max_features=max_features),
        match_options=MatchOptions(
            min_inliers=min_inliers,
            column_px=options.column_px + widening_px,
            sigma_px=SEARCH_SIGMA_PX,
        ),
    )
