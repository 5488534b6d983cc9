# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sessions before an ellipsoid that stands for a ship: paths, planes, odometry and links.

The hull's middle is the origin of the common frame g, x runs along it, z down, its surveyed side
faces +y. The vehicle is level, at a standoff, and faces the hull.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from hullrecon.geometry.poses import Poses, from_rpy, stacked
from hullrecon.native.curvature import curvature_difference
from hullrecon.studies.sessions.factors import (
    Encounters,
    Factors,
    Levels,
    Links,
    PlanePairs,
    Priors,
    Sightings,
    State,
    no_planes,
)
from hullrecon.studies.sessions.motions import between, drawn, plane_in
from hullrecon.typing import Array, Ints

AXES_M = np.array([40.0, 8.0, 9.0])  # half axes: length, breadth, depth
STANDOFF_M, STEP_M = 1.5, 1.0
DEPTHS_M = (1.5, 2.5, 3.5, 4.5)  # of the legs of a session
PLANE_EVERY = 3  # poses
# translation m and rotation rad of a step, of a link by images
ODOMETRY_SIGMA = np.array([0.02, 0.02, 0.01, 0.002, 0.002, 0.005])
LINK_SIGMA = np.repeat([0.01, 0.003], 3)
LEVEL_SIGMA = np.array([0.03, 0.004])  # depth m, roll and pitch rad
PLANE_SIGMA_M = 0.02  # of each of a plane's three numbers
PAIR_REACH_M = 3.5  # between poses whose planes are tied to each other
PAIR_FLOOR_M, PAIR_SHARE = 0.03, 0.3  # of the difference by curvature, which the radii give roughly
START_SIGMA = np.full(6, 1e-3)  # of a session's first pose in its own frame
# z, roll and pitch of a frame are those of the sea's surface and the vertical
ANCHOR_SIGMA = np.array([50.0, 50.0, 1e-4, 1e-5, 1e-5, 2.0])
KNOWN_SIGMA = np.array([1e-4, 1e-4, 1e-4, 1e-5, 1e-5, 1e-5])  # of the anchor that makes the frame
LINK_REACH_M, MEETING_M = 1.3, 1.0  # between poses whose images overlap, of one session and two
LINK_SHARE = 0.35  # of them that are linked
RADIUS_AZIMUTH_M, RADIUS_ELEVATION_M = AXES_M[0] ** 2 / AXES_M[1], AXES_M[2] ** 2 / AXES_M[1]


@dataclass(frozen=True, kw_only=True)
class Session:
    """One survey in a frame of its own, and where that lies."""

    frame: Poses  # (1) global_from_session
    truth: Poses  # (n) global_from_vehicle
    start: State  # in the session's frame, dead reckoned
    factors: tuple[Factors, ...]
    seen_from: Ints  # (p,) row of the pose that sees each plane

    @property
    def truth_in_session(self) -> Poses:
        """Express the true path in the session's frame."""
        return self.frame.inverse() @ self.truth


def surface(x_m: Array, depth_m: Array, axes_m: Array = AXES_M) -> tuple[Array, Array]:
    """Compute points of the hull's side (n, 3) m in g, and their outward unit normals.

    x_m, depth_m: (n,) along the hull and below its middle. axes_m: half axes of the ellipsoid.
    """
    y = axes_m[1] * np.sqrt(1 - (x_m / axes_m[0]) ** 2 - (depth_m / axes_m[2]) ** 2)
    points = np.column_stack([x_m, y, depth_m])
    normals = points / axes_m**2
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def facing(points: Array, normals: Array) -> Poses:
    """Place a level vehicle at the standoff before points of the hull (n, 3) m, facing it."""
    at = points + STANDOFF_M * normals
    yaw = np.arctan2(-normals[:, 1], -normals[:, 0])
    return from_rpy(at, np.column_stack([0 * yaw, 0 * yaw, yaw]))


def legs(
    from_x_m: float, to_x_m: float, depths_m: Sequence[float] = DEPTHS_M, step_m: float = STEP_M
) -> Poses:
    """Survey a stretch of the side in legs along it, to and fro: true poses global_from_vehicle.

    A leg for each depth, with a pose every step_m.
    """
    along = np.arange(from_x_m, to_x_m + 1e-9, step_m)
    x = np.concatenate([along[:: 1 if k % 2 == 0 else -1] for k in range(len(depths_m))])
    return facing(*surface(x, np.repeat(depths_m, len(along))))


