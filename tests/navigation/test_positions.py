# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Positions from outside on a dive without a camera, and what is refused of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from navigation.linked_dive import DVL_TURN_SIGMA, LinkedDive, poses, simulate

from hullrecon import native
from hullrecon.estimation.position_tables import fit_of_positions, place_path, with_positions
from hullrecon.navigation.dead_reckoning.positions import attach_positions
from hullrecon.navigation.pose_graph.graph import OPTIONS, GraphSolution, PoseGraph
from hullrecon.records.links import no_links
from hullrecon.records.sensors import PositionFixes
from hullrecon.records.trajectory import PositionTies

DRIFT = 1.5e-3  # rad/s: 10 degrees over the two minutes of the dive
ORIGIN = np.array([-0.3, 0.15, -0.25])
WORLD = np.array([40.0, -7.0, 2.5])
SIGMA_M = 0.1


def turned(xy: np.ndarray, world: np.ndarray = WORLD) -> np.ndarray:
    """Points (n, 2) of g north and east in a world that lies any way to it."""
    c, s = np.cos(world[2]), np.sin(world[2])
    return np.asarray(
        world[:2] + np.column_stack([c * xy[:, 0] - s * xy[:, 1], s * xy[:, 0] + c * xy[:, 1]])
    )


def fixes_of(
    dive: LinkedDive, sigma_m: float = SIGMA_M, seed: int = 3, wild: float = 0.0
) -> PositionFixes:
    """A fix at each node, a second later where the vehicle is half way; wild: share that is off by
    up to 50 m.
    """
    rng = np.random.default_rng(seed)
    antenna = poses(dive.global_from_vehicle).apply(ORIGIN)[:, :2]
    between = 0.5 * (antenna[:-1] + antenna[1:])
    at = turned(between) + sigma_m * rng.standard_normal(between.shape)
    off = rng.random(len(at)) < wild
    at[off] += rng.uniform(-50, 50, (off.sum(), 2))
    t = dive.trajectory.t_ns
    return PositionFixes(
        t_ns=(t[:-1] + t[1:]) // 2,
        north_east=at,
        exchanged=at[:, ::-1],
        sigma=np.full(len(at), sigma_m),
    )


def solve(dive: LinkedDive, ties: PositionTies | None) -> GraphSolution:
    graph = PoseGraph(
        trajectory=dive.trajectory,
        odometry=dive.odometry,
        attitude=dive.attitude,
        rig=dive.rig,
        positions=ties,
    )
    return graph.solve(no_links())


def ties_of(dive: LinkedDive, fixes: PositionFixes) -> PositionTies:
    found = attach_positions(fixes, dive.trajectory, ORIGIN).ties
    assert found is not None
    return found


def errors_m(found: GraphSolution, dive: LinkedDive) -> np.ndarray:
    """Horizontal errors (n, 2) in g, whose origin and heading are those of the true first pose."""
    return np.asarray(found.path.poses.translation[:, :2] - dive.global_from_vehicle[:, :2, 3])


def rms(errors: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))


@pytest.fixture(scope="module")
def dive() -> LinkedDive:
    return simulate(1, drift=DRIFT)


def test_fixes_bound_the_drift_of_a_dive_without_a_camera(dive: LinkedDive) -> None:
    """Measured: 0.42 m without, 0.07 m with 59 fixes of 0.1 m."""
    without = rms(errors_m(solve(dive, None), dive))
    found = solve(dive, ties_of(dive, fixes_of(dive)))
    assert found.converged
    assert rms(errors_m(found, dive)) < min(0.12, 0.4 * without)
    assert found.problem.unknowns.navigation[1] == pytest.approx(DRIFT, abs=4e-4)


def test_errors_of_a_bounded_path_are_as_large_as_its_sigmas_say() -> None:
    """Of twelve dives whose errors are drawn from their sigmas, the end of each in its own
    covariance: chi-square, two each.
    """
    square = []
    for seed in range(12):
        drawn = simulate(seed)
        found = solve(drawn, ties_of(drawn, fixes_of(drawn, seed=100 + seed)))
        covariance = found.record().covariance[-1, :2, :2]
        error = errors_m(found, drawn)[-1]
        square.append(error @ np.linalg.solve(covariance, error))
    assert 9.9 < np.sum(square) < 45.6  # 0.5 % to 99.5 % of 24 degrees of freedom: a mean of 24


def test_a_wrong_scale_of_the_dvl_is_found(dive: LinkedDive) -> None:
    wrong = replace(dive.odometry, translation=1.03 * dive.odometry.translation)
    scaled = replace(
        dive,
        odometry=wrong,
        rig=dive.rig.with_priors(
            navigation_sigma=dive.rig.priors.navigation_sigma * [5, 1, 1, 1, 1, 1]
        ),
    )
    before, after = (solve(scaled, ties) for ties in (None, ties_of(scaled, fixes_of(dive))))
    assert rms(errors_m(after, dive)) < 0.5 * rms(errors_m(before, dive))


@pytest.mark.parametrize("wild", [0.1, 0.25])
def test_outliers_hardly_move_the_path(dive: LinkedDive, wild: float) -> None:
    clean, spoilt = (
        solve(dive, ties_of(dive, fixes_of(dive, wild=share))) for share in (0.0, wild)
    )
    assert rms(errors_m(spoilt, dive) - errors_m(clean, dive)) < 0.6 * SIGMA_M
    fit = spoilt.fit_of_positions()
    assert fit is not None
    assert fit.outliers == pytest.approx(wild * fit.count, abs=4)
    assert fit.disagreement() is None


