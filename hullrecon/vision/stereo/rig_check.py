# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stereo calibration and stamps checked against a few pairs of images.

Features of a pair are matched without the calibration. The matches that a free epipolar geometry
explains are compared with the calibrated geometry.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.frames import Camera
from hullrecon.records.sensors import DvlPings
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Pixels
from hullrecon.vision.features.descriptors import MAX_DISTANCE, RATIO, best_of_all, to_unit
from hullrecon.vision.features.extraction import FeatureOptions, Features, extract, no_features
from hullrecon.vision.pairs.mono_motion import refine
from hullrecon.vision.pairs.two_view import TwoView, essential_of, motions_of, sampson_squared
from hullrecon.vision.stereo.matching import rectify, triangulate

PAIRS = 6  # of images, spread over the dive
MIN_MATCHES = 25  # of an informative pair of images
MIN_PAIRS = 3  # informative pairs
MAX_ERROR_PX = 1.5  # median, as wide as the band in which stereo matches are sought
MAX_TURN_DEG = 0.3  # of the bottom camera; a calibration under water is good to a tenth
TURN_SIGMAS = 5.0  # by which such a turn must be known
CLEARLY_BETTER = 1.2  # the median error of one fit over another's
MAX_SHARE = 0.3  # of the pairs beyond MAX_ERROR_PX
MAX_SHIFT = 3  # frames by which the stamps of one camera may be off
MAX_DEPTH_RATIO = 0.15  # of stereo and DVL: a curved hull, relief and lever arms make some of it
NEAR_NS = 1_000_000_000  # of a ping to a pair of images

ReadImage = Callable[[Camera, int], Pixels | None]


@dataclass(frozen=True, kw_only=True)
class StereoFrames:
    """The usable frames of two cameras, in time order."""

    pair: Ints  # (k, 2) places in top and bottom of the frames taken together
    top: tuple[Ints, Ints]  # stamps, ns, and rows in the index
    bottom: tuple[Ints, Ints]


@dataclass(frozen=True, kw_only=True)
class RigProblem:
    """A contradiction, in words."""

    what: str  # with its figures
    remedy: str


@dataclass(frozen=True, kw_only=True)
class RigCheck:
    """Result of checking k pairs of images."""

    error_px: float  # median distance of features from their epipolar lines as calibrated
    depth_m: Array  # (k,) of the scene in the top camera, NaN behind it
    at_ns: Ints  # (k,) when
    problem: RigProblem | None = None  # None where all fits


@dataclass(frozen=True, kw_only=True)
class _Matched:
    """Features of two images that one epipolar geometry explains."""

    top: Array  # (n, 2) ideal coordinates
    bottom: Array
    motion: Array  # (4, 4) bottom from top by these features, |t| = 1
    at_ns: int


def check_stereo_rig(
    rig: Rig, frames: StereoFrames, read: ReadImage, sigma_rad: float = 0.0
) -> RigCheck | None:
    """Check calibration and stamps by a few pairs of images.

    A shift of the frames shows only where the vehicle moved.

    Parameters
    ----------
    rig
        The cameras as calibrated.
    frames
        Of both cameras.
    read
        An image by camera and row.
    sigma_rad
        Of the bottom camera's rotation. By two sigmas the limits are wider.

    Returns
    -------
    check
        None where too few pairs have enough features in common.
    """
    look = _ImageMatcher(rig, frames, read)
    places = np.zeros(0, np.int64)
    if len(frames.pair):
        places = np.unique(np.linspace(0, len(frames.pair), PAIRS + 2)[1:-1].astype(np.int64))
    pairs = [found for k in places if (found := look.match(*frames.pair[k])) is not None]
    limit_px = MAX_ERROR_PX + 2 * sigma_rad * look.focal_px
    if len(pairs) < MIN_PAIRS:
        problem = _find_shift(look, frames, places, limit_px) if len(places) >= MIN_PAIRS else None
        if problem is None:
            return None
        return RigCheck(
            error_px=np.nan, depth_m=np.zeros(0), at_ns=np.zeros(0, np.int64), problem=problem
        )
    error_px = np.array([_error(found, look.given) for found in pairs]) * look.focal_px
    middle_px = float(np.median(error_px))
    depth = [look.depths(found) for found in pairs]
    behind = float(np.mean([np.mean(~(z > 0)) for z in depth])) > 0.5
    if (error_px > limit_px).mean() > MAX_SHARE or behind:
        # A shift first: a vehicle that moves evenly makes wrong neighbours look like a rig of
        # another direction.
        problem = _find_shift(look, frames, places, limit_px) or _explain(look, pairs, middle_px)
    else:
        problem = _describe_turn(look, pairs, middle_px, sigma_rad)
    return RigCheck(
        error_px=middle_px,
        depth_m=np.array([np.nan if behind else np.median(z[z > 0]) for z in depth]),
        at_ns=np.array([found.at_ns for found in pairs], np.int64),
        problem=problem,
    )


