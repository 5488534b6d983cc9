# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Positions of USBL or GPS: an unknown world frame, its covariance, the weight of outliers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from drafts import Draft, covariance, evaluate, solve

from hullrecon.errors import InputError, UsageError
from hullrecon.native import FACTORS, Options

Empty = Callable[[int], Draft]
Survey = Callable[..., Draft]
NAIVE = Options(method="naive")


def square(p: Draft, sigma_m: float = 0.1) -> None:
    """The first four nodes at the corners of a square of 2 m, each with a position; g's x axis
    points east.
    """
    p.unknowns.pose[:4, :3] = [[0, 0, 1], [2, 0, 1], [2, 2, 1], [0, 2, 1]]
    p.unknowns.world = np.array([100.0, -50.0, np.pi / 2])
    p.positions.node, p.positions.antenna = np.arange(4, dtype=np.int32), np.zeros((4, 3))
    # ahead is east, to starboard is south
    p.positions.measured = np.array([[100.0, -50], [100, -48], [98, -48], [98, -50]])
    p.positions.sigma = np.full(4, sigma_m)


def residuals(p: Draft) -> np.ndarray:
    found = evaluate(p)
    return np.asarray(found.residual[found.factor == FACTORS.index("position")])


def test_heading_points_ahead_and_starboard_is_to_its_right(empty: Empty) -> None:
    p = empty(4)
    square(p)
    np.testing.assert_allclose(residuals(p), 0, atol=1e-12)
    # each a little ahead (east) and to starboard (south)
    p.positions.antenna = np.tile([0.5, 0.2, 0.0], (4, 1))
    np.testing.assert_allclose(residuals(p).reshape(4, 2), np.tile([-2.0, 5.0], (4, 1)), atol=1e-12)


def test_without_positions_the_world_is_no_unknown(empty: Empty) -> None:
    p = empty(4)
    width = evaluate(p).width
    assert "world" not in evaluate(p).columns
    square(p)
    found = evaluate(p)
    assert (found.columns["world"][1], found.width) == (3, width + 3)
    p.constant = (*p.constant, "world")
    assert "world" not in evaluate(p).columns


def test_place_and_heading_of_the_world_come_back(make_survey: Survey) -> None:
    p = make_survey()
    place, heading = np.array([30.0, -12.0]), 2.0
    at = p.unknowns.pose[:, :2]
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    p.positions.node, p.positions.antenna = (
        np.arange(len(at), dtype=np.int32),
        np.zeros((len(at), 3)),
    )
    p.positions.measured, p.positions.sigma = place + at @ turn.T, np.full(len(at), 0.05)
    p.unknowns.world = np.array([29.0, -10.0, 1.6])
    found = solve(p, replace(NAIVE, function_tolerance=1e-12))
    np.testing.assert_allclose(found.unknowns.world, [*place, heading], atol=1e-4)
    p.unknowns.world = found.unknowns.world
    # eight fixes of 5 cm round a loop of half a metre
    sigma = np.sqrt(np.diag(covariance(p, NAIVE).world))
    assert np.all(sigma[:2] < 0.03)
    assert 0.02 < sigma[2] < 0.06


def test_of_one_position_the_heading_is_as_free_as_its_prior(make_survey: Survey) -> None:
    p = make_survey()
    p.positions.node, p.positions.antenna = np.zeros(1, np.int32), np.zeros((1, 3))
    p.positions.measured, p.positions.sigma = np.zeros((1, 2)), np.ones(1)
    assert covariance(p, NAIVE).world[2, 2] == pytest.approx(100.0, rel=1e-3)


def test_an_outlier_weighs_as_a_position_at_the_threshold(empty: Empty) -> None:
    p = empty(4)
    square(p)
    p.positions.measured[0] += [30.0, 40.0]  # 500 sigmas
    k = Options().huber_position
    assert evaluate(p).cost_by_factor["position"] == pytest.approx(0.5 * (2 * k * 500 - k**2))
    assert evaluate(p, replace(NAIVE, huber_position=np.inf)).cost_by_factor[
        "position"
    ] == pytest.approx(0.5 * 500**2)
    with pytest.raises(UsageError, match="must be positive"):
        evaluate(p, replace(NAIVE, huber_position=0.0))


def test_a_position_that_names_no_node_is_refused(empty: Empty) -> None:
    p = empty(4)
    square(p)
    p.positions.node = p.positions.node + 1
    with pytest.raises(InputError, match="is not below 4"):
        evaluate(p)
