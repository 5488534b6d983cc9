# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Nodes removed from a graph by generic linear constraints [Ozog2016 2.4.1, CarlevarisBianco2014].

The target information is that of a node's factors on its neighbours, with the node marginalised.
Its eigenvectors make one linear factor of all neighbours, or of each pair along a Chow-Liu tree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from hullrecon.geometry.poses import Poses
from hullrecon.studies.sessions.factors import Factors, Linear, State
from hullrecon.studies.sessions.graph import Graph
from hullrecon.studies.sessions.motions import between, errors, plane_in
from hullrecon.typing import Array, Ints

LEAST_EIGENVALUE = 1e-11  # of the largest: below it nothing is known
TIKHONOV = 1e-6  # of the mean eigenvalue, added where mutual information needs a full rank


@dataclass(frozen=True, kw_only=True)
class Clique:
    """Poses and planes with what is known of them, linear about a state.

    Columns are those of the poses, then those of the planes.
    """

    poses: Ints  # (k,)
    planes: Ints  # (l,)
    information: Array  # (s, s) target information; s = 6 k + 3 l
    gradient: Array  # (s,) of half the cost
    most: float  # largest information before the removal: eigenvalues far below it are rounding

    def blocks(self) -> list[slice]:
        """List the columns of each pose, then of each plane."""
        ends = np.cumsum([0, *[6] * len(self.poses), *[3] * len(self.planes)])
        return [slice(a, b) for a, b in pairwise(ends)]


@dataclass(frozen=True, kw_only=True)
class LinearFactors(Factors):
    """Generic linear constraints G x_c + offset [Ozog2016 eq. 2.6], each of as many variables.

    With `at_root` x_c has the others relative to their root, the first pose, so that a wrong place
    in the world costs nothing.
    """

    at_poses: Array  # (m, k, 7) where it is linear, as `Poses.vectors`
    at_planes: Array  # (m, l, 3)
    gain: Array  # (m, s, s), G with rows of zeros where nothing is known; s = 6 k + 3 l
    offset: Array  # (m, s) of the residual
    at_root: bool

    SHARED = frozenset({"at_root"})

    def linearise(self, state: State) -> Linear:
        """Compute whitened residuals G x_c + offset, and their derivatives."""
        off, derivative = self.differences(state)
        by, count = self.gain @ derivative, self.poses.shape[1]
        m, size = self.offset.shape
        by_pose = by[:, :, : 6 * count].reshape(m, size, count, 6).swapaxes(1, 2)
        by_plane = by[:, :, 6 * count :].reshape(m, size, self.planes.shape[1], 3).swapaxes(1, 2)
        residual = np.einsum("nij,nj->ni", self.gain, off) + self.offset
        return Linear(residual=residual, by_pose=by_pose, by_plane=by_plane)

    def differences(self, state: State) -> tuple[Array, Array]:
        """Compute x_c: what cliques differ by from the state at which they are linear.

        Returns it (m, s) with its derivative (m, s, s) by the clique's poses and planes.
        """
        m, k = self.poses.shape
        size = 6 * k + 3 * self.planes.shape[1]
        off, derivative = np.zeros((m, size)), np.zeros((m, size, size))
        poses = [state.poses[self.poses[:, j]] for j in range(k)]
        at = [Poses(self.at_poses[:, j, 3:], self.at_poses[:, j, :3]) for j in range(k)]
        for j in range(k):
            row = slice(6 * j, 6 * j + 6)
            if j and self.at_root:
                relative, by_root, by_own = between(poses[0], poses[j])
                off[:, row], by = errors(between(at[0], at[j])[0], relative)
                derivative[:, row, :6], derivative[:, row, row] = by @ by_root, by @ by_own
            else:
                off[:, row], derivative[:, row, row] = errors(at[j], poses[j])
        for j in range(self.planes.shape[1]):
            row = slice(6 * k + 3 * j, 6 * k + 3 * j + 3)
            plane, known = state.planes[self.planes[:, j]], self.at_planes[:, j]
            if k and self.at_root:
                seen, by_root, by_own = plane_in(poses[0], plane)
                off[:, row] = seen - plane_in(at[0], known)[0]
                derivative[:, row, :6], derivative[:, row, row] = by_root, by_own
            else:
                off[:, row], derivative[:, row, row] = plane - known, np.eye(3)
        return off, derivative


