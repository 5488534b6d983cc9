# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Joining and fusion of maps: one frame, common landmarks, one map [Aulinas2011 3.3.3]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.association.point_sets import Pair, PointSets, rows_of
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.global_map import GlobalMap, Submap
from hullrecon.studies.submaps.models import (
    place,
    place_by_points,
    place_by_pose,
    rotation,
    wrap,
)
from hullrecon.typing import Array, Ints

ITERATIONS = 3  # of an update
SAME_M2 = 1e-8  # variance by which two estimates of one landmark may differ: none, but for rounding


def refer_to_base(
    points: Array, covariance: Array, transform: Array, transform_covariance: Array
) -> tuple[Array, Array]:
    """Refer landmarks (n, 2) with covariance (2n, 2n) to another frame (3.13, 3.14).

    The thesis prints J_j P_j J_j' alone. The chain of transforms between maps that do not follow
    each other is itself unsure: J_T P_T J_T' belongs to it.

    Parameters
    ----------
    points, covariance
        The landmarks in their own frame.
    transform, transform_covariance
        Pose (3,) of their frame in the other, with its covariance (3, 3).

    Returns
    -------
    Array
        The landmarks (n, 2) in the other frame.
    Array
        Their covariance (2n, 2n).
    """
    by_point = place_by_points(transform, len(points))  # J_j
    by_transform = place_by_pose(transform, points)  # J_T
    carried = by_transform @ transform_covariance @ by_transform.T
    return place(transform, points), by_point @ covariance @ by_point.T + carried


def landmarks_in_one_frame(
    world: GlobalMap, first: Submap, second: Submap, marks: tuple[Ints, Ints], effort: Effort
) -> PointSets:
    """Express some landmarks of two submaps in the first's frame, with their full covariance.

    marks: numbers of the landmarks, of the first and of the second submap. Given the transforms,
    the maps are independent, and depend on the transforms from the oldest of their frames on alone:
    only that part of the covariance is multiplied.
    """
    start, size = 3 * min(*first.frames, *second.frames), len(world.mean)
    rows, twins = (rows_of(side.tolist(), 2) for side in marks)
    transform, by_links = world.relative(first.base, second.base)
    points = second.now(world)[twins].reshape(-1, 2)
    turn = rotation(transform[2])
    moved = place_by_pose(transform, points) @ by_links
    moved += turn_points(turn, second.gain_of(size)[twins])
    by_world = np.concatenate([first.gain_of(size)[rows], moved])[:, start:]
    carried = by_world @ world.covariance[start:, start:] @ by_world.T
    effort.count(len(by_world), by_world.shape[1], by_world.shape[1] + len(by_world))
    split, rest = len(rows), turn_both(turn, second.rest[np.ix_(twins, twins)])
    return PointSets(
        first=first.now(world)[rows].reshape(-1, 2),
        second=place(transform, points),
        first_covariance=carried[:split, :split] + first.rest[np.ix_(rows, rows)],
        second_covariance=carried[split:, split:] + rest,
        cross_covariance=carried[:split, split:],
    )


