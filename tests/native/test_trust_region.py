# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Levenberg-Marquardt's own rules: radius, damping, what ends a solve and what its record says."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, evaluate, solve
from native.twins import cost, damping, jacobian, moved, normal_equations

from hullrecon.native import Options

Survey = Callable[..., Draft]
CORES = ["schur", "ceres"]
ENDLESS = {"function_tolerance": 0.0, "gradient_tolerance": 0.0, "parameter_tolerance": 0.0}


@pytest.fixture
def hard(make_survey: Survey, shaken: Survey) -> Draft:
    """A start from which some steps fail."""
    return shaken(make_survey(pixel_noise=0.5), 0.3, 0.1, 4)


def test_failed_steps_divide_the_radius_by_two_four_eight(hard: Draft) -> None:
    record = solve(hard, Options(initial_radius=1e8, function_tolerance=1e-10)).iterations
    assert (~record.accepted).sum() >= 8
    shrink = 2.0
    for k in range(1, len(record.radius)):
        if record.accepted[k]:
            shrink = 2.0
            continue
        assert record.radius[k] == pytest.approx(record.radius[k - 1] / shrink, rel=1e-12)
        shrink *= 2


def test_good_step_grows_the_radius_threefold_at_most(
    hard: Draft,
) -> None:
    record = solve(hard, Options(initial_radius=1e8, function_tolerance=1e-10)).iterations
    growth = (record.radius[1:] / record.radius[:-1])[record.accepted[1:]]
    assert (growth <= 3 * (1 + 1e-12)).all()
    assert (growth > 0).all()
    assert growth.max() == pytest.approx(3)


def test_radius_follows_the_quality_of_the_first_step(make_survey: Survey, shaken: Survey) -> None:
    p = shaken(make_survey(pixel_noise=0.5), 0.05, 0.01)
    options = Options(method="naive", initial_radius=10.0, max_iterations=1, **ENDLESS)
    e = evaluate(p, options)
    information, gradient = normal_equations(e)
    d = damping(information, 10.0)
    step = np.linalg.solve(information + np.diag(d), -gradient)
    foretold = -(gradient @ step + 0.5 * step @ information @ step)
    found = cost(e) - cost(evaluate(moved(p, e, step), options))
    quality = found / foretold
    record = solve(p, options).iterations
    assert record.accepted[1]
    assert record.cost_change[1] == pytest.approx(found, rel=1e-6)
    assert record.radius[1] == pytest.approx(
        10.0 / max(1 / 3, 1 - (2 * quality - 1) ** 3), rel=1e-5
    )


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (ENDLESS | {"function_tolerance": 1e-3}, "Function tolerance reached"),
        (ENDLESS | {"gradient_tolerance": 1e3}, "Gradient tolerance reached"),
        (ENDLESS | {"parameter_tolerance": 1e-2}, "Parameter tolerance reached"),
        (ENDLESS | {"max_iterations": 2}, "Maximum number of iterations reached"),
    ],
)
def test_each_tolerance_ends_the_solve_and_says_so(
    core: str, options: dict[str, float], message: str, make_survey: Survey, shaken: Survey
) -> None:
    got = solve(shaken(make_survey(pixel_noise=0.5)), Options(core=core, **options))  # type: ignore[arg-type]
    assert message in got.message
    assert got.converged == ("Maximum" not in message)
    assert len(got.iterations.cost) <= 3 or "Maximum" not in message


@pytest.mark.parametrize("core", CORES)
def test_no_iterations_leave_the_unknowns_where_they_are(
    core: str, make_survey: Survey, shaken: Survey
) -> None:
    p = shaken(make_survey())
    got = solve(p, Options(core=core, max_iterations=0))
    assert not got.converged
    assert len(got.iterations.cost) == 1
    for name, value in got.unknowns.__dict__.items():
        np.testing.assert_array_equal(value, getattr(p.unknowns, name), err_msg=name)


