# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where on the hull the dive was: T_g_M by its profile along the hull, and its covariance.

The solve slides along a flat valley and stops at a facet's edge or where its tolerance lets it
(docs/methods.md 9). The posterior along the valley, with the CAD model's error as correlated noise,
is what is known; its mean is the pose that the last round holds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor

from hullrecon.adjustment.hull_pose import cad_error, profile_likelihood, registration
from hullrecon.adjustment.hull_pose.cad_error import CadError
from hullrecon.adjustment.hull_pose.observability import find_weak_directions
from hullrecon.adjustment.problem.assembly import Selection
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.results.covariance import hull_axes
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array, CholeskyFactor, Ints, Ints32, Mask

MAX_PASSES = 3
# of the surface that one point stands for, at least; of all, at most
CELL_M, MAX_POINTS = 0.15, 800


@dataclass(frozen=True, kw_only=True)
class LoosePoints:
    """Points of a path in stretches: stretch (n,) of each point; step (s, 6, 6): covariance of each
    stretch relative to the one that was registered, (translation, rotation) in g.
    """

    stretch: Ints
    step: Array

    def rows(self, kept: Mask) -> LoosePoints:
        """Return some of the points (n,)."""
        return replace(self, stretch=self.stretch[kept])


@dataclass(frozen=True, kw_only=True)
class HullPoints:
    """Points that lie on the hull: xyz (n, 3) in g; loose: of which stretch they are, None where
    the path holds together.
    """

    xyz: Array
    loose: LoosePoints | None = None


@dataclass(frozen=True, kw_only=True)
class HullPoseEvidence:
    """What is known of the hull pose: points (n, 3) in g that lie on the hull, the CAD model and
    how wrong it may be, and the survey's centre (3,) in M. loose: of which stretch of the path the
    points are, None where it holds together.
    """

    points: Array
    cad_model: CadModel
    center: Array
    cad_error_model: CadError
    loose: LoosePoints | None = None

    def distances_by_stretches(self, pose: Poses) -> Array:
        """Return how the points' distances to the CAD model change (n, k) by one sigma of each way
        in which the path leaves its stretches free; k is 0 where it holds together.
        """
        if self.loose is None:
            return np.zeros((len(self.points), 0))
        to_hull = np.eye(6)
        to_hull[3:, 3:] = pose.rotation.inv().as_matrix()[0]
        out = np.zeros((len(self.points), len(self.loose.step), 6))
        for k, covariance in enumerate(self.loose.step):
            own = self.loose.stretch == k
            if own.any() and covariance.any():
                at = self.points[own]
                middle = pose.inverse().apply(at).mean(axis=0)
                value, vector = np.linalg.eigh(to_hull @ covariance @ to_hull.T)
                by_step = registration.signed_distances(at, pose, middle, self.cad_model.mesh)[1]
                out[own, k] = by_step @ (vector * np.sqrt(np.maximum(value, 0)))
        return np.asarray(out.reshape(len(self.points), -1))


def collect_hull_points(
    m: Measurements, state: State, chosen: Selection, label: Ints32
) -> HullPoints:
    """Return points that lie on the hull: landmarks labelled so, and DVL returns; thinned to some
    hundreds, each stretch of a path by itself. Those of no stretch are left out.

    Raises ValueError without a CAD model in the state.
    """
    hull = state.hull
    if hull is None:
        raise ValueError("points on the hull are known by a CAD model")
    on_hull = (
        chosen.landmarks[label == 1]
        if len(chosen.landmarks) == len(label)
        else chosen.landmarks[:0]
    )
    parts = [state.landmark[on_hull]]
    if m.returns is not None:
        ends = state.mounted(m.rig).dvl_points(m.returns, state.path)
        parts.append(ends.points[chosen.returns])
    points, stretches = np.vstack(parts), hull.stretches
    if stretches is None:
        return HullPoints(xyz=thin_over_surface(points, hull.global_from_hull, hull.cad_model))
    nodes = [
        _first_nodes(m, on_hull),
        *([] if m.returns is None else [m.returns.node[chosen.returns]]),
    ]
    of_point, most = stretches.of_node[np.concatenate(nodes)], MAX_POINTS // len(stretches)
    thinned = [
        thin_over_surface(points[of_point == k], hull.global_from_hull, hull.cad_model, most)
        for k in range(len(stretches))
    ]
    return HullPoints(
        xyz=np.vstack(thinned),
        loose=LoosePoints(
            stretch=np.repeat(np.arange(len(stretches)), [len(own) for own in thinned]),
            step=np.stack([stretches.from_reference(k) for k in range(len(stretches))]),
        ),
    )


def _first_nodes(m: Measurements, landmarks: Ints) -> Ints:
    """Return the first node (L,) that saw each of some landmarks."""
    if m.tracks is None:
        return np.zeros(0, np.int64)
    first = np.full(int(m.tracks.landmark.max(initial=-1)) + 1, np.iinfo(np.int64).max)
    np.minimum.at(first, m.tracks.landmark, m.tracks.node)
    return np.asarray(first[landmarks])


def thin_over_surface(
    points: Array, pose: Poses, cad_model: CadModel, most: int = MAX_POINTS
) -> Array:
    """Return of points (n, 3) in g one a cell of the CAD model's surface, the mean of the half of
    them whose distances lie in the middle; cells are grown until at most `most` are left.

    Cells in space would give a few points that stand beside the surface cells of their own, and as
    much weight as all those that are right. Cells of M would hold other points wherever a first
    pose lies along the hull: they are cells of g.
    """
    nearest = cad_model.mesh.index.closest(pose.inverse().apply(points))
    foot, cell_m = (
        points - nearest.distance[:, None] * pose.rotation.apply(nearest.gradient),
        CELL_M,
    )
    while True:
        _, owner = np.unique(np.floor(foot / cell_m).astype(np.int64), axis=0, return_inverse=True)
        count = np.bincount(owner)
        if len(count) <= most:
            return _middle_half_means(points, nearest.distance, owner, count)
        cell_m *= 1.25