def turn_points(turn: Array, rows: Array) -> Array:
    """Rotate a matrix (2n, k), of which each point has two rows (x and y), by `turn` (2, 2)."""
    return np.asarray((turn @ rows.reshape(len(rows) // 2, 2, rows.shape[1])).reshape(rows.shape))


def turn_both(turn: Array, covariance: Array) -> Array:
    """Rotate the covariance (2n, 2n) of points by `turn` (2, 2), on both sides."""
    return turn_points(turn, turn_points(turn, covariance).T)


@dataclass(frozen=True, kw_only=True)
class Tie:
    """Common landmarks of two submaps: their difference, linearised, is observed as zero (3.15).

    The difference d = T(second) - first is linear in the transforms, but for noise that does not
    depend on them: d = ahead + by_world (transforms - transforms of before) + noise.
    """

    ahead: Array  # (2k,) m
    by_world: Array  # (2k, g)
    noise: Array  # (2k, 2k) m^2
    from_first: Array  # (2n, 2k) covariance of the first's landmarks with the noise
    from_second: Array  # (2m, 2k) the same of the second's


def fuse(
    world: GlobalMap, first: Submap, second: Submap, pairs: tuple[Pair, ...], effort: Effort
) -> Submap:
    """Make two submaps one, given their common landmarks, and update the global map.

    Both estimates of a common landmark are the same place: an observation of their difference,
    which is zero (3.15). It updates the transforms as any filter's state; then the landmarks are
    updated given the transforms, of which the two maps are independent of each other. This is the
    update of the joint state without its size.

    A loop turns what lies behind a long chain by degrees; one update, as in the thesis, leaves
    maps that are surer than they may be. It is linearised again where the update leads.
    """
    before, size = world.mean.copy(), len(world.mean)
    gains = first.gain_of(size), second.gain_of(size)
    means = first.now(world), second.now(world)
    seconds = rows_of([j for _, j in pairs], 2)
    at, shared = before.copy(), means[1][seconds]
    for _ in range(ITERATIONS):
        # the transforms by the difference of common landmarks, then the landmarks given these
        tie = _tie(before, at, shared, (first, second), pairs)
        carried = world.covariance @ tie.by_world.T
        spread = tie.by_world @ carried + tie.noise
        change = -carried @ np.linalg.solve(spread, tie.ahead)
        at = before + change
        left = np.linalg.solve(tie.noise, tie.ahead + tie.by_world @ change)
        shared = (means[1] + gains[1] @ change - tie.from_second @ left)[seconds]
        effort.count(size, size, len(seconds))
        effort.count(len(seconds), len(seconds), size)
    at[2::3] = wrap(at[2::3])
    world.mean = at
    world.covariance = world.covariance - carried @ np.linalg.solve(spread, carried.T)
    effort.count(size, size, len(seconds))
    updated = []
    for mean, gain, covariance in zip(means, gains, (tie.from_first, tie.from_second), strict=True):
        weight = np.linalg.solve(tie.noise, covariance.T).T
        updated.append((mean + gain @ change - covariance @ left, gain - weight @ tie.by_world))
        effort.count(len(mean), len(seconds), size)
    return _merge(world, (first, second), updated, tie, pairs, effort)


def _tie(
    before: Array, at: Array, shared: Array, maps: tuple[Submap, Submap], pairs: tuple[Pair, ...]
) -> Tie:
    """Linearise the difference of common landmarks.

    Parameters
    ----------
    before
        Transforms (g,) before the fusion, for which the tie is given.
    at
        Transforms (g,) at which it is linearised.
    shared
        The second's common landmarks (2k,) m at which it is linearised.
    maps
        The two submaps.
    pairs
        Common landmarks: number in the first and in the second submap.
    """
    first, second = maps
    rows, twins = (rows_of(list(side), 2) for side in zip(*pairs, strict=True))
    world = GlobalMap()
    world.mean = at
    transform, by_links = world.relative(first.base, second.base)
    points, turn = shared.reshape(-1, 2), place_by_points(transform, len(pairs))
    by_transform = place_by_pose(transform, points) @ by_links
    start = GlobalMap()
    start.mean = before
    off = before - at
    off[2::3] = wrap(off[2::3])
    ahead = place(transform, points).ravel() + by_transform @ off
    ahead += turn @ (second.now(start)[twins] - shared) - first.now(start)[rows]
    gains = first.gain_of(len(at))[rows], second.gain_of(len(at))[twins]
    from_first, from_second = -first.rest[:, rows], second.rest[:, twins] @ turn.T
    return Tie(
        ahead=ahead,
        by_world=by_transform + turn @ gains[1] - gains[0],
        noise=turn @ from_second[twins] - from_first[rows] + SAME_M2 * np.eye(len(rows)),
        from_first=from_first,
        from_second=from_second,
    )


def _merge(
    world: GlobalMap,
    maps: tuple[Submap, Submap],
    updated: list[tuple[Array, Array]],
    tie: Tie,
    pairs: tuple[Pair, ...],
    effort: Effort,
) -> Submap:
    """Put the updated landmarks of two maps into one, common ones once.

    updated: mean (2n,) and gain (2n, g) of each submap after the tie's update.
    """
    first, second = maps
    (mean, gain), (own_mean, own_gain) = updated
    mates = {second_point for _, second_point in pairs}
    left = [j for j in range(second.count) if j not in mates]
    rows = rows_of(left, 2)
    transform, by_links = world.relative(first.base, second.base)
    points = own_mean[rows].reshape(-1, 2)
    turn = rotation(transform[2])
    cross_covariance = np.concatenate([tie.from_first, turn_points(turn, tie.from_second[rows])])
    rest = -cross_covariance @ np.linalg.solve(tie.noise, cross_covariance.T)
    effort.count(len(cross_covariance), len(cross_covariance), len(tie.ahead))
    split = len(mean)
    rest[:split, :split] += first.rest
    rest[split:, split:] += turn_both(turn, second.rest[np.ix_(rows, rows)])
    by_world = place_by_pose(transform, points) @ by_links + turn_points(turn, own_gain[rows])
    return Submap(
        base=first.base,
        frames=tuple(sorted({*first.frames, *second.frames})),
        mean=np.concatenate([mean, place(transform, points).ravel()]),
        gain=np.concatenate([gain, by_world]),
        given=world.mean.copy(),
        rest=(rest + rest.T) / 2,
        truth=first.truth + tuple(second.truth[j] for j in left),
    )
