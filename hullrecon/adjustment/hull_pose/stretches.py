# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A path that an outage cuts into stretches, each laid onto the CAD model for itself
(docs/methods.md 5).

Where the DVL was silent and no image joins what lies before with what lies after, the two are known
to metres relative to each other, and no pose of the CAD model fits both. The longest stretch is
registered to the CAD model; the others are moved onto it, as far as the path leaves them free. Then
all is moved so that the first one lies where it did: frame g is where the dive began.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from hullrecon import native
from hullrecon.adjustment.hull_pose import registration
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry import poses
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import Odometry
from hullrecon.typing import Array, Ints, Mask

# sigma of the way from one node with returns to the next, from which no pose of the CAD model fits
# both sides
LOOSE_M = 0.3
MIN_POINTS = 30  # of a stretch that is laid for itself
MOST_POINTS = 800
# of the guess; m, wider where there would be more steps than these
SEARCH_SIGMAS, SEARCH_STEP_M, MOST_STEPS = 2.5, 0.5, 41
SEARCH_POINTS = 150
LEAST_SIGMA = np.r_[0.02, 0.02, 0.02, np.radians([0.1, 0.1, 0.1])]
WRONG_SIDE_M = 1.0  # counts for a point that lies on a face that its beam met from within


@dataclass(frozen=True, kw_only=True)
class Stretches:
    """The stretches of a path, in the order of time. of_node (n,): the stretch, -1 in an outage or
    where one has too few returns; reference: the one with most returns. step (s, 6, 6): covariance
    of the middle of a stretch relative to the end of its neighbour towards the reference,
    (translation, rotation) in g; of the reference zero.
    """

    of_node: Ints
    reference: int
    step: Array

    def __len__(self) -> int:
        return len(self.step)

    @property
    def loosest_m(self) -> float:
        """Return the largest sigma by which a stretch is known relative to its neighbour, of the
        axis known worst.
        """
        return float(np.sqrt(np.linalg.eigvalsh(self.step[:, :3, :3])[:, -1].max()))

    def towards_reference(self, stretch: int) -> int:
        """Return the neighbour of a stretch that lies nearer to the reference."""
        return stretch + int(np.sign(self.reference - stretch))

    def from_reference(self, stretch: int) -> Array:
        """Return the covariance (6, 6) of a stretch relative to the reference, in g."""
        low, high = sorted((stretch, self.reference))
        return np.asarray(self.step[low : high + 1].sum(axis=0))

    def outwards(self) -> list[int]:
        """Return all stretches but the reference, each after its neighbour towards it."""
        return sorted(
            set(range(len(self))) - {self.reference}, key=lambda k: abs(k - self.reference)
        )


def find_stretches(
    problem: native.Problem, settings: native.Options, odometry: Odometry, node: Ints
) -> Stretches | None:
    """Return the stretches of a path that was solved without the CAD model; None where it holds
    together. node (m,): of each return that counts.

    Raises StageError where nothing determines the path.
    """
    count = np.bincount(node, minlength=len(problem.unknowns.pose))
    at = np.flatnonzero(count)
    by_odometry = odometry.sigma_between(at[:-1], at[1:])
    loose = by_odometry > LOOSE_M
    if not loose.any():
        return None
    covariance = _relative_covariance(problem, settings, at[:-1][loose], at[1:][loose])
    loose[loose] = np.linalg.eigvalsh(covariance[:, :3, :3])[:, -1] > LOOSE_M**2
    label = np.concatenate([[0], np.cumsum(loose)])
    enough = np.bincount(label, count[at]) >= MIN_POINTS
    if enough.sum() < 2:
        return None
    of_node = np.full(len(count), -1, np.int64)
    of_node[at] = np.where(enough, np.cumsum(enough) - 1, -1)[label]
    size = np.bincount(of_node[at][of_node[at] >= 0], count[at][of_node[at] >= 0])
    found = Stretches(
        of_node=of_node, reference=int(np.argmax(size)), step=np.zeros((len(size), 6, 6))
    )
    outer = np.array(found.outwards())
    ends = np.array([_end_towards(found, found.towards_reference(k), k) for k in outer])
    middle = np.array([int(np.median(np.flatnonzero(of_node == k))) for k in outer])
    found.step[outer] = _relative_covariance(problem, settings, ends, middle)
    return found


def _end_towards(stretches: Stretches, stretch: int, other: int) -> int:
    """Return the node of a stretch that is nearest in time to another one."""
    rows = np.flatnonzero(stretches.of_node == stretch)
    return int(rows[-1] if other > stretch else rows[0])


def _relative_covariance(
    problem: native.Problem, settings: native.Options, first: Ints, second: Ints
) -> Array:
    """Return the covariance (m, 6, 6) of the second node's pose less the first one's, (translation,
    rotation) in g.
    """
    joint = native.pair_covariance(
        problem, np.column_stack([first, second]).astype(np.int32), settings
    ).pose
    rotation = Poses(
        problem.unknowns.pose[:, 3:7], problem.unknowns.pose[:, :3]
    ).rotation.as_matrix()
    difference = np.zeros((len(first), 6, 14))
    difference[:, :3, :3], difference[:, :3, 7:10] = -np.eye(3), np.eye(3)
    difference[:, 3:, 3:6], difference[:, 3:, 10:13] = -rotation[first], rotation[second]
    return np.asarray(difference @ joint @ difference.swapaxes(1, 2))


@dataclass(frozen=True, kw_only=True)
class LaidPath:
    """T_g_v (n) with each stretch moved onto the CAD model, and the CAD model as registered to the
    reference, moved with it.
    """

    nodes: Poses
    registration: registration.Registration


