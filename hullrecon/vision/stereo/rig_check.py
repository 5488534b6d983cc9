# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stereo calibration and stamps checked against a few pairs of images.

Features of a pair are matched without the calibration. The matches that a free epipolar geometry
explains are compared with the calibrated geometry.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.check.consistency_checks import BASELINE_M
from hullrecon.dive.logs.dvl_beams import SAME_UNIT, SMALL_UNITS
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.records.clock import format_time
from hullrecon.records.sensors import DvlPings
from hullrecon.rig import Rig
from hullrecon.typing import Array, Floats32, Ints, Pixels
from hullrecon.vision.features.descriptors import MAX_DISTANCE, RATIO, best_of_all, to_unit
from hullrecon.vision.features.extraction import Features, extract, no_features
from hullrecon.vision.options import FeatureOptions
from hullrecon.vision.pairs.mono_motion import refine
from hullrecon.vision.pairs.two_view import TwoView, essential_of, motions_of, sampson_squared
from hullrecon.vision.stereo.delay import Delay, MatchedRays, estimate_delay, move_to_top
from hullrecon.vision.stereo.lens_hypotheses import best_lenses, epipolar_error_px
from hullrecon.vision.stereo.matching import rectify, triangulate
from hullrecon.vision.stereo.pose_conventions import fitting_conventions

PAIRS = 6  # pairs of images that are checked, spread over the dive
MIN_MATCHES = 25  # matches of an informative pair of images
MIN_PAIRS = 3  # informative pairs
MAX_ERROR_PX = 1.5  # median, as wide as the band in which stereo matches are searched
MAX_TURN_DEG = 0.3  # of the bottom camera; a calibration under water is good to a tenth
TURN_SIGMAS = 5.0  # least ratio of such a turn to its sigma
# Ratio of the median error as calibrated to that of a fitted pose from which the pose is taken to
# be of another convention
FAR = 4.0
CLEARLY_BETTER = 1.2  # ratio of the median errors of two fits from which the better one is taken
MAX_SHARE = 0.3  # of the pairs beyond MAX_ERROR_PX
LEAST_PART = 2  # pairs that fit, and pairs that do not, where only a part of the dive is wrong
MAX_SHIFT = 3  # frames by which the stamps of one camera may be off
# Relative difference of depths by stereo and DVL. A curved hull, relief and lever arms make some.
MAX_DEPTH_RATIO = 0.15
NEAR_NS = 1_000_000_000  # largest time between a ping and a pair of images that are compared
# Largest ratio of a cause's median error to that of the best one to be named as well. Generous, as
# the matches were chosen with a wrong rig.
AS_GOOD = 1.5
WATER = 1.333  # refractive index
# Relative difference between the ratio of depths and 1 / WATER up to which a calibration in air is
# named as the cause
MEDIUM_SHARE = 0.05
# Least ratio of two units of length; that of two speeds of sound is below MAX_DEPTH_RATIO
LEAST_UNIT = 2.0
LARGEST_SHIFT = 0.1  # of a principal point, as a share of the focal length
# Ratio of the logarithmic errors with which two causes explain the distance travelled, from which
# the better one is named alone
CLEARLY_NEARER = 2.0
LEAST_WAY_M = 0.02  # motion between two pairs of images: several times the error of stereo
WAY_NS = 150_000_000  # before the first and after the second pair, within which pings count
FITS, OUTLIER_MEDIANS = 3, 3.0  # fits of a motion, and the residual of outliers over the median
LEAST_TURN_DEG = 0.05  # below, the pose is said to be shifted, not turned
UPSIDE_DOWN_DEG = 135.0  # turn from which the pictures of one camera are taken to be upside down
TURN_PICTURES = (
    "its pictures, or those of the top camera, stand otherwise than in the calibration: give them "
    "as the camera was calibrated, or calibrate with such pictures"
)
CALIBRATE = "calibrate the two cameras again, in water (both files and camera.bottom.pose_in_top)"

ReadImage = Callable[[Camera, int], Pixels | None]
TrayMotion = Callable[[Ints], Array]  # velocity and rate (n, 6) of the tray at times (n,), ns


