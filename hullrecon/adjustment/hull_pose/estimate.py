# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull's pose by its profile likelihood along the hull, and its covariance (docs/methods.md 9).

Along the hull the cost is a flat valley, in which a solve stops at a facet's edge or where its
tolerance is met. So the posterior along the valley is computed, with the CAD model's error as
correlated noise. Its mean is the pose that the last round holds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from hullrecon.adjustment.hull_pose import cad_error, pose_cost, profile_likelihood, registration
from hullrecon.adjustment.hull_pose.cad_error import CadError
from hullrecon.adjustment.hull_pose.observability import find_weak_directions
from hullrecon.adjustment.problem.assembly import Selection
from hullrecon.adjustment.problem.deviation_field import DeviationGrid
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.problem.observations import first_nodes
from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.results.covariance import hull_axes
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array, CholeskyFactor, Ints, Ints32, Mask

MAX_PASSES = 3  # of fitting and rejecting outliers
CELL_M = 0.15  # least side of the surface cell that one point represents
MAX_POINTS = 800  # their covariance is dense


@dataclass(frozen=True, kw_only=True)
class LoosePoints:
    """Segment of each point, on a path that outages cut, and the covariance of its pose."""

    segment: Ints  # (n,) of each point
    # (s, 6, 6) covariance of each segment's pose relative to the reference segment, (translation,
    # rotation) in g
    covariance: Array


@dataclass(frozen=True, kw_only=True)
class HullPoints:
    """Points that lie on the hull."""

    xyz: Array  # (n, 3) m in g
    # (n, 3) m in g: how the points move by one sigma of the common scale of all DVL ranges
    by_range: Array
    loose: LoosePoints | None = None  # None where the path is not cut


@dataclass(frozen=True, kw_only=True)
class HullPoseEvidence:
    """The points and priors from which the hull's pose is estimated."""

    points: Array  # (n, 3) m in g, on the hull
    cad_model: CadModel
    center: Array  # (3,) m in M, of the survey
    cad_error_model: CadError  # how wrong the CAD model may be
    # (n, 3) m in g: how the points move by one sigma of the common scale of all DVL ranges
    by_range: Array
    loose: LoosePoints | None = None  # None where the path is not cut

    def distances_by_segments(self, pose: Poses) -> Array:
        """Compute how distances to the CAD model change where segments move by one sigma.

        With it the fit of the pose follows loose segments less (`_factor`). Each segment has six
        directions, the eigenvectors of its covariance.

        Returns
        -------
        Array
            (n, 6 s) for s segments, (n, 0) where the path is not cut.
        """
        if self.loose is None:
            return np.zeros((len(self.points), 0))
        # As for `perturb_pose`, translations stay in g and rotations are turned into M
        to_hull = np.eye(6)
        to_hull[3:, 3:] = pose.rotation.inv().as_matrix()[0]
        out = np.zeros((len(self.points), len(self.loose.covariance), 6))
        for k, covariance in enumerate(self.loose.covariance):
            own = self.loose.segment == k
            if own.any() and covariance.any():
                at = self.points[own]
                middle = pose.inverse().apply(at).mean(axis=0)
                value, vector = np.linalg.eigh(to_hull @ covariance @ to_hull.T)
                # Points that move act as a hull that moves the other way: a covariance has no sign
                by_step = pose_cost.signed_distances(at, pose, middle, self.cad_model.mesh)[1]
                out[own, k] = by_step @ (vector * np.sqrt(np.maximum(value, 0)))
        return np.asarray(out.reshape(len(self.points), -1))