def lay_stretches(
    stretches: Stretches,
    nodes: Poses,
    points: Array,
    node: Ints,
    cad_model: CadModel,
    sigma_range: float,
) -> LaidPath:
    """Return the path with each stretch moved onto the CAD model where the reference's points have
    it, and what lies between two stretches moved with both. One that does not fit is moved with its
    neighbour; where the reference does not fit, none is.

    nodes (n,): T_g_v; points (m, 3) in g and node (m,): of the returns.
    """
    found = registration.register(
        points[stretches.of_node[node] == stretches.reference],
        _guess_of_reference(cad_model, stretches),
        sigma_range,
    )
    if found.fitness < registration.GOOD_FITNESS:
        return LaidPath(nodes=nodes, registration=found)
    in_place = replace(found.cad_model, guess=found.global_from_hull)
    moved = [poses.identity() for _ in range(len(stretches))]
    for k in stretches.outwards():
        before = moved[stretches.towards_reference(k)]
        here = stretches.of_node[node] == k
        at, start = before.apply(points[here]), (before @ nodes[node[here]]).translation
        sigma = _sigma_in_hull(stretches.step[k], before.inverse() @ found.global_from_hull)
        moved[k] = _lay(at, at - start, replace(in_place, guess_sigma=sigma), sigma_range) @ before
    back = moved[0].inverse()
    laid = _move(nodes, stretches.of_node, [back @ motion for motion in moved])
    return LaidPath(
        nodes=laid, registration=replace(found, global_from_hull=back @ found.global_from_hull)
    )


def _guess_of_reference(cad_model: CadModel, stretches: Stretches) -> CadModel:
    """Return the CAD model with the sigmas of its guess as they are for the reference: the guess is
    one of where the dive began.
    """
    by_path = _sigma_in_hull(stretches.from_reference(0), cad_model.guess)
    return (
        replace(cad_model, guess_sigma=np.hypot(cad_model.guess_sigma, by_path))
        if stretches.reference
        else cad_model
    )


def _sigma_in_hull(covariance: Array, global_from_hull: Poses) -> Array:
    """Return the sigmas (6,) along M's axes of a (translation, rotation) with covariance (6, 6) in
    g.
    """
    to_hull = np.kron(np.eye(2), global_from_hull.rotation.inv().as_matrix()[0])
    return np.asarray(np.maximum(np.sqrt(np.diag(to_hull @ covariance @ to_hull.T)), LEAST_SIGMA))


def _lay(points: Array, beams: Array, cad_model: CadModel, sigma_range: float) -> Poses:
    """Return the motion in g that lays points (n, 3) of g onto the CAD model where its guess has
    it, within the guess's sigmas; none where they do not fit. beams (n, 3): from the vehicle to the
    points.
    """
    kept = registration.thin_points(points, 0.10, MOST_POINTS)
    center = cad_model.guess.inverse().apply(kept).mean(axis=0)
    few = np.linspace(0, len(points) - 1, min(SEARCH_POINTS, len(points))).astype(int)
    found = _search(points[few], beams[few], cad_model, center)
    for _ in range(2):  # what counts as an outlier is told by distances at the start
        fitted = registration.fit_correlated(kept, found, cad_model, center, sigma_range)
        found = fitted.global_from_hull
    on_outside = ~_from_within(points[few], beams[few], found, cad_model.mesh)
    if fitted.fitness < registration.GOOD_FITNESS or on_outside.mean() < registration.GOOD_FITNESS:
        return poses.identity()
    return cad_model.guess @ found.inverse()


def _search(points: Array, beams: Array, cad_model: CadModel, center: Array) -> Poses:
    """Return the pose of a grid over the ship's horizontal plane at which points lie best on the
    CAD model's outside.
    """
    rotate, level = cad_model.guess.rotation.as_matrix()[0], cad_model.chart.ship_axes[:2]
    sigma = np.abs(level) @ cad_model.guess_sigma[:3]
    costs: list[tuple[float, int, Poses]] = []
    for along, across in product(_grid(sigma[0]), _grid(sigma[1])):
        step = np.r_[rotate @ (np.array([along, across]) @ level), 0.0, 0.0, 0.0]
        pose = registration.perturb_pose(cad_model.guess, center, step)
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
    """Return offsets around zero, zero among them."""
    steps = min(int(np.ceil(SEARCH_SIGMAS * sigma_m / SEARCH_STEP_M)), MOST_STEPS // 2)
    return np.linspace(-SEARCH_SIGMAS * sigma_m, SEARCH_SIGMAS * sigma_m, 2 * steps + 1)


def _from_within(points: Array, beams: Array, global_from_hull: Poses, mesh: Mesh) -> Mask:
    """Return which points (n, 3) in g lie nearest to a face whose inside their beams (n, 3) met."""
    outward = mesh.index.closest(global_from_hull.inverse().apply(points)).gradient
    return np.asarray(np.sum(global_from_hull.rotation.apply(outward) * beams, axis=1) > 0)


def _move(nodes: Poses, of_node: Ints, moved: list[Poses]) -> Poses:
    """Return T_g_v moved (n): a node of a stretch by its motion, one between two by what lies
    between theirs.
    """
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
    # apart by less than a right angle, whatever sign either has
    same = np.where(np.sum(ends[0].quaternion * ends[1].quaternion, axis=1) < 0, -1.0, 1.0)[:, None]
    quaternion = weight[0] * ends[0].quaternion + weight[1] * same * ends[1].quaternion
    translation = weight[0] * ends[0].translation + weight[1] * ends[1].translation
    return Poses(quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True), translation)
