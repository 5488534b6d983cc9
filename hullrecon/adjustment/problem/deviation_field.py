# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The smooth field of normal offsets between the CAD model and the hull (docs/methods.md 8).

The field has a value at each node of a regular grid on the hull chart, and is bilinear between
nodes. Its prior is the Gauss-Markov field that solves (1 - Laplace) b = noise in coordinates scaled
by the correlation lengths: a Matern field of smoothness 1, whose precision is sparse. That of the
Matern 3/2 field of `cad_error` is not in two dimensions. The lengths are matched so that both
covariances fall to 14 % at the same distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from hullrecon import native
from hullrecon.typing import Array, Ints32

KNOWN_SHARE = 1e-3  # sigma of a combination that is held, as a share of the field's sigma
NODES_A_LENGTH = 4.0  # grid nodes in a correlation length
DEPENDENT_SHARE = 1e-6  # of the largest singular value, below which combinations are dependent


@dataclass(frozen=True)
class DeviationGrid:
    """A regular grid on the hull chart. Node (i, j) has number i * shape[1] + j."""

    origin: Array  # (2,) m along and in girth, of node (0, 0)
    step: Array  # (2,) m
    shape: tuple[int, int]  # nodes along and in girth

    @property
    def size(self) -> int:
        return self.shape[0] * self.shape[1]

    def basis(self, along_girth: Array) -> tuple[Ints32, Array]:
        """Find the four nodes around each point (n, 2) m and their bilinear weights, both (n, 4).

        A point outside the grid has the value of the nearest edge.
        """
        cell = (along_girth - self.origin) / self.step
        cell = np.clip(np.nan_to_num(cell), 0.0, np.array(self.shape) - 1.0 - 1e-9)
        low = cell.astype(np.int32)
        a, g = (cell - low).T
        corner = low[:, 0] * self.shape[1] + low[:, 1]
        index = corner[:, None] + np.array([0, 1, self.shape[1], self.shape[1] + 1], np.int32)
        weight = np.stack([(1 - a) * (1 - g), (1 - a) * g, a * (1 - g), a * g], axis=1)
        return index.astype(np.int32), weight

    def value(self, field: Array, along_girth: Array) -> Array:
        """Interpolate the field, of shape (size,) or `shape`, at chart points (n, 2) m."""
        index, weight = self.basis(along_girth)
        return np.asarray(np.einsum("nk,nk->n", field.reshape(-1)[index], weight))


def grid_over(along_girth: Array, length: tuple[float, float]) -> DeviationGrid:
    """Make a grid over chart points (n, 2) m that reaches one correlation length beyond them.

    So the mirror condition at the grid's edge does not affect the field at the points.

    length: correlation length along and in girth, m.
    """
    scale = np.array(length)
    step = scale / NODES_A_LENGTH
    low, high = np.nanmin(along_girth, 0) - scale, np.nanmax(along_girth, 0) + scale
    shape = np.ceil((high - low) / step).astype(int) + 1
    return DeviationGrid(low, step, (int(shape[0]), int(shape[1])))


def prior_rows(grid: DeviationGrid, sigma: float, length: tuple[float, float]) -> sparse.csr_array:
    """Build the square root A (size, size) of a field's precision: A b has unit covariance.

    Parameters
    ----------
    grid
        Grid of the nodes of the field b.
    sigma
        Sigma of the field, m, far from the grid's edge.
    length
        Correlation length along and in girth, m.
    """
    # Distance of nodes in the coordinates in which the field solves (1 - Laplace) b = noise
    scaled = grid.step * np.sqrt(2.0) / np.array(length)
    return sparse.csr_array(_operator(grid.shape, scaled) * (_interior_sigma(scaled) / sigma))


