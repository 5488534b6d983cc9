# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Nodes removed by generic linear constraints, and which are removed."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.poses import exp, stacked
from hullrecon.studies.sessions.factors import Factors, Links, Priors, State, no_planes
from hullrecon.studies.sessions.graph import (
    Graph,
    compacted,
    covariance,
    pose_covariances,
    solve,
    whole,
)
from hullrecon.studies.sessions.removal import (
    LinearFactors,
    linear_factor,
    remove_node,
    target,
)
from hullrecon.studies.sessions.removal_study import divergence
from hullrecon.studies.sessions.sparsify import (
    Candidates,
    Neighbourhood,
    choose_nodes,
    remove_nodes,
    spatially_redundant,
)
from tests.studies.sessions.conftest import Solved


def sigmas(graph: Graph, state: State) -> np.ndarray:
    spread = pose_covariances(graph, covariance(graph, state))
    return np.sqrt(np.diagonal(spread, axis1=1, axis2=2))


@pytest.mark.parametrize("at_root", [True, False])
def test_one_factor_of_all_neighbours_is_exact(solved: Solved, at_root: bool) -> None:
    _, graph, state = solved
    less = remove_nodes(graph, state, [1, 2, 5, 9], [1, 3], tree=False, at_root=at_root)
    np.testing.assert_allclose(
        sigmas(less, state), sigmas(graph, state)[less.live_poses], rtol=1e-7
    )
    again = solve(less, state).state
    np.testing.assert_allclose(
        again.poses.translation[less.live_poses],
        state.poses.translation[less.live_poses],
        atol=1e-6,
    )


def test_a_tree_is_nowhere_surer_by_more_than_a_tenth(solved: Solved) -> None:
    session, graph, state = solved
    poses = [k for k in range(len(session.truth)) if k % 3]
    planes = np.flatnonzero(np.isin(session.seen_from, poses)).tolist()
    less = remove_nodes(graph, state, poses, planes)
    ratio = sigmas(less, state) / sigmas(graph, state)[less.live_poses]
    assert ratio.min() > 0.9
    assert ratio.max() < 1.5
    assert max(t.poses.shape[1] + t.planes.shape[1] for t in less.factors) <= 3


def test_a_chain_is_left_with_one_factor_between_its_ends() -> None:
    steps = exp([[1.0, 0.1, 0.0, 0.0, 0.0, 0.2]])
    path = [exp(np.zeros(6))]
    for _ in range(3):
        path.append(path[-1] @ steps)
    state = State(poses=stacked(path), planes=np.zeros((0, 3)))
    factors: list[Factors] = [
        Priors(
            poses=np.zeros((1, 1), int), planes=no_planes(1), measured=path[0],
            sqrt_information=np.eye(6)[None],
        ),
        Links(
            poses=np.array([[0, 1], [1, 2], [2, 3]]), planes=no_planes(3),
            measured=stacked([steps] * 3), sqrt_information=np.tile(10 * np.eye(6), (3, 1, 1)),
        ),
    ]  # fmt: skip
    graph = whole(factors, state)
    for pose in (1, 2):
        graph = remove_node(graph, state, pose=pose)
    made = [table for table in graph.factors if isinstance(table, LinearFactors)]
    assert [table.poses.tolist() for table in made] == [[[0, 3]]]
    rank = np.linalg.matrix_rank(made[0].gain[0])
    assert rank == 6  # a relative pose, and nothing of where either is


def test_a_factor_shifted_to_its_root_does_not_mind_where_it_is() -> None:
    ends = stacked([exp(np.zeros(6)), exp([[1.0, 0.1, 0.0, 0.0, 0.0, 0.2]])])
    state = State(poses=ends, planes=np.zeros((0, 3)))
    link = Links(
        poses=np.array([[0, 1]]), planes=no_planes(1), measured=ends[1],
        sqrt_information=10 * np.eye(6)[None],
    )  # fmt: skip
    clique = target([link], state, (None, None))
    there = State(poses=exp([[30.0, -20.0, 0.0, 0.0, 0.0, 1.0]]) @ ends, planes=state.planes)
    cost = {
        at_root: np.sum(
            linear_factor(clique, state, at_root=at_root).linearise(there).residual ** 2
        )
        for at_root in (True, False)
    }
    assert cost[True] < 1e-12
    assert cost[False] > 1.0


def test_numbers_stay_together_when_a_graph_is_compacted(solved: Solved) -> None:
    _, graph, state = solved
    less = remove_nodes(graph, state, [2, 3], [])
    small, left = compacted(less, state)
    np.testing.assert_allclose(sigmas(small, left), sigmas(less, state), rtol=1e-9)


def test_the_divergence_of_one_normal_is_by_hand() -> None:
    off, wide, narrow = np.array([[1.0]]), np.array([[[4.0]]]), np.array([[[1.0]]])
    expected = 0.5 * (0.25 + 0.25 - 1 + np.log(4))
    assert divergence(off, wide, narrow) == pytest.approx(expected)
    assert divergence(0 * off, wide, wide) == pytest.approx(0.0)


def candidates(nodes: list[int], x: list[float], at_s: float, salient: bool = True) -> Candidates:
    places = np.column_stack([x, np.zeros((len(x), 2))])
    times = at_s + 100.0 * np.arange(len(x))
    return Candidates(
        nodes=np.array(nodes), places=places, times_s=times, salient=np.full(len(x), salient)
    )


def test_nodes_nearer_than_a_metre_and_a_half_are_redundant() -> None:
    places = np.column_stack([[0.0, 1.0, 1.6, 2.9, 3.2], np.zeros((5, 2))])
    assert spatially_redundant(places).tolist() == [False, True, False, True, False]


def test_a_fourth_view_of_a_place_pushes_the_first_out() -> None:
    kept: list[Neighbourhood] = []
    gone = [choose_nodes(kept, candidates([day], [0.1 * day], 1e5 * day)) for day in range(4)]
    assert gone == [[], [], [], [0]]
    assert [view.node for view in kept[0].views] == [1, 2, 3]


def test_a_view_soon_after_another_or_without_texture_goes() -> None:
    kept: list[Neighbourhood] = []
    assert choose_nodes(kept, candidates([0], [0.0], 0.0)) == []
    assert choose_nodes(kept, candidates([1], [0.5], 30.0)) == [1]
    assert choose_nodes(kept, candidates([2], [0.5], 1e5, salient=False)) == [2]
