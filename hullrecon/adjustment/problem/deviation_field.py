# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The smooth field of normal offsets between the CAD model and the hull (docs/methods.md 8).

The field stands on a regular grid of the hull chart, bilinear between nodes. Its prior is the
Gauss-Markov field that solves (1 - Laplace) b = noise in coordinates scaled by the correlation
lengths: a Matern field of smoothness 1. Matern 3/2 has no sparse precision in two dimensions. The
lengths are matched so that both fall to 14 % at the same distance, and the sparse form costs the
same per metre on a patch and on a 180 m hull.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from hullrecon import native
from hullrecon.typing import Array, Ints32

KNOWN_SHARE = 1e-3  # of the field's sigma, to which a combination that is known is known
NODES_A_LENGTH = 4.0  # of a field's correlation length
DEPENDENT_SHARE = 1e-6  # least singular value, of the largest, of combinations that count


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
        """Find the four nodes around each point (n, 2) and their bilinear weights, both (n, 4).

        Outside the grid, a point has the edge's value.
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
        """Interpolate the field (size,) or (a, g) at points (n, 2)."""
        index, weight = self.basis(along_girth)
        return np.asarray(np.einsum("nk,nk->n", field.reshape(-1)[index], weight))


def grid_over(along_girth: Array, length: tuple[float, float]) -> DeviationGrid:
    """Make a grid over points (n, 2) and one correlation length beyond them.

    So its edge does not bias what is seen.
    """
    scale = np.array(length)
    step = scale / NODES_A_LENGTH
    low, high = np.nanmin(along_girth, 0) - scale, np.nanmax(along_girth, 0) + scale
    shape = np.ceil((high - low) / step).astype(int) + 1
    return DeviationGrid(low, step, (int(shape[0]), int(shape[1])))


def prior_rows(grid: DeviationGrid, sigma: float, length: tuple[float, float]) -> sparse.csr_array:
    """Build whitening rows A (size, size) of a field: A b has unit covariance.

    The field has that sigma and those correlation lengths.
    """
    scaled = grid.step * np.sqrt(2.0) / np.array(length)
    return sparse.csr_array(_operator(grid.shape, scaled) * (_interior_sigma(scaled) / sigma))


def know_combinations(
    prior: native.SparseRows, grid: DeviationGrid, known: Array, sigma: float
) -> tuple[native.SparseRows, int]:
    """Add to a field's prior that combinations (k, size) of its nodes are known.

    A residual of all nodes would make the information dense. So each sum goes along the grid, and
    what is summed up to each of its rows is an unknown of its own.

    Parameters
    ----------
    prior
        Rows over the nodes.
    grid
        Where the nodes stand.
    known
        Those that depend on the others are left out.
    sigma
        Of the field, m.

    Returns
    -------
    prior, added
        With rows for the sums, and how many unknowns these are, behind the nodes.
    """
    # independent combinations, of unit length
    length = np.linalg.norm(known, axis=1, keepdims=True)
    _, share, unit = np.linalg.svd(known / np.where(length > 0, length, 1), full_matrices=False)
    unit = unit[share > DEPENDENT_SHARE * share[0]]
    # of each, one row for each row of the grid: its nodes, and the sums up to it and its neighbour
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
    """Build 1 - Laplace on the grid, five points, mirrored at the edges."""
    along, girth = (_second_difference(n, float(h)) for n, h in zip(shape, step, strict=True))
    laplace = sparse.kron(along, sparse.eye_array(shape[1])) + sparse.kron(
        sparse.eye_array(shape[0]), girth
    )
    return sparse.csr_array(sparse.eye_array(shape[0] * shape[1]) - laplace)


def _second_difference(n: int, step: float) -> sparse.csr_array:
    """Build the second derivative on a line of n nodes, mirrored at both ends."""
    main = np.full(n, -2.0)
    main[[0, -1]] += 1.0
    neighbours = sparse.eye_array(n, k=1) + sparse.eye_array(n, k=-1)
    return sparse.csr_array((sparse.diags_array(main) + neighbours) / step**2)


def _interior_sigma(step: Array) -> float:
    """Compute the sigma that unit rows give in the middle of a grid too wide to feel its edges."""
    shape = tuple(int(2 * np.ceil(8.0 / h)) + 1 for h in step)
    a = _operator((shape[0], shape[1]), step)
    unit = np.zeros(shape[0] * shape[1])
    unit[len(unit) // 2] = 1.0
    return float(np.linalg.norm(splu(sparse.csc_array(a.T)).solve(unit)))
