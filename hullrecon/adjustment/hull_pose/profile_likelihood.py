# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Profile likelihood along the weak direction of the hull's pose (docs/methods.md 9).

Along a parallel side the cost is a flat valley and no parabola, so that the Hessian at the optimum
does not say how well the position is known. Here the hull is held at steps along its weak direction
while the remaining five degrees of freedom are fitted, with the CAD model's error as correlated
noise. The posterior over the steps gives mean and sigma.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hullrecon.adjustment.hull_pose.pose_cost import HullPoseCost, perturb_pose
from hullrecon.geometry.pose_solver import minimise_over_pose
from hullrecon.geometry.poses import Poses
from hullrecon.threads import in_threads
from hullrecon.typing import Array

MAX_ITERATIONS = 40  # of one fit
SAME_MINIMUM = 2.0  # sigmas between two fits below which they are the same minimum
MIN_DECREASE = 1e-3  # of the cost, half the chi-square, that goes on: one sigma costs 0.5


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Posterior of a shift of the hull along a direction."""

    direction: Array  # (3,) unit in M
    step: Array  # (k,) m along it
    cost: Array  # (k,) half the chi-square, the lowest is zero
    mean: float  # m, of the posterior
    sigma: float  # m, of the posterior
    global_from_hull: Poses  # at the mean
    # (6,) motion of the pose per metre of step (translation in g, rotation in M, about the centre)
    tangent: Array


@dataclass(frozen=True, kw_only=True)
class Valley:
    """A cost of the hull's pose, and the weak direction along which it is profiled."""

    cost: HullPoseCost
    direction: Array  # (3,) unit in M


def profile(valley: Valley, start: Poses, reach: float, count: int = 41) -> Profile:
    """Compute the posterior of a shift along the valley.

    The pose at its mean is the one that is delivered, and its sigma goes into the covariance.

    Parameters
    ----------
    valley
        Cost and direction.
    start
        Pose global_from_hull in the middle.
    reach
        Largest shift to either side, m.
    count
        Number of steps, odd.
    """
    steps = np.linspace(-reach, reach, count)
    fits = _fit_steps(valley, start, steps)
    cost = np.array([cost for _, cost in fits])
    weight = np.exp(-(cost - cost.min()))
    weight /= weight.sum()
    mean = float(weight @ steps)
    sigma = float(np.sqrt(weight @ (steps - mean) ** 2))
    along = _in_global(valley, start)
    at_mean, _ = _fit(valley, _shift(valley, start, mean * along), held=along)
    # The tangent is a regression over all steps, weighted by the posterior: in a flat valley a
    # single fit ends a centimetre from its minimum, or at a facet's edge.
    moves = np.array([_step_between(at_mean, pose, valley.cost.center) for pose, _ in fits])
    tangent = (weight * (steps - mean)) @ moves / max(sigma**2, 1e-12)
    return Profile(
        direction=valley.direction,
        step=steps,
        cost=cost - cost.min(),
        mean=mean,
        sigma=sigma,
        global_from_hull=at_mean,
        tangent=tangent,
    )


def inflate_covariance(covariance: Array, found: Profile, global_from_hull: Poses) -> Array:
    """Raise the variance along the profiled direction to that of the profile.

    A metre along the direction moves the pose by `Profile.tangent`, turns included. What is added
    is the covariance of such moves. A covariance whose variance along the direction is larger
    already is returned unchanged.

    Parameters
    ----------
    covariance
        (6, 6) of the hull's pose: translation in g, rotation in M, about the profile's centre.
    found
        The profile. Its tangent has the covariance's order and frames.
    global_from_hull
        The pose, which turns the direction from M into g.
    """
    rotation = global_from_hull.rotation.as_matrix()[0]
    along = np.r_[rotation @ found.direction, np.zeros(3)]  # the direction in g
    lacking = found.sigma**2 - float(along @ covariance @ along)
    if lacking <= 0:
        return covariance
    return np.asarray(covariance + lacking * np.outer(found.tangent, found.tangent))


def raise_to_moment(covariance: Array, moment: Array) -> Array:
    """Raise a covariance (n, n) to a second moment (n, n) where the moment exceeds it.

    Directions in which the covariance is larger already keep their variance.
    The directions are the eigenvectors of the moment, whitened by the covariance.
    """
    root = np.linalg.cholesky(covariance)
    # Whitened, the covariance is the identity, and the moment exceeds it by its eigenvalues over 1
    whitened = np.linalg.solve(root, np.linalg.solve(root, moment).T)
    value, vector = np.linalg.eigh((whitened + whitened.T) / 2)
    beyond = root @ vector * np.sqrt(np.maximum(value - 1, 0))
    return np.asarray(covariance + beyond @ beyond.T)