def check_baseline(found: RigCheck, dvl: DvlPings, rig: Rig) -> RigProblem | None:
    """Compare the scene's depth by stereo with the DVL's ranges.

    None where they agree, or were never measured at the same time.

    The images alone do not determine the baseline's length. The DVL sits on the tray with the
    cameras: no path is needed.
    """
    camera_from_dvl = rig.tray_from(Camera.TOP).inverse() @ rig.tray_from_dvl
    ratio = []
    for t_ns, depth_m in zip(found.at_ns, found.depth_m, strict=True):
        near = np.abs(dvl.t_ns - t_ns) < NEAR_NS
        ends = (dvl.ranges[near][:, :, None] * dvl.beams).reshape(-1, 3)
        ends = ends[np.isfinite(ends[:, 0])]
        if not len(ends):
            continue
        ahead_m = float(np.median(camera_from_dvl.apply(ends)[:, 2]))
        if ahead_m > 0 and np.isfinite(depth_m):
            ratio.append(depth_m / ahead_m)
    if len(ratio) < MIN_PAIRS or abs(np.log(np.median(ratio))) < np.log1p(MAX_DEPTH_RATIO):
        return None
    camera_from_tray = rig.tray_from(Camera.TOP).inverse()
    length_m = float(
        np.linalg.norm(camera_from_tray.apply(rig.tray_from(Camera.BOTTOM).translation))
    )
    middle = float(np.median(ratio))
    return RigProblem(
        what=f"stereo sees the hull at {middle:.2f} of the distance that the DVL measures: "
        f"the baseline of {length_m:.3f} m would have to be {length_m / middle:.3f} m",
        remedy="correct camera.bottom.pose_in_top (or the DVL's mount and beams)",
    )


class _ImageMatcher:
    """Matches images of the two cameras, extracting features once."""

    def __init__(self, rig: Rig, frames: StereoFrames, read: ReadImage) -> None:
        self._rig, self._frames, self._read = rig, frames, read
        self.given, self.focal_px = rig.from_top(Camera.BOTTOM), rig.focal_px(Camera.TOP)
        self._seen: dict[tuple[Camera, int], Features] = {}

    def match(self, top: int, bottom: int) -> _Matched | None:
        """Match a top and a bottom frame by their index in StereoFrames.

        None where little matches.
        """
        import cv2

        sides = [self._features(Camera.TOP, top), self._features(Camera.BOTTOM, bottom)]
        top_unit, bottom_unit = (to_unit(f.descriptors) for f in sides)
        found = best_of_all(top_unit, bottom_unit, RATIO, MAX_DISTANCE)
        if len(found) < MIN_MATCHES:
            return None
        a, b = (
            self._rig.model(camera).undistort(f.keypoints[rows, :2])
            for camera, f, rows in zip(Camera, sides, (found.first, found.second), strict=True)
        )
        cv2.setRNGSeed(0)
        tolerance = MAX_ERROR_PX / self.focal_px
        essential, mask = cv2.findEssentialMat(
            a, b, np.eye(3), method=cv2.RANSAC, prob=0.9999, threshold=tolerance
        )
        if essential is None or mask is None or mask.sum() < MIN_MATCHES:
            return None
        inlier = mask.ravel() > 0
        model = TwoView("essential", essential[:3], inlier)
        return _Matched(
            top=a[inlier],
            bottom=b[inlier],
            motion=motions_of(model, a, b)[0].motion,
            at_ns=int(self._frames.top[0][top]),
        )

    def depths(self, matched: _Matched) -> Array:
        """Triangulate depths (n,) m in the top camera as calibrated. Not positive behind it."""
        pose = self._rig.stereo_mount
        if pose is None:
            return np.zeros(0)
        turned = rectify(pose)
        points = triangulate(
            turned, turned.rectify_top(matched.top), turned.rectify_bottom(matched.bottom)
        )
        return np.asarray(points[:, 2])

    def _features(self, camera: Camera, place: int) -> Features:
        if (camera, place) not in self._seen:
            rows = (self._frames.top if camera is Camera.TOP else self._frames.bottom)[1]
            image = self._read(camera, int(rows[place]))
            options = FeatureOptions(max_features=1500)
            self._seen[camera, place] = no_features() if image is None else extract(image, options)
        return self._seen[camera, place]


def _error(matched: _Matched, bottom_from_top: Array) -> float:
    squared = sampson_squared(essential_of(bottom_from_top), matched.top, matched.bottom)
    return float(np.sqrt(np.median(squared)))