def ranges(places: Array, rays: Array, axes_m: Array = AXES_M) -> Array:
    """Compute how far the hull is from places (n, 3) m along unit rays (n, 3): (n,) m.

    In units of its half axes the ellipsoid is a unit sphere: the nearer root of a quadratic.
    """
    here, way = places / axes_m, rays / axes_m
    a, b, c = (np.sum(u * v, axis=1) for u, v in ((way, way), (here, way), (here, here)))
    return np.asarray((-b - np.sqrt(b**2 - a * (c - 1))) / a)


def planes_before(poses: Poses, axes_m: Array = AXES_M) -> Array:
    """Compute the planes tangent to the hull where poses in g look ahead.

    Returns planes (n, 3) m in the poses' frames: unit normal towards the pose times distance.
    """
    ahead = poses.rotation.apply(np.tile([1.0, 0, 0], (len(poses), 1)))
    points = poses.translation + ranges(poses.translation, ahead, axes_m)[:, None] * ahead
    normal = points / axes_m**2
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # towards the origin of g, times the distance from it
    in_global = -normal * np.sum(normal * points, axis=1, keepdims=True)
    return plane_in(poses, in_global)[0]


def survey(truth: Poses, rng: np.random.Generator, planes: bool = True) -> Session:
    """Simulate what a session measures along a true path, in a frame of its own.

    It has odometry, depth and level, links of images and, with `planes`, planes of the DVL. The
    frame is moved and turned at random, but for depth and level.
    """
    offset = np.r_[rng.uniform(-4, 4), rng.uniform(-3, 3), 0.0]
    frame = from_rpy(offset, np.r_[0, 0, rng.uniform(-0.6, 0.6)])
    local, count = frame.inverse() @ truth, len(truth)
    steps = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    odometry = _links(local, steps, ODOMETRY_SIGMA, rng)
    # The start is the odometry chained
    reckoned = [local[0]]
    for k in range(count - 1):
        reckoned.append(reckoned[-1] @ odometry.measured[k])
    path = stacked(reckoned)
    factors: list[Factors] = [
        Priors(
            poses=np.zeros((1, 1), int),
            planes=no_planes(1),
            measured=local[0],
            sqrt_information=np.diag(1 / START_SIGMA)[None],
        ),
        odometry,
        _levels(local, rng),
        _links(local, _near(truth, rng), LINK_SIGMA, rng),
    ]
    seers = np.arange(0, count, PLANE_EVERY) if planes else np.zeros(0, int)
    seen = planes_before(truth[seers]) + PLANE_SIGMA_M * rng.standard_normal((len(seers), 3))
    if planes:
        factors += plane_factors(seers, seen, truth)
    start = State(
        poses=path,
        planes=plane_in(path[seers].inverse(), seen)[0] if planes else np.zeros((0, 3)),
    )
    return Session(frame=frame, truth=truth, start=start, factors=tuple(factors), seen_from=seers)


def plane_factors(seers: Ints, seen: Array, truth: Poses) -> list[Factors]:
    """Tie planes to the poses that see them, and the planes of near poses to each other.

    Parameters
    ----------
    seers
        (p,) numbers of the poses that see a plane.
    seen
        (p, 3) m planes as measured, in those poses' frames: unit normal towards the pose times
        distance.
    truth
        True poses of the session in g, which tell what is near.
    """
    sightings = Sightings(
        poses=seers[:, None],
        planes=np.arange(len(seers))[:, None],
        measured=seen,
        sigma_m=PLANE_SIGMA_M,
    )
    tree = cKDTree(truth.translation[seers])
    pairs = np.array(sorted(tree.query_pairs(PAIR_REACH_M)), int).reshape(-1, 2)
    # By true poses, where a vehicle would have its estimates
    return [sightings, plane_pairs(pairs, seers, truth[seers], truth[seers], seen)]


