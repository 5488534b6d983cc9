# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from records.every_record import random_record
from scipy.interpolate import RegularGridInterpolator

from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import exp
from hullrecon.records.solution import DeviationField, Solution

QUICK = settings(max_examples=20, deadline=None, derandomize=True)
SEEDS = st.integers(0, 10**6)

# 3 x 2 nodes from (1, -1) on, half a metre along and two metres of girth apart
FIELD = DeviationField(
    origin=np.array([1.0, -1.0]),
    step=np.array([0.5, 2.0]),
    value=np.array([[0.0, 0.04], [0.01, 0.05], [0.02, 0.10]]),
    sigma=np.array([[0.1, 0.1], [0.2, 0.2], [0.4, 0.4]]),
)


def test_the_field_is_its_own_value_at_the_nodes() -> None:
    nodes = np.array([[1.0, -1], [1.5, 1], [2.0, 1]])
    np.testing.assert_allclose(FIELD.value_at(nodes), [0.0, 0.05, 0.10])
    np.testing.assert_allclose(FIELD.sigma_at(nodes), [0.1, 0.2, 0.4])


def test_the_field_is_bilinear_inside_a_cell() -> None:
    # a quarter along, three quarters over the girth of the second cell, by hand
    want = 0.75 * (0.25 * 0.01 + 0.75 * 0.05) + 0.25 * (0.25 * 0.02 + 0.75 * 0.10)
    assert FIELD.value_at(np.array([[1.625, 0.5]]))[0] == pytest.approx(want)


def test_the_field_is_held_beyond_its_ends() -> None:
    np.testing.assert_allclose(
        FIELD.value_at(np.array([[9.0, 9.0], [-9.0, -9.0], [1.5, 7.0]])), [0.10, 0.0, 0.05]
    )


def test_a_point_off_the_chart_has_no_value_and_is_not_covered() -> None:
    off = np.array([[np.nan, 0.0]])
    assert np.isnan(FIELD.value_at(off)[0])
    assert not FIELD.covers(off)[0]


def test_the_grid_covers_what_lies_between_its_outer_nodes() -> None:
    at = np.array([[1.0, -1.0], [2.0, 1.0], [1.2, 0.0], [2.01, 0.0], [1.5, -1.01]])
    np.testing.assert_array_equal(FIELD.covers(at), [True, True, True, False, False])


def test_a_field_of_one_node_is_that_value_everywhere() -> None:
    one = DeviationField(
        origin=np.zeros(2), step=np.ones(2), value=np.array([[0.03]]), sigma=np.array([[0.01]])
    )
    np.testing.assert_allclose(one.value_at(np.array([[0.0, 0.0], [4.0, -2.0]])), 0.03)


def random_field(seed: int) -> DeviationField:
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(2, 6, 2))
    return DeviationField(
        origin=rng.normal(size=2),
        step=rng.uniform(0.2, 2.0, 2),
        value=rng.normal(size=shape),
        sigma=rng.uniform(0.01, 0.1, shape),
    )


def places(field: DeviationField, seed: int, beyond: float = 0.0) -> np.ndarray:
    """Random chart points (40, 2) on the grid, or up to `beyond` of its size off its ends."""
    span = (np.array(field.value.shape) - 1) * field.step
    return field.origin + span * np.random.default_rng(seed + 1).uniform(
        -beyond, 1 + beyond, (40, 2)
    )


@QUICK
@given(SEEDS)
def test_the_field_is_what_scipy_interpolates_on_the_same_grid(seed: int) -> None:
    field = random_field(seed)
    nodes = [field.origin[k] + field.step[k] * np.arange(field.value.shape[k]) for k in range(2)]
    for grid, found in ((field.value, field.value_at), (field.sigma, field.sigma_at)):
        twin = RegularGridInterpolator(nodes, grid, bounds_error=False, fill_value=None)
        np.testing.assert_allclose(found(places(field, seed)), twin(places(field, seed)), atol=1e-9)


@QUICK
@given(SEEDS)
def test_field_beyond_its_ends_is_held(seed: int) -> None:
    field = random_field(seed)
    at = places(field, seed, beyond=0.5)
    nearest = np.clip(
        at, field.origin, field.origin + field.step * (np.array(field.value.shape) - 1)
    )
    np.testing.assert_allclose(field.value_at(at), field.value_at(nearest), atol=1e-9)
    span = field.step * (np.array(field.value.shape) - 1)
    inside = ((at >= field.origin) & (at <= field.origin + span)).all(axis=1)
    np.testing.assert_array_equal(field.covers(at), inside)


@QUICK
@given(SEEDS)
def test_field_sigma_between_nodes_is_bounded_by_nodes(seed: int) -> None:
    field = random_field(seed)
    found = field.sigma_at(places(field, seed, beyond=1.0))
    assert found.min() >= field.sigma.min() - 1e-12
    assert found.max() <= field.sigma.max() + 1e-12


@QUICK
@given(SEEDS)
def test_track_is_in_frame_of_results(
    seed: int,
) -> None:
    solution = random_record(
        Solution, np.random.default_rng(seed), {"n": 4, "m": 2, "k": 2, "b": 2, "r": 2}
    )
    rng = np.random.default_rng(seed)
    solution = replace(solution, global_from_vehicle=exp(rng.normal(size=(4, 6))))
    if solution.hull_pose is not None:
        hull = replace(solution.hull_pose, global_from_hull=exp(rng.normal(size=(1, 6))))
        solution = replace(solution, hull_pose=hull)
    track, expected = solution.track(), solution.global_from_vehicle.matrix()
    if solution.hull_pose is not None:
        expected = np.linalg.inv(solution.hull_pose.global_from_hull.matrix()) @ expected
    np.testing.assert_allclose(track.poses.matrix(), expected, atol=1e-9)
    assert (
        track.frame
        is solution.frame
        is (Frame.GLOBAL if solution.hull_pose is None else Frame.HULL)
    )
    assert track.covariance is solution.pose_covariance
    assert (
        track.t_ns is solution.t_ns,
        track.tray is solution.tray,
        track.image is solution.image,
    ) == (True, True, True)
    assert len(solution.landmarks) == 2
