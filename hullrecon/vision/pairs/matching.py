# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two nodes matched: search within navigation's ellipse, robust motion, then a guided search along
the motion found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints
from hullrecon.vision.features.descriptors import Putative, best_of_pairs, sparse_distance
from hullrecon.vision.features.kinds import best_of_each_kind, like_pairs, limit_corners
from hullrecon.vision.features.places import match_places
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pair_match import PairMatch, Reason, agrees, failed_match
from hullrecon.vision.pairs import mono_inliers, pose_from_points, two_view
from hullrecon.vision.pairs.gated_search import in_ellipse
from hullrecon.vision.pairs.gating import Motion, transfer
from hullrecon.vision.pairs.stereo_adjustment import (
    CalibrationEvidence,
    NodeObservations,
    adjust_stereo_motion,
)
from hullrecon.vision.stereo.node_view import NodeView

FEW = 100  # with fewer seeds the first motion is rough: what it guides to is worth a second look


@dataclass(frozen=True)
class PairMatcher:
    """Matches nodes of one rig. A `prior` is navigation's motion between the two nodes, None where
    it has none.
    """

    rig: Rig
    options: MatchOptions

    @property
    def tolerance(self) -> float:
        """Return how far a triangulated point may be from where a camera saw it, in ideal
        coordinates.
        """
        return self.options.ransac_px / self.rig.focal_px(Camera.TOP)

    def match(
        self,
        first: NodeView,
        second: NodeView,
        prior: Motion | None,
        seed: tuple[int, ...],
        full_search: bool,
    ) -> PairMatch:
        """Return the matches of two nodes.

        full_search: look everywhere when there is no prior, or when nothing is found where it
        points.
        """
        if min(len(first), len(second)) < self.options.min_putative:
            return failed_match(0, Reason.NO_FEATURES)
        tries = ([prior] if prior is not None else []) + (
            [None] if full_search or prior is None else []
        )
        result = failed_match(0, Reason.FEW_PUTATIVE)
        for expected in tries:
            result = self._match(first, second, expected, seed)
            if result.reason is Reason.MATCHED:
                break
        if (
            result.motion is not None
            and prior is not None
            and not agrees(result, prior, self.options.navigation_chi2)
        ):
            return failed_match(result.putative, Reason.AGAINST_NAVIGATION)
        return result

    def _match(
        self, first: NodeView, second: NodeView, prior: Motion | None, seed: tuple[int, ...]
    ) -> PairMatch:
        """Match by triangulated points of both sides; where too few, of one side; where too few of
        either, by two views.
        """
        result = failed_match(0, Reason.FEW_PUTATIVE)
        if first.stereo.any() and second.stereo.any():
            result = self._match_points(first, second, prior, seed)
        if result.reason is Reason.MATCHED:
            return result
        everywhere = np.arange(len(first)), np.arange(len(second))
        gated = self._gate(first, second, prior, *everywhere)
        seeds = self._best(first, second, gated, *everywhere)
        if not self._enough(seeds):
            return failed_match(len(seeds), Reason.FEW_PUTATIVE)
        with_point = max(
            int(first.stereo[seeds.first].sum()), int(second.stereo[seeds.second].sum())
        )
        if with_point >= max(self.options.min_putative, self.options.min_inliers):
            return self._refine_and_guide(first, second, seeds, self._resect(first, second, seeds))
        return self._match_two_views(first, second, seeds, gated, prior)

    def _match_points(
        self, first: NodeView, second: NodeView, prior: Motion | None, seed: tuple[int, ...]
    ) -> PairMatch:
        rows = np.flatnonzero(first.stereo)
        rows = rows[:: max(1, len(rows) // self.options.seeds)] if prior is not None else rows
        among = np.flatnonzero(second.stereo)
        seeds = self._best(
            first, second, self._gate(first, second, prior, rows, among), rows, among
        )
        start = None
        if self._enough(seeds):
            points = first.point[seeds.first], second.point[seeds.second]
            views = self.reprojection_terms(first, second, seeds)
            start = pose_from_points.ransac(
                *points, views, self.tolerance, self.options.ransac_trials, seed
            )
        return self._refine_and_guide(first, second, seeds, start)

    def _enough(self, seeds: Putative) -> bool:
        return len(seeds) >= self.options.min_putative

    def _gate(
        self, first: NodeView, second: NodeView, prior: Motion | None, rows: Ints, among: Ints
    ) -> tuple[Ints, Ints] | None:
        """Return the pairs that navigation and depth allow: in the 99 % ellipse of each row; None
        where they say nothing.
        """
        if prior is None or not np.isfinite(first.depth[rows]).any():
            return None
        return self._within_ellipses(first, second, prior, rows, among)

    def _best(
        self,
        first: NodeView,
        second: NodeView,
        allowed: tuple[Ints, Ints] | None,
        rows: Ints,
        among: Ints,
    ) -> Putative:
        """Return mutual best descriptors of those rows: of the pairs allowed, else of all within
        each kind.
        """
        ratio, most = self.options.ratio, self.options.max_distance
        if allowed is None:
            kinds = first.corner[rows], second.corner[among]
            found = best_of_each_kind(
                first.descriptor[rows], second.descriptor[among], *kinds, ratio, most
            )
            found = Putative(
                first=rows[found.first], second=among[found.second], distance=found.distance
            )
        else:
            found = best_of_pairs(
                *allowed,
                sparse_distance(first.descriptor, second.descriptor, *allowed),
                ratio,
                most,
            )
        found = match_places(found, first.place, second.place)
        return limit_corners(found, first.corner[found.first], self.options.harris_share)

    def _within_ellipses(
        self, first: NodeView, second: NodeView, motion: Motion, rows: Ints, among: Ints
    ) -> tuple[Ints, Ints]:
        """Return the pairs of one kind that lie in the ellipse of each row."""
        sigma = self.options.sigma_px / self.rig.focal_px(first.camera)
        mean, covariance = transfer(
            motion, first.xy[rows], first.depth[rows], first.depth_sigma[rows], sigma
        )
        known = np.flatnonzero(np.isfinite(mean).all(axis=1))
        a, b = in_ellipse(mean[known], covariance[known], second.xy[among], self.options.gate_chi2)
        return like_pairs(rows[known][a], among[b], first.corner, second.corner)

    def _refine_and_guide(
        self, first: NodeView, second: NodeView, seeds: Putative, start: Array | None
    ) -> PairMatch:
        """Return the matches to which a first guess of the motion leads, once it is refined."""
        if start is None:
            return failed_match(
                len(seeds), Reason.FEW_INLIERS if self._enough(seeds) else Reason.FEW_PUTATIVE
            )
        views = self.reprojection_terms(first, second, seeds)
        motion = Motion(*pose_from_points.refine(start, views, self.tolerance))
        if (
            _count_inliers(motion.second_from_first, views, self.tolerance, len(seeds))
            < self.options.min_inliers
        ):
            return failed_match(len(seeds), Reason.FEW_INLIERS)
        matched = self.search_along(first, second, motion)
        motion, calibration = self._adjust(first, second, _take_evenly(matched), motion)
        if len(seeds) < FEW:
            matched = self.search_along(first, second, motion)
            motion, calibration = self._adjust(first, second, _take_evenly(matched), motion)
        if len(matched) < self.options.min_inliers:
            return failed_match(len(seeds), Reason.FEW_INLIERS)
        return PairMatch(
            first=matched.first,
            second=matched.second,
            distance=matched.distance,
            putative=len(seeds),
            reason=Reason.MATCHED,
            motion=motion,
            calibration=calibration,
        )

    def _adjust(
        self, first: NodeView, second: NodeView, matched: Putative, motion: Motion
    ) -> tuple[Motion, CalibrationEvidence | None]:
        """Return the motion adjusted to the matches, and what it says of the calibration; as it is
        where they are too few.
        """
        here, there = (
            NodeObservations(lead=view.xy[rows], other=view.other[rows], point=view.point[rows])
            for view, rows in ((first, matched.first), (second, matched.second))
        )
        found = adjust_stereo_motion(
            motion.second_from_first, here, there, self.rig.from_top(Camera.BOTTOM)
        )
        return (
            (motion, None)
            if found is None
            else (Motion(found.second_from_first, found.covariance), found.calibration)
        )

    def reprojection_terms(
        self, first: NodeView, second: NodeView, seeds: Putative
    ) -> list[pose_from_points.ObservedPoints]:
        """Return each node's points as the other node's leading camera, and its bottom camera, saw
        them.
        """
        a, b = seeds.first, seeds.second
        lead, bottom = np.eye(4), self.rig.from_top(Camera.BOTTOM)
        terms = [
            (first.point[a], second.xy[b], lead, False),
            (first.point[a], second.other[b], bottom, False),
            (second.point[b], first.xy[a], lead, True),
            (second.point[b], first.other[a], bottom, True),
        ]
        return [
            pose_from_points.hide_unknown_points(
                pose_from_points.ObservedPoints(
                    points=points,
                    xy=xy,
                    camera_from_node=camera,
                    backward=backward,
                    baseline_m=self.rig.baseline_m,
                )
            )
            for points, xy, camera, backward in terms
        ]

    def _resect(self, first: NodeView, second: NodeView, seeds: Putative) -> Array | None:
        """Return the motion from the points of the side that has more of them, seen in the other
        (P3P in RANSAC).
        """
        a, b, trials = seeds.first, seeds.second, self.options.ransac_trials
        forward, backward = first.stereo[a], second.stereo[b]
        if forward.sum() >= backward.sum():
            return pose_from_points.resect(
                first.point[a[forward]], second.xy[b[forward]], self.tolerance, trials
            )
        motion = pose_from_points.resect(
            second.point[b[backward]], first.xy[a[backward]], self.tolerance, trials
        )
        return None if motion is None else np.asarray(np.linalg.inv(motion))

    def search_along(self, first: NodeView, second: NodeView, motion: Motion) -> Putative:
        """Return the matches of all features, each searched where the motion puts it and held to
        its epipolar line, in both cameras where both saw it.
        """
        # the motion is not better than its model
        sigma = 0.5 * self.options.sigma_px / self.rig.focal_px(Camera.TOP)
        loose = Motion(
            motion.second_from_first, motion.covariance + np.diag(np.repeat([sigma**2], 6))
        )
        near = self._within_ellipses(
            first, second, loose, np.arange(len(first)), np.arange(len(second))
        )
        return self._best_on_lines(first, second, motion.second_from_first, *near)

    def _best_on_lines(
        self, first: NodeView, second: NodeView, motion: Array, a: Ints, b: Ints
    ) -> Putative:
        """Return mutual best descriptors of the pairs (a, b) that lie on each other's epipolar
        lines.
        """
        limit = (self.options.verify_px / self.rig.focal_px(Camera.TOP)) ** 2
        good = (
            two_view.sampson_squared(two_view.essential_of(motion), first.xy[a], second.xy[b])
            < limit
        )
        bottom_from_top = self.rig.from_top(Camera.BOTTOM)
        of_bottom = bottom_from_top @ motion @ np.linalg.inv(bottom_from_top)
        seen = np.flatnonzero(np.isfinite(first.other[a, 0]) & np.isfinite(second.other[b, 0]))
        error = two_view.sampson_squared(
            two_view.essential_of(of_bottom), first.other[a[seen]], second.other[b[seen]]
        )
        good[seen] &= error < limit
        near = a[good], b[good]
        distance = sparse_distance(first.descriptor, second.descriptor, *near)
        found = best_of_pairs(*near, distance, self.options.guided_ratio, self.options.max_distance)
        found = match_places(found, first.place, second.place)
        return limit_corners(found, first.corner[found.first], self.options.harris_share)

    def _match_two_views(
        self,
        first: NodeView,
        second: NodeView,
        seeds: Putative,
        gated: tuple[Ints, Ints] | None,
        prior: Motion | None,
    ) -> PairMatch:
        """Match by two-view geometry alone; the motion's length is navigation's."""
        xy = first.xy[seeds.first], second.xy[seeds.second]
        tolerance = self.options.verify_px / self.rig.focal_px(Camera.TOP)
        found = two_view.fit(*xy, tolerance, self.options.two_view_model)
        possible = [] if found is None else two_view.motions_of(found, *xy)
        if found is None or found.inlier.sum() < self.options.min_inliers or not possible:
            return failed_match(len(seeds), Reason.FEW_INLIERS)
        possible = [p for p in possible if p.motion[:3, 3].any()]
        if not possible:
            return PairMatch(
                first=seeds.first[found.inlier],
                second=seeds.second[found.inlier],
                distance=seeds.distance[found.inlier],
                putative=len(seeds),
                reason=Reason.NO_MOTION,
            )
        motion = mono_inliers.choose(
            possible, (xy[0][found.inlier], xy[1][found.inlier]), prior, first.normal
        )
        motion, inlier = mono_inliers.gather(motion, *xy, prior, tolerance)
        if inlier.sum() < self.options.min_inliers:
            return failed_match(len(seeds), Reason.FEW_INLIERS)
        kept = Putative(
            first=seeds.first[inlier], second=seeds.second[inlier], distance=seeds.distance[inlier]
        )
        near = (seeds.first, seeds.second) if gated is None else gated
        kept = _add_unmatched(
            kept, self._best_on_lines(first, second, motion.second_from_first, *near)
        )
        return PairMatch(
            first=kept.first,
            second=kept.second,
            distance=kept.distance,
            putative=len(seeds),
            reason=Reason.MATCHED,
            motion=motion,
            scaled=False,
        )


def _take_evenly(matched: Putative, most: int = 500) -> Putative:
    step = max(1, len(matched) // most)
    return Putative(
        first=matched.first[::step],
        second=matched.second[::step],
        distance=matched.distance[::step],
    )


def _count_inliers(
    motion: Array, views: list[pose_from_points.ObservedPoints], tolerance: float, count: int
) -> int:
    """Return how many seeds agree with the motion in every image that saw them."""
    good, observed = np.ones(count, bool), np.zeros(count, bool)
    for view in views:
        seen = np.isfinite(view.xy[:, 0])
        good &= ~seen | (pose_from_points.squared_errors(motion[None], view)[0] < tolerance**2)
        observed |= seen
    return int((good & observed).sum())


def _add_unmatched(kept: Putative, more: Putative) -> Putative:
    """Return `kept`, and those of `more` that share no feature with it.

    A homography keeps what lies on the plane; structures that stand off it come back along the
    epipolar lines of its motion.
    """
    new = ~np.isin(more.first, kept.first) & ~np.isin(more.second, kept.second)
    return Putative(
        first=np.r_[kept.first, more.first[new]],
        second=np.r_[kept.second, more.second[new]],
        distance=np.r_[kept.distance, more.distance[new]],
    )
