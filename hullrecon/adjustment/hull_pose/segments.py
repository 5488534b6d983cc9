# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Segments of a path that outages cut, each registered to the CAD model (docs/methods.md 5).

Where the DVL gave no velocity and no image joins the nodes before with those after, the two parts
of the path are known to metres relative to each other, and no pose of the CAD model fits both. The
segment with most returns, the reference, is registered to the CAD model. The other segments are
moved onto it, within the covariance that the path leaves them. Then path and CAD model are moved so
that the first segment lies where it did, as the first node defines the frame g.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from hullrecon import native
from hullrecon.adjustment.hull_pose import pose_cost, registration
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry import poses
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import Odometry
from hullrecon.typing import Array, Ints, Mask

# A path is cut where the motion from one node with returns to the next has a larger sigma: no pose
# of the CAD model fits both sides
LOOSE_M = 0.3
MIN_POINTS = 30  # returns of a segment, below which it is not registered
MOST_POINTS = 800  # of a segment that are fitted
# Grid search for a segment's position: reach in sigmas of its guess, and step in m, which is wider
# where there would be more than MOST_STEPS steps
SEARCH_SIGMAS, SEARCH_STEP_M, MOST_STEPS = 2.5, 0.5, 41
SEARCH_POINTS = 150  # of a segment that are compared at each step
LEAST_SIGMA = np.r_[0.02, 0.02, 0.02, np.radians([0.1, 0.1, 0.1])]  # m, rad of a guess
WRONG_SIDE_M = 1.0  # least distance counted for a point on a face that its beam met from inside


@dataclass(frozen=True, kw_only=True)
class Segments:
    """The segments of a path, in the order of time."""

    of_node: Ints  # (n,) segment of each node; -1 in an outage, or in a segment with few returns
    reference: int  # the segment with most returns
    # (s, 6, 6) covariance (translation, rotation) in g of the pose of each segment's middle node,
    # relative to the near end of its neighbour towards the reference. Zero for the reference
    step_covariance: Array

    def __len__(self) -> int:
        return len(self.step_covariance)

    @property
    def loosest_m(self) -> float:
        """Largest sigma of a segment's position relative to its neighbour, along the worst axis."""
        return float(np.sqrt(np.linalg.eigvalsh(self.step_covariance[:, :3, :3])[:, -1].max()))

    def towards_reference(self, segment: int) -> int:
        """Find the neighbour of a segment that is nearer to the reference."""
        return segment + int(np.sign(self.reference - segment))

    def from_reference(self, segment: int) -> Array:
        """Sum the covariance (6, 6) of the steps between a segment and the reference, in g."""
        low, high = sorted((segment, self.reference))
        return np.asarray(self.step_covariance[low : high + 1].sum(axis=0))

    def outwards(self) -> list[int]:
        """List all segments but the reference, from its neighbours outwards."""
        return sorted(
            set(range(len(self))) - {self.reference}, key=lambda k: abs(k - self.reference)
        )


def find_segments(
    problem: native.Problem, settings: native.Options, odometry: Odometry, node: Ints
) -> Segments | None:
    """Find the segments into which outages cut a path that was solved without the CAD model.

    Each of them is then registered to the CAD model separately (`register_segments`).

    Parameters
    ----------
    problem, settings
        The path at its solution, and the options with which it was solved.
    odometry
        Motion between its nodes. The path's covariance is computed only across gaps where the
        odometry's sigma is large.
    node
        Node (k,) of each return that is not flagged.

    Returns
    -------
    Segments or None
        None where the path is not cut.

    Raises
    ------
    StageError
        Where nothing determines the path.
    """
    # Cuts: between two nodes with returns, the sigma is large by odometry and by the solved path.
    count = np.bincount(node, minlength=len(problem.unknowns.pose))  # returns of each node
    used = np.flatnonzero(count)
    is_cut = odometry.sigma_between(used[:-1], used[1:]) > LOOSE_M
    if not is_cut.any():
        return None
    covariance = _relative_covariance(problem, settings, used[:-1][is_cut], used[1:][is_cut])
    is_cut[is_cut] = np.linalg.eigvalsh(covariance[:, :3, :3])[:, -1] > LOOSE_M**2
    # The nodes between two cuts are a segment. Segments with few returns are left out.
    stretch = np.concatenate([[0], np.cumsum(is_cut)])  # number of each used node's stretch
    enough = np.bincount(stretch, count[used]) >= MIN_POINTS
    if enough.sum() < 2:
        return None
    of_node = np.full(len(count), -1, np.int64)
    of_node[used] = np.where(enough, np.cumsum(enough) - 1, -1)[stretch]
    size = np.bincount(of_node[used][of_node[used] >= 0], count[used][of_node[used] >= 0])
    found = Segments(
        of_node=of_node, reference=int(np.argmax(size)), step_covariance=np.zeros((len(size), 6, 6))
    )
    # The step to each other segment leads from the near end of its neighbour on the reference's
    # side to its own middle node.
    outer = np.array(found.outwards())
    ends = np.array([_end_towards(found, found.towards_reference(k), k) for k in outer])
    middle = np.array([int(np.median(np.flatnonzero(of_node == k))) for k in outer])
    found.step_covariance[outer] = _relative_covariance(problem, settings, ends, middle)
    return found


