# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Measure motion from images alone, without any prior, for navigation.

Two cameras measure it where there is no DVL. One camera gives the direction, and whether two images
overlap, which is how far images carry a path on where the DVL is silent.
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

# Of a feature where another pair's points predict it. Points of a rig whose calibration is rough
# lie pixels off where they move (8 px on a real set): a narrow search keeps those that happen to
# agree, and the motion is theirs.
SEARCH_SIGMA_PX = 2.0
LOOSE = 5.0  # sigmas of a motion within which its features are searched again
# Motion of features that is no noise of their places, in which a direction is found as well.
STILL_PX = 1.0
MOST = 0.5  # share of an image that counts as most of it
CELLS = 4  # of an image along either side

ReadRow = Callable[[int], Pixels | None]  # image (h, w, 3) RGB of a row, None for none


@dataclass(frozen=True, kw_only=True)
class OdometryFrame:
    """The features of a stereo pair with their depths."""

    number: int  # seeds random draws
    view: NodeView


@dataclass(frozen=True, kw_only=True)
class MeasuredMotion:
    """The motion of the top camera between two stereo pairs."""

    motion: Motion  # first_from_second, its covariance as far as features err independently
    calibration: CalibrationEvidence  # effect of the calibration's errors on it
    inliers: int


@dataclass(frozen=True, kw_only=True)
class StereoOdometer:
    """Measures the motion between two stereo pairs without any prior."""

    rig: Rig
    feature_options: FeatureOptions
    match_options: MatchOptions

    def frame(self, number: int, top: Pixels | None, bottom: Pixels | None) -> OdometryFrame:
        """Find the features of two images (h, w, 3) RGB. None for a missing image."""
        sides = [
            no_features() if image is None else extract(image, self.feature_options)
            for image in (top, bottom)
        ]
        return self.frame_of_features(number, NodeFeatures(top=sides[0], bottom=sides[1]))

    def frame_of_features(self, number: int, features: NodeFeatures) -> OdometryFrame:
        """Match the two cameras, without a prior of the scene's depth."""
        stereo = stereo_of_node(self.rig, features.top, features.bottom, None, self.match_options)
        view = view_of_node(
            self.rig, replace(features, stereo=stereo), None, self.match_options.sigma_px
        )
        return OdometryFrame(number=number, view=view)

    def motion(self, first: OdometryFrame, second: OdometryFrame) -> MeasuredMotion | None:
        """Measure the motion from one pair to another.

        None where too few features agree or the motion has no length. The pairs are matched twice:
        without a guess, then in reverse near the first result. Where features are few or the
        calibration is rough, the two may settle on different motions. Their difference is added to
        the covariance.
        """
        if Camera.BOTTOM in (first.view.camera, second.view.camera):
            return None
        options = self.match_options
        matcher, seed = PairMatcher(self.rig, options), (options.seed, second.number, first.number)
        found = _measured_motion(matcher.match(second.view, first.view, None, seed, True))
        if found is None:
            return None
        back = found.motion.inverse()
        near = replace(back, covariance=LOOSE**2 * back.covariance)
        again = _measured_motion(matcher.match(first.view, second.view, near, seed, False))
        return found if again is None else _with_disagreement(found, again)


def stereo_odometer(
    rig: Rig, max_features: int, min_inliers: int, rig_sigma_rad: float
) -> StereoOdometer:
    """Set up the odometer of a rig.

    Parameters
    ----------
    rig
        The vehicle's sensors.
    max_features
        Features of an image.
    min_inliers
        Matches that a motion must have.
    rig_sigma_rad
        Sigma of the bottom camera's rotation. By two of these the search lines are widened.
    """
    cameras = rig
    widening_px = 2 * rig_sigma_rad * cameras.focal_px(Camera.TOP)
    return StereoOdometer(
        rig=cameras,
        feature_options=FeatureOptions(max_features=max_features),
        match_options=MatchOptions(
            min_inliers=min_inliers,
            column_px=MatchOptions().column_px + widening_px,
            sigma_px=SEARCH_SIGMA_PX,
        ),
    )