@dataclass(frozen=True, kw_only=True)
class StereoFrames:
    """The usable frames of two cameras, in time order."""

    pair: Ints  # (k, 2) positions in `top` and `bottom` of the frames taken together
    top: tuple[Ints, Ints]  # stamps, ns, and rows in the camera's image index
    bottom: tuple[Ints, Ints]


@dataclass(frozen=True, kw_only=True)
class RigProblem:
    """A contradiction between the calibrated rig and the images, in words."""

    what: str  # the contradiction, with its figures
    remedy: str  # "" where none is known

    @property
    def sentence(self) -> str:
        """The contradiction, and what to do where that is known."""
        return f"{self.what}: {self.remedy}" if self.remedy else self.what


@dataclass(frozen=True, kw_only=True)
class RigCheck:
    """Result of checking k pairs of images."""

    error_px: float  # median distance of features from their epipolar lines as calibrated
    depth_m: Array  # (k,) median depth of the scene in the top camera, NaN behind it
    at_ns: Ints  # (k,) times of the pairs
    problem: RigProblem | None = None  # None where images and calibration agree
    delay: Delay | None = None  # of the bottom camera; None where none was found


@dataclass(frozen=True, kw_only=True)
class _Matched:
    """Features of two images that one epipolar geometry explains."""

    top: Array  # (n, 2) ideal coordinates
    bottom: Array
    pixels: tuple[Array, Array]  # (n, 2) raw pixels in the top and the bottom image
    descriptors: Floats32  # (n, 128) in the top image
    motion: Array  # (4, 4) bottom from top by these features, |t| = 1
    at_ns: int  # stamp of the top image
    stamped_s: float  # the bottom image's stamp minus the top image's


def check_stereo_rig(
    rig: Rig,
    frames: StereoFrames,
    read: ReadImage,
    sigma_rad: float = 0.0,
    motion: TrayMotion | None = None,
) -> RigCheck | None:
    """Check stereo calibration and stamps by a few pairs of images.

    A wrong rig gives wrong depths all through a dive, so what is wrong is named with its remedy.
    Frames that are paired wrongly are found only where the vehicle moved between them.

    Parameters
    ----------
    rig
        The cameras as calibrated.
    frames
        Usable frames of both cameras.
    read
        Reads an image by camera and row.
    sigma_rad
        Sigma of the bottom camera's rotation. The limit of the epipolar error is wider by twice
        this.
    motion
        Motion of the tray, needed to find a delay between the exposures of the two cameras. None
        where it was not measured.

    Returns
    -------
    check
        None where too few pairs have enough features in common.
    """
    matcher = _ImageMatcher(rig, frames, read)
    places = np.zeros(0, np.int64)
    if len(frames.pair):
        places = np.unique(np.linspace(0, len(frames.pair), PAIRS + 2)[1:-1].astype(np.int64))
    pairs = [found for k in places if (found := matcher.match(*frames.pair[k])) is not None]
    limit_px = MAX_ERROR_PX + 2 * sigma_rad * matcher.focal_px
    if len(pairs) < MIN_PAIRS:
        problem = (
            _find_shift(matcher, frames, places, limit_px) if len(places) >= MIN_PAIRS else None
        )
        if problem is None:
            return None
        return RigCheck(
            error_px=np.nan, depth_m=np.zeros(0), at_ns=np.zeros(0, np.int64), problem=problem
        )
    pairs, delay = (
        (pairs, None) if motion is None else _compensate_delay(matcher, pairs, motion, limit_px)
    )
    error_px = (
        np.array([_epipolar_error(found, matcher.given) for found in pairs]) * matcher.focal_px
    )
    middle_px = float(np.median(error_px))
    depth, behind = [matcher.depths(found) for found in pairs], matcher.is_behind(pairs)
    if (error_px > limit_px).mean() > MAX_SHARE or behind:
        # Wrong pairing is tried before a wrong calibration: with a vehicle that moves evenly,
        # frames paired with their neighbours look like a rig with another baseline.
        problem = (
            _find_wrong_part(matcher, pairs, error_px, limit_px)
            or _find_shift(matcher, frames, places, limit_px)
            or _explain(matcher, pairs, middle_px)
        )
    else:
        problem = _find_turn(matcher, pairs, middle_px, sigma_rad)
    return RigCheck(
        error_px=middle_px,
        depth_m=np.array([np.nan if behind else _median_or_nan(z[z > 0]) for z in depth]),
        at_ns=np.array([found.at_ns for found in pairs], np.int64),
        problem=problem,
        delay=delay,
    )