def _find_shift(
    look: _ImageMatcher, frames: StereoFrames, places: Ints, limit_px: float
) -> RigProblem | None:
    """Test whether the bottom camera's images fit a whole number of frames earlier or later."""
    top_ns, bottom_ns = frames.top[0], frames.bottom[0]
    best = (limit_px, 0)
    for shift in sorted(range(-MAX_SHIFT, MAX_SHIFT + 1), key=abs)[1:]:
        moved = [(t, b + shift) for t, b in frames.pair[places] if 0 <= b + shift < len(bottom_ns)]
        found = [m for t, b in moved if (m := look.match(t, b)) is not None]
        good = [
            _error(m, look.given) * look.focal_px
            for m in found
            if np.mean(look.depths(m) > 0) > 0.5
        ]
        if len(good) >= MIN_PAIRS:
            best = min(best, (float(np.median(good)), shift))
    error_px, shift = best
    if shift == 0:
        return None
    top, bottom = frames.pair[:, 0], frames.pair[:, 1] + shift
    inside = (bottom >= 0) & (bottom < len(bottom_ns))
    late_s = float(np.median(bottom_ns[bottom[inside]] - top_ns[top[inside]])) * 1e-9
    many = "1 frame" if abs(shift) == 1 else f"{abs(shift)} frames"
    return RigProblem(
        what="the two cameras' images are paired wrongly: the bottom camera's fit "
        f"{many} {'later' if shift > 0 else 'earlier'}, {error_px:.1f} px from their epipolar "
        "lines",
        remedy=f"add {-late_s:+.3f} s to camera.bottom.time_offset, or correct the stamps",
    )


def _explain(look: _ImageMatcher, pairs: Sequence[_Matched], error_px: float) -> RigProblem:
    """Describe how the images contradict a rig: cameras swapped, turned, or not rigid at all."""
    found, _, fitted_px = _fit(pairs, look.focal_px)
    each_px = np.array([_error(m, found) for m in pairs]) * look.focal_px
    if (each_px > MAX_ERROR_PX).mean() > MAX_SHARE:
        return RigProblem(
            what=f"the images contradict the stereo calibration: {error_px:.1f} px from the "
            "epipolar lines in the median, and no one pose of the bottom camera fits them",
            remedy="check the two calibration files, and that the cameras are triggered together",
        )
    if found[:3, 3] @ look.given[:3, 3] < 0:
        return RigProblem(
            what="the two cameras are swapped: the images put the bottom camera on the other side "
            f"of the top one, {error_px:.1f} px from the epipolar lines",
            remedy="exchange the topics and calibrations of camera_top and camera_bottom, or "
            "invert camera.bottom.pose_in_top",
        )
    return _contradiction(found, look.given, error_px, fitted_px)


def _describe_turn(
    look: _ImageMatcher, pairs: Sequence[_Matched], error_px: float, sigma_rad: float
) -> RigProblem | None:
    """Test whether matches near their lines show the bottom camera turned about the top camera."""
    # Images of a plane fit two motions alike. The one next to the given one counts, unless another
    # is clearly better.
    near, far = _fit(pairs, look.focal_px, look.given), _fit(pairs, look.focal_px)
    found, covariance, fitted_px = near if near[2] <= CLEARLY_BETTER * far[2] else far
    turn = _turn_rad(look.given, found)
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3]).max()))
    if turn < max(np.radians(MAX_TURN_DEG) + 3 * sigma_rad, TURN_SIGMAS * sigma):
        return None
    return _contradiction(found, look.given, error_px, fitted_px)


def _contradiction(found: Array, given: Array, error_px: float, fitted_px: float) -> RigProblem:
    turn_deg = np.degrees(_turn_rad(given, found))
    return RigProblem(
        what=f"the images contradict the stereo calibration: {error_px:.1f} px from the epipolar "
        f"lines in the median, {fitted_px:.1f} px with the bottom camera turned by "
        f"{turn_deg:.1f} degrees",
        remedy="correct camera.bottom.pose_in_top, or calibrate the two cameras again, under water",
    )


def _turn_rad(given: Array, found: Array) -> float:
    turn = Rotation.from_matrix(given[:3, :3].T @ found[:3, :3])
    return float(np.linalg.norm(turn.as_rotvec()))


def _fit(
    pairs: Sequence[_Matched], focal: float, given: Array | None = None
) -> tuple[Array, Array, float]:
    """Fit the motion from the top to the bottom camera to all pairs of images.

    Parameters
    ----------
    pairs
        What images have in common.
    focal
        px.
    given
        Motion (4, 4) to start from, None for that of the pair whose own motion fits all best.

    Returns
    -------
    motion, covariance, error_px
        (4, 4) with |t| = 1, (5, 5), and the median error.
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
        near = squared < 9 * max(float(np.median(squared)) / 0.455, 1e-12)
        start, covariance = refine(start, top[near], bottom[near])
    squared = sampson_squared(essential_of(start), top, bottom)
    return start, covariance, float(np.sqrt(np.median(squared))) * focal