@pytest.mark.parametrize("core", CORES)
def test_the_least_cost_of_a_linear_problem_is_met_in_one_step(
    core: str, empty: Callable[[int], Draft]
) -> None:
    p = empty(6)
    p.constant = (*p.constant, "tray")
    n = np.arange(6, dtype=np.int32)
    p.attitude.node, p.attitude.measured = n, np.c_[np.arange(6.0), np.zeros((6, 2))]
    p.attitude.sigma = np.ones((6, 3))
    p.priors.pose.node, p.priors.pose.value = n, p.unknowns.pose[:, :7].copy()
    p.priors.pose.sqrt_information = np.tile(np.eye(6), (6, 1, 1))
    got = solve(p, Options(core=core, initial_radius=1e12, function_tolerance=1e-12))
    # between prior 0 and depth k
    np.testing.assert_allclose(got.unknowns.pose[:, 2], 0.5 * np.arange(6), atol=1e-9)
    assert got.iterations.cost[1] == pytest.approx(0.25 * (np.arange(6) ** 2).sum(), rel=1e-9)


def test_rejected_iteration_repeats_the_last_accepted_row(hard: Draft) -> None:
    record = solve(hard, Options(initial_radius=1e8, function_tolerance=1e-10)).iterations
    for k in np.flatnonzero(~record.accepted):
        assert record.on_surface[k] == record.on_surface[k - 1]
        assert record.label_changes[k] == 0
        assert record.gradient_norm[k] == record.gradient_norm[k - 1]
        for name, value in record.cost_by_factor.items():
            assert value[k] == value[k - 1], name
    total = np.sum(list(record.cost_by_factor.values()), axis=0)
    np.testing.assert_allclose(total[record.accepted], record.cost[record.accepted], rtol=1e-12)
    assert (np.diff(record.seconds) >= 0).all()


def test_label_changes_count_from_one_accepted_point_to_the_next(hard: Draft) -> None:
    record = solve(hard, Options(initial_radius=1e8, function_tolerance=1e-10)).iterations
    changed = np.flatnonzero(record.label_changes)
    assert changed.size
    assert (np.abs(np.diff(record.on_surface))[changed - 1] <= record.label_changes[changed]).all()


@pytest.mark.parametrize("radius", [1e-8, 1e-4, 1.0])
def test_a_small_radius_gives_a_short_step_down_the_gradient(
    radius: float, make_survey: Survey, shaken: Survey
) -> None:
    p = shaken(make_survey(pixel_noise=0.5))
    options = Options(initial_radius=radius, max_iterations=1, **ENDLESS)
    record = solve(p, options).iterations
    assert record.accepted[1]
    assert record.cost[1] < record.cost[0]
    wider = solve(p, Options(initial_radius=10 * radius, max_iterations=1, **ENDLESS)).iterations
    assert record.step_norm[1] < wider.step_norm[1]


@pytest.mark.parametrize("threads", [1, 3])
def test_seconds_name_the_parts_and_their_whole(
    threads: int, make_survey: Survey, shaken: Survey
) -> None:
    seconds = solve(shaken(make_survey()), Options(threads=threads)).seconds
    parts = {
        "preprocess",
        "residuals",
        "jacobians",
        "linear_solver",
        "refresh",
        "record",
        "eliminate",
        "factor",
        "back_substitute",
    }
    assert set(seconds) == parts | {"total"}
    assert all(0 <= seconds[part] <= seconds["total"] for part in parts)


def test_what_no_factor_meets_stays(make_survey: Survey) -> None:
    p = make_survey()
    p.unknowns.pose = np.vstack([p.unknowns.pose, p.unknowns.pose[:1] + np.r_[5, np.zeros(6), 0.1]])
    p.unknowns.landmark = np.vstack([p.unknowns.landmark, [[1.0, 2, 3]]])
    got = solve(p, Options(max_iterations=5)).unknowns
    np.testing.assert_array_equal(got.pose[-1], p.unknowns.pose[-1])
    np.testing.assert_array_equal(got.landmark[-1], p.unknowns.landmark[-1])


def test_the_solve_ends_where_the_robust_gradient_vanishes(
    make_survey: Survey, shaken: Survey
) -> None:
    p = shaken(make_survey(pixel_noise=0.5))
    before = np.abs(
        normal_equations(evaluate(p))[1] / np.linalg.norm(jacobian(evaluate(p)), axis=0)
    ).max()
    for name, value in solve(
        p, Options(function_tolerance=1e-15, parameter_tolerance=1e-15)
    ).unknowns.__dict__.items():
        setattr(p.unknowns, name, value)
    e = evaluate(p)
    assert (
        np.abs(normal_equations(e)[1] / np.linalg.norm(jacobian(e), axis=0)).max() < 1e-6 * before
    )
