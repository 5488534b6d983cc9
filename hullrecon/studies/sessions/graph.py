# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A graph of factors, solved by Levenberg and Marquardt on the sparse normal equations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, diags_array
from scipy.sparse.linalg import splu

from hullrecon.studies.sessions.factors import Factors, State
from hullrecon.studies.sessions.motions import moved
from hullrecon.typing import Array, Ints, Mask

MAX_ITERATIONS, LEAST_GAIN = 60, 1e-9  # of the cost, as a share
DAMPING = 1e-6  # at first, of the diagonal


@dataclass(frozen=True, kw_only=True)
class Graph:
    """Factors, and which poses and planes of a state are still in it."""

    factors: tuple[Factors, ...]
    live_poses: Mask  # (n,)
    live_planes: Mask  # (p,)

    @property
    def nodes(self) -> int:
        """Number of poses and planes."""
        return int(self.live_poses.sum() + self.live_planes.sum())

    @property
    def factor_count(self) -> int:
        """Number of factors."""
        return sum(len(table) for table in self.factors)

    def starts(self) -> tuple[Ints, Ints, int]:
        """Compute the first column of each pose (n,) and plane (p,), and the count of all columns.

        A pose has six columns, a plane three. Entries of removed poses and planes have no meaning.
        """
        poses = 6 * (np.cumsum(self.live_poses) - 1)
        first = 6 * int(self.live_poses.sum())
        planes = first + 3 * (np.cumsum(self.live_planes) - 1)
        return poses, planes, first + 3 * int(self.live_planes.sum())


@dataclass(frozen=True, kw_only=True)
class Solution:
    """The state of least cost, and the way there."""

    state: State
    costs: tuple[float, ...]  # before each iteration, and at the end
    converged: bool

    @property
    def iterations(self) -> int:
        """Number of the solver's iterations."""
        return len(self.costs) - 1


def whole(factors: Sequence[Factors], state: State) -> Graph:
    """Make a graph of every pose and plane of a state."""
    return Graph(
        factors=tuple(table for table in factors if len(table)),
        live_poses=np.ones(len(state.poses), bool),
        live_planes=np.ones(len(state.planes), bool),
    )


def compacted(graph: Graph, state: State) -> tuple[Graph, State]:
    """Leave removed poses and planes out of a graph's state, and number the rest anew."""
    numbers = [np.cumsum(live) - 1 for live in (graph.live_poses, graph.live_planes)]
    left = State(poses=state.poses[graph.live_poses], planes=state.planes[graph.live_planes])
    return whole([table.renumbered(*numbers) for table in graph.factors], left), left


def linear_system(graph: Graph, state: State) -> tuple[csc_matrix, Array]:
    """Stack the derivatives of all residuals (rows, columns), and the residuals (rows,)."""
    of_poses, of_planes, size = graph.starts()
    values, rows, columns, residuals = [], [], [], []
    row = 0  # the first one of the next table
    for table in graph.factors:
        at = table.linearise(state)
        count, width = at.residual.shape
        here = row + np.arange(count * width).reshape(count, width)
        for derivative, keys, starts, numbers in (
            (at.by_pose, table.poses, of_poses, 6),
            (at.by_plane, table.planes, of_planes, 3),
        ):
            place = starts[keys][:, :, None, None] + np.arange(numbers)
            values.append(derivative.ravel())
            rows.append(np.broadcast_to(here[:, None, :, None], derivative.shape).ravel())
            columns.append(np.broadcast_to(place, derivative.shape).ravel())
        residuals.append(at.residual.ravel())
        row += count * width
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return coo_matrix(entries, shape=(row, size)).tocsc(), np.concatenate(residuals)


def information(graph: Graph, state: State) -> csc_matrix:
    """Compute the information matrix: of the poses that are there, then of the planes."""
    jacobian, _ = linear_system(graph, state)
    return csc_matrix(jacobian.T @ jacobian)


def solve(graph: Graph, state: State) -> Solution:
    """Minimise the sum of squared residuals from a state [Ozog2016 eqs 1.3, 1.4]."""
    jacobian, residual = linear_system(graph, state)
    costs, damping, converged = [float(residual @ residual)], DAMPING, False
    for _ in range(MAX_ITERATIONS):
        normal, gradient = (jacobian.T @ jacobian).tocsc(), jacobian.T @ residual
        damped = normal + diags_array(damping * normal.diagonal() + 1e-12, format="csc")
        trial = stepped(graph, state, -splu(damped.tocsc()).solve(gradient))
        new_jacobian, new_residual = linear_system(graph, trial)
        cost = float(new_residual @ new_residual)
        if cost > costs[-1] * (1 + 1e-12):
            damping *= 10
            costs.append(costs[-1])
            continue
        gain = 1 - cost / max(costs[-1], 1e-300)
        state, jacobian, residual = trial, new_jacobian, new_residual
        damping = max(0.1 * damping, 1e-12)
        costs.append(cost)
        if gain < LEAST_GAIN:
            converged = True
            break
    return Solution(state=state, costs=tuple(costs), converged=converged)


def stepped(graph: Graph, state: State, step: Array) -> State:
    """Move the poses and planes that are in the graph by a step (columns,) of the solver."""
    size = 6 * int(graph.live_poses.sum())
    by_pose, by_plane = np.zeros((len(state.poses), 6)), np.zeros((len(state.planes), 3))
    by_pose[graph.live_poses] = step[:size].reshape(-1, 6)
    by_plane[graph.live_planes] = step[size:].reshape(-1, 3)
    return State(poses=moved(state.poses, by_pose), planes=state.planes + by_plane)


def covariance(graph: Graph, state: State) -> Array:
    """Compute the dense covariance (columns, columns) of all poses and planes of a small graph."""
    return np.asarray(np.linalg.inv(information(graph, state).toarray()))


def pose_covariances(graph: Graph, dense: Array) -> Array:
    """Cut the own covariance (n, 6, 6) of each pose out of the graph's dense one."""
    count = int(graph.live_poses.sum())
    blocks = dense[: 6 * count, : 6 * count].reshape(count, 6, count, 6)
    return np.asarray(blocks[np.arange(count), :, np.arange(count)])
