# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""SLAM by one extended Kalman filter: a submap, or a whole mission [Aulinas2011 Alg. 4]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.association.methods import joint_compatibility, nearest_neighbours
from hullrecon.studies.association.point_sets import Association, PointSets, chi_square
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.models import (
    Car,
    block_diagonal,
    invert,
    invert_jacobian,
    observe,
    observe_jacobians,
    place,
    place_by_points,
    place_by_pose,
    sighted_covariance,
    sighted_points,
    wrap,
)
from hullrecon.studies.submaps.worlds import Log, Scan
from hullrecon.typing import Array, Ints

CONFIDENCE = 0.99  # of a pair, and of all pairs of a scan
# A point that no landmark explains at this confidence is a new landmark. One that a landmark
# explains at this but not at CONFIDENCE is left out.
NEW_CONFIDENCE = 0.9999
MARGIN_M = 4.0  # landmarks farther than the farthest reading by this are not tried
START = 1e-9  # m^2 and rad^2, variances of the pose at a map's start


@dataclass(frozen=True, kw_only=True)
class Limits:
    """When a submap is full."""

    landmarks: int = 15  # as printed, p. 50
    sigma_m: float = 1.0  # of the car's position; the thesis names such a bound, not its value


@dataclass(frozen=True, kw_only=True)
class PathPoint:
    """The filter at a scan."""

    step: int
    pose: Array  # (3,) in the map's frame
    covariance: Array  # (3, 3)
    nis: float  # normalised innovation squared (3.22)
    degrees: int  # of freedom, of nis