def collect_hull_points(
    m: Measurements, state: State, chosen: Selection, label: Ints32
) -> HullPoints:
    """Collect landmarks labelled on the hull and DVL returns, thinned to some hundreds.

    Where outages cut the path, each segment is thinned separately, and points between segments are
    left out.

    Parameters
    ----------
    m, state, chosen
        Measurements, solution, and which measurements entered.
    label
        (L_used,) of each landmark that entered, 1: on the hull.

    Raises
    ------
    ValueError
        The state has no CAD model.
    """
    hull = state.hull
    if hull is None:
        raise ValueError("points on the hull are known by a CAD model")
    # A round without surface factors has no labels: then no landmark is taken
    on_hull = (
        chosen.landmarks[label == 1]
        if len(chosen.landmarks) == len(label)
        else chosen.landmarks[:0]
    )
    # Columns: the point, and how it moves by one sigma of the ranges' common scale.
    parts = [np.c_[state.landmark[on_hull], np.zeros((len(on_hull), 3))]]
    if m.returns is not None:
        ends = state.mounted(m.rig).dvl_points(m.returns, state.path)
        # An end moves along its beam by the sigma of the scale times the range
        reach = ends.directions * m.returns.range_m[:, None]
        by_range = reach * _range_scale_sigma(m, seen=len(on_hull) > 0)
        parts.append(np.c_[ends.points, by_range][chosen.returns])
    points, segments = np.vstack(parts), hull.segments
    if segments is None:
        thinned = thin_over_surface(points, hull.global_from_hull, hull.cad_model)
        return HullPoints(xyz=thinned[:, :3], by_range=thinned[:, 3:])
    # A point belongs to the segment of the node that saw it first, or that measured the range
    nodes = [
        first_nodes(m)[on_hull],
        *([] if m.returns is None else [m.returns.node[chosen.returns]]),
    ]
    of_point, most = segments.of_node[np.concatenate(nodes)], MAX_POINTS // len(segments)
    by_segment = [
        thin_over_surface(points[of_point == k], hull.global_from_hull, hull.cad_model, most)
        for k in range(len(segments))
    ]
    thinned = np.vstack(by_segment)
    return HullPoints(
        xyz=thinned[:, :3],
        by_range=thinned[:, 3:],
        loose=LoosePoints(
            segment=np.repeat(np.arange(len(segments)), [len(own) for own in by_segment]),
            covariance=np.stack([segments.from_reference(k) for k in range(len(segments))]),
        ),
    )


def _range_scale_sigma(m: Measurements, seen: bool) -> float:
    """Compute the sigma of the scale, a share, that all DVL ranges have in common.

    A wrong speed of sound scales the ranges as it does the velocities. Other causes count only
    where no camera has seen the hull (`seen` is False), as landmarks would show them.
    """
    assert m.returns is not None
    of_sound = float(m.rig.priors.navigation_sigma[0])
    return of_sound if seen else float(np.hypot(of_sound, m.returns.scale_sigma))


def thin_over_surface(
    points: Array, pose: Poses, cad_model: CadModel, most: int = MAX_POINTS
) -> Array:
    """Thin points (n, 3) in g to one for each cell of the CAD model's surface.

    In each cell the quarter of points with the smallest distances from the CAD model and the
    quarter with the largest are left out, and the others are averaged. The mean of points on a
    curved hull lies inside of it, so it is moved along the normal to their mean distance.

    A point belongs to the cell of its foot, the nearest point of the surface. If cells were
    made by the points' own positions, a few points off the surface would have cells to
    themselves, and as much weight as all others. Cells are cubes of g: with cubes of M, the
    first pose of the path would decide which points share a cell.

    Parameters
    ----------
    points
        (n, 3 + k): m in g, and further columns that are averaged with the points.
    pose
        Pose global_from_hull, at which the points are compared with the surface.
    cad_model
        The surface, to which the points' distances are measured.
    most
        Cells grow until at most this number of points is left.

    Returns
    -------
    Array
        (c, 3 + k) m in g, c <= most: one row for each cell.
    """
    nearest = cad_model.mesh.index.closest(pose.inverse().apply(points[:, :3]))
    foot, cell_m = (
        points[:, :3] - nearest.distance[:, None] * pose.rotation.apply(nearest.gradient),
        CELL_M,
    )
    while True:
        _, owner = np.unique(np.floor(foot / cell_m).astype(np.int64), axis=0, return_inverse=True)
        count = np.bincount(owner)
        if len(count) <= most:
            break
        cell_m *= 1.25
    # The last column of the means is their points' mean distance, to which each mean is moved
    means = _middle_half_means(np.c_[points, nearest.distance], nearest.distance, owner, count)
    near = cad_model.mesh.index.closest(pose.inverse().apply(means[:, :3]))
    outward = pose.rotation.apply(near.gradient) * (means[:, -1] - near.distance)[:, None]
    return np.asarray(np.c_[means[:, :3] + outward, means[:, 3:-1]])