def _end_towards(segments: Segments, segment: int, other: int) -> int:
    """Find the node of a segment that is nearest in time to another segment."""
    rows = np.flatnonzero(segments.of_node == segment)
    return int(rows[-1] if other > segment else rows[0])


def _relative_covariance(
    problem: native.Problem, settings: native.Options, first: Ints, second: Ints
) -> Array:
    """Compute the covariance (k, 6, 6) of the second node's pose relative to the first, in g.

    problem, settings: the path at its solution. first, second (k,): nodes of each pair.
    """
    # (k, 14, 14): of each node its translation in g, rotation in the vehicle's axes, tray angle
    joint = native.pair_covariance(
        problem, np.column_stack([first, second]).astype(np.int32), settings
    ).pose
    rotation = Poses(
        problem.unknowns.pose[:, 3:7], problem.unknowns.pose[:, :3]
    ).rotation.as_matrix()
    # Second minus first node, with rotations turned from the vehicle's axes into g
    difference = np.zeros((len(first), 6, 14))
    difference[:, :3, :3], difference[:, :3, 7:10] = -np.eye(3), np.eye(3)
    difference[:, 3:, 3:6], difference[:, 3:, 10:13] = -rotation[first], rotation[second]
    return np.asarray(difference @ joint @ difference.swapaxes(1, 2))


@dataclass(frozen=True, kw_only=True)
class RegisteredPath:
    """A path whose segments were moved onto the CAD model."""

    nodes: Poses  # (n,) global_from_vehicle
    registration: registration.Registration  # to the reference, moved with it


def register_segments(
    segments: Segments,
    nodes: Poses,
    points: Array,
    node: Ints,
    cad_model: CadModel,
    sigma_range: float,
) -> RegisteredPath:
    """Register the CAD model to the reference segment, and move the other segments onto the model.

    The motion of nodes between two segments is interpolated. A segment that does not fit is moved
    as its neighbour towards the reference. Where the reference does not fit, none is moved.

    Parameters
    ----------
    segments
        Which nodes belong together, and how loose each segment is.
    nodes
        The path (n,), global_from_vehicle.
    points, node
        Ends of the returns (k, 3) m in g, and their nodes (k,).
    cad_model
        The mesh, and the guess of its pose relative to the first node.
    sigma_range
        Sigma of a range, m, the noise of a point.
    """
    found = registration.register(
        points[segments.of_node[node] == segments.reference],
        _guess_of_reference(cad_model, segments),
        sigma_range,
    )
    if found.fitness < registration.GOOD_FITNESS:
        return RegisteredPath(nodes=nodes, registration=found)
    # Outwards from the reference: each first moves with its neighbour, then onto the CAD model.
    in_place = replace(found.cad_model, guess=found.global_from_hull)
    moved = [poses.identity() for _ in range(len(segments))]
    for k in segments.outwards():
        before = moved[segments.towards_reference(k)]
        own = segments.of_node[node] == k
        ends, vehicle = before.apply(points[own]), (before @ nodes[node[own]]).translation
        sigma = _sigma_in_hull(
            segments.step_covariance[k], before.inverse() @ found.global_from_hull
        )
        onto = _motion_onto(ends, ends - vehicle, replace(in_place, guess_sigma=sigma), sigma_range)
        moved[k] = onto @ before
    # Move everything so that the first segment lies where it did.
    back = moved[0].inverse()
    after = _move(nodes, segments.of_node, [back @ motion for motion in moved])
    return RegisteredPath(
        nodes=after, registration=replace(found, global_from_hull=back @ found.global_from_hull)
    )


def _guess_of_reference(cad_model: CadModel, segments: Segments) -> CadModel:
    """Widen the guess's sigmas by the covariance of the reference relative to the first segment.

    The package's guess is relative to the first node.
    """
    by_path = _sigma_in_hull(segments.from_reference(0), cad_model.guess)
    return (
        replace(cad_model, guess_sigma=np.hypot(cad_model.guess_sigma, by_path))
        if segments.reference
        else cad_model
    )


def _sigma_in_hull(covariance: Array, global_from_hull: Poses) -> Array:
    """Turn a covariance (6, 6) of (translation, rotation) in g into sigmas (6,) along M's axes."""
    to_hull = np.kron(np.eye(2), global_from_hull.rotation.inv().as_matrix()[0])
    return np.asarray(np.maximum(np.sqrt(np.diag(to_hull @ covariance @ to_hull.T)), LEAST_SIGMA))