def check_baseline(
    found: RigCheck, dvl: DvlPings, rig: Rig, motion_ratio: Callable[[], float | None]
) -> RigProblem | None:
    """Compare the scene's depth by stereo with the DVL's ranges, to find a wrong baseline.

    None where they agree, or were measured together for fewer than MIN_PAIRS pairs of images.

    The images alone do not determine the baseline's length. The DVL sits on the tray with the
    cameras, so that no path is needed. A wrong baseline scales the distance travelled by stereo as
    much as depths. Wrong focal lengths of both cameras scale depths alone.

    Parameters
    ----------
    found
        Result of the check of the images.
    dvl, rig
        Pings of the DVL, and where it sits beside the cameras.
    motion_ratio
        Measures the distance travelled by stereo over that by the DVL, None where it cannot. It is
        called only where depths disagree.
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
    middle = float(np.median(ratio))
    what = f"stereo sees the hull at {middle:.2g} of the distance that the DVL measures"
    shift_share = rig.baseline_m * abs(1 - middle) / float(np.nanmedian(found.depth_m))
    causes, remedy = _causes_of_depth(middle, motion_ratio(), rig.baseline_m, shift_share)
    return RigProblem(what=f"{what}: {causes}", remedy=remedy)


def _causes_of_depth(
    depth: float, way: float | None, baseline_m: float, shift_share: float
) -> tuple[str, str]:
    """Say what explains depths by stereo of `depth` times the DVL's, and how to correct it.

    Parameters
    ----------
    depth
        Depth by stereo over that by the DVL.
    way
        Distance travelled by stereo over that by the DVL, None where it is not known.
    baseline_m
        Length of the baseline as calibrated, from which the one that would fit follows.
    shift_share
        Error of a principal point along the baseline that would have the same effect as the wrong
        baseline, as a share of the focal length.

    Returns
    -------
    causes
        What would explain it, in words.
    remedy
        What to do, "" where that is not known.
    """
    baseline = f"the baseline of {baseline_m:.3f} m would have to be {baseline_m / depth:.3f} m"
    focal = f"the focal lengths of both cameras would have to be {1 / depth:.2f} times as long"
    if abs(np.log(depth * WATER)) < np.log1p(MEDIUM_SHARE):
        focal += ", as where they were calibrated in air"
    if way is None:
        return f"{baseline}, or as well {focal}", ""
    # Errors with which the two causes explain the ratio of distances: `depth` and 1 are expected.
    by_baseline, by_focal = abs(np.log(way / depth)), abs(np.log(way))
    if by_baseline < by_focal / CLEARLY_NEARER:
        if baseline_m > BASELINE_M[1] and baseline_m / depth < BASELINE_M[1]:
            return baseline, "give x, y, z of camera.bottom.pose_in_top in metres"
        if shift_share < LARGEST_SHIFT:
            centre = "one of the principal points lies elsewhere along the baseline"
            return f"{baseline}, or as well {centre}", CALIBRATE
        if abs(np.log(depth)) < np.log(LEAST_UNIT):
            return baseline, "correct camera.bottom.pose_in_top"
        return f"{baseline}, or as well the DVL measures in another unit", ""
    unit = next((u for u, m in SMALL_UNITS.items() if abs(np.log(depth / m)) < SAME_UNIT), None)
    if by_focal < by_baseline / CLEARLY_NEARER and unit is not None:
        return f"the DVL's ranges are in {unit}, not in m", ""
    if by_focal < by_baseline / CLEARLY_NEARER:
        return f"{focal}, or the DVL's ranges or dvl.mount are wrong", CALIBRATE
    return f"{baseline}, or as well {focal}", ""


def compare_ways(rig: Rig, frames: StereoFrames, read: ReadImage, dvl: DvlPings) -> float | None:
    """Compute the ratio of the vehicle's motion by stereo to that by the DVL.

    It tells a wrong baseline, which scales motion and depths, from wrong focal lengths, which scale
    depths alone. The median over pairs of consecutive frames. None where the vehicle hardly moved,
    or frames have too few features in common.
    """
    matcher = _ImageMatcher(rig, frames, read)
    top_from_dvl = rig.tray_from(Camera.TOP).inverse() @ rig.tray_from_dvl
    places = np.unique(np.linspace(0, len(frames.pair) - 1, PAIRS + 2)[1:-1].astype(np.int64))
    ratio = []
    for k in places[places + 1 < len(frames.pair)]:
        pair = [matcher.match(*frames.pair[row]) for row in (k, k + 1)]
        if pair[0] is None or pair[1] is None:
            continue
        by_dvl_m = _way_of_dvl(dvl, pair[0].at_ns, pair[1].at_ns)
        motion = _motion_between(matcher, pair[0], pair[1])
        if motion is not None and by_dvl_m > LEAST_WAY_M:
            moved = top_from_dvl.inverse() @ motion @ top_from_dvl
            ratio.append(float(np.linalg.norm(moved.translation)) / by_dvl_m)
    return float(np.median(ratio)) if len(ratio) >= MIN_PAIRS else None


def _way_of_dvl(dvl: DvlPings, from_ns: int, to_ns: int) -> float:
    """Compute how far the DVL moved between two times, m, by its mean velocity, NaN without any."""
    inside = (dvl.t_ns >= from_ns - WAY_NS) & (dvl.t_ns <= to_ns + WAY_NS)
    velocity = dvl.velocity[inside & np.isfinite(dvl.velocity).all(axis=1)]
    if not len(velocity):
        return float("nan")
    return float(np.linalg.norm(velocity.mean(axis=0))) * (to_ns - from_ns) * 1e-9


def _motion_between(matcher: _ImageMatcher, first: _Matched, second: _Matched) -> Poses | None:
    """Fit the motion of the top camera, first_from_second, to points that two pairs share.

    Each pair is triangulated, so the motion has a length. Outliers are removed and the fit
    repeated. None with fewer than MIN_MATCHES inliers.
    """
    shared = best_of_all(first.descriptors, second.descriptors, RATIO, MAX_DISTANCE)
    here, there = matcher.points(first)[shared.first], matcher.points(second)[shared.second]
    keep = (here[:, 2] > 0) & (there[:, 2] > 0)
    here, there = here[keep], there[keep]
    for _ in range(FITS):
        if len(here) < MIN_MATCHES:
            return None
        motion = fit_rigid(there, here)
        away = np.linalg.norm(motion.apply(there) - here, axis=1)
        near = away <= OUTLIER_MEDIANS * np.median(away)
        here, there = here[near], there[near]
    return fit_rigid(there, here)


class _ImageMatcher:
    """Matches images of the two cameras, extracting the features of each only once."""

    def __init__(self, rig: Rig, frames: StereoFrames, read: ReadImage) -> None:
        self.rig, self._frames, self._read = rig, frames, read
        self.given, self.focal_px = rig.from_top(Camera.BOTTOM), rig.focal_px(Camera.TOP)
        self.lenses = (rig.model(Camera.TOP), rig.model(Camera.BOTTOM))
        self.mount = rig.tray_from(Camera.TOP).inverse() @ rig.tray_from(Camera.BOTTOM)
        self._seen: dict[tuple[Camera, int], Features] = {}

    def match(self, top: int, bottom: int) -> _Matched | None:
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
        return _Matched(
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

    def depths(self, matched: _Matched) -> Array:
        """Triangulate depths (n,) m in the top camera as calibrated. Not positive behind it."""
        return self.points(matched)[:, 2]

    def is_behind(self, pairs: Sequence[_Matched]) -> bool:
        """Decide whether most matches lie behind the cameras as calibrated."""
        return float(np.mean([np.mean(~(self.depths(m) > 0)) for m in pairs])) > 0.5

    def points(self, matched: _Matched) -> Array:
        """Triangulate matches to points (n, 3), m, in the top camera, by the rig as calibrated.

        NaN where the disparity is not positive.
        """
        turned = rectify(self.mount)
        return np.asarray(
            triangulate(
                turned, turned.rectify_top(matched.top), turned.rectify_bottom(matched.bottom)
            )
        )

    def pixels(self, pairs: Sequence[_Matched]) -> tuple[Array, Array]:
        """Collect the matches of all pairs, (n, 2) raw pixels of either image."""
        top, bottom = (np.concatenate([m.pixels[side] for m in pairs]) for side in (0, 1))
        return top, bottom

    def _features(self, camera: Camera, place: int) -> Features:
        if (camera, place) not in self._seen:
            rows = (self._frames.top if camera is Camera.TOP else self._frames.bottom)[1]
            image = self._read(camera, int(rows[place]))
            options = FeatureOptions(max_features=1500)
            self._seen[camera, place] = no_features() if image is None else extract(image, options)
        return self._seen[camera, place]


def _compensate_delay(
    matcher: _ImageMatcher, pairs: list[_Matched], motion: TrayMotion, limit_px: float
) -> tuple[list[_Matched], Delay | None]:
    """Move the bottom camera's features to where they were at the top camera's exposure.

    Otherwise the rig's motion between the two exposures would look like a wrong calibration. They
    are moved by the difference of the stamps, and by a delay where one is found. A delay is
    believed only if it brings the matches within limit_px of their epipolar lines with the rig as
    calibrated. One longer than half a period would mean that the images are of different frames,
    and is not corrected.

    Returns the moved matches, and the delay (None where none was found).
    """
    twist = motion(np.array([matched.at_ns for matched in pairs], np.int64))
    rays = [
        MatchedRays(top=m.top, bottom=m.bottom, twist=row, stamped_s=m.stamped_s)
        for m, row in zip(pairs, twist, strict=True)
    ]

    def moved(delay_s: float) -> list[_Matched]:
        """Move the bottom features, unless both images were exposed together anyway."""
        out = []
        for matched, ray in zip(pairs, rays, strict=True):
            apart_s = ray.stamped_s + delay_s
            if np.isfinite(ray.twist).all() and apart_s != 0:
                bottom = move_to_top(matcher.rig, ray, delay_s)
                pixels = matched.pixels[0], matcher.lenses[1].distort(bottom)
                matched = replace(matched, bottom=bottom, pixels=pixels)
            out.append(matched)
        return out

    def error_px(matched: list[_Matched]) -> float:
        return matcher.focal_px * float(
            np.median([_epipolar_error(m, matcher.given) for m in matched])
        )

    as_stamped, delay = moved(0.0), estimate_delay(matcher.rig, rays)
    if delay is None or not delay.is_significant or abs(delay.early_s) > matcher.half_period_s:
        return as_stamped, None
    delayed = moved(delay.early_s)
    if error_px(delayed) < min(error_px(as_stamped), limit_px):
        return delayed, delay
    return as_stamped, None


def _epipolar_error(matched: _Matched, bottom_from_top: Array) -> float:
    """Compute the median Sampson distance of a pair's matches, ideal coordinates."""
    squared = sampson_squared(essential_of(bottom_from_top), matched.top, matched.bottom)
    return float(np.sqrt(np.median(squared)))


