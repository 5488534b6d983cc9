# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Match two nodes: search within navigation's ellipses, robust motion, guided search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints
from hullrecon.vision.features.descriptors import (
    FeatureSet,
    MatchDescriptors,
    Putative,
    match_descriptors,
)
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs import mono_inliers, pose_from_points, two_view
from hullrecon.vision.pairs.gating import Motion, in_ellipse, transfer
from hullrecon.vision.pairs.pair_match import PairMatch, Reason, agrees, failed_match
from hullrecon.vision.pairs.stereo_adjustment import (
    CalibrationEvidence,
    NodeObservations,
    adjust_stereo_motion,
)
from hullrecon.vision.stereo.node_view import NodeView

VERIFY_PX = 1.0  # largest distance of a match from its epipolar line once the motion is known
RANSAC_PX = 3.0  # largest reprojection error of an inlier's triangulated point in the other images
GATE_CHI2 = 9.21  # of the search ellipse: 99 % of a two-dimensional Gaussian
MIN_PUTATIVE = 8  # matches before verification, as many as an essential matrix takes
RANSAC_TRIALS = 400  # finds three inliers with 99.99 % where 28 % of the matches are right
SEEDS = 500  # features used for the first motion when a prior is known; the guided search takes all
FEW = 100  # with fewer seeds the first motion is rough, and the guided search is repeated
ADJUSTED = 500  # matches that the motion is adjusted to: more add no information
# Largest chi-square (six degrees of freedom) of a motion's difference from navigation's. Far beyond
# chance (22.5 is 99.9 %), as navigation's sigmas do not cover all its errors.
NAVIGATION_CHI2 = 50.0


@dataclass(frozen=True)
class MatchStrategy:
    """The parts of matching that hullrecon/studies replaces by published variants."""

    match_descriptors: MatchDescriptors = match_descriptors
    # two-view model of ideal coordinates (n, 2) of both images, given a tolerance
    fit_two_views: Callable[[Array, Array, float], two_view.TwoView | None] = two_view.fit


