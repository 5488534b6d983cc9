# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Submaps joined in a tree, in a graph, and with variables that two of them share."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.schemes import shared_variables as shared
from hullrecon.studies.schemes.schemes_study import (
    LAPS,
    SEED,
    SQUARE,
    correlation_left,
    graph_over_time,
    tree_of_joins,
)
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits
from hullrecon.studies.submaps.missions import build_submaps
from hullrecon.studies.submaps.worlds import Noise, simulate_loop


@pytest.fixture(scope="module")
def submaps() -> list[EkfMap]:
    return build_submaps(simulate_loop(SQUARE, LAPS, Noise(), SEED).log, Limits(), Effort())


def test_a_tree_of_joins_ends_with_every_landmark_once(submaps: list[EkfMap]) -> None:
    tree = tree_of_joins(submaps[:4])
    assert [len(level) for level in tree.levels] == [4, 2, 1]
    names = tree.levels[-1][0].truth
    assert set(names) == {name for built in submaps[:4] for name in built.truth}
    assert len(names) < sum(len(built.truth) for built in submaps[:4])


def test_a_closed_loop_shrinks_the_last_frame(submaps: list[EkfMap]) -> None:
    before, after = graph_over_time(submaps)[:2]
    assert after.loops > before.loops == 0
    assert np.trace(after.covariances[-1]) < 0.25 * np.trace(before.covariances[-1])


def test_two_submaps_that_share_variables_are_one_estimate() -> None:
    rows = shared.measured(np.random.default_rng(0))
    two, one = shared.in_two_submaps(rows), shared.whole(rows)
    np.testing.assert_allclose(two.mean, one.mean, atol=1e-12)
    np.testing.assert_allclose(two.covariance, one.covariance, atol=1e-12)


def test_they_are_independent_given_what_they_share_and_not_else() -> None:
    one = shared.whole(shared.measured(np.random.default_rng(0)))
    assert correlation_left(one) < 1e-10
    assert np.abs(one.covariance[np.ix_(shared.FIRST, shared.SECOND)]).max() > 1e-5