def _motion_onto(points: Array, beams: Array, cad_model: CadModel, sigma_range: float) -> Poses:
    """Find the motion in g that moves points onto the CAD model at its guess.

    The identity where they do not fit, or where most lie on the inside of the CAD model.

    Parameters
    ----------
    points
        (n, 3) m in g, of one segment.
    beams
        (n, 3) m in g, vectors from the vehicle to the points.
    cad_model
        At the pose of the reference, with sigmas of the segment relative to it.
    sigma_range
        Sigma of a DVL range, m, the noise of a point.
    """
    kept = registration.thin_points(points, voxel_m=0.10, most_points=MOST_POINTS)
    center = cad_model.guess.inverse().apply(kept).mean(axis=0)
    few = np.linspace(0, len(points) - 1, min(SEARCH_POINTS, len(points))).astype(int)
    found = _search(points[few], beams[few], cad_model, center)
    for _ in range(2):  # twice, as a fit judges outliers by the distances at its start
        fitted = registration.fit_correlated(kept, found, cad_model, center, sigma_range)
        found = fitted.global_from_hull
    on_outside = ~_from_within(points[few], beams[few], found, cad_model.mesh)
    if fitted.fitness < registration.GOOD_FITNESS or on_outside.mean() < registration.GOOD_FITNESS:
        return poses.identity()
    return cad_model.guess @ found.inverse()


def _search(points: Array, beams: Array, cad_model: CadModel, center: Array) -> Poses:
    """Search a grid of shifts along and across the ship for the pose that fits points best.

    A point that lies on the CAD model's inside counts as WRONG_SIDE_M away.

    Parameters
    ----------
    points, beams
        Ends of beams (n, 3) m in g, and the beams' directions (n, 3).
    cad_model
        The CAD model, with the guess of its pose around which the grid lies.
    center
        (3,) m in M, of the points.
    """
    rotate, level = cad_model.guess.rotation.as_matrix()[0], cad_model.chart.ship_axes[:2]
    sigma = np.abs(level) @ cad_model.guess_sigma[:3]
    costs: list[tuple[float, int, Poses]] = []
    for along, across in product(_grid(sigma[0]), _grid(sigma[1])):
        step = np.r_[rotate @ (np.array([along, across]) @ level), 0.0, 0.0, 0.0]
        pose = pose_cost.perturb_pose(cad_model.guess, center, step)
        distance = np.abs(cad_model.mesh.index.closest(pose.inverse().apply(points)).distance)
        distance = np.where(
            _from_within(points, beams, pose, cad_model.mesh),
            np.maximum(distance, WRONG_SIDE_M),
            distance,
        )
        costs.append(
            (registration.trimmed_cost(distance, pose, cad_model, center), len(costs), pose)
        )
    return min(costs, key=lambda entry: entry[:2])[2]


def _grid(sigma_m: float) -> Array:
    """Make the shifts (k,) m of the grid search along one axis, symmetric about zero."""
    steps = min(int(np.ceil(SEARCH_SIGMAS * sigma_m / SEARCH_STEP_M)), MOST_STEPS // 2)
    return np.linspace(-SEARCH_SIGMAS * sigma_m, SEARCH_SIGMAS * sigma_m, 2 * steps + 1)


def _from_within(points: Array, beams: Array, global_from_hull: Poses, mesh: Mesh) -> Mask:
    """Tell which points (n, 3) in g lie on faces that their beams (n, 3) in g met from inside."""
    outward = mesh.index.closest(global_from_hull.inverse().apply(points)).gradient
    return np.asarray(np.sum(global_from_hull.rotation.apply(outward) * beams, axis=1) > 0)


def _move(nodes: Poses, of_node: Ints, moved: list[Poses]) -> Poses:
    """Move nodes (n,) by the motion of their segment. Between segments, interpolate the motion.

    Parameters
    ----------
    nodes
        The path, global_from_vehicle.
    of_node
        (n,) segment of each node, -1 between segments.
    moved
        Motion of each segment in g.
    """
    # For each node the last one before it and the first one after it that has a segment. Both are
    # the same for a node with a segment, and before the first and after the last of these
    known = np.flatnonzero(of_node >= 0)
    at = np.clip(np.arange(len(of_node)), known[0], known[-1])
    after = np.searchsorted(known, at)
    before = np.where(known[after] == at, after, after - 1)
    first, second = known[before], known[after]
    share = (at - first) / np.maximum(second - first, 1)
    motion = Poses(
        np.vstack([pose.quaternion for pose in moved]),
        np.vstack([pose.translation for pose in moved]),
    )
    ends = motion[of_node[first]] @ nodes, motion[of_node[second]] @ nodes
    weight = np.stack([1 - share, share])[:, :, None]
    # q and -q are the same rotation: take the sign with which the two are nearer to each other
    same = np.where(np.sum(ends[0].quaternion * ends[1].quaternion, axis=1) < 0, -1.0, 1.0)[:, None]
    quaternion = weight[0] * ends[0].quaternion + weight[1] * same * ends[1].quaternion
    translation = weight[0] * ends[0].translation + weight[1] * ends[1].translation
    return Poses(quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True), translation)
