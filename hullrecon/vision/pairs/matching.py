# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two nodes matched: search within navigation's ellipse, robust motion, then a guided search along the motion found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from hullrecon.typing import Array, Floats32, Ints
from hullrecon.vision.features.descriptors import Putative, best_of_all, best_of_candidates, sparse_distance
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs import mono_motion, pose_from_points, two_view
from hullrecon.vision.pairs.gated_search import in_ellipse
from hullrecon.vision.pairs.gating import Motion, transfer
from hullrecon.vision.stereo.node_view import View
from hullrecon.vision.stereo.rectification import Rig

FEW = 100  # with fewer seeds the first motion is rough: what it guides to is worth a second look


class Reason(IntEnum):
    """Why a pair gave nothing, as stored in pairs.npz."""

    MATCHED = 0
    NO_FEATURES = 1
    FEW_PUTATIVE = 2
    FEW_INLIERS = 3
    AGAINST_NAVIGATION = 4
    SMALL_OVERLAP = 5


WORDS = {
    Reason.MATCHED: "matched",
    Reason.NO_FEATURES: "too few features in one of the images",
    Reason.FEW_PUTATIVE: "too few putative matches",
    Reason.FEW_INLIERS: "too few inliers",
    Reason.AGAINST_NAVIGATION: "inconsistent with navigation",
    Reason.SMALL_OVERLAP: "overlap too small",
}


@dataclass(frozen=True)
class PairMatch:
    """first, second (m,): rows of the two views' features that show one point; distance (m,) of their descriptors.

    motion: between the leading cameras, None when the pair failed; scaled: whether its translation has a measured length
    (mono: navigation's, or one).
    """

    first: Ints
    second: Ints
    distance: Floats32
    putative: int
    reason: Reason
    motion: Motion | None = None
    scaled: bool = True


def match_pair(
    rig: Rig, first: View, second: View, prior: Motion | None, options: MatchOptions, seed: tuple[int, ...], full_search: bool
) -> PairMatch:
    """Matches of two nodes. full_search: look everywhere when there is no prior, or when nothing is found where it points."""
    if min(len(first), len(second)) < options.min_putative:
        return _failed(0, Reason.NO_FEATURES)
    tries = ([prior] if prior is not None else []) + ([None] if full_search or prior is None else [])
    result = _failed(0, Reason.FEW_PUTATIVE)
    for expected in tries:
        result = _match(rig, first, second, expected, options, seed)
        if result.reason is Reason.MATCHED:
            break
    if result.motion is not None and prior is not None and not agrees(result, prior, options.navigation_chi2):
        return _failed(result.putative, Reason.AGAINST_NAVIGATION)
    return result


def agrees(found: PairMatch, prior: Motion, most_chi2: float) -> bool:
    """Whether the motion lies within navigation's covariance plus its own (its length aside where that is not measured)."""
    if found.motion is None:
        return False
    if not found.scaled:
        return mono_motion.navigation_chi2(found.motion, prior) <= most_chi2
    own, wanted = found.motion.second_from_first, prior.second_from_first
    turn = np.linalg.inv(wanted[:3, :3]) @ own[:3, :3]
    from scipy.spatial.transform import Rotation

    gap = np.concatenate([own[:3, 3] - wanted[:3, 3], Rotation.from_matrix(turn).as_rotvec()])
    covariance = prior.covariance + found.motion.covariance
    return bool(gap @ np.linalg.solve(covariance, gap) <= most_chi2)