def hold_combinations(
    prior: native.SparseRows, grid: DeviationGrid, held: Array, sigma: float
) -> tuple[native.SparseRows, int]:
    """Add prior rows that hold linear combinations of a field's nodes at their present values.

    So what the covariance of the hull's pose holds already is not counted again in the field. One
    residual of all nodes would make the information matrix dense. So a combination is summed row by
    row of the grid, and each partial sum is an additional unknown. A prior row then depends on one
    row of nodes, the partial sum before it and the one after it.

    Parameters
    ----------
    prior
        Rows over the nodes.
    grid
        The grid of the nodes, along whose rows a combination is summed.
    held
        Combinations (k, size). Those that depend linearly on others are left out.
    sigma
        Sigma of the field, m. Combinations are held to a share KNOWN_SHARE of it.

    Returns
    -------
    prior, added
        The prior with the additional rows, and the number of additional unknowns, whose columns
        follow those of the nodes.
    """
    # Independent combinations, of unit length
    length = np.linalg.norm(held, axis=1, keepdims=True)
    _, share, unit = np.linalg.svd(held / np.where(length > 0, length, 1), full_matrices=False)
    unit = unit[share > DEPENDENT_SHARE * share[0]]
    # For each combination one prior row for each row of the grid: its nodes, and two partial sums
    rows, across = grid.shape
    start = np.arange(0, grid.size + 1, across)
    by_node = sparse.vstack(
        [sparse.csr_array((-u, np.arange(grid.size), start), shape=(rows, grid.size)) for u in unit]
    )
    step = sparse.eye_array(rows, rows - 1) - sparse.eye_array(rows, rows - 1, k=-1)
    sums = sparse.hstack([by_node, sparse.block_diag([step] * len(unit))])
    nodes = sparse.csr_array(
        (prior.value, prior.index, prior.start), shape=(len(prior.start) - 1, sums.shape[1])
    )
    weighted = sparse.csr_array(sums) * (1 / (KNOWN_SHARE * sigma))
    return as_rows(sparse.vstack([nodes, weighted])), sums.shape[1] - grid.size


def as_rows(matrix: sparse.csr_array) -> native.SparseRows:
    """Convert a sparse matrix to the solver's rows."""
    rows = sparse.csr_array(matrix)
    return native.SparseRows(
        start=rows.indptr.astype(np.int32), index=rows.indices.astype(np.int32), value=rows.data
    )


def _operator(shape: tuple[int, int], step: Array) -> sparse.csr_array:
    """Build the matrix of 1 - Laplace on the grid: five-point stencil, mirrored at the edges.

    Applied to a field of the wanted smoothness it leaves independent noise, so that its rows are
    those of the field's prior.

    step (2,): distance of nodes in scaled coordinates.
    """
    along, girth = (_second_difference(n, float(h)) for n, h in zip(shape, step, strict=True))
    laplace = sparse.kron(along, sparse.eye_array(shape[1])) + sparse.kron(
        sparse.eye_array(shape[0]), girth
    )
    return sparse.csr_array(sparse.eye_array(shape[0] * shape[1]) - laplace)


def _second_difference(n: int, step: float) -> sparse.csr_array:
    """Build the matrix (n, n) of the second derivative on a line, mirrored at both ends.

    step: distance of its n nodes, in scaled coordinates.
    """
    main = np.full(n, -2.0)
    main[[0, -1]] += 1.0
    neighbours = sparse.eye_array(n, k=1) + sparse.eye_array(n, k=-1)
    return sparse.csr_array((sparse.diags_array(main) + neighbours) / step**2)


def _interior_sigma(step: Array) -> float:
    """Compute the sigma of the field that the unscaled operator gives, far from any edge.

    The operator is divided by the wanted sigma times this one. It is computed in the middle of a
    grid so wide that its edges have no effect. step (2,): as of `_operator`.
    """
    # eight lengths of correlation from the middle to each edge, in scaled coordinates
    shape = tuple(int(2 * np.ceil(8.0 / h)) + 1 for h in step)
    a = _operator((shape[0], shape[1]), step)
    # The field is a^-1 noise: the sigma of its middle node is the length of that row of a^-1
    unit = np.zeros(shape[0] * shape[1])
    unit[len(unit) // 2] = 1.0
    return float(np.linalg.norm(splu(sparse.csc_array(a.T)).solve(unit)))
