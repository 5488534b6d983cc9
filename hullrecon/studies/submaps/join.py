# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Joining and fusion of maps: one frame, common landmarks, one map [Aulinas2011 3.3.3]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.association.point_sets import Pair, PointSets
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import update_state
from hullrecon.studies.submaps.global_map import GlobalMap, Submap
from hullrecon.studies.submaps.models import place, place_by_pose, rotation, wrap
from hullrecon.typing import Array

SAME_M2 = 1e-8  # variance by which two estimates of one landmark may differ: none, but for rounding


def refer_to_base(
    points: Array, covariance: Array, transform: Array, transform_covariance: Array
) -> tuple[Array, Array]:
    """Refer landmarks (n, 2) to another frame (3.13, 3.14).

    The thesis prints J_j P_j J_j' alone. The chain of transforms between maps that do not follow
    each other is itself unsure: J_T P_T J_T' belongs to it.

    Returns
    -------
    Array
        The landmarks (n, 2) in the other frame.
    Array
        Their covariance (2n, 2n).
    """
    by_point = np.kron(np.eye(len(points)), rotation(transform[2]))  # J_j
    by_transform = place_by_pose(transform, points)  # J_T
    carried = by_transform @ transform_covariance @ by_transform.T
    return place(transform, points), by_point @ covariance @ by_point.T + carried


@dataclass(frozen=True, kw_only=True)
class Joined:
    """The transforms and the landmarks of two submaps in one state, both in the first's frame."""

    mean: Array  # (g + 2n + 2m,)
    covariance: Array
    transforms: int  # g
    first: Submap
    second: Submap

    def point_sets(self) -> PointSets:
        """Give both maps' landmarks as sets to be paired."""
        cut, split = self.transforms, self.transforms + 2 * self.first.count
        return PointSets(
            first=self.mean[cut:split].reshape(-1, 2),
            second=self.mean[split:].reshape(-1, 2),
            first_covariance=self.covariance[cut:split, cut:split],
            second_covariance=self.covariance[split:, split:],
            cross_covariance=self.covariance[cut:split, split:],
        )


def join(world: GlobalMap, first: Submap, second: Submap, effort: Effort) -> Joined:
    """Refer two submaps to the first's frame, in one state with the transforms (3.13).

    The thesis takes both maps and the chain between them for independent. They are at first but
    for the transform that ends a map, and no longer after a fusion: the correlations are kept.
    """
    size = len(world.mean)
    transform, by_links = world.relative(first.base, second.base)
    points = second.now(world).reshape(-1, 2)
    by_point = np.kron(np.eye(len(points)), rotation(transform[2]))
    by_transform = place_by_pose(transform, points) @ by_links
    cross = second.with_transforms(world)
    moved = by_point @ cross + by_transform @ world.covariance
    own = by_point @ second.covariance(world) @ by_point.T
    mixed = by_point @ cross @ by_transform.T
    own = own + mixed + mixed.T + by_transform @ world.covariance @ by_transform.T
    held = first.with_transforms(world)
    # both are independent but for the transforms
    between = first.gain @ moved[:, : len(first.given)].T
    effort.count(size, size, 2 * second.count)
    return Joined(
        mean=np.concatenate([world.mean, first.now(world), place(transform, points).ravel()]),
        covariance=np.block(
            [
                [world.covariance, held.T, moved.T],
                [held, first.covariance(world), between],
                [moved, between.T, own],
            ]
        ),
        transforms=size,
        first=first,
        second=second,
    )


def fuse(world: GlobalMap, joined: Joined, pairs: tuple[Pair, ...], effort: Effort) -> Submap:
    """Make two joined submaps one, given their common landmarks, and update the global map.

    Both estimates of a common landmark are the same place: an observation of their difference,
    which is zero (3.15). One update corrects the landmarks and the transforms.
    """
    first, second = joined.first, joined.second
    mean, covariance = joined.mean.copy(), joined.covariance.copy()
    rows, twins = _rows_of_pairs(joined, pairs)
    carried = covariance[:, twins] - covariance[:, rows]
    spread = carried[twins] - carried[rows] + SAME_M2 * np.eye(len(rows))
    update_state(mean, covariance, carried, spread, mean[rows] - mean[twins])
    effort.count(len(mean), len(mean), len(rows))
    cut = joined.transforms
    mean[2:cut:3] = wrap(mean[2:cut:3])
    world.mean, world.covariance = mean[:cut].copy(), covariance[:cut, :cut].copy()
    kept = np.setdiff1d(np.arange(cut, len(mean)), twins)  # each common landmark once
    mates = {second_point for _, second_point in pairs}
    left = tuple(number for j, number in enumerate(second.truth) if j not in mates)
    gain = np.asarray(np.linalg.solve(world.covariance, covariance[:cut, kept]).T)
    effort.count(cut, cut, cut + len(kept))
    rest = covariance[np.ix_(kept, kept)] - gain @ covariance[:cut, kept]
    return Submap(
        base=first.base,
        frames=tuple(sorted({*first.frames, *second.frames})),
        mean=mean[kept],
        gain=gain,
        given=world.mean.copy(),
        rest=(rest + rest.T) / 2,
        truth=first.truth + left,
    )


def _rows_of_pairs(joined: Joined, pairs: tuple[Pair, ...]) -> tuple[Array, Array]:
    cut, split = joined.transforms, joined.transforms + 2 * joined.first.count
    firsts, seconds = np.array(pairs).T
    both = np.arange(2)
    rows = (cut + 2 * firsts[:, None] + both).ravel()
    twins = (split + 2 * seconds[:, None] + both).ravel()
    return rows, twins