class EkfMap:
    """A car and landmarks in the frame of the first pose, in one state (3.16).

    The thesis takes each Jacobian at the newest estimate, (3.8) and (3.9). A pose or a landmark
    linearised both before and after an update then seems to give information on the heading that no
    reading gave. With `first_estimates` a landmark is linearised where it was placed first, a pose
    where it was predicted [Huang2010].
    """

    def __init__(self, effort: Effort, whole: bool = False, first_estimates: bool = False) -> None:
        """Start an empty map.

        Parameters
        ----------
        effort
            Counts the multiplications that the filter takes.
        whole
            Multiply F and H as they are printed, or leave out their ones and zeros.
        first_estimates
            Take Jacobians at first estimates, or at the newest ones, as they are printed.
        """
        self.mean = np.zeros(3)  # the car's pose, what a method adds, x and y of each landmark
        self.covariance = np.eye(3) * START
        self.fixed = 3  # rows before the landmarks: the car's pose, and what a method adds
        self.truth: list[int] = []  # true number of each landmark, only for judging
        self.path: list[PathPoint] = []
        self.wrong_pairs = 0  # against the truth
        self._whole = whole
        self._first_estimates = first_estimates
        self._predicted = self.mean.copy()  # the car at the last scan, before its update
        self._placed = np.zeros((0, 2))  # the landmarks when they were added
        self._effort = effort

    @property
    def landmarks(self) -> Array:
        """Places of the landmarks (n, 2)."""
        return self.mean[self.fixed :].reshape(-1, 2)

    def predict(
        self,
        car: Car,
        odometry: Array,
        step_s: Array,
        noise: Array,
        covariance_at: Array | None = None,
    ) -> None:
        """Move the car by the odometry since the last scan (3.7). Landmarks stay.

        Parameters
        ----------
        car
            The motion model.
        odometry, step_s
            Speed and steering (k, 2), and duration (k,) of each step since the last scan.
        noise
            Covariance (2, 2) of a step's speed and steering.
        covariance_at
            Speed and steering (k, 2) at which the odometry's covariance is taken to second order.
            If absent, it is taken at `odometry` to first order, as printed.
        """
        before = self.mean[:3].copy()
        start = self._predicted if self._first_estimates else before
        self.mean[:3], by_pose, spread = car.move_steps(before, odometry, step_s, noise)
        if covariance_at is not None:
            spread = car.spread(before, covariance_at, step_s, noise, with_product=True)
        # how heading moves the position, from where the step is linearised to where it ends
        by_pose[:2, 2] = start[1] - self.mean[1], self.mean[0] - start[0]
        self._predicted = self.mean[:3].copy()
        size = len(self.mean)
        # The same result by products of whole matrices, as printed, or of what changes alone
        if self._whole:
            moved = np.eye(size)  # F
            moved[:3, :3] = by_pose
            self.covariance = moved @ self.covariance @ moved.T
            self._effort.count(2, size, size, size)
        else:
            self.covariance[:3] = by_pose @ self.covariance[:3]
            self.covariance[:, :3] = self.covariance[:, :3] @ by_pose.T
            self._effort.count(2, 3, 3, size)
        self.covariance[:3, :3] += spread

    def observe(self, step: int, scan: Scan, noise: Array) -> None:
        """Pair a scan's readings with landmarks, update by the pairs, and add new landmarks.

        step: the odometry step that the scan follows. noise: covariance (2, 2) of a reading.
        """
        found, near, distance = self._associate(scan.readings, noise)
        landmarks = [int(near[i]) for i, _ in found.pairs]
        readings = [j for _, j in found.pairs]
        nis = self.update(landmarks, scan.readings[readings], noise) if found.pairs else 0.0
        self._judge(scan, landmarks, readings)
        best = distance.min(axis=0, initial=np.inf)
        far = np.flatnonzero(best > chi_square(NEW_CONFIDENCE, 2)).tolist()
        self._add([j for j in far if j not in readings], scan, noise)
        self.path.append(
            PathPoint(
                step=step,
                pose=self.mean[:3].copy(),
                covariance=self.covariance[:3, :3].copy(),
                nis=nis,
                degrees=2 * len(readings),
            )
        )

    def _associate(self, readings: Array, noise: Array) -> tuple[Association, Ints, Array]:
        """Pair landmarks near the car with readings (m, 2), both as points in the car's frame.

        Returns
        -------
        Association
            Pairs of a row of the near landmarks and a reading.
        Ints
            (n,) the near landmarks' numbers in the map.
        Array
            (n, m) squared Mahalanobis distances of all pairs.
        """
        farthest = readings[:, 0].max(initial=0.0) + MARGIN_M
        off = self.landmarks - self.mean[:2]
        near = np.asarray(np.flatnonzero((np.abs(off) < farthest).all(axis=1)), dtype=np.int64)
        pose_from_map = invert(self.mean[:3])
        by_pose = place_by_pose(pose_from_map, self.landmarks[near])
        jacobian = np.zeros((2 * len(near), 3 + 2 * len(near)))
        jacobian[:, :3] = by_pose @ invert_jacobian(self.mean[:3])
        jacobian[:, 3:] = place_by_points(pose_from_map, len(near))
        rows = np.concatenate([np.arange(3), self.rows(near)])
        part = self.covariance[np.ix_(rows, rows)]
        spread = block_diagonal(sighted_covariance(readings, noise))
        sets = PointSets(
            first=place(pose_from_map, self.landmarks[near]),
            second=sighted_points(readings),
            first_covariance=jacobian @ part @ jacobian.T,
            second_covariance=spread,
        )
        return pair_points(sets), near, sets.squared_distances

    def update(self, landmarks: list[int], readings: Array, noise: Array) -> float:
        """Update the state by readings (m, 2) of landmarks (3.10).

        landmarks: (m) numbers in the map. noise: covariance (2, 2) of a reading. Returns the
        normalised innovation squared.
        """
        points = self.landmarks[landmarks]
        if self._first_estimates:
            by_pose, by_point = observe_jacobians(self._predicted, self._placed[landmarks])
        else:
            by_pose, by_point = observe_jacobians(self.mean[:3], points)
        columns = np.concatenate([np.arange(3), self.rows(np.array(landmarks))])
        jacobian = np.concatenate([by_pose.reshape(-1, 3), block_diagonal(by_point)], axis=1)
        if self._whole:
            jacobian, columns = self._printed(jacobian, columns), np.arange(len(self.mean))
        carried = self.covariance[:, columns] @ jacobian.T
        spread = jacobian @ carried[columns]
        self._effort.count(len(jacobian), len(columns), len(self.mean) + len(jacobian))
        spread += block_diagonal(np.broadcast_to(noise, (len(landmarks), 2, 2)))
        innovation = readings - observe(self.mean[:3], points)
        innovation[:, 1] = wrap(innovation[:, 1])
        nis = update_state(self.mean, self.covariance, carried, spread, innovation.ravel())
        self.mean[2] = wrap(self.mean[2])
        self._effort.count(len(self.mean), len(self.mean), 2 * len(landmarks))
        return nis

    def _printed(self, jacobian: Array, columns: Ints) -> Array:
        """Widen a Jacobian (2m, k) by k columns of the state to all of them, as (3.20) prints H."""
        whole = np.zeros((len(jacobian), len(self.mean)))
        whole[:, columns] = jacobian
        return whole

    def _add(self, new: list[int], scan: Scan, noise: Array) -> None:
        """Add readings as landmarks, with the covariance that the car and the laser give them.

        new: rows of the scan's readings. noise: covariance (2, 2) of a reading.
        """
        if not new:
            return
        readings = scan.readings[new]
        points = place(self.mean[:3], sighted_points(readings))
        seen_from = self._predicted if self._first_estimates else self.mean[:3]
        by_pose, by_point = observe_jacobians(seen_from, points)
        back = np.linalg.inv(by_point)  # a point is where its reading says: h (3.5) the other way
        by_pose = -(back @ by_pose).reshape(-1, 3)
        spread = back @ noise @ back.transpose(0, 2, 1)
        across = by_pose @ self.covariance[:3]
        own = by_pose @ self.covariance[:3, :3] @ by_pose.T + block_diagonal(spread)
        self.mean = np.concatenate([self.mean, points.ravel()])
        self.covariance = np.block([[self.covariance, across.T], [across, own]])
        self._placed = np.concatenate([self._placed, points])
        self.truth += [scan.truth[j] if scan.truth else -1 for j in new]

    def _judge(self, scan: Scan, landmarks: list[int], readings: list[int]) -> None:
        """Count the pairs of landmark and reading that are wrong, where the truth is known."""
        if scan.truth:
            pairs = zip(landmarks, readings, strict=True)
            self.wrong_pairs += sum(self.truth[i] != scan.truth[j] for i, j in pairs)

    def rows(self, landmarks: Ints) -> Ints:
        """Find the rows (2n,) of the state that hold x and y of landmarks (n,)."""
        rows = self.fixed + 2 * landmarks[:, None] + np.arange(2)
        return np.asarray(rows.ravel(), dtype=np.int64)


