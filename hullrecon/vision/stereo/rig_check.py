# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a dive's stereo images fit to the calibration and the stamps that they come with, seen in
a few pairs of images.

Features of a pair are matched without the calibration: what a free epipolar geometry explains is
held against the one given.
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
from hullrecon.vision.features.descriptors import best_of_all, to_unit
from hullrecon.vision.features.extraction import FeatureOptions, Features, extract, no_features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.mono_motion import refine
from hullrecon.vision.pairs.two_view import TwoView, essential_of, motions_of, sampson_squared
from hullrecon.vision.stereo.rectification import rectify, triangulate

PAIRS = 6  # of images, spread over the dive
MIN_MATCHES = 25  # of a pair of images that says something
MIN_PAIRS = 3
MAX_ERROR_PX = 1.5  # median, as wide as the band in which stereo matches are sought
MAX_TURN_DEG = 0.3  # of the bottom camera; a calibration under water is good to a tenth
TURN_SIGMAS = 5.0
CLEARLY_BETTER = 1.2  # the median error of one fit over another's
MAX_SHARE = 0.3  # of the pairs, beyond MAX_ERROR_PX
MAX_SHIFT = 3  # frames by which the stamps of one camera may be off
# between stereo and DVL: a curved hull, relief and lever arms make some of it
MAX_DEPTH_RATIO = 0.15
NEAR_NS = 1_000_000_000  # of a ping to a pair of images

ReadImage = Callable[[Camera, int], Pixels | None]


@dataclass(frozen=True, kw_only=True)
class StereoFrames:
    """pair (k, 2): places in `top` and `bottom` of the frames that are taken together. top, bottom:
    stamps and rows of the usable frames of each camera, in time order.
    """

    pair: Ints
    top: tuple[Ints, Ints]
    bottom: tuple[Ints, Ints]


@dataclass(frozen=True, kw_only=True)
class RigProblem:
    """What does not fit, with its figures, and what to do."""

    what: str
    remedy: str


@dataclass(frozen=True, kw_only=True)
class RigCheck:
    """error_px: median distance of matched features from their epipolar lines as calibrated;
    depth_m (k,): of the scene in the top camera, NaN behind it, and at_ns (k,), when; problem: None
    where all fits.
    """

    error_px: float
    depth_m: Array
    at_ns: Ints
    problem: RigProblem | None = None


@dataclass(frozen=True, kw_only=True)
class _Matched:
    """Features (n, 2) of both images that one epipolar geometry explains, ideal coordinates, and
    the motion it stands for.
    """

    top: Array
    bottom: Array
    motion: Array
    at_ns: int


def check_stereo_rig(
    rig: Rig, frames: StereoFrames, read: ReadImage, sigma_rad: float = 0.0
) -> RigCheck | None:
    """Return what a few pairs of images say of calibration and stamps; None where too few have
    enough features in common.

    sigma_rad: how well the bottom camera's rotation is said to be known; by two sigmas the limits
    are wider. A shift of the frames shows only where the vehicle moved.
    """
    look = _Look(rig, frames, read)
    places = (
        np.unique(np.linspace(0, len(frames.pair), PAIRS + 2)[1:-1].astype(np.int64))
        if len(frames.pair)
        else np.zeros(0, int)
    )
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
    depth = [look.depths(found) for found in pairs]
    behind = float(np.mean([np.mean(~(z > 0)) for z in depth])) > 0.5
    if (error_px > limit_px).mean() > MAX_SHARE or behind:
        # A shift first: a vehicle that moves evenly makes wrong neighbours look like a rig of
        # another direction.
        problem = _find_shift(look, frames, places, limit_px) or _explain(
            look, pairs, float(np.median(error_px))
        )
    else:
        problem = _describe_turn(look, pairs, float(np.median(error_px)), sigma_rad)
    return RigCheck(
        error_px=float(np.median(error_px)),
        depth_m=np.array([np.nan if behind else np.median(z[z > 0]) for z in depth]),
        at_ns=np.array([found.at_ns for found in pairs], np.int64),
        problem=problem,
    )


def check_baseline(found: RigCheck, dvl: DvlPings, rig: Rig) -> RigProblem | None:
    """Return words where stereo and the DVL's ranges put the scene at different depths; None where
    they agree or did not meet.

    The images alone say nothing of the baseline's length. The DVL sits on the tray with the
    cameras: no path is needed.
    """
    camera_from_dvl = rig.tray_from(Camera.TOP).inverse() @ rig.tray_from_dvl
    ratio = []
    for t_ns, depth_m in zip(found.at_ns, found.depth_m, strict=True):
        near = np.abs(dvl.t_ns - t_ns) < NEAR_NS
        ends = (dvl.ranges[near][:, :, None] * dvl.beams).reshape(-1, 3)
        ahead = (
            camera_from_dvl.apply(ends[np.isfinite(ends[:, 0])])[:, 2] if len(ends) else np.zeros(0)
        )
        ratio += (
            [depth_m / np.median(ahead)]
            if len(ahead) and np.median(ahead) > 0 and np.isfinite(depth_m)
            else []
        )
    if len(ratio) < MIN_PAIRS or abs(np.log(np.median(ratio))) < np.log1p(MAX_DEPTH_RATIO):
        return None
    length_m = float(
        np.linalg.norm(
            rig.tray_from(Camera.TOP).inverse().apply(rig.tray_from(Camera.BOTTOM).translation)
        )
    )
    middle = float(np.median(ratio))
    return RigProblem(
        what=f"stereo sees the hull at {middle:.2f} of the distance that the DVL measures: the baseline of {length_m:.3f} m "
        f"would have to be {length_m / middle:.3f} m",
        remedy="correct camera.bottom.pose_in_top (or the DVL's mount and beams)",
    )