@dataclass(frozen=True)
class PairMatcher:
    """Matches nodes of one rig."""

    rig: Rig
    options: MatchOptions
    strategy: MatchStrategy = field(default_factory=MatchStrategy)

    @cached_property
    def bottom_from_top(self) -> Array:
        """Motion (4, 4) from the top camera to the bottom one, the identity with one camera."""
        return self.rig.from_top(Camera.BOTTOM)

    @cached_property
    def tolerance(self) -> float:
        """RANSAC_PX in ideal coordinates."""
        return RANSAC_PX / self.rig.focal_px(Camera.TOP)

    def match(
        self,
        first: NodeView,
        second: NodeView,
        prior: Motion | None,
        seed: tuple[int, ...],
        full_search: bool,
    ) -> PairMatch:
        """Find the features that two nodes have in common, and the motion of the leading camera.

        The pair fails where too few features match or agree with one motion, and where that motion
        contradicts the prior. The result then holds the reason.

        Parameters
        ----------
        first, second
            The nodes.
        prior
            Navigation's motion between them, near which features are searched. None where unknown:
            the whole image is searched.
        seed
            Seeds the random draws, so that a pair always gives the same result.
        full_search
            Search the whole image where the search near the prior finds nothing.
        """
        if min(len(first), len(second)) < MIN_PUTATIVE:
            return failed_match(0, Reason.NO_FEATURES)
        result = self._match(first, second, prior, seed)
        if prior is not None and full_search and result.reason is not Reason.MATCHED:
            result = self._match(first, second, None, seed)
        if prior is None or result.motion is None or agrees(result, prior, NAVIGATION_CHI2):
            return result
        return failed_match(result.putative, Reason.AGAINST_NAVIGATION)

    def _match(
        self, first: NodeView, second: NodeView, prior: Motion | None, seed: tuple[int, ...]
    ) -> PairMatch:
        """Match by triangulated points of both nodes, else of one, else two views without depth.

        Two views give the direction of the motion alone, so they come last. prior: navigation's
        motion, which bounds the search. seed: of RANSAC's draws.
        """
        # Use the triangulated points of both nodes.
        if first.stereo.any() and second.stereo.any():
            result = self._match_points(first, second, prior, seed)
            if result.reason is Reason.MATCHED:
                return result
        everywhere = np.arange(len(first)), np.arange(len(second))
        gated = self._gate(first, second, prior, *everywhere)
        seeds = self._match_descriptors(first, second, gated, *everywhere)
        if len(seeds) < MIN_PUTATIVE:
            return failed_match(len(seeds), Reason.FEW_PUTATIVE)
        # Where these are too few, use the triangulated points of one node.
        with_point = max(
            int(first.stereo[seeds.first].sum()), int(second.stereo[seeds.second].sum())
        )
        if with_point >= max(MIN_PUTATIVE, self.options.min_inliers):
            views = self.reprojection_terms(first, second, seeds)
            start = self._resect(first, second, seeds)
            return self._refine_and_guide(first, second, seeds, views, start)
        # Where these are too few as well, use two views without depth.
        return self._match_two_views(first, second, seeds, gated, prior)

    def _match_points(
        self, first: NodeView, second: NodeView, prior: Motion | None, seed: tuple[int, ...]
    ) -> PairMatch:
        """Match features that have triangulated points in both nodes, by RANSAC on these points.

        With a prior, about SEEDS features are enough: the guided search finds the others. prior,
        seed: as of `_match`.
        """
        rows = np.flatnonzero(first.stereo)
        if prior is not None:
            rows = rows[:: max(1, len(rows) // SEEDS)]
        among = np.flatnonzero(second.stereo)
        gated = self._gate(first, second, prior, rows, among)
        seeds = self._match_descriptors(first, second, gated, rows, among)
        if len(seeds) < MIN_PUTATIVE:
            return failed_match(len(seeds), Reason.FEW_PUTATIVE)
        views = self.reprojection_terms(first, second, seeds)
        start = pose_from_points.ransac(
            first.point[seeds.first],
            second.point[seeds.second],
            views,
            self.tolerance,
            RANSAC_TRIALS,
            seed,
        )
        return self._refine_and_guide(first, second, seeds, views, start)

    def _gate(
        self, first: NodeView, second: NodeView, prior: Motion | None, rows: Ints, among: Ints
    ) -> tuple[Ints, Ints] | None:
        """Pair features of the first node with those of the second where they are expected.

        That is where navigation and depth predict them. None without prior or depth: every feature
        may then match every other. rows, among: features of the first and of the second node that
        are considered. Returns the pairs (k,): features of the first node, and of the second.
        """
        if prior is None or not np.isfinite(first.depth[rows]).any():
            return None
        return self._within_ellipses(first, second, prior, rows, among)

    def _match_descriptors(
        self,
        first: NodeView,
        second: NodeView,
        allowed: tuple[Ints, Ints] | None,
        rows: Ints,
        among: Ints,
    ) -> Putative:
        """Match descriptors of the allowed pairs of features, or of all `rows` with all `among`.

        rows, among: features of the first and of the second view, which are matched where `allowed`
        is None.
        """
        if allowed is not None:
            return self.strategy.match_descriptors(first, second, allowed)
        of_first = FeatureSet(descriptor=first.descriptor[rows], place=first.place[rows])
        of_second = FeatureSet(descriptor=second.descriptor[among], place=second.place[among])
        return self.strategy.match_descriptors(of_first, of_second, None)

    def _within_ellipses(
        self, first: NodeView, second: NodeView, motion: Motion, rows: Ints, among: Ints
    ) -> tuple[Ints, Ints]:
        """Pair each feature of `rows` with those of `among` inside its search ellipse.

        The ellipse is where the motion and the feature's depth put it in the second camera, within
        their covariance (GATE_CHI2). Features without a depth are left out. Returns the pairs (k,):
        features of the first node, and of the second.
        """
        sigma = self.options.sigma_px / self.rig.focal_px(first.camera)
        mean, covariance = transfer(
            motion, first.xy[rows], first.depth[rows], first.depth_sigma[rows], sigma
        )
        known = np.flatnonzero(np.isfinite(mean).all(axis=1))
        a, b = in_ellipse(mean[known], covariance[known], second.xy[among], GATE_CHI2)
        return rows[known][a], among[b]

    def _refine_and_guide(
        self,
        first: NodeView,
        second: NodeView,
        seeds: Putative,
        views: list[pose_from_points.ObservedPoints],
        start: Array | None,
    ) -> PairMatch:
        """Refine a first guess of the motion, then match all features guided by it.

        The pair fails without a guess, or where fewer than min_inliers features agree with the
        motion.

        Parameters
        ----------
        first, second
            The nodes.
        seeds
            Matches that the first guess was found from.
        views
            Triangulated points of the seeds with their observations (`reprojection_terms`).
        start
            First guess of second_from_first (4, 4), None where none was found.
        """
        if start is None:
            return failed_match(len(seeds), Reason.FEW_INLIERS)
        motion = Motion(*pose_from_points.refine(start, views, self.tolerance))
        inliers = _count_inliers(motion.second_from_first, views, self.tolerance, len(seeds))
        if inliers < self.options.min_inliers:
            return failed_match(len(seeds), Reason.FEW_INLIERS)
        # The motion of few seeds is rough, so that the lines are off. It is guided once more by the
        # motion of all the features found.
        matched = self.search_along(first, second, motion)
        motion, calibration = self._adjust(first, second, matched, motion)
        if len(seeds) < FEW:
            matched = self.search_along(first, second, motion)
            motion, calibration = self._adjust(first, second, matched, motion)
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
        """Adjust the motion to at most about ADJUSTED of the matches, and compute its covariance.

        Also returned is how much the matches say of the stereo calibration. Where too few of them
        have a stereo point or agree, the motion is unchanged and there is no such evidence.
        """
        matched = matched.take(slice(None, None, max(1, len(matched) // ADJUSTED)))
        of_first, of_second = (
            NodeObservations(lead=view.xy[rows], other=view.other[rows], point=view.point[rows])
            for view, rows in ((first, matched.first), (second, matched.second))
        )
        found = adjust_stereo_motion(
            motion.second_from_first, of_first, of_second, self.bottom_from_top
        )
        if found is None:
            return motion, None
        return Motion(found.second_from_first, found.covariance), found.calibration

    def reprojection_terms(
        self, first: NodeView, second: NodeView, seeds: Putative
    ) -> list[pose_from_points.ObservedPoints]:
        """Collect each node's points with their observations in the opposite node's cameras.

        Four terms: points of either node, seen by the leading and by the bottom camera of the
        other. A motion is judged by all of them together. A row is not seen where its point or its
        observation is missing.
        """
        a, b = seeds.first, seeds.second
        lead, bottom = np.eye(4), self.bottom_from_top
        # Points, observations, the observing camera from its node's leading one, and whether the
        # points are the second node's.
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
        """Find the motion by P3P in RANSAC, from the points of the node that has more of them.

        Returns second_from_first (4, 4), None where no motion fits.
        """
        a, b = seeds.first, seeds.second
        forward, backward = first.stereo[a], second.stereo[b]
        if forward.sum() >= backward.sum():
            return pose_from_points.resect(
                first.point[a[forward]], second.xy[b[forward]], self.tolerance, RANSAC_TRIALS
            )
        motion = pose_from_points.resect(
            second.point[b[backward]], first.xy[a[backward]], self.tolerance, RANSAC_TRIALS
        )
        return None if motion is None else np.asarray(np.linalg.inv(motion))

    def search_along(self, first: NodeView, second: NodeView, motion: Motion) -> Putative:
        """Match all features near the epipolar lines of a known motion.

        So all common features are found, not only the seeds of the motion. Where both cameras saw a
        feature, it must be near the lines of both.
        """
        # The motion is no more accurate than the lens model: half a feature's sigma, rad and m.
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
        """Match descriptors of those pairs (a, b) that are near each other's epipolar lines.

        motion: second_from_first (4, 4). a, b: (k,) features of the first node, and of the second.
        """
        limit = (VERIFY_PX / self.rig.focal_px(Camera.TOP)) ** 2
        essential = two_view.essential_of(motion)
        good = two_view.sampson_squared(essential, first.xy[a], second.xy[b]) < limit
        # The same motion, as the bottom cameras make it.
        of_bottom = self.bottom_from_top @ motion @ np.linalg.inv(self.bottom_from_top)
        seen = np.flatnonzero(np.isfinite(first.other[a, 0]) & np.isfinite(second.other[b, 0]))
        error = two_view.sampson_squared(
            two_view.essential_of(of_bottom), first.other[a[seen]], second.other[b[seen]]
        )
        good[seen] &= error < limit
        return self.strategy.match_descriptors(first, second, (a[good], b[good]))

    def _match_two_views(
        self,
        first: NodeView,
        second: NodeView,
        seeds: Putative,
        gated: tuple[Ints, Ints] | None,
        prior: Motion | None,
    ) -> PairMatch:
        """Match by two-view geometry alone, with navigation's length of the motion.

        The pair fails where too few matches fit one geometry. Where a rotation alone explains them,
        the result has common features but no motion (NO_MOTION).

        Parameters
        ----------
        first, second
            The nodes.
        seeds
            Putative matches.
        gated
            Pairs of features that navigation and depth allow, None for those of the seeds alone.
        prior
            Navigation's motion, which helps to choose inliers and gives the length. None where
            unknown: the length is then 1.
        """
        few = failed_match(len(seeds), Reason.FEW_INLIERS)
        xy = first.xy[seeds.first], second.xy[seeds.second]
        tolerance = VERIFY_PX / self.rig.focal_px(Camera.TOP)
        found = self.strategy.fit_two_views(*xy, tolerance)
        if found is None or found.inlier.sum() < self.options.min_inliers:
            return few
        possible = two_view.motions_of(found, *xy)
        if not possible:
            return few
        possible = [p for p in possible if p.motion[:3, 3].any()]
        if not possible:
            # a rotation alone explains the matches: they show the same place, but no motion
            still = seeds.take(found.inlier)
            return PairMatch(
                first=still.first,
                second=still.second,
                distance=still.distance,
                putative=len(seeds),
                reason=Reason.NO_MOTION,
            )
        motion = mono_inliers.choose(
            possible, (xy[0][found.inlier], xy[1][found.inlier]), prior, first.normal
        )
        motion, inlier = mono_inliers.gather(motion, *xy, prior, tolerance)
        if inlier.sum() < self.options.min_inliers:
            return few
        near = (seeds.first, seeds.second) if gated is None else gated
        kept = _add_unmatched(
            seeds.take(inlier), self._best_on_lines(first, second, motion.second_from_first, *near)
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


def _count_inliers(
    motion: Array, views: list[pose_from_points.ObservedPoints], tolerance: float, count: int
) -> int:
    """Count the seeds that fit the motion in every image in which they were seen.

    motion: second_from_first (4, 4). views: rows of the seeds. tolerance: largest error, ideal
    coordinates. count: number of seeds. Seeds without any observation do not count.
    """
    good, observed = np.ones(count, bool), np.zeros(count, bool)
    for view in views:
        seen = np.isfinite(view.xy[:, 0])
        good &= ~seen | (pose_from_points.squared_errors(motion[None], view)[0] < tolerance**2)
        observed |= seen
    return int((good & observed).sum())


def _add_unmatched(kept: Putative, more: Putative) -> Putative:
    """Add to the matches `kept` those of `more` that share no feature with them.

    A homography has only the features on its plane as inliers. Features of structures that stand
    off the plane are found along the epipolar lines of its motion.
    """
    new = more.take(~np.isin(more.first, kept.first) & ~np.isin(more.second, kept.second))
    return Putative(
        first=np.r_[kept.first, new.first],
        second=np.r_[kept.second, new.second],
        distance=np.r_[kept.distance, new.distance],
    )