def update_state(
    mean: Array, covariance: Array, carried: Array, spread: Array, innovation: Array
) -> float:
    """Update a state in place (3.11), and return the normalised innovation squared (3.22).

    Joseph's form multiplied out, with W = P H' S^-1: P - (P H' L^-T) (P H' L^-T)', where
    L L' = S. It stays symmetric, and costs n n k where the product of matrices costs n n n.

    Parameters
    ----------
    mean, covariance
        As predicted, (n,) and (n, n).
    carried
        P H' (n, k).
    spread
        S = H P H' + R (k, k).
    innovation
        z - h(x) (k,).
    """
    whitening = np.linalg.inv(np.linalg.cholesky(spread))
    half = carried @ whitening.T
    white = whitening @ innovation
    mean += half @ white
    covariance -= half @ half.T
    return float(white @ white)


def pair_points(sets: PointSets) -> Association:
    """Pair points by joint compatibility, or by nearest neighbour where that leaves no doubt.

    Nearest neighbours that are jointly compatible, with every point paired that has a
    candidate, are as many pairs as joint compatibility can find.
    """
    nearest = nearest_neighbours(sets, CONFIDENCE)
    paired = int(sets.compatible(CONFIDENCE).any(axis=0).sum())
    bound = chi_square(CONFIDENCE, max(1, 2 * len(nearest.pairs)))
    if len(nearest.pairs) == paired and nearest.squared_distance < bound:
        return nearest
    return joint_compatibility(sets, CONFIDENCE, most_tests=2000)


def build_map(
    log: Log,
    first_step: int,
    limits: Limits | None,
    effort: Effort,
    whole: bool = False,
    first_estimates: bool = False,
) -> tuple[EkfMap, int]:
    """Build one map from a step on, until it is full, or to the last scan where it has no limits.

    Parameters
    ----------
    log
        The mission.
    first_step
        First step of the map. Its frame is that of the car before this step.
    limits
        When it is full.
    effort
        What it costs is added here.
    whole
        Multiply F and H as they are printed, or leave out their zeros.
    first_estimates
        Take Jacobians at first estimates, or at the newest, as they are printed.

    Returns
    -------
    EkfMap
        The map, whose car is where the last scan was taken.
    int
        The step after its last.
    """
    built, step = EkfMap(effort, whole, first_estimates), first_step
    for number in sorted(number for number in log.scans if number >= first_step):
        moved = slice(step, number + 1)
        at = None if log.covariance_at is None else log.covariance_at[moved]
        built.predict(log.car, log.odometry[moved], log.step_s[moved], log.noise.odometry, at)
        built.observe(number, log.scans[number], log.noise.laser)
        step = number + 1
        if limits is not None and _full(built, limits):
            break
    return built, step


def _full(built: EkfMap, limits: Limits) -> bool:
    """Tell whether a map has enough landmarks, or its car is too unsure, to go on with it."""
    position = float(np.trace(built.covariance[:2, :2]))
    return len(built.landmarks) >= limits.landmarks or position > limits.sigma_m**2
