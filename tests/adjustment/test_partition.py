# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A dive adjusted in parts comes out as it does whole, and what a plan promises."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from adjustment.simulated_dive import simulate
from adjustment.solved_dives import solved
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.partition import join
from hullrecon.adjustment.partition import plan as planning
from hullrecon.adjustment.partition.plan import plan_parts
from hullrecon.adjustment.partition.sub_problem import SubProblems
from hullrecon.adjustment.results.summary import summarise_adjustment

QUICK = settings(max_examples=20, deadline=None, derandomize=True)
# column of each table in which the rows of a drawn problem are numbered
NUMBERED = {
    "odometry": "tray",
    "stereo": "sigma_ratio",
    "ranges": "measured",
    "surface": "weight",
    "plane_ranges": "measured",
    "plane_pairs": "measured",
}
MET = {
    "odometry": {"pose": ("first", "second")},
    "stereo": {"pose": ("node",), "landmark": ("landmark",)},
    "ranges": {"pose": ("node",)},
    "surface": {"landmark": ("landmark",)},
    "plane_ranges": {"pose": ("node",), "plane": ("plane",)},
    "plane_pairs": {"plane": ("first", "second")},
}


@pytest.fixture(scope="module")
def dive():
    return solved()


def of_parts(dive, parts):
    return plan_parts(dive.adjusted.problem, dive.adjusted.state, parts)


def sigmas(covariance):
    return np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))


def expect_same_marginals(got, want):
    """To 1e-9 as correlations."""
    sigma = sigmas(want)
    assert (np.abs(got - want) <= 1e-9 * sigma[..., :, None] * sigma[..., None, :]).all()


@pytest.mark.parametrize("parts", [2, 3, 8])
def test_a_solve_in_parts_is_the_solve_of_the_whole(dive, parts):
    problem, options = dive.adjusted.problem, native.Options(threads=2)
    shaken = problem.unknowns.pose + np.r_[0.005, -0.005, 0.005, np.zeros(5)]
    problem = problem.started_from(replace(problem.unknowns, pose=shaken))
    whole, found = (
        native.solve(problem, options),
        join.solve(problem, of_parts(dive, parts), options),
    )
    assert len(found.iterations.cost) == len(whole.iterations.cost) > 3
    np.testing.assert_allclose(found.iterations.cost, whole.iterations.cost, rtol=1e-10)
    for field in fields(native.Unknowns):
        got, want = (getattr(of.unknowns, field.name) for of in (found, whole))
        np.testing.assert_allclose(got, want, rtol=0, atol=1e-9, err_msg=field.name)
    for name in ("label", "ray_hit"):
        np.testing.assert_array_equal(getattr(found, name), getattr(whole, name), err_msg=name)
    np.testing.assert_allclose(found.distance, whole.distance, rtol=0, atol=1e-9)