def moment_of_minima(valley: Valley, pose: Poses, starts: Sequence[Poses]) -> Array:
    """Compute the posterior's second moment (6, 6) about `pose` over several minima.

    The minima are those that fits from `pose` and from `starts` end in, each once. A minimum
    weighs by its likelihood times the volume around it (Laplace's approximation).
    """
    found = sorted((minimise_cost(valley, start) for start in (pose, *starts)), key=lambda f: f[1])
    steps: list[Array] = []
    spreads: list[Array] = []
    logs: list[float] = []
    # From the least cost on: an end near one that was taken already is the same minimum
    for at, cost in found:
        step, spread = _step_between(pose, at, valley.cost.center), posterior_covariance(valley, at)
        apart = [
            (step - other) @ np.linalg.solve(wide + spread, step - other)
            for other, wide in zip(steps, spreads, strict=True)
        ]
        if min(apart, default=np.inf) > SAME_MINIMUM**2:
            steps.append(step)
            spreads.append(spread)
            # Log of the likelihood times the square root of the covariance's determinant
            logs.append(0.5 * float(np.linalg.slogdet(spread)[1]) - cost)
    weight = np.exp(np.array(logs) - max(logs))
    moments = np.array(spreads) + np.einsum("ki,kj->kij", steps, steps)
    return np.asarray(np.tensordot(weight / weight.sum(), moments, axes=1))


def minimise_cost(valley: Valley, start: Poses) -> tuple[Poses, float]:
    """Find the pose of least cost over all six degrees of freedom, and that cost."""
    return _fit(valley, start)


def posterior_covariance(valley: Valley, pose: Poses) -> Array:
    """Compute the covariance (6, 6) of the pose about the centre from the cost's information."""
    return np.asarray(np.linalg.inv(valley.cost.linearise(pose).information))


def _fit_steps(valley: Valley, start: Poses, steps: Array) -> list[tuple[Poses, float]]:
    """Fit the pose with the hull held at each step, and return it with its cost.

    Fits go outwards from the middle step, each from the pose of its neighbour, to both sides at the
    same time. The direction is that of `start` in g for all: if it turned with the hull, a fit
    could leave its step by turning.

    steps (k,): shifts along the direction, m.
    """
    middle = len(steps) // 2
    along = _in_global(valley, start)

    def fit_from(base: Poses, shift_m: float) -> tuple[Poses, float]:
        """Shift a pose along the direction, and fit it there: the pose and its cost."""
        return _fit(valley, _shift(valley, base, shift_m * along), held=along)

    def fit_outwards(outwards: Array) -> list[tuple[Poses, float]]:
        """Fit at the steps of one side, the nearest to the middle first."""
        found = [at_middle]
        for nearer, farther in pairwise((steps[middle], *outwards)):
            found.append(fit_from(found[-1][0], farther - nearer))
        return found[1:]

    at_middle = fit_from(start, steps[middle])
    below, above = in_threads(fit_outwards, [steps[:middle][::-1], steps[middle + 1 :]])
    return [*below[::-1], at_middle, *above]


def _in_global(valley: Valley, pose: Poses) -> Array:
    """Compute the valley's direction (3,) in g."""
    return np.asarray(pose.rotation.as_matrix()[0] @ valley.direction)


def _shift(valley: Valley, global_from_hull: Poses, step: Array) -> Poses:
    """Move a hull pose by a step (3,) m in g."""
    return perturb_pose(global_from_hull, valley.cost.center, np.r_[step, np.zeros(3)])


def _fit(valley: Valley, start: Poses, held: Array | None = None) -> tuple[Poses, float]:
    """Find the pose of least cost near a start, and its cost (half the chi-square).

    held (3,): a direction of g along which the hull is not moved. None: all six are free.
    """
    basis = np.eye(6) if held is None else _basis_across(held)
    found = minimise_over_pose(
        start,
        valley.cost.linearise,
        valley.cost.update,
        max_iterations=MAX_ITERATIONS,
        min_decrease=MIN_DECREASE,
        free_directions=lambda _: basis,
    )
    return found.pose, found.at_minimum.cost


def _basis_across(direction: Array) -> Array:
    """Make a basis (6, 5) of the steps that do not move along a unit direction (3,) in g."""
    basis = np.linalg.svd(direction[None])[2][1:].T
    out = np.zeros((6, 5))
    out[:3, :2], out[3:, 2:] = basis, np.eye(3)
    return out


def _step_between(a: Poses, b: Poses, center: Array) -> Array:
    """Compute the step (6,) of `perturb_pose` that takes pose a to b."""
    shift = b.apply(center[None])[0] - a.apply(center[None])[0]
    return np.asarray(np.r_[shift, (a.rotation.inv() * b.rotation).as_rotvec()[0]])