def _median_or_nan(values: Array) -> float:
    return float(np.median(values)) if len(values) else np.nan


def _find_wrong_part(
    matcher: _ImageMatcher, pairs: Sequence[_Matched], error_px: Array, limit_px: float
) -> RigProblem | None:
    """Test whether some pairs fit the rig as calibrated, and the others are far from it.

    A wrong calibration would show in all pairs. So this means wrong pairing, or exchanged cameras,
    in a part of the dive. If the good pairs all come first, or all last, the remedy is to map that
    part alone. None where fewer than LEAST_PART pairs are on either side, or where the errors of
    the others are not far larger. error_px: (k,) median epipolar error of the pairs.
    """
    behind = np.array([np.mean(matcher.depths(m) > 0) < 0.5 for m in pairs])
    good = (error_px <= limit_px) & ~behind
    if good.sum() < LEAST_PART or (~good).sum() < LEAST_PART:
        return None
    good_px = float(np.median(error_px[good]))
    if (error_px[~good & ~behind] < FAR * good_px).any():
        return None
    at_ns = np.array([m.at_ns for m in pairs], np.int64)
    remedy = ""
    if good[0] and (np.diff(good.astype(np.int8)) != 0).sum() == 1:
        remedy = f"map the part before (dive.to = {format_time(int(at_ns[good][-1]))})"
    elif good[-1] and (np.diff(good.astype(np.int8)) != 0).sum() == 1:
        remedy = f"map the part after (dive.from = {format_time(int(at_ns[good][0]))})"
    far = f"{float(np.median(error_px[~good])):.1f} px"
    if behind.any():
        far += ", and behind the cameras"
    return RigProblem(
        what=f"{good.sum()} of {len(pairs)} pairs of images, spread over the dive, fit the stereo "
        f"calibration ({good_px:.1f} px from the epipolar lines), the others do not ({far}): "
        "images were paired wrongly, or the cameras exchanged, for a part of it",
        remedy=remedy,
    )


