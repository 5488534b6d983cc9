# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The extended information filter of [KimEustice2009 II] as a reference: on a linear problem it
ends where the batch does.
"""

from __future__ import annotations

import numpy as np
import pytest
from drafts import Draft, covariance, evaluate, solve
from native.test_links import circle
from native.twins import jacobian, step_between

from hullrecon.native import FACTORS, LinkKernel, Options, pair_covariance

N = 6


class InformationFilter:
    """A delayed-state filter on nodes of six coordinates: information and information vector, all
    nodes kept.
    """

    def __init__(self, information: np.ndarray, vector: np.ndarray) -> None:
        self.information, self.vector = information, vector

    def augment(self, transition: np.ndarray, offset: np.ndarray, noise: np.ndarray) -> None:
        """Adds x_k+1 = transition x_k + offset + w: three blocks, of the last node, the new one and
        between them.
        """
        n, inverse = len(self.vector), np.linalg.inv(noise)
        whole = np.zeros((n + N, n + N))
        whole[:n, :n] = self.information
        whole[n - N : n, n - N : n] += transition.T @ inverse @ transition
        whole[n - N : n, n:] = -transition.T @ inverse
        whole[n:, n - N : n], whole[n:, n:] = whole[n - N : n, n:].T, inverse
        self.information, self.vector = whole, np.r_[self.vector, inverse @ offset]
        self.vector[n - N : n] -= transition.T @ inverse @ offset

    def update(
        self, nodes: tuple[int, int], H: tuple[np.ndarray, np.ndarray], z: np.ndarray
    ) -> None:
        """z = H_i x_i + H_j x_j + v, v of unit covariance."""
        for a, by in zip(nodes, H, strict=True):
            self.vector[N * a : N * a + N] += by.T @ z
            for b, other in zip(nodes, H, strict=True):
                self.information[N * a : N * a + N, N * b : N * b + N] += by.T @ other


def rows(p: Draft, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Whitened derivative (R / 6, 6, 6 n) and residual of priors and links, and which of them are
    links.
    """
    e = evaluate(p)
    links = (e.factor == FACTORS.index("link")).reshape(-1, N)[:, 0]
    return jacobian(e).reshape(-1, N, N * n), e.residual.reshape(-1, N), links


def filtered(p: Draft, n: int) -> tuple[InformationFilter, list[np.ndarray]]:
    """Prior, then nodes one by one, each link as soon as both its nodes are there; what each link
    changed.
    """
    J, r, links = rows(p, n)
    (prior,) = np.flatnonzero(~links)
    at = J[prior][:, :N]
    found, changed = InformationFilter(at.T @ at, -at.T @ r[prior]), []
    ends = np.c_[p.links.first, p.links.second]
    of_link = np.flatnonzero(links)
    for new in range(1, n):
        for k in np.flatnonzero(ends.max(1) == new):
            i, j = ends[k]
            by = [J[of_link[k]][:, N * e : N * e + N] for e in (i, j)]
            if (i, j) == (new - 1, new):
                back = np.linalg.inv(by[1])
                found.augment(-back @ by[0], -back @ r[of_link[k]], back @ back.T)
                continue
            before = found.information.copy()
            found.update((i, j), (by[0], by[1]), -r[of_link[k]])
            changed.append(
                np.argwhere(
                    (found.information != before).reshape(new + 1, N, new + 1, N).any((1, 3))
                )
            )
    return found, changed


@pytest.fixture
def graph() -> Draft:
    p, _ = circle(40, np.random.default_rng(5), wrong=0)
    p.links.kernel[:] = LinkKernel.NONE
    return p


def test_the_filter_ends_at_the_step_of_the_batch(graph: Draft) -> None:
    found, _ = filtered(graph, 40)
    mean = np.linalg.solve(found.information, found.vector)
    never = {"function_tolerance": 0.0, "gradient_tolerance": 0.0, "parameter_tolerance": 0.0}
    one = solve(graph, Options(max_iterations=1, initial_radius=1e16, **never))
    step = step_between(graph, one.unknowns, evaluate(graph))
    assert np.abs(mean).max() > 0.1
    np.testing.assert_allclose(step, mean, rtol=0, atol=1e-9 * np.abs(mean).max())


def test_its_covariances_are_those_of_the_batch(graph: Draft) -> None:
    found, _ = filtered(graph, 40)
    dense = np.linalg.inv(found.information)
    alone = covariance(graph).pose[:, :N, :N]
    for k in range(40):
        np.testing.assert_allclose(
            alone[k],
            dense[N * k : N * k + N, N * k : N * k + N],
            rtol=0,
            atol=1e-9 * np.abs(dense).max(),
        )
    pairs = np.array([[0, 39], [7, 21], [38, 3]])
    free = np.r_[0:6, 7:13]
    for (i, j), joint in zip(pairs, pair_covariance(graph.build(), pairs).pose, strict=True):
        at = np.r_[N * i : N * i + N, N * j : N * j + N]
        np.testing.assert_allclose(
            joint[np.ix_(free, free)],
            dense[np.ix_(at, at)],
            rtol=0,
            atol=1e-9 * np.abs(dense).max(),
        )


def test_each_link_touches_four_blocks_only(graph: Draft) -> None:
    _, changed = filtered(graph, 40)
    assert len(changed) == 20
    for blocks in changed:
        i, j = np.unique(blocks)
        np.testing.assert_array_equal(blocks, [[i, i], [i, j], [j, i], [j, j]])