def _middle_half_means(points: Array, distance: Array, owner: Ints, count: Ints) -> Array:
    """Return of each cell the mean (c, 3) of the points whose distances are neither in its lowest
    nor in its highest quarter.

    One point of each, the median, would be another one by the last digit of the path, with a noise
    of its own.
    """
    order = np.lexsort((distance, owner))
    rank = np.arange(len(order)) - np.repeat(np.cumsum(count) - count, count)
    size = count[owner[order]]
    middle = order[(rank >= size // 4) & (rank < size - size // 4)]
    kept = np.bincount(owner[middle])
    return np.stack(
        [np.bincount(owner[middle], points[middle, k]) / kept for k in range(3)], axis=1
    )


def fit_hull_pose(
    points: Array, pose: Poses, cad_model: CadModel, center: Array, loose: LoosePoints | None = None
) -> tuple[HullPoseEvidence, Poses]:
    """Return points (n, 3) in g without their outliers as evidence, and T_g_M fitted to it from
    `pose`.
    """
    expected = cad_error.expected_cad_error(cad_model)
    evidence = HullPoseEvidence(
        points=points, cad_model=cad_model, center=center, cad_error_model=expected, loose=loose
    )
    along = cad_model.chart.ship_axes[0]
    for _ in range(MAX_PASSES):
        valley = _valley(evidence, pose, along)
        pose, _ = profile_likelihood.minimise_cost(valley, pose)
        distance, _ = registration.signed_distances(evidence.points, pose, center, cad_model.mesh)
        outlier = cad_error.find_outliers(valley.cost.factor, distance)
        if not outlier.any():
            break
        left = None if evidence.loose is None else evidence.loose.rows(~outlier)
        evidence = replace(evidence, points=evidence.points[~outlier], loose=left)
    return evidence, pose


def profile_mean_pose(evidence: HullPoseEvidence, pose: Poses) -> Poses:
    """Return T_g_M at the mean of its profile along the hull."""
    return _profile(evidence, pose, evidence.cad_model.chart.ship_axes[0]).global_from_hull


def hull_pose_covariance(evidence: HullPoseEvidence, pose: Poses) -> Array:
    """Return the covariance (6, 6) of T_g_M about the centre, given the points: what the CAD
    model's error, its facets and the package's prior leave open; with the variances along the hull
    and along its weak directions from their profiles, taken as the posterior's second moment about
    the delivered pose.
    """
    ship_axes = evidence.cad_model.chart.ship_axes
    out = profile_likelihood.posterior_covariance(_valley(evidence, pose, ship_axes[0]), pose)
    for direction in _directions(hull_axes(out, pose), ship_axes):
        found = _profile(evidence, pose, direction)
        out = profile_likelihood.inflate_covariance(
            out, replace(found, sigma=float(np.hypot(found.sigma, found.mean))), pose
        )
    return np.asarray(out + _contradiction(evidence, pose))


def _contradiction(evidence: HullPoseEvidence, pose: Poses) -> Array:
    """Return the covariance (6, 6) that a contradiction adds: where guess or form contradict the
    CAD model, it or the guess may be wrong, so the sigma along the line between guess and fit is at
    least its length (docs/methods.md 20). Else zero.
    """
    if not evidence.cad_model.contradicted:
        return np.zeros((6, 6))
    step = registration.prior_step(pose, evidence.cad_model, evidence.center)
    apart = np.r_[evidence.cad_model.guess.rotation.as_matrix()[0] @ step[:3], step[3:]]
    return np.outer(apart, apart)


def _profile(
    evidence: HullPoseEvidence, pose: Poses, direction: Array
) -> profile_likelihood.Profile:
    valley = _valley(evidence, pose, direction)
    return profile_likelihood.profile(
        valley,
        pose,
        reach=3 * float(np.linalg.norm(direction * evidence.cad_model.guess_sigma[:3])),
    )


def _valley(evidence: HullPoseEvidence, pose: Poses, direction: Array) -> profile_likelihood.Valley:
    cost = registration.HullPoseCost(
        points=evidence.points,
        cad_model=evidence.cad_model,
        center=evidence.center,
        factor=_factor(evidence, pose),
    )
    return profile_likelihood.Valley(cost=cost, direction=direction)


def _factor(evidence: HullPoseEvidence, pose: Poses) -> CholeskyFactor:
    at, by_stretches = (
        pose.inverse().apply(evidence.points),
        evidence.distances_by_stretches(pose),
    )
    covariance = cad_error.distance_covariance(evidence.cad_error_model, evidence.cad_model, at)
    return cho_factor(covariance + by_stretches @ by_stretches.T, lower=True)


def _directions(hull_in_axes: Array, ship_axes: Array) -> list[Array]:
    """Return along the hull, and the weak directions of position (unit vectors in M) that point
    elsewhere.
    """
    weak = [
        np.array(w["direction"])
        for w in find_weak_directions(hull_in_axes, ship_axes)
        if w["kind"] == "position"
    ]
    return [ship_axes[0], *(d for d in weak if abs(d @ ship_axes[0]) < 0.9)]