def remove_node(
    graph: Graph,
    state: State,
    *,
    pose: int | None = None,
    plane: int | None = None,
    tree: bool = True,
    at_root: bool = True,
) -> Graph:
    """Remove a pose or a plane from a graph: factors among its neighbours take its place.

    Parameters
    ----------
    graph, state
        The graph, and the state at which the new factors are linear.
    pose, plane
        Number of what is removed, one of both.
    tree
        Leave a Chow-Liu tree of factors instead of one of all neighbours, which is exact.
    at_root
        Linear relative to one pose of the clique, not in the world.
    """
    rows = [
        (table.poses == (-1 if pose is None else pose)).any(axis=1)
        | (table.planes == (-1 if plane is None else plane)).any(axis=1)
        for table in graph.factors
    ]
    taken = [
        table.take(mask) for table, mask in zip(graph.factors, rows, strict=True) if mask.any()
    ]
    left = [
        table if not mask.any() else table.take(~mask)
        for table, mask in zip(graph.factors, rows, strict=True)
    ]
    live_poses, live_planes = graph.live_poses.copy(), graph.live_planes.copy()
    live_poses[[] if pose is None else pose] = False
    live_planes[[] if plane is None else plane] = False
    clique = target(taken, state, (pose, plane))
    cliques = tree_of(clique) if tree else [clique]
    made = [linear_factor(part, state, at_root=at_root) for part in cliques if len(part.blocks())]
    return Graph(
        factors=tuple(_append_linear([t for t in left if len(t)], made)),
        live_poses=live_poses,
        live_planes=live_planes,
    )


def target(
    taken: Sequence[Factors], state: State, removed: tuple[int | None, int | None]
) -> Clique:
    """Marginalise one pose or plane out of its factors: L_cc - L_cm L_mm^-1 L_mc [Ozog2016 2.4.1].

    Parameters
    ----------
    taken
        The factors that see it.
    state
        Where they are linearised.
    removed
        Number of the pose, or of the plane, that is removed. The other is None.
    """
    poses = np.unique(np.concatenate([table.poses.ravel() for table in taken])).astype(int)
    planes = np.unique(np.concatenate([table.planes.ravel() for table in taken])).astype(int)
    size = 6 * len(poses) + 3 * len(planes)
    # Information and gradient of all that these factors see, poses first, then planes
    whole, slope = np.zeros((size, size)), np.zeros(size)
    for table in taken:
        at = table.linearise(state)
        rows = np.zeros((*at.residual.shape, size))
        _place(rows, at.by_pose, np.searchsorted(poses, table.poses), 6, 0)
        _place(rows, at.by_plane, np.searchsorted(planes, table.planes), 3, 6 * len(poses))
        flat = rows.reshape(-1, size)
        whole += flat.T @ flat
        slope += flat.T @ at.residual.ravel()
    # The Schur complement on what is kept (c) of what is removed (m)
    gone = np.concatenate([np.repeat(poses == removed[0], 6), np.repeat(planes == removed[1], 3)])
    kept = ~gone
    back = whole[np.ix_(kept, gone)] @ _inverse(whole[np.ix_(gone, gone)])
    left = whole[np.ix_(kept, kept)] - back @ whole[np.ix_(gone, kept)]
    return Clique(
        poses=poses[poses != removed[0]],
        planes=planes[planes != removed[1]],
        information=0.5 * (left + left.T),
        gradient=slope[kept] - back @ slope[gone],
        most=float(np.abs(whole).max()),
    )


def linear_factor(clique: Clique, state: State, *, at_root: bool) -> LinearFactors:
    """Make the factor, a table of one row, whose information is the clique's [Ozog2016 eq. 2.6].

    at_root: as of `remove_node`.
    """
    size = len(clique.information)
    factor = LinearFactors(
        poses=clique.poses[None],
        planes=clique.planes[None],
        at_poses=state.poses[clique.poses].vectors()[None],
        at_planes=state.planes[clique.planes][None],
        gain=np.zeros((1, size, size)),
        offset=np.zeros((1, size)),
        at_root=at_root,
    )
    by_state = np.linalg.inv(factor.differences(state)[1][0])
    root = by_state.T @ clique.information @ by_state
    values, vectors = np.linalg.eigh(0.5 * (root + root.T))
    known = values > LEAST_EIGENVALUE * clique.most
    scale = np.sqrt(values[known])
    factor.gain[0, : len(scale)] = scale[:, None] * vectors[:, known].T
    factor.offset[0, : len(scale)] = vectors[:, known].T @ (by_state.T @ clique.gradient) / scale
    return factor


def tree_of(clique: Clique) -> list[Clique]:
    """Split a clique along its Chow-Liu tree: one of the root alone, then parent and child each.

    The tree joins the variables of largest mutual information [ChowLiu1968]; each child is
    conditional on its parent. Together the parts have the clique's gradient, so that what was the
    state of least cost remains it.
    """
    blocks = clique.blocks()
    if len(blocks) < 2:
        return [clique]
    mutual = mutual_information(clique)
    order, parents = breadth_first_order(
        minimum_spanning_tree(mutual.max() + 1 - mutual), 0, directed=False
    )
    parts = [([0], _marginal(clique.information, np.r_[blocks[0]]))]
    for k in order[1:]:
        pair = sorted([int(parents[k]), int(k)])  # poses stand before planes
        parts.append((pair, _conditional(clique.information, blocks, pair, int(parents[k]))))
    return _with_gradient(clique, parts)


