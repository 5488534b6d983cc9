# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Name what is wrong where images contradict the stereo rig: pairing, pose, turn or lens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.records.clock import format_time
from hullrecon.typing import Array, Ints
from hullrecon.vision.pairs.two_view import essential_of
from hullrecon.vision.stereo.image_matcher import (
    MAX_ERROR_PX,
    ImageMatcher,
    Matched,
    StereoFrames,
    fit_pose,
)
from hullrecon.vision.stereo.lens_hypotheses import (
    LensFit,
    best_lenses,
    epipolar_error_px,
    in_other_order,
)
from hullrecon.vision.stereo.pose_conventions import fitting_conventions

MIN_PAIRS = 3  # informative pairs
MAX_TURN_DEG = 0.3  # of the bottom camera; a calibration under water is good to a tenth
TURN_SIGMAS = 5.0  # least ratio of such a turn to its sigma
# Ratio of two median errors from which the larger one counts as far off: that of pairs that do not
# fit, beside that of pairs that do; and that as calibrated, beside that of a fitted pose, from
# which the calibrated pose is taken to be of another convention
FAR = 4.0
CLEARLY_BETTER = 1.2  # ratio of the median errors of two fits from which the better one is taken
MAX_SHARE = 0.3  # of the pairs beyond MAX_ERROR_PX
LEAST_PART = 2  # pairs that fit, and pairs that do not, where only a part of the dive is wrong
MAX_SHIFT = 3  # frames by which the stamps of one camera may be off
# Largest ratio of a cause's median error to that of the best one to be named as well. Generous, as
# the matches were chosen with a wrong rig.
AS_GOOD = 1.5
LEAST_TURN_DEG = 0.05  # below, the pose is said to be shifted, not turned
UPSIDE_DOWN_DEG = 135.0  # turn from which the pictures of one camera are taken to be upside down
TURN_PICTURES = (
    "its pictures, or those of the top camera, stand otherwise than in the calibration: give them "
    "as the camera was calibrated, or calibrate with such pictures"
)
CALIBRATE = "calibrate the two cameras again, in water (both files and camera.bottom.pose_in_top)"


@dataclass(frozen=True, kw_only=True)
class RigProblem:
    """A contradiction between the calibrated rig and the images, in words."""

    what: str  # the contradiction, with its figures
    remedy: str  # "" where none is known

    @property
    def sentence(self) -> str:
        """The contradiction, and what to do where that is known."""
        return f"{self.what}: {self.remedy}" if self.remedy else self.what


def find_wrong_part(
    matcher: ImageMatcher, pairs: Sequence[Matched], error_px: Array, limit_px: float
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
    changes = (np.diff(good.astype(np.int8)) != 0).sum()  # from good pairs to others, or back
    if good[0] and changes == 1:
        remedy = f"map the part before (dive.to = {format_time(int(at_ns[good][-1]))})"
    elif good[-1] and changes == 1:
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


def find_shift(
    matcher: ImageMatcher, frames: StereoFrames, places: Ints, limit_px: float
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
        errors_px = matcher.errors_px(
            [m for m in found if m is not None and np.mean(matcher.depths(m) > 0) > 0.5]
        )
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


def explain_images(matcher: ImageMatcher, pairs: Sequence[Matched], error_px: float) -> RigProblem:
    """Fit one pose to all pairs, and name what explains the images better than the calibration.

    The pose is offered as a cause only if it fits most pairs. error_px: median epipolar error as
    calibrated.
    """
    found, _, fitted_px = fit_pose(pairs, matcher.focal_px)
    fits_most = (matcher.errors_px(pairs, found) > MAX_ERROR_PX).mean() <= MAX_SHARE
    return _name_cause(matcher, pairs, found if fits_most else None, error_px, fitted_px)


def find_turn(
    matcher: ImageMatcher, pairs: Sequence[Matched], error_px: float, sigma_rad: float
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
    from_given = fit_pose(pairs, matcher.focal_px, matcher.given)
    from_own = fit_pose(pairs, matcher.focal_px)
    is_near_as_good = from_given[2] <= CLEARLY_BETTER * from_own[2]
    found, covariance, fitted_px = from_given if is_near_as_good else from_own
    turn = _turn_rad(matcher.given, found)
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3]).max()))
    if turn < max(np.radians(MAX_TURN_DEG) + 3 * sigma_rad, TURN_SIGMAS * sigma):
        return None
    return _name_cause(matcher, pairs, found, error_px, fitted_px)


