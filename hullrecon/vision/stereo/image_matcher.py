# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Match images of the two cameras without their calibrated pose, and fit one pose to the matches.

The matches that a free epipolar geometry explains can then be compared with the calibrated one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Array, Floats32, Ints, Pixels
from hullrecon.vision.features.descriptors import MAX_DISTANCE, RATIO, best_of_all, to_unit
from hullrecon.vision.features.extraction import Features, extract, no_features
from hullrecon.vision.options import FeatureOptions
from hullrecon.vision.pairs.mono_motion import refine
from hullrecon.vision.pairs.two_view import TwoView, essential_of, motions_of, sampson_squared
from hullrecon.vision.stereo.matching import rectify, triangulate

MIN_MATCHES = 25  # matches of an informative pair of images
MAX_ERROR_PX = 1.5  # median, as wide as the band in which stereo matches are searched
ReadImage = Callable[[Camera, int], Pixels | None]


@dataclass(frozen=True, kw_only=True)
class StereoFrames:
    """The usable frames of two cameras, in time order."""

    pair: Ints  # (k, 2) positions in `top` and `bottom` of the frames taken together
    top: tuple[Ints, Ints]  # stamps, ns, and rows in the camera's image index
    bottom: tuple[Ints, Ints]


@dataclass(frozen=True, kw_only=True)
class Matched:
    """Features of two images that one epipolar geometry explains."""

    top: Array  # (n, 2) ideal coordinates
    bottom: Array
    pixels: tuple[Array, Array]  # (n, 2) raw pixels in the top and the bottom image
    descriptors: Floats32  # (n, 128) in the top image
    motion: Array  # (4, 4) bottom from top by these features, |t| = 1
    at_ns: int  # stamp of the top image
    stamped_s: float  # the bottom image's stamp minus the top image's


