# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Levenberg-Marquardt on one pose whose cost is given linearised [Triggs2000].

The cost must be one function of the pose, as its values before and after a step decide whether the
step is taken. Iterations with other unknowns than a pose, or with a cost that changes on the way
(inliers chosen again, weights by the last residuals), are written where they are used: those of
vision for two views, and that of two surveys.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

# Factor of the information's diagonal that is added to it, at first, at least and at most. A step
# with the largest damping is too small to lower the cost, so the minimum is reached.
FIRST_DAMPING = 1e-4
LEAST_DAMPING = 1e-9
MOST_DAMPING = 1e6


@dataclass(frozen=True, kw_only=True)
class LinearisedCost:
    """A cost at a pose, with its derivatives by the step of an update."""

    cost: float  # half the chi-square
    gradient: Array  # (6,) of the cost
    information: Array  # (6, 6) Gauss-Newton approximation of its Hessian


@dataclass(frozen=True, kw_only=True)
class PoseSolution:
    """The minimum of a cost over a pose."""

    pose: Poses  # a batch of one
    at_minimum: LinearisedCost  # the cost at this pose


def minimise_over_pose(
    start: Poses,
    linearise: Callable[[Poses], LinearisedCost],
    update: Callable[[Poses, Array], Poses],
    *,
    max_iterations: int,
    min_decrease: float = 0.0,
    min_relative_decrease: float = 0.0,
    free_directions: Callable[[Poses], Array] | None = None,
) -> PoseSolution:
    """Minimise a cost over a pose by damped Gauss-Newton steps.

    A step that raises the cost is not taken, and tried again with more damping. So the result is
    the best pose found, also where `max_iterations` ends the search before the minimum.

    Parameters
    ----------
    start
        Pose to start from, a batch of one.
    linearise
        Computes the cost and its derivatives at a pose.
    update
        Applies a step (6,) to a pose.
    max_iterations
        Largest number of steps, accepted and rejected ones.
    min_decrease, min_relative_decrease
        The iteration ends when an accepted step lowers the cost by less than either.
    free_directions
        Computes a basis (6, k) of the steps that are allowed at a pose. By default all six are.
    """
    pose, here, damping = start, linearise(start), FIRST_DAMPING
    for _ in range(max_iterations):
        basis = np.eye(6) if free_directions is None else free_directions(pose)
        # Only steps in the span of the basis: the unknowns are its k coefficients
        reduced = basis.T @ here.information @ basis
        step = -basis @ np.linalg.solve(
            reduced + damping * np.diag(np.diag(reduced)), basis.T @ here.gradient
        )
        trial = update(pose, np.asarray(step))
        there = linearise(trial)
        if there.cost > here.cost:
            damping *= 10
            if damping > MOST_DAMPING:
                break
            continue
        decrease, cost_before = here.cost - there.cost, here.cost
        pose, here, damping = trial, there, max(damping / 5, LEAST_DAMPING)
        if decrease < min_decrease or decrease < min_relative_decrease * cost_before:
            break
    return PoseSolution(pose=pose, at_minimum=here)
