# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Measure motion from images alone, without any prior, for navigation.

Two cameras measure it where there is no DVL. One camera gives the direction, and whether two images
overlap. As long as they do, a path goes on where the DVL is silent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Array, Pixels
from hullrecon.vision.features.extraction import extract, no_features
from hullrecon.vision.options import FeatureOptions, MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import PairMatcher
from hullrecon.vision.pairs.pair_match import PairMatch, Reason
from hullrecon.vision.pairs.stereo_adjustment import CalibrationEvidence
from hullrecon.vision.stereo.node_view import (
    NodeFeatures,
    NodeView,
    stereo_of_node,
    view_of_node,
)

# Sigma of a feature's position in the search for it. With a roughly calibrated rig, triangulated
# points project pixels away from the true feature (8 px on a real set). A narrow search would keep
# only the features that happen to agree, and give a wrong motion.
SEARCH_SIGMA_PX = 2.0
LOOSE = 5.0  # factor on the sigmas of a motion within which its features are searched again
# Median motion of features above which they moved: more than the noise of their positions.
STILL_PX = 1.0
MOST = 0.5  # share of an image that counts as most of it
CELLS = 4  # cells of an image along either side, to see how much of it features cover

# image (h, w, 3) RGB by its row in the index of images, None where it cannot be read
ReadRow = Callable[[int], Pixels | None]


@dataclass(frozen=True, kw_only=True)
class OdometryFrame:
    """The features of a stereo pair with their depths."""

    number: int  # seeds random draws
    view: NodeView


@dataclass(frozen=True, kw_only=True)
class MeasuredMotion:
    """The motion of the top camera between two stereo pairs."""

    # first_from_second, with the covariance from errors that features have independently
    motion: Motion
    calibration: CalibrationEvidence  # effect of the stereo calibration's errors on the motion
    inliers: int


@dataclass(frozen=True, kw_only=True)
class StereoOdometer:
    """Measures the motion between two stereo pairs without any prior."""

    rig: Rig
    feature_options: FeatureOptions
    match_options: MatchOptions

    def frame(self, number: int, top: Pixels | None, bottom: Pixels | None) -> OdometryFrame:
        """Find the features of two images (h, w, 3) RGB. top, bottom: None for a missing image."""
        sides = [
            no_features() if image is None else extract(image, self.feature_options)
            for image in (top, bottom)
        ]
        return self.frame_of_features(number, NodeFeatures(top=sides[0], bottom=sides[1]))

    def frame_of_features(self, number: int, features: NodeFeatures) -> OdometryFrame:
        """Prepare a stereo pair: match its two cameras, without a prior of the scene's depth.

        number: seeds the random draws of later matching.
        """
        stereo = stereo_of_node(self.rig, features.top, features.bottom, None, self.match_options)
        view = view_of_node(
            self.rig, replace(features, stereo=stereo), None, self.match_options.sigma_px
        )
        return OdometryFrame(number=number, view=view)

    def motion(self, first: OdometryFrame, second: OdometryFrame) -> MeasuredMotion | None:
        """Measure the motion from one pair to another.

        None where too few features agree, the motion has no length, or the top camera is dark or
        missing in either pair. The pairs are matched twice: without a guess, then from the second
        to the first near the inverse of that result. Where features are few or the calibration is
        rough, the two may settle on different motions. Their difference is added to the covariance.
        """
        if Camera.BOTTOM in (first.view.camera, second.view.camera):
            return None
        options = self.match_options
        matcher, seed = PairMatcher(self.rig, options), (options.seed, second.number, first.number)
        found = _measured_motion(matcher.match(second.view, first.view, None, seed, False))
        if found is None:
            return None
        back = found.motion.inverse()
        near = replace(back, covariance=LOOSE**2 * back.covariance)
        again = _measured_motion(matcher.match(first.view, second.view, near, seed, False))
        return found if again is None else _with_disagreement(found, again)


def stereo_odometer(
    rig: Rig, max_features: int, min_inliers: int, rig_sigma_rad: float
) -> StereoOdometer:
    """Set up the odometer of a rig, which measures its path where there is no DVL.

    Parameters
    ----------
    rig
        The vehicle's sensors.
    max_features
        Features of an image.
    min_inliers
        Matches that a motion must have.
    rig_sigma_rad
        Sigma of the bottom camera's rotation. The search along epipolar lines is wider by twice
        this.
    """
    widening_px = 2 * rig_sigma_rad * rig.focal_px(Camera.TOP)
    return StereoOdometer(
        rig=rig,
        feature_options=FeatureOptions(max_features=max_features),
        match_options=MatchOptions(
            min_inliers=min_inliers,
            column_px=MatchOptions().column_px + widening_px,
            sigma_px=SEARCH_SIGMA_PX,
        ),
    )