def _find_shift(
    matcher: _ImageMatcher, frames: StereoFrames, places: Ints, limit_px: float
) -> RigProblem | None:
    """Test whether the bottom camera's images fit a whole number of frames earlier or later.

    None where no shift, up to MAX_SHIFT frames, brings enough pairs within limit_px of their
    epipolar lines. places: pairs of frames that are tried.
    """
    top_ns, bottom_ns = frames.top[0], frames.bottom[0]
    best = (limit_px, 0)
    for shift in sorted(range(-MAX_SHIFT, MAX_SHIFT + 1), key=abs)[1:]:
        moved = [
            (top, bottom + shift)
            for top, bottom in frames.pair[places]
            if 0 <= bottom + shift < len(bottom_ns)
        ]
        found = [matcher.match(top, bottom) for top, bottom in moved]
        errors_px = [
            _epipolar_error(matched, matcher.given) * matcher.focal_px
            for matched in found
            if matched is not None and np.mean(matcher.depths(matched) > 0) > 0.5
        ]
        if len(errors_px) >= MIN_PAIRS:
            best = min(best, (float(np.median(errors_px)), shift))
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


def _explain(matcher: _ImageMatcher, pairs: Sequence[_Matched], error_px: float) -> RigProblem:
    """Fit one pose to all pairs, and name what explains the images better than the calibration.

    The pose is offered as a cause only if it fits most pairs. error_px: median epipolar error as
    calibrated.
    """
    found, _, fitted_px = _fit(pairs, matcher.focal_px)
    each_px = np.array([_epipolar_error(m, found) for m in pairs]) * matcher.focal_px
    rigid = (each_px > MAX_ERROR_PX).mean() <= MAX_SHARE
    return _contradiction(matcher, pairs, found if rigid else None, error_px, fitted_px)