def image_motion(
    rig: Rig, read: ReadRow, max_features: int, min_inliers: int
) -> Callable[[int, int], tuple[Array, Array] | None]:
    """Set up the measurement of the top camera's motion between two of its images.

    Parameters
    ----------
    rig
        The vehicle's sensors.
    read
        An image by its row.
    max_features
        Features of an image.
    min_inliers
        Matches that a motion must have.

    Returns
    -------
    between
        From two rows second_from_first (4, 4), its translation of any length, and sigmas (2,) of
        rotation and direction about the axis known worst, rad. None where features do not agree.
    """
    match, _ = _match_top_images(rig, read, max_features, min_inliers)

    def between(first: int, second: int) -> tuple[Array, Array] | None:
        """See `image_motion`. The sigma of the direction is that across it."""
        found = match(first, second).motion
        if found is None:
            return None
        length = float(np.linalg.norm(found.second_from_first[:3, 3]))
        direction = found.second_from_first[:3, 3] / length
        across = np.eye(3) - np.outer(direction, direction)
        of_direction = across @ found.covariance[:3, :3] @ across / length**2
        variance = [np.linalg.eigvalsh(c)[-1] for c in (found.covariance[3:, 3:], of_direction)]
        return found.second_from_first, np.sqrt(variance)

    return between


def continuity(
    rig: Rig, read: ReadRow, max_features: int, min_inliers: int
) -> Callable[[int, int], bool]:
    """Set up the test whether two images of the top camera overlap.

    They do where min_inliers features move as those of one rigid scene. Where they stand still they
    have to fill most of the image: a visible part of the vehicle stands still in open water too.
    Parameters are those of `image_motion`.
    """
    match, view = _match_top_images(rig, read, max_features, min_inliers)
    camera = rig.camera_models[Camera.TOP]

    def goes_on(first: int, second: int) -> bool:
        """Test whether features move as of one scene, and if they stand still, fill the image."""
        found = match(first, second)
        if found.reason not in (Reason.MATCHED, Reason.NO_MOTION):
            return False
        before, after = view(first).xy[found.first], view(second).xy[found.second]
        moved_px = np.linalg.norm((after - before) * [camera.fx, camera.fy], axis=1)
        return bool(np.median(moved_px) > STILL_PX) or fills_most(after, camera)

    return goes_on


def image_flow(
    rig: Rig, read: ReadRow, max_features: int, min_inliers: int
) -> Callable[[int, int], tuple[Array, Array] | None]:
    """Set up the search for features of one rigid scene in two images of the top camera.

    Parameters are those of `image_motion`. From two rows the places (m, 2) of m features in both
    images, in ideal coordinates. None where features do not agree.
    """
    match, view = _match_top_images(rig, read, max_features, min_inliers)

    def between(first: int, second: int) -> tuple[Array, Array] | None:
        found = match(first, second)
        if found.reason is not Reason.MATCHED:
            return None
        return view(first).xy[found.first], view(second).xy[found.second]

    return between


def fills_most(xy: Array, camera: CameraModel) -> bool:
    """Decide whether points (n, 2), ideal coordinates, cover more than MOST of an image.

    Both the area that their scatter stands for and the share of cells with a point must exceed it:
    scatter alone would pass points along the rim.
    """
    place = (xy * [camera.fx, camera.fy] + [camera.cx, camera.cy]) / [camera.width, camera.height]
    # Points that are even over a rectangle scatter by a twelfth of the square of its sides.
    area = 12 * np.sqrt(max(np.linalg.det(np.cov(place.T)), 0.0))
    cells = np.unique(np.clip((place * CELLS).astype(np.int64), 0, CELLS - 1), axis=0)
    return bool(area > MOST and len(cells) > MOST * CELLS**2)


def _match_top_images(
    rig: Rig, read: ReadRow, max_features: int, min_inliers: int
) -> tuple[Callable[[int, int], PairMatch], Callable[[int], NodeView]]:
    """Set up matching of the top camera's images by row, keeping the features of the last two."""
    options = MatchOptions(min_inliers=min_inliers)
    cameras, feature_options = rig, FeatureOptions(max_features=max_features)
    matcher = PairMatcher(cameras, options)

    @lru_cache(maxsize=2)
    def view(row: int) -> NodeView:
        image = read(row)
        found = no_features() if image is None else extract(image, feature_options)
        features = NodeFeatures(top=found, bottom=no_features())
        return view_of_node(cameras, features, None, options.sigma_px)

    def match(first: int, second: int) -> PairMatch:
        seed = (options.seed, first, second)
        return matcher.match(view(first), view(second), None, seed, True)

    return match, view


def _measured_motion(found: PairMatch) -> MeasuredMotion | None:
    if found.motion is None or found.calibration is None:
        return None
    return MeasuredMotion(
        motion=found.motion, calibration=found.calibration, inliers=len(found.first)
    )


def _with_disagreement(found: MeasuredMotion, again: MeasuredMotion) -> MeasuredMotion:
    """Add half the squared difference of both directions: either may be wrong."""
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