def mutual_information(clique: Clique) -> Array:
    """Compute the mutual information (v, v), nats, of each two poses or planes of a clique."""
    blocks, size = clique.blocks(), len(clique.information)
    weak = TIKHONOV * np.trace(clique.information) / size
    spread = np.linalg.inv(clique.information + weak * np.eye(size))
    mutual = np.zeros((len(blocks), len(blocks)))
    for i, first in enumerate(blocks):
        for j, second in enumerate(blocks[:i]):
            both = np.r_[first, second]
            logs = (
                np.linalg.slogdet(spread[np.ix_(c, c)])[1]
                for c in (np.r_[first], np.r_[second], both)
            )
            one, other, joint = logs
            mutual[i, j] = mutual[j, i] = 0.5 * (one + other - joint)
    return mutual


def _conditional(information: Array, blocks: list[slice], pair: list[int], given: int) -> Array:
    """Compute what is known of a pair of variables besides what is known of one of them.

    Parameters
    ----------
    information
        Information matrix (n, n) of all variables.
    blocks
        Rows of each variable.
    pair, given
        Numbers of the two variables, and of that of them whose own information is taken off.

    Returns
    -------
    Array
        Information matrix of both variables, in the order of `pair`.
    """
    columns = np.concatenate([np.r_[blocks[k]] for k in pair])
    joint = _marginal(information, columns)
    own = np.flatnonzero(np.isin(columns, np.r_[blocks[given]]))
    joint[np.ix_(own, own)] -= _marginal(joint, own)
    return joint


def _marginal(information: Array, kept: Ints) -> Array:
    """Eliminate all but some rows (k,) from an information matrix: (k, k) is left."""
    gone = np.setdiff1d(np.arange(len(information)), kept)
    left = information[np.ix_(kept, kept)].copy()
    if len(gone):
        inner = _inverse(information[np.ix_(gone, gone)])
        across = information[np.ix_(kept, gone)]
        left -= across @ inner @ across.T
    return np.asarray(0.5 * (left + left.T))


def _inverse(information: Array) -> Array:
    """Invert an information matrix on the subspace that it knows, and leave the rest at zero."""
    values, vectors = np.linalg.eigh(information)
    known = values > LEAST_EIGENVALUE * values.max(initial=1e-300)
    return np.asarray((vectors[:, known] / values[known]) @ vectors[:, known].T)


def _with_gradient(clique: Clique, parts: list[tuple[list[int], Array]]) -> list[Clique]:
    """Turn the parts of a tree into cliques, with gradients that add up to the whole clique's.

    parts: numbers of the variables of each part, and its information.
    """
    blocks, count = clique.blocks(), len(clique.poses)
    columns = [np.concatenate([np.r_[blocks[k]] for k in names]) for names, _ in parts]
    together = np.zeros_like(clique.information)
    for at, (_, information) in zip(columns, parts, strict=True):
        together[np.ix_(at, at)] += information
    step = _inverse(together) @ clique.gradient
    return [
        Clique(
            poses=clique.poses[[k for k in names if k < count]],
            planes=clique.planes[[k - count for k in names if k >= count]],
            information=information,
            gradient=information @ step[at],
            most=clique.most,
        )
        for at, (names, information) in zip(columns, parts, strict=True)
    ]


def _place(rows: Array, derivative: Array, at: Ints, width: int, first: int) -> None:
    """Add derivatives of m factors by k variables each into their Jacobians, in place.

    Parameters
    ----------
    rows
        (m, d, columns) Jacobian of each factor by all variables.
    derivative
        (m, k, d, width) by the variables that a factor sees.
    at
        (m, k) place of these variables among all of their kind.
    width
        Columns of a variable.
    first
        First column of their kind.
    """
    for k in range(derivative.shape[1]):
        for m in range(len(derivative)):
            start = first + width * at[m, k]
            rows[m, :, start : start + width] += derivative[m, k]


def _append_linear(tables: list[Factors], made: list[LinearFactors]) -> list[Factors]:
    """Add linear factors to the table with the same number of variables, if there is one."""
    out = list(tables)
    for new in made:
        if not new.gain.any():
            continue
        shape = new.poses.shape[1], new.planes.shape[1]
        same = [
            k
            for k, t in enumerate(out)
            if isinstance(t, LinearFactors) and (t.poses.shape[1], t.planes.shape[1]) == shape
        ]
        if not same:
            out.append(new)
            continue
        old = out[same[0]]
        assert isinstance(old, LinearFactors)
        out[same[0]] = LinearFactors(
            **{
                name: np.concatenate([getattr(old, name), getattr(new, name)])
                for name in ("poses", "planes", "at_poses", "at_planes", "gain", "offset")
            },
            at_root=old.at_root,
        )
    return out