def _match(
    rig: Rig, first: View, second: View, prior: Motion | None, options: MatchOptions, seed: tuple[int, ...]
) -> PairMatch:
    """By triangulated points of both sides; where too few, of one side; where too few of either, by two-view geometry."""
    result = _failed(0, Reason.FEW_PUTATIVE)
    tolerance = options.ransac_px / rig.focal(0)
    if first.stereo.any() and second.stereo.any():
        rows = np.flatnonzero(first.stereo)
        rows = rows[:: max(1, len(rows) // options.seeds)] if prior is not None else rows
        seeds = search(rig, first, second, prior, options, rows, np.flatnonzero(second.stereo))
        points = first.point[seeds.first], second.point[seeds.second]
        sights = sights_of(rig, first, second, seeds)
        start = (
            pose_from_points.ransac(*points, sights, tolerance, options.ransac_trials, seed)
            if _enough(seeds, options)
            else None
        )
        result = _with_points(rig, first, second, seeds, start, options)
    if result.reason is Reason.MATCHED:
        return result
    everywhere = np.arange(len(first)), np.arange(len(second))
    near = _candidates(rig, first, second, prior, options, *everywhere)
    seeds = _best(first, second, near, options, *everywhere)
    if not _enough(seeds, options):
        return _failed(len(seeds), Reason.FEW_PUTATIVE)
    with_point = max(int(first.stereo[seeds.first].sum()), int(second.stereo[seeds.second].sum()))
    if with_point >= max(options.min_putative, options.min_inliers):
        return _with_points(rig, first, second, seeds, _resection(first, second, seeds, tolerance, options), options)
    return _without_points(rig, first, second, seeds, near, prior, options)


def _enough(seeds: Putative, options: MatchOptions) -> bool:
    return len(seeds) >= options.min_putative


def search(
    rig: Rig, first: View, second: View, prior: Motion | None, options: MatchOptions, rows: Ints, among: Ints
) -> Putative:
    """Mutual best descriptors of those rows: in the 99 % ellipse of each where motion and depth are known, else everywhere."""
    return _best(first, second, _candidates(rig, first, second, prior, options, rows, among), options, rows, among)


def _candidates(
    rig: Rig, first: View, second: View, prior: Motion | None, options: MatchOptions, rows: Ints, among: Ints
) -> tuple[Ints, Ints] | None:
    """Pairs that navigation and depth allow; None where they say nothing."""
    if prior is None or not np.isfinite(first.depth[rows]).any():
        return None
    return _within(rig, first, second, prior, options, rows, among)


def _best(
    first: View, second: View, near: tuple[Ints, Ints] | None, options: MatchOptions, rows: Ints, among: Ints
) -> Putative:
    if near is None:
        found = best_of_all(first.descriptor[rows], second.descriptor[among], options.ratio, options.max_distance)
        return Putative(rows[found.first], among[found.second], found.distance)
    distance = sparse_distance(first.descriptor, second.descriptor, *near)
    return best_of_candidates(*near, distance, options.ratio, options.max_distance)


def _within(
    rig: Rig, first: View, second: View, motion: Motion, options: MatchOptions, rows: Ints, among: Ints
) -> tuple[Ints, Ints]:
    sigma = options.sigma_px / rig.focal(first.camera)
    mean, covariance = transfer(motion, first.xy[rows], first.depth[rows], first.depth_sigma[rows], sigma)
    known = np.flatnonzero(np.isfinite(mean).all(axis=1))
    a, b = in_ellipse(mean[known], covariance[known], second.xy[among], options.gate_chi2)
    return rows[known][a], among[b]


def _with_points(rig: Rig, first: View, second: View, seeds: Putative, start: Array | None, options: MatchOptions) -> PairMatch:
    """From the first guess of a motion to the matches that it guides to."""
    if start is None:
        return _failed(len(seeds), Reason.FEW_INLIERS if _enough(seeds, options) else Reason.FEW_PUTATIVE)
    sights = sights_of(rig, first, second, seeds)
    tolerance = options.ransac_px / rig.focal(0)
    motion = Motion(*pose_from_points.refine(start, sights, tolerance))
    if _support(motion.second_from_first, sights, tolerance, len(seeds)) < options.min_inliers:
        return _failed(len(seeds), Reason.FEW_INLIERS)
    matched = guided(rig, first, second, motion, options)
    if len(matched) > len(seeds):
        motion = Motion(
            *pose_from_points.refine(motion.second_from_first, sights_of(rig, first, second, _thinned(matched)), tolerance, 4)
        )
        matched = guided(rig, first, second, motion, options) if len(seeds) < FEW else matched
    if len(matched) < options.min_inliers:
        return _failed(len(seeds), Reason.FEW_INLIERS)
    return PairMatch(matched.first, matched.second, matched.distance, len(seeds), Reason.MATCHED, motion)


def _thinned(matched: Putative, most: int = 500) -> Putative:
    step = max(1, len(matched) // most)
    return Putative(matched.first[::step], matched.second[::step], matched.distance[::step])


def sights_of(rig: Rig, first: View, second: View, seeds: Putative) -> list[pose_from_points.Sight]:
    """Each node's points as the other node's leading camera, and its bottom camera, saw them."""
    a, b = seeds.first, seeds.second
    eye, down, baseline = np.eye(4), rig.from_top(1), rig.baseline_m
    sights = [
        pose_from_points.Sight(first.point[a], second.xy[b], eye, False, baseline),
        pose_from_points.Sight(first.point[a], second.other[b], down, False, baseline),
        pose_from_points.Sight(second.point[b], first.xy[a], eye, True, baseline),
        pose_from_points.Sight(second.point[b], first.other[a], down, True, baseline),
    ]
    return [pose_from_points.known(s) for s in sights]


def _support(motion: Array, sights: list[pose_from_points.Sight], tolerance: float, count: int) -> int:
    """Seeds that agree with the motion in every image that tells."""
    good, told = np.ones(count, bool), np.zeros(count, bool)
    for sight in sights:
        seen = np.isfinite(sight.xy[:, 0])
        good &= ~seen | (pose_from_points.squared_errors(motion[None], sight)[0] < tolerance**2)
        told |= seen
    return int((good & told).sum())


def _resection(first: View, second: View, seeds: Putative, tolerance: float, options: MatchOptions) -> Array | None:
    """Pose from the points of the side that has more of them, seen in the other (P3P in RANSAC)."""
    a, b, trials = seeds.first, seeds.second, options.ransac_trials
    forward, backward = first.stereo[a], second.stereo[b]
    if forward.sum() >= backward.sum():
        return pose_from_points.resect(first.point[a[forward]], second.xy[b[forward]], tolerance, trials)
    motion = pose_from_points.resect(second.point[b[backward]], first.xy[a[backward]], tolerance, trials)
    return None if motion is None else np.asarray(np.linalg.inv(motion))


def guided(rig: Rig, first: View, second: View, motion: Motion, options: MatchOptions) -> Putative:
    """Every feature searched again where the motion puts it, then held to its epipolar line, in both cameras where both saw."""
    floor = np.diag(np.repeat([(0.5 * options.sigma_px / rig.focal(0)) ** 2], 6))  # the motion is not better than its model
    loose = Motion(motion.second_from_first, motion.covariance + floor)
    near = _within(rig, first, second, loose, options, np.arange(len(first)), np.arange(len(second)))
    near = _on_lines(rig, first, second, motion.second_from_first, options, *near)
    distance = sparse_distance(first.descriptor, second.descriptor, *near)
    return best_of_candidates(*near, distance, options.guided_ratio, options.max_distance)


def _on_lines(rig: Rig, first: View, second: View, motion: Array, options: MatchOptions, a: Ints, b: Ints) -> tuple[Ints, Ints]:
    limit = (options.verify_px / rig.focal(0)) ** 2
    good = two_view.sampson_squared(two_view.essential_of(motion), first.xy[a], second.xy[b]) < limit
    down = rig.from_top(1)
    below = down @ motion @ np.linalg.inv(down)
    seen = np.flatnonzero(np.isfinite(first.other[a, 0]) & np.isfinite(second.other[b, 0]))
    error = two_view.sampson_squared(two_view.essential_of(below), first.other[a[seen]], second.other[b[seen]])
    good[seen] &= error < limit
    return a[good], b[good]


def _without_points(
    rig: Rig,
    first: View,
    second: View,
    seeds: Putative,
    near: tuple[Ints, Ints] | None,
    prior: Motion | None,
    options: MatchOptions,
) -> PairMatch:
    found = two_view.fit(first.xy[seeds.first], second.xy[seeds.second], options.verify_px / rig.focal(0))
    if found is None or found.inlier.sum() < options.min_inliers:
        return _failed(len(seeds), Reason.FEW_INLIERS)
    choices = two_view.motions_of(found, first.xy[seeds.first], second.xy[seeds.second])
    if not choices:
        return _failed(len(seeds), Reason.FEW_INLIERS)
    inlier = found.inlier
    motion = mono_motion.choose(choices, (first.xy[seeds.first[inlier]], second.xy[seeds.second[inlier]]), prior, first.normal)
    kept = Putative(seeds.first[inlier], seeds.second[inlier], seeds.distance[inlier])
    near = (seeds.first, seeds.second) if near is None else near
    near = _on_lines(rig, first, second, motion.second_from_first, options, *near)
    distance = sparse_distance(first.descriptor, second.descriptor, *near)
    kept = _joined(kept, best_of_candidates(*near, distance, options.guided_ratio, options.max_distance))
    return PairMatch(kept.first, kept.second, kept.distance, len(seeds), Reason.MATCHED, motion, scaled=False)


def _joined(kept: Putative, more: Putative) -> Putative:
    """`kept`, and those of `more` that share no feature with it. A homography keeps what lies on the plane; structures that
    stand off it come back along the epipolar lines of its motion."""
    new = ~np.isin(more.first, kept.first) & ~np.isin(more.second, kept.second)
    first, second = np.r_[kept.first, more.first[new]], np.r_[kept.second, more.second[new]]
    return Putative(first, second, np.r_[kept.distance, more.distance[new]])


def _failed(putative: int, reason: Reason) -> PairMatch:
    return PairMatch(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.float32), putative, reason)
