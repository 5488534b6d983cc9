# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check the length of the stereo baseline by the DVL's ranges and velocities.

The images alone do not determine it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hullrecon.dive.check.consistency_checks import BASELINE_M
from hullrecon.dive.logs.dvl_beams import SAME_UNIT, SMALL_UNITS
from hullrecon.findings.adjustment import WATER
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.records.sensors import DvlPings
from hullrecon.rig import Rig
from hullrecon.vision.features.descriptors import MAX_DISTANCE, RATIO, best_of_all
from hullrecon.vision.stereo.image_matcher import (
    MIN_MATCHES,
    ImageMatcher,
    Matched,
    ReadImage,
    StereoFrames,
)
from hullrecon.vision.stereo.rig_causes import CALIBRATE, MIN_PAIRS, RigProblem
from hullrecon.vision.stereo.rig_check import PAIRS, RigCheck

# Relative difference of depths by stereo and DVL. A curved hull, relief and lever arms make some.
MAX_DEPTH_RATIO = 0.15
NEAR_NS = 1_000_000_000  # largest time between a ping and a pair of images that are compared
# Relative difference between the ratio of depths and 1 / WATER up to which a calibration in air is
# named as the cause
MEDIUM_SHARE = 0.05
# Least ratio of two units of length; that of two speeds of sound is below MAX_DEPTH_RATIO
LEAST_UNIT = 2.0
LARGEST_SHIFT = 0.1  # of a principal point, as a share of the focal length
# Ratio of the logarithmic errors with which two causes explain the distance travelled, from which
# the better one is named alone
CLEARLY_NEARER = 2.0
LEAST_MOTION_M = 0.02  # between two pairs of images: several times the error of stereo
PING_MARGIN_NS = 150_000_000  # before the first and after the second pair, within which pings count
FITS, OUTLIER_MEDIANS = 3, 3.0  # fits of a motion, and the residual of outliers over the median


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
        # distance of the hull along the camera's axis
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
    depth_ratio: float, distance_ratio: float | None, baseline_m: float, shift_share: float
) -> tuple[str, str]:
    """Say what explains depths by stereo of `depth_ratio` times the DVL's, and how to correct it.

    Parameters
    ----------
    depth_ratio
        Depth by stereo over that by the DVL.
    distance_ratio
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
    baseline = (
        f"the baseline of {baseline_m:.3f} m would have to be {baseline_m / depth_ratio:.3f} m"
    )
    focal = (
        f"the focal lengths of both cameras would have to be {1 / depth_ratio:.2f} times as long"
    )
    if abs(np.log(depth_ratio * WATER)) < np.log1p(MEDIUM_SHARE):
        focal += ", as where they were calibrated in air"
    if distance_ratio is None:
        return f"{baseline}, or as well {focal}", ""
    # Errors with which the two causes explain the ratio of distances: a wrong baseline makes it
    # `depth_ratio`, wrong focal lengths leave it at 1.
    by_baseline, by_focal = abs(np.log(distance_ratio / depth_ratio)), abs(np.log(distance_ratio))
    if by_baseline < by_focal / CLEARLY_NEARER:
        if baseline_m > BASELINE_M[1] and baseline_m / depth_ratio < BASELINE_M[1]:
            return baseline, "give x, y, z of camera.bottom.pose_in_top in metres"
        if shift_share < LARGEST_SHIFT:
            centre = "one of the principal points lies elsewhere along the baseline"
            return f"{baseline}, or as well {centre}", CALIBRATE
        if abs(np.log(depth_ratio)) < np.log(LEAST_UNIT):
            return baseline, "correct camera.bottom.pose_in_top"
        return f"{baseline}, or as well the DVL measures in another unit", ""
    unit = next(
        (u for u, m in SMALL_UNITS.items() if abs(np.log(depth_ratio / m)) < SAME_UNIT), None
    )
    if by_focal < by_baseline / CLEARLY_NEARER and unit is not None:
        return f"the DVL's ranges are in {unit}, not in m", ""
    if by_focal < by_baseline / CLEARLY_NEARER:
        return f"{focal}, or the DVL's ranges or dvl.mount are wrong", CALIBRATE
    return f"{baseline}, or as well {focal}", ""


def compare_distances(
    rig: Rig, frames: StereoFrames, read: ReadImage, dvl: DvlPings
) -> float | None:
    """Compute the ratio of the distance travelled by stereo to that by the DVL.

    It distinguishes a wrong baseline, which scales motion and depths, from wrong focal lengths,
    which scale depths alone. It is the median over pairs of consecutive frames. None where the
    vehicle hardly moved, or frames have too few features in common.
    """
    matcher = ImageMatcher(rig, frames, read)
    top_from_dvl = rig.tray_from(Camera.TOP).inverse() @ rig.tray_from_dvl
    places = np.unique(np.linspace(0, len(frames.pair) - 1, PAIRS + 2)[1:-1].astype(np.int64))
    ratio = []
    for k in places[places + 1 < len(frames.pair)]:
        pair = [matcher.match(*frames.pair[row]) for row in (k, k + 1)]
        if pair[0] is None or pair[1] is None:
            continue
        by_dvl_m = _distance_by_dvl(dvl, pair[0].at_ns, pair[1].at_ns)
        motion = _motion_between(matcher, pair[0], pair[1])
        if motion is not None and by_dvl_m > LEAST_MOTION_M:
            moved = top_from_dvl.inverse() @ motion @ top_from_dvl
            ratio.append(float(np.linalg.norm(moved.translation)) / by_dvl_m)
    return float(np.median(ratio)) if len(ratio) >= MIN_PAIRS else None


def _distance_by_dvl(dvl: DvlPings, from_ns: int, to_ns: int) -> float:
    """Compute how far the DVL moved between two times, m, by its mean velocity, NaN without any."""
    inside = (dvl.t_ns >= from_ns - PING_MARGIN_NS) & (dvl.t_ns <= to_ns + PING_MARGIN_NS)
    velocity = dvl.velocity[inside & np.isfinite(dvl.velocity).all(axis=1)]
    if not len(velocity):
        return float("nan")
    return float(np.linalg.norm(velocity.mean(axis=0))) * (to_ns - from_ns) * 1e-9


def _motion_between(matcher: ImageMatcher, first: Matched, second: Matched) -> Poses | None:
    """Fit the motion of the top camera, first_from_second, to points that two pairs share.

    Each pair is triangulated, so the motion has a length. Outliers are removed and the fit
    repeated. None with fewer than MIN_MATCHES inliers.
    """
    shared = best_of_all(first.descriptors, second.descriptors, RATIO, MAX_DISTANCE)
    of_first, of_second = matcher.points(first)[shared.first], matcher.points(second)[shared.second]
    keep = (of_first[:, 2] > 0) & (of_second[:, 2] > 0)
    of_first, of_second = of_first[keep], of_second[keep]
    for _ in range(FITS):
        if len(of_first) < MIN_MATCHES:
            return None
        motion = fit_rigid(of_second, of_first)
        residual = np.linalg.norm(motion.apply(of_second) - of_first, axis=1)
        near = residual <= OUTLIER_MEDIANS * np.median(residual)
        of_first, of_second = of_first[near], of_second[near]
    return fit_rigid(of_second, of_first)
