# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Joining of maps that follow each other: one after the other, or in a binary tree.

Local map joining (LMJ) of [Tardos2002] adds each map to one that grows. Divide and conquer (DCS)
of [Paz2007] joins two maps of the same size at a time, which costs less while maps are small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.association.point_sets import PointSets
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, update_state
from hullrecon.studies.submaps.join import SAME_M2
from hullrecon.studies.submaps.loops import pair_maps
from hullrecon.studies.submaps.models import (
    compose,
    compose_jacobians,
    place,
    place_by_points,
    place_by_pose,
    wrap,
)
from hullrecon.typing import Array

SEED = 5  # of random draws


@dataclass(frozen=True, kw_only=True)
class PlainMap:
    """The car's last pose and landmarks, in the frame of the map's start."""

    mean: Array  # (3 + 2n,) x, y, heading, then the landmarks
    covariance: Array  # (3 + 2n, 3 + 2n)
    truth: tuple[int, ...]  # numbers of the true landmarks, only for judging

    @property
    def points(self) -> Array:
        """Places of the landmarks (n, 2)."""
        return self.mean[3:].reshape(-1, 2)


def plain_map(built: EkfMap) -> PlainMap:
    """Take the state of a finished submap over, as joining needs no more."""
    return PlainMap(mean=built.mean, covariance=built.covariance, truth=tuple(built.truth))


def join_next(
    first: PlainMap, second: PlainMap, effort: Effort, rng: np.random.Generator
) -> PlainMap:
    """Join a map with the one that starts where it ends, and fuse their common landmarks.

    The transform between them is the first map's last pose: its covariance, and its correlation
    with the first map's landmarks, are in J_i P_i J_i' of (3.13).
    """
    mean, covariance = _one_frame(first, second)
    effort.count(len(mean), len(mean), 3)
    split = 3 + 2 * len(first.truth)
    sets = PointSets(
        first=mean[3:split].reshape(-1, 2),
        second=mean[split:].reshape(-1, 2),
        first_covariance=covariance[3:split, 3:split],
        second_covariance=covariance[split:, split:],
        cross_covariance=covariance[3:split, split:],
    )
    with effort.stage("association"):
        pairs = pair_maps(sets, rng).pairs
    if not pairs:
        return PlainMap(mean=mean, covariance=covariance, truth=first.truth + second.truth)
    firsts, seconds = np.array(pairs).T
    rows = (3 + 2 * firsts[:, None] + np.arange(2)).ravel()
    twins = (split + 2 * seconds[:, None] + np.arange(2)).ravel()
    carried = covariance[:, twins] - covariance[:, rows]
    spread = carried[twins] - carried[rows] + SAME_M2 * np.eye(len(rows))
    update_state(mean, covariance, carried, spread, mean[rows] - mean[twins])
    mean[2] = wrap(mean[2])
    effort.count(len(mean), len(mean), len(rows))
    kept = np.setdiff1d(np.arange(len(mean)), twins)
    left = tuple(number for j, number in enumerate(second.truth) if j not in set(seconds))
    return PlainMap(
        mean=mean[kept], covariance=covariance[np.ix_(kept, kept)], truth=first.truth + left
    )


def _one_frame(first: PlainMap, second: PlainMap) -> tuple[Array, Array]:
    """Refer both maps to the first's frame: mean and covariance of the joint state.

    It holds the second map's last pose, the first map's landmarks, then the second map's.
    """
    pose, own = first.mean[:3], first.covariance
    by_first, by_second = compose_jacobians(pose, second.mean[:3])
    # the rows that move with the first's last pose: J_i of (3.14), which is one elsewhere
    moved_by = np.concatenate([by_first, place_by_pose(pose, second.points)])
    size = len(second.mean)
    turned = np.zeros((size, size))  # J_j of (3.14)
    turned[:3, :3] = by_second
    turned[3:, 3:] = place_by_points(pose, len(second.truth))
    block = moved_by @ own[:3, :3] @ moved_by.T + turned @ second.covariance @ turned.T
    across = own[3:, :3] @ moved_by.T
    mean = np.concatenate(
        [compose(pose, second.mean[:3]), first.mean[3:], place(pose, second.points).ravel()]
    )
    covariance = np.block(
        [
            [block[:3, :3], across[:, :3].T, block[:3, 3:]],
            [across[:, :3], own[3:, 3:], across[:, 3:]],
            [block[3:, :3], across[:, 3:].T, block[3:, 3:]],
        ]
    )
    return mean, covariance


class JoinedSequence:
    """Maps in a row that are joined as soon as a rule says so."""

    def __init__(self, effort: Effort, tree: bool) -> None:
        """Start without maps.

        tree: join maps of the same size only (DCS), or each new map with the one before (LMJ).
        """
        self._effort, self._tree = effort, tree
        self._rng = np.random.default_rng(SEED)
        self._maps: list[tuple[int, PlainMap]] = []  # submaps that each was made from

    def add(self, built: EkfMap) -> None:
        """Add a submap, and join: all at once, or those made from as many submaps."""
        self._maps.append((1, plain_map(built)))
        while len(self._maps) > 1 and not (self._tree and self._maps[-2][0] != self._maps[-1][0]):
            self._join_last()

    def finish(self) -> None:
        """Join what is left into one map."""
        while len(self._maps) > 1:
            self._join_last()

    def _join_last(self) -> None:
        """Join the last two maps."""
        (count, first), (last_count, last) = self._maps[-2:]
        with self._effort.stage("global"):
            joined = join_next(first, last, self._effort, self._rng)
        self._maps[-2:] = [(count + last_count, joined)]

    def last_frame(self) -> tuple[Array, Array]:
        """Compute where the last map ended, with covariance, in the mission's frame."""
        pose, covariance = np.zeros(3), np.zeros((3, 3))
        for _, built in self._maps:
            by_pose, by_link = compose_jacobians(pose, built.mean[:3])
            own = by_link @ built.covariance[:3, :3] @ by_link.T
            covariance = by_pose @ covariance @ by_pose.T + own
            pose = compose(pose, built.mean[:3])
        return pose, covariance

    def landmarks(self) -> list[tuple[int, Array]]:
        """List the landmarks of each map: number of the true one, place (2,) m in the mission."""
        pose, places = np.zeros(3), []
        for _, built in self._maps:
            places += list(zip(built.truth, place(pose, built.points), strict=True))
            pose = compose(pose, built.mean[:3])
        return places
