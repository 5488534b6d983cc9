# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check stereo calibration and stamps by a few pairs of images."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints
from hullrecon.vision.stereo.delay import Delay, MatchedRays, estimate_delay, move_to_top
from hullrecon.vision.stereo.image_matcher import (
    MAX_ERROR_PX,
    ImageMatcher,
    Matched,
    ReadImage,
    StereoFrames,
)
from hullrecon.vision.stereo.rig_causes import (
    MAX_SHARE,
    MIN_PAIRS,
    RigProblem,
    explain_images,
    find_shift,
    find_turn,
    find_wrong_part,
)

PAIRS = 6  # pairs of images that are checked, spread over the dive
TrayMotion = Callable[[Ints], Array]  # velocity and rate (n, 6) of the tray at times (n,), ns


@dataclass(frozen=True, kw_only=True)
class RigCheck:
    """Result of checking k pairs of images."""

    error_px: float  # median distance of features from their epipolar lines as calibrated
    depth_m: Array  # (k,) median depth of the scene in the top camera, NaN behind it
    at_ns: Ints  # (k,) times of the pairs
    problem: RigProblem | None = None  # None where images and calibration agree
    delay: Delay | None = None  # of the bottom camera; None where none was found


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
    matcher = ImageMatcher(rig, frames, read)
    limit_px = MAX_ERROR_PX + 2 * sigma_rad * matcher.focal_px
    places = np.zeros(0, np.int64)
    if len(frames.pair):
        places = np.unique(np.linspace(0, len(frames.pair), PAIRS + 2)[1:-1].astype(np.int64))
    pairs = [found for k in places if (found := matcher.match(*frames.pair[k])) is not None]
    if len(pairs) < MIN_PAIRS:
        # Images paired wrongly may show nothing in common.
        problem = None
        if len(places) >= MIN_PAIRS:
            problem = find_shift(matcher, frames, places, limit_px)
        if problem is None:
            return None
        return RigCheck(
            error_px=np.nan, depth_m=np.zeros(0), at_ns=np.zeros(0, np.int64), problem=problem
        )

    # The rig's own motion between the exposures of both cameras must not look like its error.
    delay = None
    if motion is not None:
        pairs, delay = _compensate_delay(matcher, pairs, motion, limit_px)
    error_px = matcher.errors_px(pairs)
    middle_px = float(np.median(error_px))
    behind = matcher.is_behind(pairs)
    if (error_px > limit_px).mean() > MAX_SHARE or behind:
        # Wrong pairing is tried before a wrong calibration: with a vehicle that moves evenly,
        # frames paired with their neighbours look like a rig with another baseline.
        problem = (
            find_wrong_part(matcher, pairs, error_px, limit_px)
            or find_shift(matcher, frames, places, limit_px)
            or explain_images(matcher, pairs, middle_px)
        )
    else:
        problem = find_turn(matcher, pairs, middle_px, sigma_rad)
    depth = [matcher.depths(found) for found in pairs]
    return RigCheck(
        error_px=middle_px,
        depth_m=np.array([np.nan if behind else _median_or_nan(z[z > 0]) for z in depth]),
        at_ns=np.array([found.at_ns for found in pairs], np.int64),
        problem=problem,
        delay=delay,
    )


def _compensate_delay(
    matcher: ImageMatcher, pairs: list[Matched], motion: TrayMotion, limit_px: float
) -> tuple[list[Matched], Delay | None]:
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

    def moved(delay_s: float) -> list[Matched]:
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

    as_stamped, delay = moved(0.0), estimate_delay(matcher.rig, rays)
    if delay is None or not delay.is_significant or abs(delay.early_s) > matcher.half_period_s:
        return as_stamped, None
    delayed = moved(delay.early_s)
    error_px, stamped_px = (np.median(matcher.errors_px(m)) for m in (delayed, as_stamped))
    if error_px < min(stamped_px, limit_px):
        return delayed, delay
    return as_stamped, None


def _median_or_nan(values: Array) -> float:
    return float(np.median(values)) if len(values) else np.nan