def _find_turn(
    matcher: _ImageMatcher, pairs: Sequence[_Matched], error_px: float, sigma_rad: float
) -> RigProblem | None:
    """Test whether matches near their lines show the bottom camera turned about the top camera.

    A small turn keeps matches within the limit but changes depths. None where the fitted turn is
    within the tolerance or its own uncertainty.

    Parameters
    ----------
    matcher
        Has the rig as calibrated.
    pairs
        Matches of the checked pairs.
    error_px
        Median epipolar error as calibrated.
    sigma_rad
        Sigma of the bottom camera's rotation as calibrated.
    """
    # Images of a plane fit two motions equally well. The one nearest to the calibrated one is
    # taken, unless another is clearly better.
    near, far = _fit(pairs, matcher.focal_px, matcher.given), _fit(pairs, matcher.focal_px)
    found, covariance, fitted_px = near if near[2] <= CLEARLY_BETTER * far[2] else far
    turn = _turn_rad(matcher.given, found)
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3]).max()))
    if turn < max(np.radians(MAX_TURN_DEG) + 3 * sigma_rad, TURN_SIGMAS * sigma):
        return None
    return _contradiction(matcher, pairs, found, error_px, fitted_px)


def _contradiction(
    matcher: _ImageMatcher,
    pairs: Sequence[_Matched],
    found: Array | None,
    error_px: float,
    fitted_px: float,
) -> RigProblem:
    """Name what explains the images: a pose in another convention, a turn, a lens, or none of them.

    A turn of the bottom camera and wrong lenses are named together where they fit equally well.

    Parameters
    ----------
    matcher
        Has the rig as calibrated.
    pairs
        Matches of the checked pairs.
    found
        Fitted bottom_from_top (4, 4), None where no single pose fits all pairs.
    error_px, fitted_px
        Median epipolar error as calibrated, and with the fitted pose.
    """
    what = (
        f"the images contradict the stereo calibration: {error_px:.1f} px from the epipolar "
        "lines in the median"
    )
    behind, seen = matcher.is_behind(pairs), matcher.pixels(pairs)
    what += " and behind the cameras" if behind else ""
    # a wrong convention causes large errors, a turn or a lens small ones
    is_far = behind or error_px > FAR * fitted_px
    conventions = fitting_conventions(matcher.lenses, matcher.mount, *seen, AS_GOOD * fitted_px)
    if is_far and conventions:
        words = ", or as well ".join(one.words for one in conventions)
        return RigProblem(
            what=f"{what}; they fit {words}", remedy=", or ".join(one.remedy for one in conventions)
        )
    lenses = best_lenses(matcher.lenses, matcher.given, *seen)
    best_px = min(lenses[0].error_px, fitted_px if found is not None else np.inf)
    # Exchanged calibrations have no number to fit, so that they are believed before a fitted cause.
    exchanged_px = epipolar_error_px(matcher.lenses[::-1], essential_of(matcher.given), seen)
    if exchanged_px <= min(MAX_ERROR_PX, AS_GOOD * best_px):
        return RigProblem(
            what=f"{what}, {exchanged_px:.1f} px with the two cameras' calibrations exchanged",
            remedy="exchange camera.top.calibration and camera.bottom.calibration",
        )
    if best_px > MAX_ERROR_PX:
        return RigProblem(
            what=f"{what}, and neither one pose, one delay of the bottom camera nor one lens fits "
            "them: do its stamps drift, or were images paired wrongly from some time on?",
            remedy="",
        )
    causes = []
    if found is not None and fitted_px <= AS_GOOD * best_px:
        turn_deg = np.degrees(_turn_rad(matcher.given, found))
        moved = f"the bottom camera turned by {turn_deg:.1f} degrees"
        if turn_deg < LEAST_TURN_DEG:
            moved = "x, y, z of camera.bottom.pose_in_top in another direction"
        causes.append(f"{fitted_px:.1f} px with {moved}")
        if turn_deg > UPSIDE_DOWN_DEG:  # no rig is built so far from its calibration
            return RigProblem(what=f"{what}, {causes[0]}", remedy=TURN_PICTURES)
    causes += [
        f"{lens.error_px:.1f} px with {lens.words}"
        for lens in lenses
        if lens.error_px <= AS_GOOD * best_px
    ]
    return RigProblem(what=f"{what}, {', or as well '.join(causes)}", remedy=CALIBRATE)


def _turn_rad(given: Array, found: Array) -> float:
    """Compute the angle between the rotations of two motions (4, 4)."""
    turn = Rotation.from_matrix(given[:3, :3].T @ found[:3, :3])
    return float(np.linalg.norm(turn.as_rotvec()))


def _fit(
    pairs: Sequence[_Matched], focal: float, given: Array | None = None
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