@pytest.mark.parametrize("parts", [2, 3, 8])
def test_marginals_in_parts_are_those_of_the_whole(dive, parts):
    problem, options = dive.adjusted.problem, dive.adjusted.settings
    whole, found = (
        native.covariance(problem, options),
        join.covariance(problem, of_parts(dive, parts), options),
    )
    for name in ("pose", "landmark", "T_s_ct", "T_ct_cb", "T_s_d", "navigation"):
        expect_same_marginals(getattr(found, name), getattr(whole, name))
    np.testing.assert_allclose(found.deviation, whole.deviation, rtol=1e-8)
    for kind, leverage in whole.leverage_by_factor.items():
        assert found.leverage_by_factor[kind] == pytest.approx(leverage, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("parts", [2, 8])
def test_residuals_in_parts_are_those_of_the_whole(dive, parts):
    problem, options = dive.adjusted.problem, dive.adjusted.settings
    (whole,) = join.residuals(problem, None, options)
    found = list(join.residuals(problem, of_parts(dive, parts), options))
    assert len(found) == parts
    for name, values in whole.items():
        joined = np.concatenate([of_part[name] for of_part in found])
        np.testing.assert_allclose(np.sort(joined), np.sort(values), rtol=1e-12, atol=1e-12)


def test_a_dive_in_parts_comes_out_as_it_does_whole(dive):
    measured, options = simulate().measured, AdjustOptions(parts=3)
    adjusted = adjust(measured, options, lambda _: None)
    found, whole = summarise_adjustment(measured, adjusted, options), dive.outcome
    here, there = found.solution, whole.solution
    apart = here.global_from_vehicle.translation - there.global_from_vehicle.translation
    assert np.abs(apart).max() < 1e-9
    assert np.abs(here.landmarks.position - there.landmarks.position).max() < 1e-9
    expect_same_marginals(here.pose_covariance, there.pose_covariance)
    expect_same_marginals(here.landmarks.covariance, there.landmarks.covariance)
    assert found.summary["iterations"] == whole.summary["iterations"]
    said = found.summary["parts"]
    assert (said["count"], said["reason"]) == (3, "adjust.parts asks for 3")
    assert sum(said["poses"]) == len(measured.trajectory.t_ns)
    assert whole.summary["parts"]["count"] == 1


def test_one_part_has_the_bytes_of_a_solve_without_parts(dive):
    problem, options = dive.adjusted.problem, native.Options(max_iterations=3)
    whole, one = native.solve(problem, options), join.solve(problem, of_parts(dive, 1), options)
    for field in fields(native.Unknowns):
        got, want = (getattr(of.unknowns, field.name) for of in (one, whole))
        assert got.tobytes() == want.tobytes(), field.name


def test_two_threads_give_the_bytes_of_one_in_parts(dive):
    problem, plan = dive.adjusted.problem, of_parts(dive, 3)
    one, two = (
        join.solve(problem, plan, native.Options(threads=n, max_iterations=3)).unknowns
        for n in (1, 2)
    )
    for field in fields(native.Unknowns):
        assert getattr(one, field.name).tobytes() == getattr(two, field.name).tobytes(), field.name


def test_stripes_are_cut_along_the_longer_side_of_the_chart(dive):
    plan, state = of_parts(dive, 3), dive.adjusted.state
    at = state.hull.to_chart(state.nodes.translation)
    longer = int(np.argmax(np.ptp(at, axis=0)))
    assert plan.axis == ("along", "girth")[longer]
    np.testing.assert_array_equal(plan.owner, np.searchsorted(plan.cuts_m, at[:, longer], "right"))


def test_a_path_without_chart_is_cut_along_its_length(dive):
    state = replace(dive.adjusted.state, hull=None)
    plan = plan_parts(dive.adjusted.problem, state, 2)
    assert plan.axis == "path"
    first, second = (state.nodes.translation[plan.owner == k].mean(axis=0) for k in range(2))
    assert np.linalg.norm(first - second) > 0.4 * np.ptp(state.nodes.translation, axis=0).max()


def test_parts_are_as_few_as_their_memory_allows(dive, monkeypatch):
    one = of_parts(dive, "auto")
    assert one.parts == 1
    whole_mb = one.predicted_mb.sum()
    monkeypatch.setattr(planning, "SOLVER_MB", 0.75 * whole_mb)
    two = of_parts(dive, "auto")
    assert two.parts == 2
    assert two.predicted_mb.max() < 0.75 * whole_mb
    assert f"{whole_mb:.0f} MB in one part" in two.reason
    monkeypatch.setattr(planning, "SOLVER_MB", 0.1 * whole_mb)
    many = of_parts(dive, "auto")
    assert many.parts > 8
    assert many.predicted_mb.max() < 0.6 * two.predicted_mb.max() + 0.1 * whole_mb


def test_no_part_is_without_a_pose(dive):
    plan = of_parts(dive, 64)
    assert 30 < plan.parts <= len(dive.adjusted.state.nodes)
    assert np.bincount(plan.owner).min() > 0


def first_column(values):
    return values if values.ndim == 1 else values[:, 0]


def drawn_problem(seed):
    """Tables of a short survey, rows at random but numbered."""
    rng = np.random.default_rng(seed)
    poses, landmarks, nodes, planes = (int(n) for n in rng.integers(4, 40, 4))
    rows = 40

    def draw(high, *shape):
        return rng.integers(0, high, shape).astype(np.int32)

    return native.Problem(
        unknowns=native.Unknowns(
            pose=rng.normal(size=(poses, 8)),
            landmark=rng.normal(size=(landmarks, 3)),
            deviation=rng.normal(size=nodes),
            plane=rng.normal(size=(planes, 3)),
        ),
        priors=native.Priors(
            deviation=native.SparseRows(
                start=np.arange(nodes + 1, dtype=np.int32) * 2,
                index=draw(nodes, 2 * nodes),
                value=np.ones(2 * nodes),
            )
        ),
        odometry=native.OdometryTable(
            first=draw(poses, rows), second=draw(poses, rows), tray=np.arange(rows) + 0.0
        ),
        stereo=native.StereoTable(
            node=draw(poses, rows),
            landmark=draw(landmarks, rows),
            sigma_ratio=np.arange(rows) + 0.0,
        ),
        ranges=native.RangeTable(
            node=draw(poses, rows),
            measured=np.arange(rows) + 0.0,
            field=native.FieldNodes(index=draw(nodes, rows, 4), weight=np.ones((rows, 4))),
        ),
        surface=native.SurfaceTable(landmark=draw(landmarks, rows), weight=np.arange(rows) + 0.0),
        planes=native.PlaneTable(anchor=draw(poses, planes)),
        plane_ranges=native.PlaneRangeTable(
            node=draw(poses, rows), plane=draw(planes, rows), measured=np.arange(rows) + 0.0
        ),
        plane_pairs=native.PlanePairTable(
            first=draw(planes, 9), second=draw(planes, 9), measured=np.arange(27.0).reshape(9, 3)
        ),
    )


@QUICK
@given(seed=st.integers(0, 2**32 - 1), parts=st.integers(2, 5))
def test_each_row_is_in_one_part_and_meets_what_it_met(seed, parts):
    problem = drawn_problem(seed)
    owner = np.random.default_rng(seed).integers(0, parts, len(problem.unknowns.pose))
    _, owner = np.unique(owner, return_inverse=True)
    split = SubProblems(problem, owner)
    stands = {"pose": split.poses, "landmark": split.landmarks, "plane": split.planes}
    for name, column in NUMBERED.items():
        whole = getattr(problem, name)
        tables = [getattr(part.problem, name) for part in split.parts()]
        numbers = [first_column(getattr(table, column)) for table in tables]
        order = first_column(getattr(whole, column))
        np.testing.assert_array_equal(np.sort(np.concatenate(numbers)), order, err_msg=name)
        for k, (table, number) in enumerate(zip(tables, numbers, strict=True)):
            row = np.searchsorted(order, number)
            for kind, columns in MET[name].items():
                for of in columns:
                    met = stands[kind][k][getattr(table, of)]
                    np.testing.assert_array_equal(met, getattr(whole, of)[row], err_msg=of)


@QUICK
@given(seed=st.integers(0, 2**32 - 1), parts=st.integers(2, 5))
def test_no_row_joins_the_interiors_of_two_parts(seed, parts):
    problem = drawn_problem(seed)
    owner = np.random.default_rng(seed).integers(0, parts, len(problem.unknowns.pose))
    _, owner = np.unique(owner, return_inverse=True)
    split = SubProblems(problem, owner)
    interior = np.where(np.isin(np.arange(len(owner)), split.shared_poses), -1, owner)
    anchor = problem.planes.anchor
    rows = [
        np.stack([problem.odometry.first, problem.odometry.second]),
        np.stack([problem.plane_ranges.node, anchor[problem.plane_ranges.plane]]),
        np.stack([anchor[problem.plane_pairs.first], anchor[problem.plane_pairs.second]]),
        *(  # of a landmark, all poses that see it
            problem.stereo.node[problem.stereo.landmark == landmark][:, None]
            for landmark in range(len(problem.unknowns.landmark))
        ),
    ]
    for met in rows:
        for row in met.T:
            assert len({int(k) for k in interior[row] if k >= 0}) <= 1


@QUICK
@given(seed=st.integers(0, 2**32 - 1))
def test_each_prior_of_the_field_is_in_one_part(seed):
    problem = drawn_problem(seed)
    owner = np.arange(len(problem.unknowns.pose)) * 3 // len(problem.unknowns.pose)
    split = SubProblems(problem, owner)
    rows = []
    for k, part in enumerate(split.parts()):
        prior = part.problem.priors.deviation
        index = split.nodes[k][prior.index]
        rows += [tuple(index[a:b]) for a, b in zip(prior.start[:-1], prior.start[1:], strict=True)]
    whole = problem.priors.deviation.index.reshape(-1, 2)
    assert sorted(rows) == sorted(tuple(row) for row in whole)
