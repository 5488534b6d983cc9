# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A vehicle found again in an old map by planes: Monte-Carlo localisation [Ozog2016 2.4.3.1].

Depth, roll and pitch are measured, so that a particle is x, y and yaw in the map's frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from hullrecon.geometry.poses import Poses, from_rpy
from hullrecon.studies.sessions.motions import plane_in
from hullrecon.typing import Array, Ints

FREE_M = 3.0  # largest distance from a plane at which particles start, as printed
# Sigma of a plane, m, and what the hull's curvature adds per metre to the plane's node
SIGMA_M, SIGMA_BY_GAP = 0.1, 0.2
TEMPER = 0.2  # of a weight's logarithm: planes seen one after the other err together
STIR = np.array([0.15, 0.15, 0.03])  # m, m, rad: of particles that are drawn again


@dataclass(frozen=True, kw_only=True)
class PlaneMap:
    """Poses of an old graph and the plane that each of them saw, in the map's frame."""

    poses: Poses  # (n)
    planes: Array  # (n, 3) m, unit normal towards the origin times distance, as in `motions`

    @cached_property
    def tree(self) -> cKDTree:
        """Sort the poses by place."""
        return cKDTree(self.poses.translation)

    def nearest(self, places: Array) -> tuple[Ints, Array]:
        """Find the nearest poses of places (m, 3), and how far they are."""
        gap, node = self.tree.query(places)
        return np.asarray(node, int), np.asarray(gap)


def spread(known: PlaneMap, depth_m: float, count: int, rng: np.random.Generator) -> Array:
    """Draw particles at a depth uniformly over free water before the map, with any yaw.

    Returns (count, 3), x and y in m, yaw in rad. Free is what is outside of the nearest pose's
    plane, and nearer to it than FREE_M.
    """
    low, high = (of(known.poses.translation[:, :2], axis=0) for of in (np.min, np.max))
    found: list[Array] = []
    while sum(map(len, found)) < count:
        place = np.column_stack(
            [rng.uniform(low - FREE_M, high + FREE_M, (4 * count, 2)), np.full(4 * count, depth_m)]
        )
        node, _ = known.nearest(place)
        plane = known.planes[node]
        squared = np.sum(plane**2, axis=1)
        # m outward of the plane {x : plane @ x = -|plane|^2}
        outside = -(np.sum(plane * place, axis=1) + squared) / np.sqrt(squared)
        found.append(place[(outside > 0) & (outside < FREE_M)][:, :2])
    place = np.concatenate(found)[:count]
    return np.column_stack([place, rng.uniform(-np.pi, np.pi, count)])


def as_poses(particles: Array, depth_m: float) -> Poses:
    """Turn particles (m, 3) into level poses at a depth."""
    at = np.column_stack([particles[:, :2], np.full(len(particles), depth_m)])
    zero = np.zeros(len(particles))
    return from_rpy(at, np.column_stack([zero, zero, particles[:, 2]]))


def moved_on(particles: Array, step: Array, sigma: Array, rng: np.random.Generator) -> Array:
    """Move particles (m, 3) by odometry in their own frames, (3,) x, y, yaw, with sigmas (3,)."""
    noisy = step + sigma * rng.standard_normal(particles.shape)
    c, s = np.cos(particles[:, 2]), np.sin(particles[:, 2])
    along = np.column_stack([c * noisy[:, 0] - s * noisy[:, 1], s * noisy[:, 0] + c * noisy[:, 1]])
    return np.column_stack([particles[:, :2] + along, particles[:, 2] + noisy[:, 2]])


def plane_distances(known: PlaneMap, poses: Poses, seen: Array) -> tuple[Array, Array]:
    """Compare a plane seen (3,) m, in the vehicle's frame, with what poses (m) should see.

    Returns squared distances (m,), in sigmas, and logarithms of the sigmas (m,), m.

    d^2 = |z - (x_p ⊟ pi_i)|^2 with the nearest node's plane pi_i. The print takes the pose of that
    node for the particle's own, and d^2 itself for the weight, by which the worst weigh most.
    """
    node, gap = known.nearest(poses.translation)
    sigma = np.hypot(SIGMA_M, SIGMA_BY_GAP * gap)
    off = plane_in(poses, known.planes[node])[0] - seen
    return np.sum(off**2, axis=1) / sigma**2, np.log(sigma)


def weights(distances: Array, log_sigmas: Array) -> Array:
    """Compute normalised weights (m,) of particles by what `plane_distances` gives.

    They are tempered likelihoods of the plane's three numbers.
    """
    logs = TEMPER * (-0.5 * distances - 3 * log_sigmas)
    found = np.exp(logs - logs.max())
    return np.asarray(found / found.sum())


def drawn_again(particles: Array, weight: Array, rng: np.random.Generator) -> Array:
    """Resample particles (m, 3) systematically by their weights (m,), and stir them a little."""
    count = len(particles)
    at = (rng.random() + np.arange(count)) / count
    rows = np.searchsorted(np.cumsum(weight), at).clip(0, count - 1)
    return np.asarray(particles[rows] + STIR * rng.standard_normal((count, 3)))


def area_m2(particles: Array) -> float:
    """Measure how far particles spread: root of the determinant of x and y's covariance, m^2."""
    return float(np.sqrt(max(np.linalg.det(np.cov(particles[:, :2].T)), 0.0)))


def candidates(known: PlaneMap, particles: Array, depth_m: float) -> Ints:
    """Collect the key frames that are nearest to a particle [Ozog2016 Algorithm 1].

    particles: (m, 3) x, y m and yaw rad. depth_m: of all of them.
    """
    return np.unique(known.nearest(as_poses(particles, depth_m).translation)[0])