def plane_pairs(pairs: Ints, poses: Ints, first: Poses, second: Poses, seen: Array) -> PlanePairs:
    """Make factors by which planes differ as the hull's radii of curvature say [Ozog2016 eq. 2.3].

    The print holds them equal and counts the difference as noise.

    Parameters
    ----------
    pairs
        (m, 2) numbers of planes of one surface.
    poses
        (p,) number of the pose that sees each plane.
    first, second
        (p) poses in one frame that see the planes. Those of the first plane of a pair are looked up
        in `first`, those of the second in `second`.
    seen
        (p, 3) m planes as measured, in those poses' frames.
    """
    between_them = between(first[pairs[:, 0]], second[pairs[:, 1]])[0].translation
    radii = (np.full(len(pairs), r) for r in (RADIUS_AZIMUTH_M, RADIUS_ELEVATION_M))
    differ = curvature_difference(seen[pairs[:, 0]], between_them, *radii)
    root = np.zeros((len(pairs), 3, 3))
    sigma = np.hypot(PAIR_SHARE * np.linalg.norm(differ, axis=1), PAIR_FLOOR_M)
    root[:, np.arange(3), np.arange(3)] = 1 / sigma[:, None]
    return PlanePairs(
        poses=poses[pairs[:, :1]], planes=pairs, measured=differ, sqrt_information=root
    )


def encounters(
    first: Poses, second: Poses, rng: np.random.Generator, share: float = LINK_SHARE
) -> tuple[Ints, Links]:
    """Link poses of two sessions by images: pairs (m, 2) of a pose of each, and their links.

    Of all poses nearer than MEETING_M a share, drawn at random, is linked. The links' poses are
    rows of first, and of second counted on after it.
    """
    apart = np.linalg.norm(first.translation[:, None] - second.translation, axis=2)
    pairs: Ints = np.argwhere(apart < MEETING_M)
    pairs = pairs[rng.random(len(pairs)) < share]
    both = stacked([first, second])
    return pairs, _links(both, pairs + np.array([0, len(first)]), LINK_SIGMA, rng)


def through_anchors(
    links: Links, pairs: Ints, anchors: tuple[int, int], starts: Ints
) -> Encounters:
    """Turn links between two sessions into factors of a graph with anchors.

    Parameters
    ----------
    links
        Relative poses as measured.
    pairs
        (m, 2) the linked poses, counted in either session.
    anchors
        Numbers of the two sessions' anchors in the graph.
    starts
        (2,) numbers of the two sessions' first poses in the graph.
    """
    count = len(pairs)
    keys = np.column_stack(
        [np.full(count, anchors[0]), starts[0] + pairs[:, 0], np.full(count, anchors[1]),
         starts[1] + pairs[:, 1]]
    )  # fmt: skip
    return Encounters(
        poses=keys, planes=links.planes, measured=links.measured,
        sqrt_information=links.sqrt_information,
    )  # fmt: skip


def _near(truth: Poses, rng: np.random.Generator) -> Ints:
    """Draw pairs (m, 2) of poses of one session that images link: near, and not neighbours."""
    pairs = np.array(sorted(cKDTree(truth.translation).query_pairs(LINK_REACH_M)), int)
    apart = pairs[pairs[:, 1] - pairs[:, 0] > 2]
    return np.asarray(apart[rng.random(len(apart)) < LINK_SHARE])


def _links(poses: Poses, pairs: Ints, sigma: Array, rng: np.random.Generator) -> Links:
    """Measure relative poses of pairs (m, 2) of true poses, with sigmas (6,) of a motion."""
    exact = between(poses[pairs[:, 0]], poses[pairs[:, 1]])[0]
    return Links(
        poses=pairs,
        planes=no_planes(len(pairs)),
        measured=exact @ drawn(sigma, rng, len(pairs)),
        sqrt_information=np.tile(np.diag(1 / sigma), (len(pairs), 1, 1)),
    )


def _levels(poses: Poses, rng: np.random.Generator) -> Levels:
    """Measure depth and the downward direction in the vehicle at each pose."""
    count = len(poses)
    down = poses.rotation.inv().apply([0.0, 0.0, 1.0]).reshape(-1, 3)
    return Levels(
        poses=np.arange(count)[:, None],
        planes=no_planes(count),
        depth=poses.translation[:, 2] + LEVEL_SIGMA[0] * rng.standard_normal(count),
        down=down + LEVEL_SIGMA[1] * rng.standard_normal((count, 3)),
        sigma=LEVEL_SIGMA,
    )