def _name_cause(
    matcher: ImageMatcher,
    pairs: Sequence[Matched],
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
    best_px = _best_px(lenses, found, fitted_px)
    miswritten = _miswritten_calibration(matcher, seen, what, error_px, best_px)
    if miswritten is not None:
        return miswritten
    if best_px > MAX_ERROR_PX:
        return RigProblem(
            what=f"{what}, and neither one pose, one delay of the bottom camera nor one lens fits "
            "them: do its stamps drift, or were images paired wrongly from some time on?",
            remedy="",
        )
    return _fitted_cause(matcher, found, lenses, what, fitted_px)


def _miswritten_calibration(
    matcher: ImageMatcher, seen: tuple[Array, Array], what: str, error_px: float, best_px: float
) -> RigProblem | None:
    """Name calibrations that were exchanged, or whose coefficients are in another order.

    These have no number to fit, so that they are believed before a fitted cause. None where neither
    explains the images.

    Parameters
    ----------
    matcher
        Has the rig as calibrated.
    seen
        Raw pixels (n, 2) of the matches in both images.
    what
        The contradiction in words.
    error_px, best_px
        Median epipolar error as calibrated, and with the best fitted cause.
    """
    exchanged_px = epipolar_error_px(matcher.lenses[::-1], essential_of(matcher.given), seen)
    if exchanged_px <= min(MAX_ERROR_PX, AS_GOOD * best_px):
        return RigProblem(
            what=f"{what}, {exchanged_px:.1f} px with the two cameras' calibrations exchanged",
            remedy="exchange camera.top.calibration and camera.bottom.calibration",
        )
    top, bottom = map(in_other_order, matcher.lenses)
    ordered_px = epipolar_error_px((top, bottom), essential_of(matcher.given), seen)
    if ordered_px <= min(AS_GOOD * best_px, error_px / CLEARLY_BETTER):
        return RigProblem(
            what=f"{what}, {ordered_px:.1f} px with the coefficients of distortion taken as k1, "
            "k2, k3, p1, p2",
            remedy="write distortion_coefficients of both cameras as k1, k2, p1, p2, k3",
        )
    return None


def _fitted_cause(
    matcher: ImageMatcher,
    found: Array | None,
    lenses: Sequence[LensFit],
    what: str,
    fitted_px: float,
) -> RigProblem:
    """Name the turn of the bottom camera or the wrong lenses that explain the images best.

    Parameters
    ----------
    matcher
        Has the rig as calibrated.
    found, fitted_px
        Fitted bottom_from_top (4, 4), None where no single pose fits all pairs, and the median
        epipolar error with it.
    lenses
        Changed lenses, the best ones first.
    what
        The contradiction in words.
    """
    best_px = _best_px(lenses, found, fitted_px)
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


def _best_px(lenses: Sequence[LensFit], found: Array | None, fitted_px: float) -> float:
    """Compute the epipolar error with the fitted cause that explains most, px."""
    return min(lenses[0].error_px, fitted_px if found is not None else np.inf)


def _turn_rad(given: Array, found: Array) -> float:
    """Compute the angle between the rotations of two motions (4, 4)."""
    turn = Rotation.from_matrix(given[:3, :3].T @ found[:3, :3])
    return float(np.linalg.norm(turn.as_rotvec()))
