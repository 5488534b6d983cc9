# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The weak direction profiled: how sure the position along the hull really is (docs/methods.md 9).

The Hessian at the optimum sees the CAD model's curvature at one place; the valley is flat and not parabolic. Here the hull is
held at steps along its weak direction while the other five freedoms and the CAD model's error (as correlated noise) settle. The
posterior over the steps gives mean and sigma.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_solve

from hullrecon.adjustment.hull_pose.registration import (
    perturb_pose,
    prior_rows,
    prior_step,
    signed_distances,
)
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.poses import Poses
from hullrecon.native import MeshIndex
from hullrecon.typing import Array


@dataclass(frozen=True)
class Profile:
    """step (k,) m along `direction` (3,) unit in M; cost (k,), lowest zero; mean and sigma (m) of the posterior; global_from_hull:
    T_g_M at the mean; tangent (6,): how T_g_M (translation in g, rotation in M, about the centre) moves per metre of step."""

    direction: Array
    step: Array
    cost: Array
    mean: float
    sigma: float
    global_from_hull: Poses
    tangent: Array


@dataclass(frozen=True)
class Valley:
    """What a profile needs: points (n, 3) in g that lie on the hull, the weak direction (3,) unit in M, the CAD model, the
    survey's centre in M, the CAD model's index, the Cholesky factor of the points' errors (the CAD model's field and noise)."""

    points: Array
    direction: Array
    cad_model: CadModel
    center: Array
    index: MeshIndex
    factor: Any


def profile(v: Valley, start: Poses, reach: float, count: int = 41) -> Profile:
    """The posterior of a shift along the valley within +-`reach` metres of `start` (T_g_M)."""
    steps = np.linspace(-reach, reach, count)
    cost = np.array([cost for _, cost in _walk(v, start, steps)])
    weight = np.exp(-(cost - cost.min()))
    weight /= weight.sum()
    mean = float(weight @ steps)
    sigma = float(np.sqrt(weight @ (steps - mean) ** 2))
    here, _ = _settle(v, _shifted(v, start, mean))
    ahead, _ = _settle(v, _shifted(v, here, 0.5 * sigma))
    tangent = _between(here, ahead, v.center) / max(0.5 * sigma, 1e-6)
    return Profile(v.direction, steps, cost - cost.min(), mean, sigma, here, tangent)


def inflate_covariance(covariance: Array, found: Profile, global_from_hull: Poses) -> Array:
    """Covariance (6, 6) of T_g_M whose variance along the profiled direction is the profile's, moving along its valley."""
    to_hull = global_from_hull.rotation.as_matrix()[0].T
    along = np.r_[to_hull.T @ found.direction, np.zeros(3)]
    lacking = found.sigma**2 - float(along @ covariance @ along)
    if lacking <= 0:
        return covariance
    return np.asarray(covariance + lacking * np.outer(found.tangent, found.tangent))


def minimise_cost(v: Valley, start: Poses) -> tuple[Poses, float]:
    """T_g_M at the optimum of all six freedoms, and half the sum of squares there."""
    return _settle(v, start, held=False)


def posterior_covariance(v: Valley, place: Poses) -> Array:
    """Covariance (6, 6) of T_g_M about the centre, of the points and the package's prior alone."""
    return np.asarray(np.linalg.inv(_linearised(v, place)[2]))


def _walk(v: Valley, start: Poses, steps: Array) -> list[tuple[Poses, float]]:
    """Settled poses and costs at the steps, each started from its neighbour nearer to the middle."""
    middle = len(steps) // 2
    found: dict[int, tuple[Poses, float]] = {}
    for order in (range(middle, len(steps)), range(middle - 1, -1, -1)):
        for k in order:
            near = k - 1 if k > middle else k + 1
            base, walked = (found[near][0], steps[k] - steps[near]) if near in found else (start, steps[k])
            found[k] = _settle(v, _shifted(v, base, walked))
    return [found[k] for k in range(len(steps))]


def _shifted(v: Valley, global_from_hull: Poses, step: float) -> Poses:
    in_global = global_from_hull.rotation.as_matrix()[0] @ v.direction
    return perturb_pose(global_from_hull, v.center, np.r_[step * in_global, np.zeros(3)])


def _settle(v: Valley, pose: Poses, held: bool = True, most: int = 40) -> tuple[Poses, float]:
    """T_g_M with its shift along the direction `held`, or not, and the rest at the optimum (Levenberg-Marquardt); and half the
    sum of squares there."""
    cost, right, information = _linearised(v, pose)
    damping = 1e-4
    for _ in range(most):
        free = _across(pose.rotation.as_matrix()[0] @ v.direction) if held else np.eye(6)
        reduced = free.T @ information @ free
        step = -free @ np.linalg.solve(reduced + damping * np.diag(np.diag(reduced)), free.T @ right)
        trial = perturb_pose(pose, v.center, np.asarray(step))
        there = _linearised(v, trial)
        if there[0] > cost:
            damping *= 10
            if damping > 1e6:
                break
            continue
        gain = cost - there[0]
        pose, damping = trial, max(damping / 5, 1e-9)
        cost, right, information = there
        if gain < 1e-3:
            break
    return pose, cost


def _linearised(v: Valley, pose: Poses) -> tuple[float, Array, Array]:
    """Cost, gradient (6,) and information (6, 6) at T_g_M."""
    distance, jacobian = signed_distances(v.points, pose, v.center, v.index)
    solved = cho_solve(v.factor, np.c_[jacobian, distance])
    whitened = prior_rows(v.cad_model)
    prior = prior_step(pose, v.cad_model, v.center) / v.cad_model.guess_sigma
    cost = 0.5 * float(distance @ solved[:, 6] + prior @ prior)
    return cost, jacobian.T @ solved[:, 6] + whitened.T @ prior, jacobian.T @ solved[:, :6] + whitened.T @ whitened


def _across(direction: Array) -> Array:
    """Basis (6, 5) of the steps that do not move along a unit direction (3,) in g."""
    basis = np.linalg.svd(direction[None])[2][1:].T
    out = np.zeros((6, 5))
    out[:3, :2], out[3:, 2:] = basis, np.eye(3)
    return out


def _between(a: Poses, b: Poses, center: Array) -> Array:
    """The step (6,) of `perturb_pose` that takes T_g_M a to b."""
    shift = b.apply(center[None])[0] - a.apply(center[None])[0]
    return np.asarray(np.r_[shift, (a.rotation.inv() * b.rotation).as_rotvec()[0]])