def _middle_half_means(points: Array, distance: Array, owner: Ints, count: Ints) -> Array:
    """Average the points of each cell whose distances are in the middle half.

    The median point alone would change with the last digit of the path, and with it its noise.

    Parameters
    ----------
    points
        (n, k) columns to average.
    distance
        (n,) from the CAD model, by which points of a cell are ordered.
    owner, count
        Cell (n,) of each point, and number of points (c,) of each cell.

    Returns
    -------
    Array
        (c, k).
    """
    order = np.lexsort((distance, owner))
    # Rank of each point by distance within its cell, and number of points of that cell
    rank = np.arange(len(order)) - np.repeat(np.cumsum(count) - count, count)
    size = count[owner[order]]
    middle = order[(rank >= size // 4) & (rank < size - size // 4)]
    kept = np.bincount(owner[middle])
    return np.stack(
        [np.bincount(owner[middle], column) / kept for column in points[middle].T], axis=1
    )


def fit_hull_pose(
    points: HullPoints, pose: Poses, cad_model: CadModel, center: Array
) -> tuple[HullPoseEvidence, Poses]:
    """Fit the hull's pose to points, and reject points that the others contradict.

    Parameters
    ----------
    points
        On the hull.
    pose
        Start, global_from_hull.
    cad_model
        The mesh, the prior of its pose, and its stated error as noise of the fit.
    center
        The survey's middle (3,) m in M, about which the pose turns.

    Returns
    -------
    evidence, pose
        The points that are left, and the pose fitted to them. Where no depth was measured, fits
        from several heights are compared, and the one of least cost is taken.
    """
    evidence = HullPoseEvidence(
        points=points.xyz,
        cad_model=cad_model,
        center=center,
        cad_error_model=cad_error.expected_cad_error(cad_model),
        by_range=points.by_range,
        loose=points.loose,
    )
    heights = _at_heights(pose, cad_model, center)
    if not heights:
        return _fit_without_outliers(evidence, pose)[:2]
    fits = [_fit_from_afar(evidence, start) for start in (pose, *heights)]
    evidence, pose, _ = min(fits, key=lambda fit: fit[2])
    return evidence, pose


def _fit_from_afar(
    evidence: HullPoseEvidence, start: Poses
) -> tuple[HullPoseEvidence, Poses, float]:
    """Fit from a start at which few points may lie on the CAD model.

    A robust fit comes first, and its outliers are rejected: a single point may pull a least-squares
    fit anywhere. Returns the points that are left, the pose, and its cost. Each rejected point adds
    the cost of a point at the outlier threshold, so that fits from several starts can be compared.
    """
    near = registration.fit_correlated(
        evidence.points,
        start,
        evidence.cad_model,
        evidence.center,
        evidence.cad_error_model.noise,
    ).global_from_hull
    kept = _select(evidence, ~_outliers(evidence, near, _factor(evidence, near)))
    kept, pose, cost = _fit_without_outliers(kept, near)
    rejected = len(evidence.points) - len(kept.points)
    return kept, pose, cost + 0.5 * cad_error.OUTLIER_SIGMAS**2 * rejected


def _fit_without_outliers(
    evidence: HullPoseEvidence, pose: Poses
) -> tuple[HullPoseEvidence, Poses, float]:
    """Fit the pose, and reject points that the others contradict, until none is left.

    Returns the points that are left, the pose, and its cost (half the chi-square).
    """
    along, cost = evidence.cad_model.chart.ship_axes[0], np.inf
    for _ in range(MAX_PASSES):
        valley = _valley(evidence, pose, along)
        pose, cost = profile_likelihood.minimise_cost(valley, pose)
        outlier = _outliers(evidence, pose, valley.cost.factor)
        if not outlier.any():
            break
        evidence = _select(evidence, ~outlier)
    return evidence, pose, cost


def _outliers(evidence: HullPoseEvidence, pose: Poses, factor: CholeskyFactor) -> Mask:
    """Find points (n,) that the others contradict at a pose.

    factor: Cholesky factor of the distances' covariance.
    """
    distance, _ = pose_cost.signed_distances(
        evidence.points, pose, evidence.center, evidence.cad_model.mesh
    )
    return cad_error.find_outliers(factor, distance)


def _select(evidence: HullPoseEvidence, kept: Mask) -> HullPoseEvidence:
    """Keep those of the evidence's points that the mask (n,) selects."""
    loose = evidence.loose
    return replace(
        evidence,
        points=evidence.points[kept],
        by_range=evidence.by_range[kept],
        loose=None if loose is None else replace(loose, segment=loose.segment[kept]),
    )


def _at_heights(pose: Poses, cad_model: CadModel, center: Array) -> list[Poses]:
    """List poses to start a fit from: with the guess's attitude, at this and at other heights.

    Empty where the package knows the height well. Where no depth was measured, a solve that slides
    along the height turns the hull with it, and a fit from that attitude ends in a minimum beside
    the right one.

    pose: gives the position of the survey's centre, (3,) in M. cad_model: gives the attitude, and
    the sigma of the height.
    """
    guess = cad_model.guess
    # The hull turns about the survey's centre, which stays.
    back = guess.rotation.apply(center[None])
    as_guessed = Poses(guess.quaternion, pose.apply(center[None]) - back)
    heights = registration.at_other_heights(as_guessed, cad_model, center)
    return [as_guessed, *heights] if heights else []


def profile_mean_pose(evidence: HullPoseEvidence, pose: Poses) -> Poses:
    """Compute the hull's pose at the posterior mean of its position along the hull."""
    return _profile(evidence, pose, evidence.cad_model.chart.ship_axes[0]).global_from_hull


def hull_pose_covariance(evidence: HullPoseEvidence, pose: Poses) -> Array:
    """Compute the covariance (6, 6) of the hull's pose about the centre, given the points.

    It is what the CAD model's error, its facets and the package's prior leave open. Along the hull
    and along weak directions the cost is not a parabola, and the variance comes from the profile
    likelihood: the posterior's second moment about the delivered pose. Where no depth was measured,
    the height is profiled too, and other heights at which the hull fits are counted: minima along
    it are many and narrow.
    """
    cad_model = evidence.cad_model
    ship_axes = cad_model.chart.ship_axes
    out = profile_likelihood.posterior_covariance(_valley(evidence, pose, ship_axes[0]), pose)
    heights = _at_heights(pose, cad_model, evidence.center)
    held = ship_axes[[0, 2]] if heights else ship_axes[:1]
    for direction in _directions(hull_axes(out, pose), ship_axes, held):
        found = _profile(evidence, pose, direction)
        # The sigma about the delivered pose also holds how far the posterior's mean lies from it
        out = profile_likelihood.inflate_covariance(
            out, replace(found, sigma=float(np.hypot(found.sigma, found.mean))), pose
        )
    if heights:
        valley = _valley(evidence, pose, ship_axes[2])
        moment = profile_likelihood.moment_of_minima(valley, pose, heights)
        out = profile_likelihood.raise_to_moment(out, moment)
    return np.asarray(
        out + _range_scale_covariance(evidence, pose) + _contradiction_covariance(evidence, pose)
    )


def field_as_motion(evidence: HullPoseEvidence, pose: Poses, grid: DeviationGrid) -> Array:
    """Compute the combinations of a deviation field's nodes that the fit takes for a motion.

    A row says how strongly each node, per metre, pulls the fitted hull pose along one of the six
    steps of `perturb_pose`. These parts of the field are in that pose's covariance already, and are
    held so that they do not count twice (`hold_combinations`). What remains is the hull's shape.

    Parameters
    ----------
    evidence
        Points of the fit, the CAD model, and how wrong it may be.
    pose
        global_from_hull, fitted.
    grid
        The grid of the field's nodes.

    Returns
    -------
    Array
        (6, size).
    """
    by_motion = pose_cost.signed_distances(
        evidence.points, pose, evidence.center, evidence.cad_model.mesh
    )[1]
    at = cad_error.chart_coordinates(evidence.cad_model, pose.inverse().apply(evidence.points))
    index, weight = grid.basis(at)
    by_node = np.zeros((len(at), grid.size))
    np.put_along_axis(by_node, index.astype(np.int64), weight, axis=1)
    return np.asarray(by_motion.T @ cho_solve(_factor(evidence, pose), by_node))


def _range_scale_covariance(evidence: HullPoseEvidence, pose: Poses) -> Array:
    """Compute the covariance (6, 6) of the hull pose due to an unknown scale of all ranges.

    The scale is not estimated, as a path that is bent by centimetres would pass for one. So the
    covariance is that of the step by which the fit moves where all ranges grow by one sigma.
    """
    valley = _valley(evidence, pose, evidence.cad_model.chart.ship_axes[0])
    _, jacobian = pose_cost.signed_distances(
        evidence.points, pose, evidence.center, evidence.cad_model.mesh
    )
    # How distances change as the points move: as if the hull moved the other way
    farther = -(jacobian[:, :3] * evidence.by_range).sum(axis=1)
    pulled = jacobian.T @ cho_solve(valley.cost.factor, farther)
    step = np.linalg.solve(valley.cost.linearise(pose).information, pulled)
    return np.outer(step, step)


def _contradiction_covariance(evidence: HullPoseEvidence, pose: Poses) -> Array:
    """Compute the covariance (6, 6) that a contradicted guess or CAD model adds. Otherwise zero.

    Guess or fit may be wrong, so one sigma reaches from the fit to the guess (docs/methods.md 20).
    """
    if not evidence.cad_model.contradicted:
        return np.zeros((6, 6))
    # The step is in M's axes. A covariance has its translation in g
    step = pose_cost.prior_step(pose, evidence.cad_model, evidence.center)
    apart = np.r_[evidence.cad_model.guess.rotation.as_matrix()[0] @ step[:3], step[3:]]
    return np.outer(apart, apart)


def _profile(
    evidence: HullPoseEvidence, pose: Poses, direction: Array
) -> profile_likelihood.Profile:
    """Compute the posterior of a shift along a unit direction (3,) of M.

    It is computed within three sigmas of the guess to either side of `pose`.
    """
    valley = _valley(evidence, pose, direction)
    return profile_likelihood.profile(
        valley,
        pose,
        reach=3 * float(np.linalg.norm(direction * evidence.cad_model.guess_sigma[:3])),
    )


def _valley(evidence: HullPoseEvidence, pose: Poses, direction: Array) -> profile_likelihood.Valley:
    """Make the cost of the hull's pose, with the unit direction (3,) in M that is profiled.

    pose: at which the covariance of the distances is computed.
    """
    cost = pose_cost.HullPoseCost(
        points=evidence.points,
        cad_model=evidence.cad_model,
        center=evidence.center,
        factor=_factor(evidence, pose),
    )
    return profile_likelihood.Valley(cost=cost, direction=direction)


def _factor(evidence: HullPoseEvidence, pose: Poses) -> CholeskyFactor:
    """Factorise the covariance of the distances: the CAD model's error, and loose segments."""
    at, by_segments = pose.inverse().apply(evidence.points), evidence.distances_by_segments(pose)
    covariance = cad_error.distance_covariance(evidence.cad_error_model, evidence.cad_model, at)
    return cho_factor(covariance + by_segments @ by_segments.T, lower=True)


def _directions(hull_in_axes: Array, ship_axes: Array, always: Array) -> list[Array]:
    """List the directions in M that are profiled: given ones, and weak ones that differ from them.

    Parameters
    ----------
    hull_in_axes
        Covariance (6, 6) of the hull's pose in M's axes.
    ship_axes
        Rows (3, 3) forward, port, up in M.
    always
        (k, 3) unit vectors in M that are listed anyway.
    """
    weak = [
        np.array(w["direction"])
        for w in find_weak_directions(hull_in_axes, ship_axes)
        if w["kind"] == "position"
    ]
    # within 26 degrees, the profile of a given direction stands for the weak one
    return [*always, *(d for d in weak if np.abs(always @ d).max() < 0.9)]