class _Look:
    """Features of the images asked for, each extracted once, and what two of them have in common."""

    def __init__(self, rig: Rig, frames: StereoFrames, read: ReadImage) -> None:
        self._rig, self._frames, self._read = rig, frames, read
        self.given, self.focal_px = rig.from_top(Camera.BOTTOM), rig.focal_px(Camera.TOP)
        self._seen: dict[tuple[Camera, int], Features] = {}

    def match(self, top: int, bottom: int) -> _Matched | None:
        """Return what the frames in those places of their cameras' order have in common; None where
        that is little.
        """
        import cv2

        sides = [self._features(Camera.TOP, top), self._features(Camera.BOTTOM, bottom)]
        options = MatchOptions()
        top_unit, bottom_unit = (to_unit(f.descriptors) for f in sides)
        found = best_of_all(top_unit, bottom_unit, options.ratio, options.max_distance)
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
        """Return the depth (n,), m, of matches in the top camera as calibrated; NaN or negative
        behind it.
        """
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
            self._seen[camera, place] = (
                no_features()
                if image is None
                else extract(image, FeatureOptions(max_features=1500))
            )
        return self._seen[camera, place]


def _error(matched: _Matched, bottom_from_top: Array) -> float:
    return float(
        np.sqrt(
            np.median(sampson_squared(essential_of(bottom_from_top), matched.top, matched.bottom))
        )
    )


def _find_shift(
    look: _Look, frames: StereoFrames, places: Ints, limit_px: float
) -> RigProblem | None:
    """Return words where the bottom camera's images fit a whole number of frames earlier or later;
    None where they do not.
    """
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
    inside = frames.pair[
        (frames.pair[:, 1] + shift >= 0) & (frames.pair[:, 1] + shift < len(bottom_ns))
    ]
    late_s = float(np.median(bottom_ns[inside[:, 1] + shift] - top_ns[inside[:, 0]])) * 1e-9
    many = "1 frame" if abs(shift) == 1 else f"{abs(shift)} frames"
    return RigProblem(
        what="the two cameras' images are paired wrongly: the bottom camera's fit "
        f"{many} {'later' if shift > 0 else 'earlier'}, {error_px:.1f} px from their epipolar lines",
        remedy=f"add {-late_s:+.3f} s to camera.bottom.time_offset, or correct the stamps",
    )


def _explain(look: _Look, pairs: Sequence[_Matched], error_px: float) -> RigProblem:
    """Return words for a rig that the images contradict: swapped, turned, or no one rig at all."""
    found, _, fitted_px = _fit(pairs, look.focal_px)
    each_px = np.array([_error(m, found) for m in pairs]) * look.focal_px
    if (each_px > MAX_ERROR_PX).mean() > MAX_SHARE:
        return RigProblem(
            what=f"the images contradict the stereo calibration: {error_px:.1f} px from the epipolar lines in the median, and "
            "no one pose of the bottom camera fits them",
            remedy="check the two calibration files, and that the cameras are triggered together",
        )
    if found[:3, 3] @ look.given[:3, 3] < 0:
        return RigProblem(
            what="the two cameras are swapped: the images put the bottom camera on the other side of the top one, "
            f"{error_px:.1f} px from the epipolar lines",
            remedy="exchange the topics and calibrations of camera_top and camera_bottom, or invert camera.bottom.pose_in_top",
        )
    return _contradiction(found, look.given, error_px, fitted_px)


def _describe_turn(
    look: _Look, pairs: Sequence[_Matched], error_px: float, sigma_rad: float
) -> RigProblem | None:
    """Return words where the matches lie near their lines and yet show the bottom camera turned
    towards the top one.
    """
    # Images of a plane fit two motions alike: the one next to what is given counts, unless another
    # is clearly better.
    near, far = _fit(pairs, look.focal_px, look.given), _fit(pairs, look.focal_px)
    found, covariance, fitted_px = near if near[2] <= CLEARLY_BETTER * far[2] else far
    turn = np.linalg.norm(Rotation.from_matrix(look.given[:3, :3].T @ found[:3, :3]).as_rotvec())
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3]).max()))
    if turn < max(np.radians(MAX_TURN_DEG) + 3 * sigma_rad, TURN_SIGMAS * sigma):
        return None
    return _contradiction(found, look.given, error_px, fitted_px)


def _contradiction(found: Array, given: Array, error_px: float, fitted_px: float) -> RigProblem:
    turn = float(
        np.degrees(
            np.linalg.norm(Rotation.from_matrix(given[:3, :3].T @ found[:3, :3]).as_rotvec())
        )
    )
    return RigProblem(
        what=f"the images contradict the stereo calibration: {error_px:.1f} px from the epipolar lines in the median, "
        f"{fitted_px:.1f} px with the bottom camera turned by {turn:.1f} degrees",
        remedy="correct camera.bottom.pose_in_top, or calibrate the two cameras again, under water",
    )


def _fit(
    pairs: Sequence[_Matched], focal: float, given: Array | None = None
) -> tuple[Array, Array, float]:
    """Return the motion (4, 4) from the top to the bottom camera that all pairs of images fit best,
    |t| = 1, its covariance (5, 5), and the median error, px. given: the motion to start from; None:
    that of the pair whose own fits all best.
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
    return (
        start,
        covariance,
        float(np.sqrt(np.median(sampson_squared(essential_of(start), top, bottom)))) * focal,
    )