class ImageMatcher:
    """Matches images of the two cameras, extracting the features of each only once."""

    def __init__(self, rig: Rig, frames: StereoFrames, read: ReadImage) -> None:
        """Take the calibrated rig, the frames, and the function that reads an image."""
        self.rig, self._frames, self._read = rig, frames, read
        self.given, self.focal_px = rig.from_top(Camera.BOTTOM), rig.focal_px(Camera.TOP)
        self.lenses = (rig.model(Camera.TOP), rig.model(Camera.BOTTOM))
        self.mount = rig.tray_from(Camera.TOP).inverse() @ rig.tray_from(Camera.BOTTOM)
        self._seen: dict[tuple[Camera, int], Features] = {}

    def match(self, top: int, bottom: int) -> Matched | None:
        """Match a top and a bottom frame, without using the calibrated pose of the two cameras.

        top, bottom: positions of the frames in StereoFrames. None where fewer than MIN_MATCHES
        features fit one epipolar geometry.
        """
        import cv2

        sides = [self._features(Camera.TOP, top), self._features(Camera.BOTTOM, bottom)]
        top_unit, bottom_unit = (to_unit(f.descriptors) for f in sides)
        found = best_of_all(top_unit, bottom_unit, RATIO, MAX_DISTANCE)
        if len(found) < MIN_MATCHES:
            return None
        seen = [
            f.keypoints[rows, :2]
            for f, rows in zip(sides, (found.first, found.second), strict=True)
        ]
        # the essential matrix that most matches fit, in ideal coordinates
        a, b = (self.rig.model(c).undistort(p) for c, p in zip(Camera, seen, strict=True))
        cv2.setRNGSeed(0)
        tolerance = MAX_ERROR_PX / self.focal_px
        essential, mask = cv2.findEssentialMat(
            a, b, np.eye(3), method=cv2.RANSAC, prob=0.9999, threshold=tolerance
        )
        if essential is None or mask is None or mask.sum() < MIN_MATCHES:
            return None
        inlier = mask.ravel() > 0
        model = TwoView("essential", essential[:3], inlier)
        return Matched(
            top=a[inlier],
            bottom=b[inlier],
            pixels=(seen[0][inlier], seen[1][inlier]),
            descriptors=top_unit[found.first][inlier],
            motion=motions_of(model, a, b)[0].motion,
            at_ns=int(self._frames.top[0][top]),
            stamped_s=1e-9 * float(self._frames.bottom[0][bottom] - self._frames.top[0][top]),
        )

    @property
    def half_period_s(self) -> float:
        """Half the time from one frame of the top camera to the next."""
        return 0.5e-9 * float(np.median(np.diff(self._frames.top[0])))

    def errors_px(self, pairs: Sequence[Matched], bottom_from_top: Array | None = None) -> Array:
        """Compute the median distance (k,), px, of each pair's matches from their epipolar lines.

        bottom_from_top: (4, 4), by which lines are drawn. None: as calibrated.
        """
        essential = essential_of(self.given if bottom_from_top is None else bottom_from_top)
        squared = [np.median(sampson_squared(essential, m.top, m.bottom)) for m in pairs]
        return np.asarray(np.sqrt(squared) * self.focal_px)

    def depths(self, matched: Matched) -> Array:
        """Triangulate depths (n,) m in the top camera as calibrated. NaN or negative behind it."""
        return self.points(matched)[:, 2]

    def is_behind(self, pairs: Sequence[Matched]) -> bool:
        """Decide whether most matches lie behind the cameras as calibrated."""
        return float(np.mean([np.mean(~(self.depths(m) > 0)) for m in pairs])) > 0.5

    def points(self, matched: Matched) -> Array:
        """Triangulate matches to points (n, 3), m, in the top camera, by the rig as calibrated.

        NaN where the disparity is not positive.
        """
        turned = rectify(self.mount)
        return np.asarray(
            triangulate(
                turned, turned.rectify_top(matched.top), turned.rectify_bottom(matched.bottom)
            )
        )

    def pixels(self, pairs: Sequence[Matched]) -> tuple[Array, Array]:
        """Collect the matches of all pairs, (n, 2) raw pixels of either image."""
        top, bottom = (np.concatenate([m.pixels[side] for m in pairs]) for side in (0, 1))
        return top, bottom

    def _features(self, camera: Camera, place: int) -> Features:
        """Extract the features of a frame, given by its position in StereoFrames, once."""
        if (camera, place) not in self._seen:
            rows = (self._frames.top if camera is Camera.TOP else self._frames.bottom)[1]
            image = self._read(camera, int(rows[place]))
            options = FeatureOptions(max_features=1500)
            self._seen[camera, place] = no_features() if image is None else extract(image, options)
        return self._seen[camera, place]


def fit_pose(
    pairs: Sequence[Matched], focal: float, given: Array | None = None
) -> tuple[Array, Array, float]:
    """Fit the motion from the top to the bottom camera to all pairs of images.

    Matches far from their epipolar lines are left out of the fit, but count in the error.

    Parameters
    ----------
    pairs
        Matches of the checked pairs.
    focal
        Focal length, px.
    given
        Motion (4, 4) to start from. None: that of the pair whose own motion fits all pairs best.

    Returns
    -------
    motion
        bottom_from_top (4, 4) with |t| = 1.
    covariance
        (5, 5) of its rotation (3) and the direction of its translation (2), rad.
    error_px
        Median epipolar error of all matches.
    """
    top, bottom = (np.concatenate([getattr(m, name) for m in pairs]) for name in ("top", "bottom"))
    if given is None:
        start = min(
            (m.motion for m in pairs),
            key=lambda k: float(np.median(sampson_squared(essential_of(k), top, bottom))),
        )
    else:
        start = given.copy()
        start[:3, 3] /= np.linalg.norm(given[:3, 3])
    for _ in range(2):
        squared = sampson_squared(essential_of(start), top, bottom)
        # Within 3 robust sigmas: the median of a squared Gaussian is 0.455 variances.
        near = squared < 9 * max(float(np.median(squared)) / 0.455, 1e-12)
        start, covariance = refine(start, top[near], bottom[near])
    squared = sampson_squared(essential_of(start), top, bottom)
    return start, covariance, float(np.sqrt(np.median(squared))) * focal
