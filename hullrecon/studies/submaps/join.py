# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Joining and fusion of maps: one frame, common landmarks, one map [Aulinas2011 3.3.3]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.association.point_sets import Pair, PointSets, rows_of
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import update_state
from hullrecon.studies.submaps.global_map import GlobalMap, Submap
from hullrecon.studies.submaps.models import place, place_by_pose, rotation, wrap
from hullrecon.typing import Array

ITERATIONS = 3  # of an update
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
    """The transforms and the landmarks of two submaps in one state, each in its own frame."""

    mean: Array  # (g + 2n + 2m,)
    covariance: Array
    first: Submap
    second: Submap

    @property
    def parts(self) -> tuple[slice, slice, slice]:
        """Rows of the transforms, of the first's landmarks and of the second's."""
        split = len(self.mean) - 2 * self.second.count
        cut = split - 2 * self.first.count
        return slice(0, cut), slice(cut, split), slice(split, None)

    def moved(self, mean: Array) -> tuple[Array, Array]:
        """Refer the second's landmarks of a state to the first's frame, with the derivative.

        Returns
        -------
        Array
            The landmarks (m, 2).
        Array
            Derivative (2m, g + 2n + 2m) by the state: J_T and J_j of (3.14), chained.
        """
        links, _, own = self.parts
        world = GlobalMap()
        world.mean = mean[links]
        transform, by_links = world.relative(self.first.base, self.second.base)
        points = mean[own].reshape(-1, 2)
        jacobian = np.zeros((2 * len(points), len(mean)))
        jacobian[:, links] = place_by_pose(transform, points) @ by_links
        jacobian[:, own] = np.kron(np.eye(len(points)), rotation(transform[2]))
        return place(transform, points), jacobian

    def point_sets(self) -> PointSets:
        """Give both maps' landmarks in the first's frame, to be paired."""
        _, held, _ = self.parts
        points, jacobian = self.moved(self.mean)
        carried = self.covariance @ jacobian.T
        return PointSets(
            first=self.mean[held].reshape(-1, 2),
            second=points,
            first_covariance=self.covariance[held, held],
            second_covariance=jacobian @ carried,
            cross_covariance=carried[held],
        )


def join(world: GlobalMap, first: Submap, second: Submap, effort: Effort) -> Joined:
    """Put two submaps and the transforms between them into one state (3.13).

    The thesis takes both maps and the chain between them for independent. They are at first but
    for the transform that ends a map, and no longer after a fusion: the correlations are kept.
    """
    held, own = first.with_transforms(world), second.with_transforms(world)
    # both are independent but for the transforms
    between = first.gain @ own[:, : len(first.given)].T
    effort.count(len(world.mean), len(world.mean), 2 * second.count)
    return Joined(
        mean=np.concatenate([world.mean, first.now(world), second.now(world)]),
        covariance=np.block(
            [
                [world.covariance, held.T, own.T],
                [held, first.covariance(world), between],
                [own, between.T, second.covariance(world)],
            ]
        ),
        first=first,
        second=second,
    )


def fuse(world: GlobalMap, joined: Joined, pairs: tuple[Pair, ...], effort: Effort) -> Submap:
    """Make two joined submaps one, given their common landmarks, and update the global map.

    Both estimates of a common landmark are the same place: an observation of their difference,
    which is zero (3.15). One update corrects the landmarks and the transforms.
    """
    first, second = joined.first, joined.second
    mean, covariance = _update(joined, pairs, effort)
    links, held, _ = joined.parts
    updated = Joined(mean=mean, covariance=covariance, first=first, second=second)
    points, jacobian = updated.moved(mean)
    # each common landmark once
    mates = {second_point for _, second_point in pairs}
    left = [j for j in range(second.count) if j not in mates]
    rows = rows_of(left, 2)
    kept = np.concatenate([np.eye(len(mean))[held], jacobian[rows]])
    carried = kept @ covariance
    spread = carried @ kept.T
    world.mean, world.covariance = mean[links].copy(), covariance[links, links].copy()
    gain = np.asarray(np.linalg.solve(world.covariance, carried[:, links].T).T)
    size = len(world.mean)
    effort.count(size, size, size + len(kept))
    rest = spread - gain @ carried[:, links].T
    return Submap(
        base=first.base,
        frames=tuple(sorted({*first.frames, *second.frames})),
        mean=np.concatenate([mean[held], points.ravel()[rows]]),
        gain=gain,
        given=world.mean.copy(),
        rest=(rest + rest.T) / 2,
        truth=first.truth + tuple(second.truth[j] for j in left),
    )


def _update(joined: Joined, pairs: tuple[Pair, ...], effort: Effort) -> tuple[Array, Array]:
    """Update by the pairs, linearised again where the update leads.

    A loop turns what lies behind a long chain by degrees; one update, as in the thesis, leaves
    maps that are surer than they may be (`submap-consistency`).
    """
    links, held, _ = joined.parts
    firsts, seconds = (list(side) for side in zip(*pairs, strict=True))
    rows, twins = rows_of(firsts, 2), rows_of(seconds, 2)
    state = joined.mean.copy()
    for _ in range(ITERATIONS):
        points, jacobian = joined.moved(state)
        by_state = jacobian[twins]
        by_state[np.arange(len(rows)), held.start + rows] -= 1.0
        carried = joined.covariance @ by_state.T
        spread = by_state @ carried + SAME_M2 * np.eye(len(rows))
        difference = points.ravel()[twins] - state[held][rows]
        change = joined.mean - state
        change[2 : links.stop : 3] = wrap(change[2 : links.stop : 3])
        mean, covariance = joined.mean.copy(), joined.covariance.copy()
        update_state(mean, covariance, carried, spread, -difference - by_state @ change)
        mean[2 : links.stop : 3] = wrap(mean[2 : links.stop : 3])
        state = mean
        effort.count(len(mean), len(mean), len(rows))
    return mean, covariance