def test_the_heading_of_the_world_is_found_within_its_sigma(dive: LinkedDive) -> None:
    fit = solve(dive, ties_of(dive, fixes_of(dive))).fit_of_positions()
    assert fit is not None
    assert abs(fit.heading - WORLD[2]) < 3 * fit.heading_sigma < 0.1
    assert 0.8 < fit.rms < 1.25
    assert fit.facts()["count"] == 59


def test_fixes_that_contradict_navigation_are_told_in_words(dive: LinkedDive) -> None:
    fixes = fixes_of(dive)
    away = fixes.north_east * [1, -1] + np.arange(59)[:, None] * [0.5, 0.0]
    mirrored = replace(fixes, north_east=away, exchanged=away[:, ::-1])
    sentence = solve(dive, ties_of(dive, mirrored)).fit_of_positions()
    assert sentence is not None
    assert "disagree with navigation" in (sentence.disagreement() or "")


def test_exchanged_coordinates_are_put_right_and_told(dive: LinkedDive) -> None:
    fixes = fixes_of(dive)
    # 54 degrees north, where a degree of longitude is 0.59 times as long as one of latitude
    logged = fixes.exchanged * [1.7, 1.0]
    swapped = replace(fixes, north_east=logged, exchanged=fixes.north_east)
    found = attach_positions(swapped, dive.trajectory, ORIGIN)
    assert found.ties is not None
    np.testing.assert_array_equal(found.ties.north_east, ties_of(dive, fixes).north_east)
    assert "exchanged: as logged they lie" in found.sentences()[0]
    assert attach_positions(fixes, dive.trajectory, ORIGIN).sentences() == []


def test_without_fixes_the_problem_is_the_same(dive: LinkedDive) -> None:
    problem = solve(dive, None).problem
    assert with_positions(problem, None) is problem
    assert fit_of_positions(problem, None, np.zeros((3, 3)), OPTIONS) is None
    assert solve(dive, None).fit_of_positions() is None


@pytest.mark.parametrize("wild", [0.0, 0.3])
def test_the_first_place_of_a_path_is_that_of_most_fixes(dive: LinkedDive, wild: float) -> None:
    ties = ties_of(dive, fixes_of(dive, sigma_m=0.02, wild=wild))
    world = place_path(ties, poses(dive.global_from_vehicle))
    np.testing.assert_allclose(world[:2], WORLD[:2], atol=0.1)
    assert world[2] == pytest.approx(WORLD[2], abs=0.02)


def test_the_antenna_is_where_the_vehicle_was_at_the_fix(dive: LinkedDive) -> None:
    perfect = replace(dive.trajectory, **_true(dive))
    ties = attach_positions(fixes_of(dive, sigma_m=1e-9), perfect, ORIGIN).ties
    assert ties is not None
    at = perfect.poses()[ties.node].apply(ties.antenna)[:, :2]
    np.testing.assert_allclose(turned(at), ties.north_east, atol=2e-3)
    assert np.all(np.abs(ties.t_ns - perfect.t_ns[ties.node]) <= 1_000_000_000)


def _true(dive: LinkedDive) -> dict[str, np.ndarray]:
    true = poses(dive.global_from_vehicle)
    return {"quaternion": true.quaternion, "translation": true.translation}


def rows(fixes: PositionFixes, keep: slice | np.ndarray) -> PositionFixes:
    return PositionFixes(
        t_ns=fixes.t_ns[keep],
        north_east=fixes.north_east[keep],
        exchanged=fixes.exchanged[keep],
        sigma=fixes.sigma[keep],
    )


def test_one_fix_tells_nothing_and_two_do(dive: LinkedDive) -> None:
    fixes = fixes_of(dive)
    alone = attach_positions(rows(fixes, slice(0, 1)), dive.trajectory, ORIGIN)
    assert alone.ties is None
    assert alone.sentences() == [
        (
            "Positions from outside tell nothing of this dive: there is one alone, and "
            "where the dive began is free."
        )
    ]
    both = attach_positions(rows(fixes, np.array([0, 29])), dive.trajectory, ORIGIN)
    assert both.ties is not None
    assert both.sentences() == []
    assert (
        rms(errors_m(solve(dive, both.ties), dive)) <= rms(errors_m(solve(dive, None), dive)) + 0.05
    )


def test_fixes_of_one_place_tell_nothing(dive: LinkedDive) -> None:
    fixes = fixes_of(dive)
    noise = SIGMA_M * np.random.default_rng(1).standard_normal(fixes.north_east.shape)
    there = attach_positions(replace(fixes, north_east=noise), dive.trajectory, ORIGIN)
    assert there.ties is None
    assert there.facts() == {"used": 0, "outside": 0, "refusal": there.refusal}
    assert "all 59 are of one place within their sigma of 0.1 m" in str(there.refusal)


def test_fixes_before_and_after_the_path_are_counted(dive: LinkedDive) -> None:
    fixes = fixes_of(dive)
    late = replace(fixes, t_ns=fixes.t_ns + np.int64(60_000_000_000))
    found = attach_positions(late, dive.trajectory, ORIGIN)
    assert found.outside == 30
    assert (
        "30 positions from outside lie before or after the path, or more than 5 s from a pose"
        in found.sentences()[0]
    )
    none = attach_positions(
        replace(fixes, t_ns=fixes.t_ns + np.int64(10**12)), dive.trajectory, ORIGIN
    )
    assert none.refusal == "there is none along the path"


def test_the_rows_of_the_table_are_those_of_the_ties(dive: LinkedDive) -> None:
    ties = ties_of(dive, fixes_of(dive))
    problem = with_positions(solve(dive, None).problem, ties)
    np.testing.assert_array_equal(problem.positions.node, ties.node)
    found = native.evaluate(problem)
    assert int((found.factor == native.FACTORS.index("position")).sum()) == 2 * len(ties)
    assert DVL_TURN_SIGMA > 0