class TopImages:
    """Images of the top camera, matched without any prior of the motion.

    Each image is given by its row in the index of images.
    """

    def __init__(self, rig: Rig, read: ReadRow, max_features: int, min_inliers: int) -> None:
        """Set up the matching.

        Parameters
        ----------
        rig
            The vehicle's sensors.
        read
            Reads an image by its row. None where it cannot be read.
        max_features
            Features of an image.
        min_inliers
            Matches that a motion must have.
        """
        self._rig, self._read = rig, read
        self._options = MatchOptions(min_inliers=min_inliers)
        self._feature_options = FeatureOptions(max_features=max_features)
        self._view = lru_cache(maxsize=2)(self._find_features)  # of the last two images

    def motion(self, first: int, second: int) -> tuple[Array, Array] | None:
        """Measure the motion from one image to another. None where they do not match.

        Returns
        -------
        second_from_first
            (4, 4), whose translation has an arbitrary length.
        sigma_rad
            (2,) of its rotation and of the translation's direction, each about the least well
            known axis.
        """
        found = self._match(first, second).motion
        if found is None:
            return None
        length = float(np.linalg.norm(found.second_from_first[:3, 3]))
        direction = found.second_from_first[:3, 3] / length
        across = np.eye(3) - np.outer(direction, direction)
        # A direction errs by the part of the translation's error across it, over the length.
        of_direction = across @ found.covariance[:3, :3] @ across / length**2
        variance = [np.linalg.eigvalsh(c)[-1] for c in (found.covariance[3:, 3:], of_direction)]
        return found.second_from_first, np.sqrt(variance)

    def overlap(self, first: int, second: int) -> bool:
        """Test whether two images overlap: their features move as those of one rigid scene.

        As long as they do, a path may be carried on where the DVL is silent. Features that stand
        still must also fill most of the image: a visible part of the vehicle stands still in open
        water too.
        """
        found = self._match(first, second)
        if found.reason not in (Reason.MATCHED, Reason.NO_MOTION):
            return False
        camera = self._rig.camera_models[Camera.TOP]
        before, after = self._common(first, second, found)
        moved_px = np.linalg.norm((after - before) * [camera.fx, camera.fy], axis=1)
        return bool(np.median(moved_px) > STILL_PX) or fills_most(after, camera)

    def flow(self, first: int, second: int) -> tuple[Array, Array] | None:
        """Find features of one rigid scene in two images. None where features do not agree.

        Returns the positions (m, 2) of the same m features in each image, in ideal coordinates.
        """
        found = self._match(first, second)
        return self._common(first, second, found) if found.reason is Reason.MATCHED else None

    def _match(self, first: int, second: int) -> PairMatch:
        """Match two frames, given by number, without any prior of the motion between them."""
        seed = (self._options.seed, first, second)
        matcher = PairMatcher(self._rig, self._options)
        # without a prior the whole image is searched in any case
        return matcher.match(self._view(first), self._view(second), None, seed, full_search=False)

    def _common(self, first: int, second: int, found: PairMatch) -> tuple[Array, Array]:
        """Look up the positions (m, 2) of the features that two images have in common."""
        return self._view(first).xy[found.first], self._view(second).xy[found.second]

    def _find_features(self, row: int) -> NodeView:
        """Find the features of an image, in ideal coordinates: none where it cannot be read."""
        image = self._read(row)
        found = no_features() if image is None else extract(image, self._feature_options)
        features = NodeFeatures(top=found, bottom=no_features())
        return view_of_node(self._rig, features, None, self._options.sigma_px)


def fills_most(xy: Array, camera: CameraModel) -> bool:
    """Decide whether points (n, 2), ideal coordinates, cover more than MOST of an image.

    Both the area of the rectangle over which points of this scatter would be spread evenly and the
    share of cells with a point must exceed it. Scatter alone would pass points along the rim.
    """
    share = (xy * [camera.fx, camera.fy] + [camera.cx, camera.cy]) / [camera.width, camera.height]
    # Points spread evenly along a side of length a have the variance a^2 / 12.
    area = 12 * np.sqrt(max(np.linalg.det(np.cov(share.T)), 0.0))
    cells = np.unique(np.clip((share * CELLS).astype(np.int64), 0, CELLS - 1), axis=0)
    return bool(area > MOST and len(cells) > MOST * CELLS**2)


def _measured_motion(found: PairMatch) -> MeasuredMotion | None:
    """Take the motion of a pair that matched. None of one that did not."""
    if found.motion is None or found.calibration is None:
        return None
    return MeasuredMotion(
        motion=found.motion, calibration=found.calibration, inliers=len(found.first)
    )


def _with_disagreement(found: MeasuredMotion, again: MeasuredMotion) -> MeasuredMotion:
    """Add the difference of the motion matched forward and in reverse to the covariance.

    Half its square is added, the variance of one of two measurements that differ by so much.
    """
    reversed_motion = again.motion.inverse().second_from_first
    turn = found.motion.second_from_first[:3, :3].T @ reversed_motion[:3, :3]
    gap = np.concatenate(
        [
            reversed_motion[:3, 3] - found.motion.second_from_first[:3, 3],
            Rotation.from_matrix(turn).as_rotvec(),
        ]
    )
    covariance = found.motion.covariance + 0.5 * np.outer(gap, gap)
    return replace(found, motion=replace(found.motion, covariance=covariance))
